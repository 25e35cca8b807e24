//! The frames in which cells measure distances.
//!
//! \[BL\] names individually oriented cells as future work. Cells are cut by bisectors of the
//! Euclidean distance, which no rotation changes, so a frame touches nothing but d∞: a cell's pieces
//! are turned into its frame, integrated there, and what comes out is turned back. Frames belong to
//! sites, not to places: while sites move, each keeps its own, and so the energy of all cells has an
//! exact gradient.
//!
//! # Frames that follow the boundary
//!
//! A frame is as good as the 24 that the cube's symmetry makes of it, so two frames are compared, and
//! averaged, only after one has been replaced by its equivalent nearest to the other. One step does
//! both, smoothing and alignment: it sums the frames of a cell's neighbors, each as the equivalent
//! nearest to the cell's own and weighted by the common facet's area, and for every wall facet the
//! outer product of its normal with the axis of the cell's frame nearest to it. The rotation nearest
//! to that sum (its polar factor, by singular values) is the cell's new frame.
//!
//! Frames spread from where the walls fix all three axes, at edges and corners of the domain, from
//! layer to layer of neighbors; where there are none, from the first cell with a wall, whose frame is
//! the smallest rotation from the axes of space that aligns it. Then all cells take a number of steps
//! at once. A turned box gets its own rotation everywhere, for that is where nothing changes.
//!
//! Walls are known from the cells themselves, so this works in every domain.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Point3, Rotation3, Unit, Vector3};

use crate::domain::facet_kind::FacetKind;
use crate::domain::{domain::Domain, shape::PieceScratch};
use crate::parallel::map;
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};

/// The rotation that takes the axes of a cell's frame to where they point in space.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Frames, Relaxation};
/// use nalgebra::{Rotation3, Vector3};
///
/// let turned = Rotation3::new(Vector3::new(0.0, 0.0, 0.5));
/// let relaxation = Relaxation::new(Cuboid::unit()).frames(Frames::PerSite(vec![turned; 2]));
/// relaxation.run(&mut vec![[0.3; 3], [0.6; 3]])?;
/// # Ok::<(), chebloyd::RelaxError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Frames {
    /// The axes of space, for all cells.
    #[default]
    Axes,
    /// One frame for all cells.
    One(Rotation3<f64>),
    /// A frame for every site, in site order.
    PerSite(Vec<Rotation3<f64>>),
}

impl Frames {
    /// How many frames there are, where every site has its own.
    #[must_use]
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::PerSite(frames) => Some(frames.len()),
            Self::Axes | Self::One(_) => None,
        }
    }

    /// The frame of a site; none for the axes of space.
    #[must_use]
    pub fn of(&self, site: u32) -> Option<&Rotation3<f64>> {
        match self {
            Self::Axes => None,
            Self::One(frame) => Some(frame),
            Self::PerSite(frames) => frames.get(site as usize),
        }
    }
}

/// How much more a cell's walls weigh than its neighbors.
const WALL_WEIGHT: f64 = 10.0;

/// How often all frames take a step together: enough for fifty layers of cells to agree.
const SWEEPS: usize = 50;

/// A wall whose area is at most this share of the largest facet's is what rounding leaves of signed
/// pieces that cancel: it has no direction.
const NO_WALL: f64 = 1e-12;

/// Walls fix a frame if those of at least this share of their area are more than so far from the
/// main one's normal (as the cosine): sixty degrees, above what curved walls do within a cell.
const CREASE: (f64, f64) = (0.05, 0.5);

/// The facets of a cell.
#[derive(Debug, Default)]
struct CellFacets {
    /// Neighbors and the areas of the facets towards them (L²).
    neighbors: Vec<(u32, f64)>,
    /// The area vectors of the walls (L²).
    walls: Vec<Vector3<f64>>,
}

/// For every site the frame that follows the boundary of `domain`.
///
/// # Errors
/// When the sites have no diagram.
pub(crate) fn boundary_frames(
    domain: &dyn Domain,
    sites: &[Point3<f64>],
) -> Result<Vec<Rotation3<f64>>, DiagramError> {
    let diagram = Diagram::borrowed(domain, sites)?;
    let cells =
        diagram.map(|scratch: &mut PieceScratch, cell| facets_of(domain, &cell, scratch))?;
    let equivalents = equivalents();
    let mut frames: Vec<Rotation3<f64>> = spread(&cells, &equivalents);
    for _ in 0..SWEEPS {
        frames = map(cells.len(), &|site| {
            let known = |site: u32| frames.get(site as usize);
            step(&cells[site], &frames[site], known, &equivalents)
        });
    }
    Ok(frames)
}

fn facets_of(domain: &dyn Domain, cell: &Cell<'_>, scratch: &mut PieceScratch) -> CellFacets {
    let mut areas: BTreeMap<u64, Vector3<f64>> = BTreeMap::new();
    domain.pieces(
        &cell.position,
        cell.polyhedron(),
        scratch,
        &mut |sign, part| {
            part.visit_facets(|label, _, area| *areas.entry(label).or_default() += area * sign);
        },
    );
    let mut facets = CellFacets::default();
    let largest = areas.values().map(Vector3::norm).fold(0.0, f64::max);
    areas.retain(|_, area| area.norm() > NO_WALL * largest);
    for (label, area) in areas {
        match FacetKind::of(label) {
            FacetKind::Neighbor { site, .. } => facets.neighbors.push((site, area.norm())),
            FacetKind::Wall(_) => facets.walls.push(area),
            FacetKind::Inner => {}
        }
    }
    facets
}

/// Frames for all cells, from those whose walls fix them on to their neighbors, layer by layer.
fn spread(cells: &[CellFacets], equivalents: &[Matrix3<f64>]) -> Vec<Rotation3<f64>> {
    let mut frames: Vec<Option<Rotation3<f64>>> = vec![None; cells.len()];
    let mut layer: Vec<usize> = (0..cells.len()).filter(|&c| is_fixed(&cells[c])).collect();
    if layer.is_empty() {
        layer = (0..cells.len())
            .find(|&c| !cells[c].walls.is_empty())
            .into_iter()
            .collect();
    }
    while !layer.is_empty() {
        let known = |site: u32| frames[site as usize].as_ref();
        let found: Vec<_> = layer
            .iter()
            .map(|&cell| {
                let nearest = cells[cell].neighbors.iter();
                let nearest = nearest
                    .filter(|(site, _)| known(*site).is_some())
                    .max_by(|a, b| a.1.total_cmp(&b.1));
                let start = nearest.and_then(|(site, _)| known(*site));
                let start = start.copied().unwrap_or_else(|| aligned(&cells[cell]));
                (cell, step(&cells[cell], &start, known, equivalents))
            })
            .collect();
        let mut next = Vec::new();
        for (cell, frame) in found {
            frames[cell] = Some(frame);
            next.extend(cells[cell].neighbors.iter().map(|(site, _)| *site as usize));
        }
        next.sort_unstable();
        next.dedup();
        next.retain(|&cell| frames[cell].is_none());
        layer = next;
    }
    let or_axes = |frame: Option<Rotation3<f64>>| frame.unwrap_or_default();
    frames.into_iter().map(or_axes).collect()
}

/// Whether the walls of a cell have more than one direction.
fn is_fixed(cell: &CellFacets) -> bool {
    let Some(main) = main_wall(cell) else {
        return false;
    };
    let unit = main.normalize();
    let all: f64 = cell.walls.iter().map(Vector3::norm).sum();
    let others = cell.walls.iter();
    let others = others.filter(|wall| wall.dot(&unit).abs() < CREASE.1 * wall.norm());
    others.map(Vector3::norm).sum::<f64>() > CREASE.0 * all
}

fn main_wall(cell: &CellFacets) -> Option<&Vector3<f64>> {
    cell.walls
        .iter()
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
}

/// The smallest rotation from the axes of space that aligns one of them with the main wall, then the
/// smallest about that one that aligns another with the wall most nearly at right angles to it.
fn aligned(cell: &CellFacets) -> Rotation3<f64> {
    let Some(main) = main_wall(cell).map(Vector3::normalize) else {
        return Rotation3::identity();
    };
    let first = toward(&Rotation3::identity(), &main);
    let across = |wall: &Vector3<f64>| wall - main * wall.dot(&main);
    let second = cell
        .walls
        .iter()
        .map(across)
        .max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()));
    match second {
        Some(second) if second.norm() > CREASE.0 * main_wall(cell).map_or(0.0, Vector3::norm) => {
            toward(&first, &second.normalize())
        }
        _ => first,
    }
}

/// `frame` turned by the smallest angle that brings one of its axes onto ± the unit vector.
fn toward(frame: &Rotation3<f64>, unit: &Vector3<f64>) -> Rotation3<f64> {
    let axis = nearest_axis(frame, unit);
    let around = axis.cross(unit);
    let sine = around.norm();
    // The angle by both sine and cosine: of nearly equal directions rounding lifts the cosine past 1.
    let angle = sine.atan2(axis.dot(unit));
    match Unit::try_new(around, f64::EPSILON) {
        Some(around) => Rotation3::from_axis_angle(&around, angle) * frame,
        None => *frame,
    }
}

/// The one of the frame's six directions that is nearest to a vector.
fn nearest_axis(frame: &Rotation3<f64>, vector: &Vector3<f64>) -> Vector3<f64> {
    let in_frame = frame.inverse() * vector;
    let axis = in_frame.iamax();
    let mut direction = Vector3::zeros();
    direction[axis] = in_frame[axis].signum();
    frame * direction
}

/// The frame of a cell that follows from its walls and the frames known around it.
fn step<'a>(
    cell: &CellFacets,
    own: &Rotation3<f64>,
    known: impl Fn(u32) -> Option<&'a Rotation3<f64>>,
    equivalents: &[Matrix3<f64>],
) -> Rotation3<f64> {
    let (mut sum, mut weight) = (Matrix3::zeros(), 0.0);
    for &(site, area) in &cell.neighbors {
        if let Some(other) = known(site) {
            sum += nearest_equivalent(other, own, equivalents) * area;
            weight += area;
        }
    }
    // The present frame decides where neighbors and walls leave a rotation free.
    sum += own.matrix() * (if weight > 0.0 { 1e-3 * weight } else { 1.0 });
    let scale = WALL_WEIGHT * if weight > 0.0 { weight } else { 1.0 };
    let all: f64 = cell.walls.iter().map(Vector3::norm).sum();
    for wall in &cell.walls {
        let axis = own.inverse() * nearest_axis(own, wall);
        sum += wall * axis.transpose() * (scale / all);
    }
    rotation_of(&sum).unwrap_or(*own)
}

/// The equivalent of `other` nearest to `own`.
fn nearest_equivalent(
    other: &Rotation3<f64>,
    own: &Rotation3<f64>,
    equivalents: &[Matrix3<f64>],
) -> Matrix3<f64> {
    let between = own.inverse() * other;
    let likeness = |turn: &&Matrix3<f64>| (between.matrix() * *turn).trace();
    let best = equivalents
        .iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.map_or(*other.matrix(), |turn| other.matrix() * turn)
}

/// The 24 rotations that map the cube onto itself.
fn equivalents() -> Vec<Matrix3<f64>> {
    let mut all = Vec::with_capacity(24);
    for first in 0..3 {
        for second in (0..3).filter(|&second| second != first) {
            for signs in 0..4 {
                let sign = |bit: usize| if signs >> bit & 1 == 1 { -1.0 } else { 1.0 };
                let (x, y) = (Vector3::ith(first, sign(0)), Vector3::ith(second, sign(1)));
                all.push(Matrix3::from_columns(&[x, y, x.cross(&y)]));
            }
        }
    }
    all
}

/// The rotation nearest to a matrix; none if it is singular.
fn rotation_of(matrix: &Matrix3<f64>) -> Option<Rotation3<f64>> {
    let svd = matrix.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut signs = Vector3::new(1.0, 1.0, (u * v_t).determinant().signum());
    let least = svd.singular_values.imin();
    signs.swap_rows(2, least);
    let rotation = u * Matrix3::from_diagonal(&signs) * v_t;
    let is_whole = rotation.iter().all(|entry| entry.is_finite());
    is_whole.then(|| Rotation3::from_matrix_unchecked(rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Walls 45° off the axes, whose directions after the first turn are an axis but for rounding: in one
    /// such cell of a model the cosine of the second turn was 1 + 2⁻⁵² and the frame not a number.
    #[test]
    fn walls_at_right_angles_give_rotations_whatever_the_rounding() {
        for number in 0..2000_u32 {
            let angle = f64::from(number) * 0.0123;
            let tilt = Rotation3::from_euler_angles(0.3 * angle, angle, 0.7 * angle);
            let wall = |x: f64, y: f64, z: f64| tilt * Vector3::new(x, y, z);
            let size = 1e-3 * f64::from(number + 1);
            let cell = CellFacets {
                neighbors: Vec::new(),
                walls: vec![
                    wall(size, 0.0, size),
                    wall(-0.1 * size, 1e-19, 0.100_000_1 * size),
                ],
            };
            let frame = aligned(&cell);
            let off = (frame.matrix() * frame.matrix().transpose() - Matrix3::identity()).norm();
            assert!(off < 1e-12, "{number}: {frame}");
            for wall in &cell.walls {
                let along = (frame.inverse() * wall.normalize()).amax();
                assert!(along > 1.0 - 1e-9, "{number}: {along}");
            }
        }
    }

    #[test]
    fn the_cube_has_twenty_four_rotations() {
        let all = equivalents();
        assert_eq!(all.len(), 24);
        for (number, one) in all.iter().enumerate() {
            assert!((one.determinant() - 1.0).abs() < 1e-15);
            assert!(all[..number].iter().all(|other| (one - other).norm() > 1.0));
        }
    }

    #[test]
    fn equivalent_frames_average_to_themselves() {
        let frame = Rotation3::from_euler_angles(0.3, -0.2, 0.9);
        for turn in equivalents() {
            let other = Rotation3::from_matrix_unchecked(frame.matrix() * turn);
            let found = nearest_equivalent(&other, &frame, &equivalents());
            assert!((found - frame.matrix()).norm() < 1e-14);
        }
    }

    #[test]
    fn the_nearest_rotation_of_a_scaled_one_is_that_one() {
        let frame = Rotation3::from_euler_angles(-1.1, 0.4, 2.0);
        let found = rotation_of(&(frame.matrix() * 3.0)).expect("regular");
        assert!((found.matrix() - frame.matrix()).norm() < 1e-14);
    }
}
