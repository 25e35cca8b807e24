//! One Voronoi cell: bisectors of ever farther sites until the security radius.
//!
//! Cells are cut in fixed slots. One that does not fit there is begun anew as a polyhedron of any
//! size: two in 10⁵ among random sites, and wherever many sites lie on one sphere.

use nalgebra::Point3;

use crate::domain::domain::Domain;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::ClipScratch;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::geometry::small_polyhedron_clip::SmallClipScratch;
use crate::voronoi::body::Body;
use crate::voronoi::index::SiteIndex;
use crate::voronoi::search::{Duplicate, Halt, Manner, Search};

/// A cell under the caller's eyes: its body, clipped to the domain's convex start, in coordinates
/// relative to its site.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// The site's index.
    pub site: u32,
    /// The site's position.
    pub position: Point3<f64>,
    pub(crate) body: &'a Body,
}

impl<'a> Cell<'a> {
    /// The body as a polyhedron; the site is its origin.
    #[must_use]
    pub fn polyhedron(&self) -> &'a Polyhedron {
        self.body.polyhedron()
    }

    /// The least axis-aligned box around the body, relative to the site.
    #[must_use]
    pub fn bounds(&self) -> Bounds<3> {
        self.body.bounds()
    }

    /// The half-spaces that meet in the body, and maybe some that hold all of it.
    #[must_use]
    pub fn half_spaces(&self) -> &'a [HalfSpace] {
        self.body.half_spaces()
    }

    /// The body in fixed slots, if it fits there.
    #[must_use]
    pub fn compact(&self) -> Option<&'a SmallPolyhedron> {
        self.body.compact()
    }
}

/// The memory in which cells are built, one after the other.
#[derive(Debug, Default)]
pub struct CellBuilder {
    start: Polyhedron,
    clip: ClipScratch,
    body: Body,
    compact_scratch: Box<SmallClipScratch>,
    search: Search,
}

impl CellBuilder {
    /// Builds the cell of the site in `place` of the index.
    ///
    /// # Errors
    /// When another site, or an image of one, lies in the same place.
    pub fn build(
        &mut self,
        domain: &dyn Domain,
        index: &SiteIndex,
        place: usize,
    ) -> Result<Cell<'_>, Duplicate> {
        self.build_in(Manner::Crowd, domain, index, place)
    }

    /// As [`CellBuilder::build`], with sites looked for in some manner.
    pub(crate) fn build_in(
        &mut self,
        manner: Manner,
        domain: &dyn Domain,
        index: &SiteIndex,
        place: usize,
    ) -> Result<Cell<'_>, Duplicate> {
        let (site, position) = (index.site(place), index.position(place));
        let Self {
            start,
            clip,
            body,
            compact_scratch,
            search,
        } = self;
        domain.start(&position, site, start);
        let compact = body.slots();
        let halt = if compact.assign(start) {
            let mut shape = (compact, &mut **compact_scratch);
            search.shape(index, (place, manner), &mut shape)
        } else {
            Err(Halt::Full)
        };
        match halt {
            Ok(()) => {}
            Err(Halt::Duplicate(duplicate)) => return Err(duplicate),
            Err(Halt::Full) => body.assign(|polyhedron| {
                polyhedron.clone_from(start);
                let mut shape = (&mut *polyhedron, &mut *clip);
                match search.shape(index, (place, manner), &mut shape) {
                    Err(Halt::Duplicate(duplicate)) => Err(duplicate),
                    // Any size fits.
                    Ok(()) | Err(Halt::Full) => Ok(()),
                }
            })?,
        }
        Ok(Cell {
            site,
            position,
            body,
        })
    }
}
