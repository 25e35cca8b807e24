//! The convex polyhedron given by half-spaces, as a domain.

use nalgebra::{Point3, Vector3};

use crate::domain::error::{DomainError, check_digits};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;

/// Half sides of the cubes that half-spaces are cut from one after the other, relative to the farthest
/// plane's distance from the origin, until one holds the whole solid: each loses the digits of its size.
/// Half-spaces whose intersection reaches farther than the last count as unbounded. Two planes that meet
/// at an angle of 1e-6 still bound.
const REACHES: [f64; 3] = [2.0, 1e3, 1e6];

/// How often the solid is cut again, from a box about its own bounds and in coordinates about its own
/// middle: the first result is exact to the reach's roundings, the second to a few.
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
    /// Relative to `middle`.
    solid: Polyhedron,
    middle: Point3<f64>,
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
        let (solid, middle) = refitted_intersection(&walls)?;
        let volume = solid.moments().mass;
        if !volume.is_normal() || volume <= solid.bounds().volume() * f64::EPSILON {
            return Err(DomainError::NoVolume { volume });
        }
        let bounds = solid.bounds().translated(&middle.coords);
        check_digits(&bounds)?;
        Ok(Self {
            half_spaces: walls,
            solid,
            middle,
            bounds,
            volume,
        })
    }

    /// The domain itself as a polyhedron.
    #[must_use]
    pub fn solid(&self) -> Polyhedron {
        let mut solid = Polyhedron::default();
        solid.assign_translated(&self.solid, &self.middle.coords);
        solid
    }
}

/// The walls' intersection relative to a point near its middle, and that point.
fn refitted_intersection(walls: &[HalfSpace]) -> Result<(Polyhedron, Point3<f64>), DomainError> {
    let mut solid = rough_intersection(walls)?;
    let mut middle = Point3::origin();
    for _ in 0..REFITS {
        let fit = solid.bounds();
        middle += fit.center().coords;
        let about = |wall: &HalfSpace| HalfSpace {
            normal: wall.normal,
            offset: wall.offset - wall.normal.dot(&middle.coords),
        };
        let walls: Vec<_> = walls.iter().map(about).collect();
        let reach = Point3::from(fit.extent());
        let around = Bounds {
            min: -reach,
            max: reach,
        };
        solid = intersection(&walls, &around)?;
    }
    Ok((solid, middle))
}

/// The walls' intersection, cut from the smallest cube that holds it.
fn rough_intersection(walls: &[HalfSpace]) -> Result<Polyhedron, DomainError> {
    let offsets = walls.iter().map(|wall| wall.offset.abs());
    let farthest = offsets.fold(0.0, f64::max);
    let farthest = if farthest > 0.0 { farthest } else { 1.0 };
    let [near, far, farther] = REACHES.map(|reach| {
        let corner = Point3::from([farthest * reach; 3]);
        Bounds {
            min: -corner,
            max: corner,
        }
    });
    intersection(walls, &near)
        .or_else(|_| intersection(walls, &far))
        .or_else(|_| intersection(walls, &farther))
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
            let corners = facet.corners().map(|corner| corner + self.middle.coords);
            let corners: Vec<Point3<f64>> = corners.collect();
            triangles.extend(
                corners[1..]
                    .windows(2)
                    .map(|pair| [corners[0], pair[0], pair[1]]),
            );
        }
        triangles
    }

    fn start(&self, site: &Point3<f64>, _index: u32, cell: &mut Polyhedron) {
        cell.assign_translated(&self.solid, &(self.middle - site));
    }

    fn wall_ahead(&self, site: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let ahead = self.half_spaces.iter().filter_map(|wall| {
            let (climb, room) = (wall.normal.dot(step), (-wall.excess(site)).max(0.0));
            (climb > room).then(|| (room / climb, wall.normal))
        });
        ahead.min_by(|a, b| a.0.total_cmp(&b.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    /// The box of these half extents about `center`, turned.
    fn turned_box(half: [f64; 3], center: &Point3<f64>, turn: &Rotation3<f64>) -> Vec<HalfSpace> {
        let sides = (0..6).map(|side: usize| {
            let mut normal = Vector3::zeros();
            normal[side / 2] = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
            let normal = turn * normal;
            HalfSpace {
                normal,
                offset: normal.dot(&center.coords) + half[side / 2],
            }
        });
        sides.collect()
    }

    #[test]
    fn half_spaces_near_each_other_bound_a_solid() {
        let turn = Rotation3::from_euler_angles(0.3, 0.5, 0.7);
        for thin in [1e-9, 1e-10, 1e-11] {
            for turn in [Rotation3::identity(), turn] {
                for center in [Point3::origin(), Point3::new(1.0, 0.5, 0.25)] {
                    let walls = turned_box([0.5, 0.5, 0.5 * thin], &center, &turn);
                    let slab = ConvexPolyhedron::new(&walls).expect("a slab");
                    let digits = 4.0 * f64::EPSILON / thin * center.coords.amax().max(1.0);
                    assert!(
                        (slab.volume() / thin - 1.0).abs() < digits,
                        "{thin}: {}",
                        slab.volume()
                    );
                    assert!(slab.contains(&center));
                }
            }
        }
        for scale in [1e-30, 1e-10, 1e10, 1e30] {
            let walls = turned_box([scale, 0.5 * scale, 0.25 * scale], &Point3::origin(), &turn);
            let solid = ConvexPolyhedron::new(&walls).expect("a box");
            assert!((solid.volume() / scale.powi(3) - 1.0).abs() < 1e-13);
        }
    }
}
