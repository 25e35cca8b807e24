//! The convex polyhedron given by half-spaces, as a domain.

use nalgebra::{Point3, Vector3};

use crate::domain::error::DomainError;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;

/// The half side of the cube that half-spaces are first cut from, relative to the farthest plane's
/// distance from the origin: half-spaces whose intersection reaches farther count as unbounded. Two planes that meet
/// at an angle of 1e-6 still bound.
const REACH: f64 = 1e6;

/// How often the solid is cut again from a box about its own bounds: the first result is exact to
/// `REACH` roundings, the second to a few.
const REFITS: usize = 2;

/// How far a point may lie beyond a wall, relative to the size of the numbers, and still count as
/// on it: a few roundings of n·y − d.
const ON_WALL: f64 = 8.0 * f64::EPSILON;

/// A bounded intersection of half-spaces.
///
/// # Examples
/// ```
/// use chebloyd::{ConvexPolyhedron, DomainShape, HalfSpace};
///
/// let signs = (0..8).map(|n| [0, 1, 2].map(|axis| if n >> axis & 1 == 1 { -1.0 } else { 1.0 }));
/// let walls: Vec<_> = signs.map(|normal| HalfSpace { normal: normal.into(), offset: 1.0 }).collect();
/// let octahedron = ConvexPolyhedron::new(&walls)?;
/// assert!((octahedron.volume() - 4.0 / 3.0).abs() < 1e-14);
/// # Ok::<(), chebloyd::DomainError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ConvexPolyhedron {
    half_spaces: Vec<HalfSpace>,
    solid: Polyhedron,
    bounds: Bounds<3>,
    volume: f64,
}

impl ConvexPolyhedron {
    /// The intersection of `half_spaces`; wall numbers are places in that list.
    ///
    /// # Errors
    /// When a number is not finite, a normal is zero, or the intersection is unbounded or has no
    /// interior.
    pub fn new(half_spaces: &[HalfSpace]) -> Result<Self, DomainError> {
        let walls = normalized(half_spaces)?;
        let solid = refitted_intersection(&walls)?;
        let volume = solid.moments().mass;
        let bounds = solid.bounds();
        if volume.is_nan() || volume <= bounds.volume() * f64::EPSILON {
            return Err(DomainError::NoVolume { volume });
        }
        Ok(Self {
            half_spaces: walls,
            solid,
            bounds,
            volume,
        })
    }

    /// The domain itself as a polyhedron.
    #[must_use]
    pub fn solid(&self) -> &Polyhedron {
        &self.solid
    }
}

/// The walls' intersection, cut from a box about itself: vertices carry the rounding of the box that
/// they were cut from.
fn refitted_intersection(walls: &[HalfSpace]) -> Result<Polyhedron, DomainError> {
    let offsets = walls.iter().map(|wall| wall.offset.abs());
    let corner = Point3::from([offsets.fold(1.0, f64::max) * REACH; 3]);
    let around = Bounds {
        min: -corner,
        max: corner,
    };
    let mut solid = intersection(walls, &around)?;
    for _ in 0..REFITS {
        let fit = solid.bounds();
        solid = intersection(walls, &fit.grown(&(0.5 * fit.extent())))?;
    }
    Ok(solid)
}

/// The walls' intersection within a box, no side of which may be left in it.
fn intersection(walls: &[HalfSpace], around: &Bounds<3>) -> Result<Polyhedron, DomainError> {
    let mut solid = Polyhedron::cuboid(around, [FacetKind::Inner.label(); 6]);
    let mut scratch = ClipScratch::default();
    for (number, wall) in walls.iter().enumerate() {
        let label = FacetKind::Wall(number as u32).label();
        if clip(&mut solid, wall, label, &mut scratch) == Clip::Emptied {
            return Err(DomainError::NoInterior { number });
        }
    }
    let open = solid
        .facets()
        .find(|facet| FacetKind::of(facet.label()) == FacetKind::Inner);
    if let Some(open) = open {
        let direction = open.half_space().normal.into();
        let count = walls.len();
        return Err(DomainError::Unbounded { count, direction });
    }
    Ok(solid)
}

fn normalized(half_spaces: &[HalfSpace]) -> Result<Vec<HalfSpace>, DomainError> {
    let check = |(number, wall): (usize, &HalfSpace)| {
        let numbers = wall.normal.iter().chain([&wall.offset]);
        if let Some(&value) = numbers.clone().find(|value| !value.is_finite()) {
            return Err(DomainError::NotFinite { value });
        }
        if wall.normal.norm() <= 0.0 {
            return Err(DomainError::NoNormal { number });
        }
        Ok(wall.normalized())
    };
    half_spaces.iter().enumerate().map(check).collect()
}

impl DomainShape for ConvexPolyhedron {
    fn bounds(&self) -> Bounds<3> {
        self.bounds
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        let scale = point.coords.amax();
        self.half_spaces
            .iter()
            .all(|wall| wall.excess(point) <= ON_WALL * (scale + wall.offset.abs()))
    }

    fn boundary(&self) -> Vec<[Point3<f64>; 3]> {
        let mut triangles = Vec::new();
        for facet in self.solid.facets() {
            let corners: Vec<Point3<f64>> = facet.corners().collect();
            triangles.extend(
                corners[1..]
                    .windows(2)
                    .map(|pair| [corners[0], pair[0], pair[1]]),
            );
        }
        triangles
    }

    fn start(&self, site: &Point3<f64>, _index: u32, cell: &mut Polyhedron) {
        cell.assign_translated(&self.solid, &-site.coords);
    }

    fn wall_ahead(&self, site: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let ahead = self.half_spaces.iter().filter_map(|wall| {
            let (climb, room) = (wall.normal.dot(step), (-wall.excess(site)).max(0.0));
            (climb > room).then(|| (room / climb, wall.normal))
        });
        ahead.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}
