//! The outline of a cell in space, for files and pictures.

use crate::domain::domain::Domain;
use crate::domain::shape::PieceScratch;
use crate::geometry::shell::Shell;
use crate::voronoi::cell::Cell;

/// The surface of `cell` within the domain, in the domain's coordinates: what files and pictures
/// show.
pub fn shell(domain: &dyn Domain, cell: &Cell<'_>, scratch: &mut PieceScratch) -> Shell {
    let mut shell = Shell::default();
    domain.outline(&cell.position, cell.polyhedron(), scratch, &mut |piece| {
        shell = Shell::from(piece).translated(&cell.position.coords);
    });
    shell
}
