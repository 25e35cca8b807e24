//! The body of a cell: as it was cut, and as a polyhedron for those who ask.

use std::cell::{OnceCell, RefCell};

use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;

/// A cell's body, in memory to be reused from one cell to the next.
///
/// Integrals are taken straight from fixed slots; what else is asked of a cell is asked of a
/// polyhedron, which is only made then.
#[derive(Debug, Default)]
pub(crate) struct Body {
    compact: SmallPolyhedron,
    /// Whether the body is in the fixed slots.
    is_compact: bool,
    polyhedron: OnceCell<Polyhedron>,
    /// The memory of an earlier polyhedron.
    spare: RefCell<Polyhedron>,
}

impl Body {
    /// The body in fixed slots, if it fits.
    #[inline]
    pub(crate) fn compact(&self) -> Option<&SmallPolyhedron> {
        self.is_compact.then_some(&self.compact)
    }

    /// The body as a polyhedron.
    pub(crate) fn polyhedron(&self) -> &Polyhedron {
        self.polyhedron.get_or_init(|| {
            let mut polyhedron = self.spare.take();
            self.compact.write(&mut polyhedron);
            polyhedron
        })
    }

    /// The slots, for a new body to be written there.
    #[inline]
    pub(crate) fn slots(&mut self) -> &mut SmallPolyhedron {
        self.forget();
        self.is_compact = true;
        &mut self.compact
    }

    /// Becomes what `make` makes of a polyhedron, whatever that holds: in slots if it fits there.
    pub(crate) fn assign<E>(
        &mut self,
        make: impl FnOnce(&mut Polyhedron) -> Result<(), E>,
    ) -> Result<(), E> {
        self.forget();
        let mut polyhedron = self.spare.take();
        make(&mut polyhedron)?;
        self.is_compact = self.compact.assign(&polyhedron);
        self.polyhedron = OnceCell::from(polyhedron);
        Ok(())
    }

    /// The least axis-aligned box around the body, which holds the origin.
    pub(crate) fn bounds(&self) -> Bounds<3> {
        match self.compact() {
            Some(compact) => compact.bounds_about_origin(),
            None => self.polyhedron().bounds(),
        }
    }

    /// The half-spaces that meet in the body, and maybe some that hold all of it.
    pub(crate) fn half_spaces(&self) -> &[HalfSpace] {
        match self.compact() {
            Some(compact) => &compact.planes,
            None => &self.polyhedron().planes,
        }
    }

    fn forget(&mut self) {
        if let Some(polyhedron) = self.polyhedron.take() {
            *self.spare.get_mut() = polyhedron;
        }
    }
}
