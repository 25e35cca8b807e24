//! Sites from crowded rows go to holes.
//!
//! What a descent leaves of a cubic tessellation is mostly perfect, with a few point defects: a row
//! that holds one site too many, somewhere else a hole where a site is missing. Neither can heal
//! alone, and noise would have to carry a site all the way from one to the other. An exchange takes
//! it out of the crowded row, where cells are worth least, and puts it into the hole, the place
//! farthest from every site (the swap of k-means, in a tessellation's words). A descent then closes
//! the gap in the row. The caller keeps the outcome only if the energy fell.

use nalgebra::{Point3, Vector3};

use crate::geometry::random::Random;
use crate::relax::cell_memory::CellMemory;
use crate::relax::record::optimal_side;
use crate::relax::space::Space;
use crate::relax::tessellation::Tessellation;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// A corner of a cell farther from its site than this share of the mean cell's side belongs to a
/// hole; in a perfect cube all corners are at half of it.
const HOLE: f64 = 0.58;

/// Two holes, or two sites taken out, lie at least so many sides apart: a hole has many corners,
/// and neighbors taken out together would leave a new one.
const APART: f64 = 1.2;

/// Energies and distances are compared after so much noise, so that the same exchange is not tried
/// again and again.
const JITTER: f64 = 0.03;

/// At most so many sites are exchanged at once.
const MOST_PAIRS: usize = 1000;

/// How crowded a cell is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Room {
    /// Its energy of order 1 (L⁴).
    pub(crate) energy: f64,
    /// Its corner farthest from the site, and how far that is in the Chebyshev norm (L).
    pub(crate) corner: Point3<f64>,
    pub(crate) distance: f64,
}

/// The rooms of all sites.
pub(crate) fn rooms(space: &Space, sites: &[Point3<f64>]) -> Result<Vec<Room>, DiagramError> {
    let diagram = Diagram::new(space.domain(), sites)?;
    diagram.map(|memory: &mut CellMemory, cell| {
        let frame = space.frames().of(cell.site);
        memory.load_in_frame(space.domain(), &cell, frame);
        let distance =
            |way: &Vector3<f64>| frame.map_or(way.amax(), |frame| (frame.inverse() * way).amax());
        let mut farthest = Vector3::zeros();
        for corner in cell.polyhedron().vertices() {
            let inside = || {
                space
                    .domain()
                    .contains(&space.domain().wrap(&(cell.position + corner.coords)))
            };
            if distance(&corner.coords) > distance(&farthest) && inside() {
                farthest = corner.coords;
            }
        }
        Room {
            energy: memory.evaluate(&Vector3::zeros(), 1).value,
            corner: space.domain().wrap(&(cell.position + farthest)),
            distance: distance(&farthest),
        }
    })
}

/// Moves up to `pairs` sites from crowded cells to holes and returns how many.
pub(crate) fn exchange(
    space: &Space,
    sites: &mut [Point3<f64>],
    rooms: &[Room],
    pairs: usize,
    random: &mut Random,
) -> usize {
    let side = optimal_side::<3>(space.volume(), sites.len());
    let pairs = pairs.min(MOST_PAIRS);
    let is_apart = |chosen: &[Point3<f64>], point: &Point3<f64>| {
        chosen
            .iter()
            .all(|other| space.displacement(other, point).amax() > APART * side)
    };
    let mut holes: Vec<Point3<f64>> = Vec::new();
    for room in by_size(rooms, |room| -room.distance, random) {
        let found = &rooms[room];
        if holes.len() < pairs && found.distance > HOLE * side && is_apart(&holes, &found.corner) {
            holes.push(found.corner);
        }
    }
    let mut gone: Vec<Point3<f64>> = Vec::new();
    for site in by_size(rooms, |room| room.energy, random) {
        if gone.len() < holes.len() && is_apart(&gone, &sites[site]) {
            gone.push(sites[site]);
            sites[site] = holes[gone.len() - 1];
        }
    }
    gone.len()
}

/// The rooms in the order of a size that is read with some noise.
fn by_size(rooms: &[Room], size: impl Fn(&Room) -> f64, random: &mut Random) -> Vec<usize> {
    let mut sizes: Vec<(f64, usize)> = rooms
        .iter()
        .enumerate()
        .map(|(room, of)| (size(of) * (1.0 + JITTER * random.gaussian()), room))
        .collect();
    sizes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    sizes.into_iter().map(|(_, room)| room).collect()
}
