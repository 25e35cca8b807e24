//! One Voronoi cell: bisectors of ever farther sites until the security radius.
//!
//! Cells are cut in fixed slots. One that does not fit there is begun anew as a polyhedron of any
//! size: two in 10⁵ among random sites, and wherever many sites lie on one sphere.

use nalgebra::Point3;

use crate::domain::space::Domain;
use crate::geometry::clip::ClipScratch;
use crate::geometry::compact::Compact;
use crate::geometry::compact_clip::CompactScratch;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::index::SiteIndex;
use crate::voronoi::search::{Duplicate, Halt, Search};

/// A cell under the caller's eyes, in coordinates relative to its site.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// The site's index.
    pub site: u32,
    /// The site's position.
    pub position: Point3<f64>,
    /// The cell, clipped to the domain's convex start; its site is the origin.
    pub polyhedron: &'a Polyhedron,
}

/// The memory in which cells are built, one after the other.
#[derive(Clone, Debug, Default)]
pub struct CellBuilder {
    polyhedron: Polyhedron,
    clip: ClipScratch,
    compact: Compact,
    compact_scratch: Box<CompactScratch>,
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
        let (site, position) = (index.site(place), index.position(place));
        domain.start(&position, site, &mut self.polyhedron);
        let halt = if self.compact.assign(&self.polyhedron) {
            let mut shape = (&mut self.compact, &mut *self.compact_scratch);
            self.search.shape(index, place, &mut shape)
        } else {
            Err(Halt::Full)
        };
        match halt {
            Ok(()) => self.compact.write(&mut self.polyhedron),
            Err(Halt::Duplicate(duplicate)) => return Err(duplicate),
            Err(Halt::Full) => {
                let mut shape = (&mut self.polyhedron, &mut self.clip);
                match self.search.shape(index, place, &mut shape) {
                    Err(Halt::Duplicate(duplicate)) => return Err(duplicate),
                    // Any size fits.
                    Ok(()) | Err(Halt::Full) => {}
                }
            }
        }
        Ok(Cell {
            site,
            position,
            polyhedron: &self.polyhedron,
        })
    }
}
