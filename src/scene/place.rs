//! From a scene's `sites` to points: drawn at random, on a grid, listed or read, then checked.
//!
//! Random sites are uniform over the domain, by rejection from its bounding box or, where the domain
//! is too thin for that, from boxes or triangles close about it. A grid's box is
//! the bounding box; grid cell (i, j, k) has its middle at min + ((i, j, k) + 1/2) · spacing, and a
//! site is uniform in the box about the middle that is `jitter` grid cells wide. The last axis runs
//! fastest. Sites that are not finite, outside the domain, or two at one place have no diagram.

use std::cmp::Ordering;
use std::fmt;
use std::sync::atomic;

use nalgebra::{Point, Point3, Rotation3, SVector};

use crate::domain::domain::Domain;
use crate::domain::planar::PlaneDomain;
use crate::domain::random_points::{source_in_plane, source_in_solid};
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::random::{PointSource, Random, points_inside};
use crate::parallel::{RUN, map, map_runs};
use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::frames::FrameChoice;
use crate::scene::memory;
use crate::scene::numbers::point;
use crate::scene::site_file;
use crate::scene::sites::{Grid, Random as RandomSites, Sites};
use crate::scene::turned_lattice::turned_lattice;
use crate::voronoi::diagram::StopFlag;

/// Makes a source of points closer to a domain than its bounding box is, if there is one.
type Closer<'a, const D: usize> = Box<dyn Fn() -> Option<PointSource<'static, D>> + Sync + 'a>;

/// Lists the vertices of a domain's boundary; none in the plane.
type Vertices<'a> = Box<dyn Fn() -> Vec<Point3<f64>> + Sync + 'a>;

/// Says whether a point lies in a closed domain.
pub type Contains<'a, const D: usize> = Box<dyn Fn(&Point<f64, D>) -> bool + Sync + 'a>;

/// The part of a domain that sites are placed in and checked against.
pub struct SiteRegion<'a, const D: usize> {
    /// The domain's bounding box.
    pub bounds: Bounds<D>,
    /// Along which axes the domain repeats itself.
    pub periodic: [bool; D],
    /// Whether the closed domain holds a point.
    pub contains: Contains<'a, D>,
    /// The domain's volume; none where it fills its bounding box.
    pub(crate) volume: Option<f64>,
    /// For domains that fill next to nothing of their bounding box.
    pub(crate) closer: Closer<'a, D>,
    /// The vertices of the domain's boundary.
    pub(crate) vertices: Vertices<'a>,
    /// Ends checks early: they then refuse nothing, and what stands on them ends as well.
    pub(crate) stop: StopFlag,
}

impl<const D: usize> SiteRegion<'_, D> {
    /// The box `bounds` itself.
    #[must_use]
    pub fn of_box(bounds: Bounds<D>, periodic: [bool; D]) -> Self {
        Self {
            bounds,
            periodic,
            contains: Box::new(move |point| bounds.contains(point)),
            volume: None,
            closer: Box::new(|| None),
            vertices: Box::new(Vec::new),
            stop: None,
        }
    }

    /// The region of a domain in space.
    #[must_use]
    pub fn of_solid(domain: &dyn Domain) -> SiteRegion<'_, 3> {
        SiteRegion {
            bounds: domain.bounds(),
            periodic: domain.periods().map(|period| period.is_some()),
            contains: Box::new(|point| domain.contains(point)),
            volume: (!domain.is_box()).then(|| domain.volume()),
            closer: Box::new(|| source_in_solid(domain.shape())),
            vertices: Box::new(|| vertices_of(domain.shape())),
            stop: None,
        }
    }

    /// The region of a domain in the plane.
    #[must_use]
    pub fn of_plane(domain: &PlaneDomain) -> SiteRegion<'_, 2> {
        SiteRegion {
            bounds: domain.bounds(),
            periodic: domain.periods().map(|period| period.is_some()),
            contains: Box::new(|point| domain.contains(point)),
            volume: None,
            closer: Box::new(|| source_in_plane(domain)),
            vertices: Box::new(Vec::new),
            stop: None,
        }
    }

    /// Whether the domain holds `point`.
    #[must_use]
    pub fn holds(&self, point: &Point<f64, D>) -> bool {
        (self.contains)(point)
    }

    fn is_stopped(&self) -> bool {
        let stop = self.stop.as_ref();
        stop.is_some_and(|stop| stop.load(atomic::Ordering::Relaxed))
    }

    /// The image of `point` on the lower wall where it lies on the upper wall of a periodic axis.
    #[must_use]
    pub fn canonical(&self, point: &Point<f64, D>) -> Point<f64, D> {
        let mut image = *point;
        for axis in 0..D {
            if self.periodic[axis] && image[axis] >= self.bounds.max[axis] {
                image[axis] = self.bounds.min[axis];
            }
        }
        image
    }
}

impl<const D: usize> fmt::Debug for SiteRegion<'_, D> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Region")
            .field("bounds", &self.bounds)
            .field("periodic", &self.periodic)
            .finish_non_exhaustive()
    }
}

/// Sites where they are placed, and what there is to say about them.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedSites<const D: usize> {
    /// The sites in their order, each finite, in the region, and alone at its place.
    pub sites: Vec<Point<f64, D>>,
    /// How many outside the region are left out.
    pub dropped: usize,
    /// One sentence each.
    pub notes: Vec<String>,
}

/// The points that the scene's `sites` names. With its `drop_outside`, those outside the region are
/// left out.
///
/// # Errors
/// When a site file cannot be read, or [`check()`] refuses a point.
pub fn place<const D: usize>(
    scene: &Scene,
    region: &SiteRegion<'_, D>,
) -> Result<PlacedSites<D>, Error> {
    let (mut sites, mut notes): (Vec<Point<f64, D>>, _) = match &scene.sites {
        Sites::Random(random) => {
            let turn = scene.frames.as_ref().and_then(FrameChoice::of_all);
            (random_or_lattice(random, turn, region)?, Vec::new())
        }
        Sites::Grid(grid) => (grid_sites(grid, region)?, Vec::new()),
        Sites::List(list) => (list.iter().map(|row| point(row)).collect(), Vec::new()),
        Sites::File(path) => {
            let file = site_file::read_as(path, scene.sites_format)?;
            (file.sites, file.notes)
        }
        Sites::Given(numbers) => (numbers.chunks_exact(D).map(point).collect(), Vec::new()),
    };
    let all = sites.len();
    if scene.drop_outside {
        sites.retain(|point| region.holds(point));
        if sites.is_empty() {
            return Err(Error::AllOutside);
        }
    }
    let dropped = all - sites.len();
    if dropped > 0 {
        notes.push(format!(
            "{dropped} of {all} sites lie outside the domain and are left out"
        ));
    }
    check(&sites, region)?;
    Ok(PlacedSites {
        sites,
        dropped,
        notes,
    })
}

/// Vertices of the convex hull of a domain, and perhaps others.
fn vertices_of(domain: &dyn DomainShape) -> Vec<Point3<f64>> {
    if let Some(surface) = domain.surface_mesh() {
        return surface.vertices.clone();
    }
    let mut vertices: Vec<_> = domain.boundary().into_iter().flatten().collect();
    if vertices.is_empty() {
        let Bounds { min, max } = domain.bounds();
        vertices.extend((0..8).map(|number| {
            Point3::from(SVector::from_fn(|axis, _| {
                [min, max][number >> axis & 1][axis]
            }))
        }));
    }
    vertices
}

/// The rounded counts of edges along the sides of the region's box.
fn sides<const D: usize>(edge: f64, region: &SiteRegion<'_, D>) -> [f64; D] {
    let extent = region.bounds.extent();
    std::array::from_fn(|axis| (extent[axis] / edge).round().max(1.0))
}

/// Random sites, or those of a lattice along the axes of the cells' one frame: as many as asked for, or as cubes of
/// an edge fill the domain.
///
/// # Errors
/// [`Error::TooManySites`] for more than memory holds, [`Error::NoRoom`], [`Error::EmptyGrid`].
fn random_or_lattice<const D: usize>(
    random: &RandomSites,
    turn: Option<Rotation3<f64>>,
    region: &SiteRegion<'_, D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let volume = region.volume.unwrap_or(region.bounds.extent().product());
    let edge = match (random.edge, random.count) {
        (Some(edge), _) => edge,
        (None, count) => (volume / count.unwrap_or(1) as f64).powf(1.0 / D as f64),
    };
    let sides = sides(edge, region);
    let in_box: f64 = sides.iter().product();
    if random.lattice {
        memory::check(in_box as u64)?;
        if let Some(turn) = turn {
            let sites = turned_lattice(&(region.vertices)(), edge, turn);
            let sites = sites.map(|site| Point::from(SVector::from_fn(|axis, _| site[axis])));
            let held: Vec<Point<f64, D>> = sites.filter(|site| region.holds(site)).collect();
            return if held.is_empty() {
                Err(Error::EmptyGrid)
            } else {
                Ok(held)
            };
        }
        let counts = sides.map(|count| count as usize).to_vec();
        let (jitter, seed) = (0.0, random.seed);
        return grid_sites(
            &Grid {
                counts,
                jitter,
                seed,
            },
            region,
        );
    }
    let of_edge = match region.volume {
        Some(volume) => (volume / edge.powi(D as i32)).round().max(1.0),
        None => in_box,
    };
    memory::check(random.count.map_or(of_edge as u64, |count| count as u64))?;
    random_sites(
        random.count.unwrap_or(of_edge as usize),
        random.seed,
        region,
    )
}

/// `count` sites uniform over the region, by rejection from its bounding box or from closer about it.
///
/// # Errors
/// [`Error::NoRoom`] when the region fills next to nothing of either.
fn random_sites<const D: usize>(
    count: usize,
    seed: u64,
    region: &SiteRegion<'_, D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let holds = |point: &Point<f64, D>| region.holds(point);
    points_inside(count, seed, &region.bounds, holds, || (region.closer)())
        .map_err(|draws| Error::NoRoom { draws })
}

/// The grid's sites that the region holds.
///
/// # Errors
/// [`Error::EmptyGrid`] when there is none.
fn grid_sites<const D: usize>(
    grid: &Grid,
    region: &SiteRegion<'_, D>,
) -> Result<Vec<Point<f64, D>>, Error> {
    let mut uniform = Random::new(grid.seed);
    let mut sites = Vec::new();
    let mut at = [0; D];
    loop {
        let site = jittered(&at, grid, region, &mut uniform);
        if region.holds(&site) {
            sites.push(site);
        }
        if !advance(&mut at, &grid.counts) {
            break;
        }
    }
    if sites.is_empty() {
        return Err(Error::EmptyGrid);
    }
    Ok(sites)
}

fn jittered<const D: usize>(
    at: &[usize; D],
    grid: &Grid,
    region: &SiteRegion<'_, D>,
    uniform: &mut Random,
) -> Point<f64, D> {
    let extent = region.bounds.extent();
    let mut site = region.bounds.min;
    for axis in 0..D {
        let shift = grid.jitter * (uniform.uniform() - 0.5);
        let steps = at[axis] as f64 + 0.5 + shift;
        site[axis] += steps * extent[axis] / grid.counts[axis] as f64;
    }
    region.bounds.clamp(&site)
}

/// The next grid cell; false after the last.
fn advance<const D: usize>(at: &mut [usize; D], counts: &[usize]) -> bool {
    for axis in (0..D).rev() {
        at[axis] += 1;
        if at[axis] < counts[axis] {
            return true;
        }
        at[axis] = 0;
    }
    false
}

/// Refuses sites that have no diagram.
///
/// # Errors
/// [`Error::NotFinite`], [`Error::Outside`] or [`Error::Duplicate`], in that order, with the
/// lowest index and the number of further ones.
pub fn check<const D: usize>(
    sites: &[Point<f64, D>],
    region: &SiteRegion<'_, D>,
) -> Result<(), Error> {
    finite(sites)?;
    inside(sites, region)?;
    distinct(sites, region)
}

/// Refuses a part of some sites, which begins with number `first`, if one is not in the region.
///
/// # Errors
/// [`Error::Outside`], which counts those of the part.
pub(crate) fn check_part<const D: usize>(
    sites: &[Point<f64, D>],
    first: usize,
    region: &SiteRegion<'_, D>,
) -> Result<(), Error> {
    inside(sites, region).map_err(|error| match error {
        Error::Outside {
            index,
            point,
            others,
        } => Error::Outside {
            index: first + index,
            point,
            others,
        },
        other => other,
    })
}

/// The refusal of two sites in one place.
pub(crate) fn twins<const D: usize>([first, second]: [u64; 2], point: &Point<f64, D>) -> Error {
    Error::Duplicate {
        first: first as usize,
        second: second as usize,
        point: shown(point),
        others: 0,
    }
}

/// A point as messages show it: `(0.5, 0.25, 1.0)`.
fn shown<const D: usize>(point: &Point<f64, D>) -> String {
    let numbers: Vec<String> = point.iter().map(|value| format!("{value:?}")).collect();
    format!("({})", numbers.join(", "))
}

fn finite<const D: usize>(sites: &[Point<f64, D>]) -> Result<(), Error> {
    let strange = |site: &Point<f64, D>| site.iter().any(|value| !value.is_finite());
    match sites.iter().position(strange) {
        Some(index) => Err(Error::NotFinite {
            index,
            point: shown(&sites[index]),
        }),
        None => Ok(()),
    }
}

fn inside<const D: usize>(
    sites: &[Point<f64, D>],
    region: &SiteRegion<'_, D>,
) -> Result<(), Error> {
    let strays = map_runs(sites.len(), RUN, |run| {
        let of_run = if region.is_stopped() { 0..0 } else { run };
        let mut strays = of_run.filter(|&index| !region.holds(&sites[index]));
        strays.next().map(|first| (first, strays.count()))
    });
    let mut strays = strays.into_iter().flatten();
    match strays.next() {
        Some((index, others)) => Err(Error::Outside {
            index,
            point: shown(&sites[index]),
            others: others + strays.map(|(_, others)| 1 + others).sum::<usize>(),
        }),
        None => Ok(()),
    }
}

/// About so many sites are compared by one task.
const SITES_PER_BUCKET: usize = 1 << 16;

/// The most tasks: each reads what all sites' coordinates mix to.
const MOST_BUCKETS: usize = 256;

fn distinct<const D: usize>(
    sites: &[Point<f64, D>],
    region: &SiteRegion<'_, D>,
) -> Result<(), Error> {
    let key = |index: usize| region.canonical(&sites[index]);
    let mixed = map(sites.len(), &|index| mixed(&key(index)));
    let buckets = sites.len().div_ceil(SITES_PER_BUCKET).min(MOST_BUCKETS);
    let pairs = map(buckets, &|bucket| {
        let is_mine = |&index: &usize| mixed[index] % buckets as u64 == bucket as u64;
        let mut mine: Vec<usize> = if region.is_stopped() {
            Vec::new()
        } else {
            (0..sites.len()).filter(is_mine).collect()
        };
        mine.sort_unstable_by(|&a, &b| {
            let order = mixed[a].cmp(&mixed[b]);
            let order = order.then_with(|| lexicographic(&key(a), &key(b)));
            order.then(a.cmp(&b))
        });
        let is_twin = |&[a, b]: &[usize; 2]| {
            mixed[a] == mixed[b] && lexicographic(&key(a), &key(b)) == Ordering::Equal
        };
        let pairs = mine.windows(2).map(|pair| [pair[0], pair[1]]);
        pairs.filter(is_twin).collect::<Vec<_>>()
    })
    .concat();
    match pairs.iter().min_by_key(|pair| pair[1]) {
        Some(&[first, second]) => Err(Error::Duplicate {
            first,
            second,
            point: shown(&sites[second]),
            others: pairs.len() - 1,
        }),
        None => Ok(()),
    }
}

/// The same number for equal points, different ones for nearly all others (Steele, Lea & Flood, *Fast splittable
/// pseudorandom number generators*, 2014).
fn mixed<const D: usize>(point: &Point<f64, D>) -> u64 {
    point.iter().fold(0, |sum, value| {
        // −0 becomes 0.
        let mut bits = sum ^ (value + 0.0).to_bits();
        bits = bits.wrapping_add(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    })
}

/// Compares finite points axis by axis; −0 equals 0.
fn lexicographic<const D: usize>(a: &Point<f64, D>, b: &Point<f64, D>) -> Ordering {
    let axes = a.iter().zip(b.iter());
    axes.fold(Ordering::Equal, |order, (a, b)| {
        order.then_with(|| a.partial_cmp(b).unwrap_or(Ordering::Equal))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point2, Point3};
    fn cube() -> Bounds<3> {
        Bounds {
            min: Point3::new(0.0, 0.0, 0.0),
            max: Point3::new(1.0, 1.0, 1.0),
        }
    }

    #[test]
    fn a_seed_keeps_its_sites() {
        let region = SiteRegion::of_box(cube(), [false; 3]);
        let first = random_sites(2, 1, &region).expect("a cube has room");
        assert_eq!(first, random_sites(2, 1, &region).expect("a cube has room"));
        assert_ne!(first, random_sites(2, 2, &region).expect("a cube has room"));
        assert_eq!(
            format!("{:?}", first[0]),
            PINNED,
            "written down once, on x86-64"
        );
    }

    const PINNED: &str = "[0.40248566366484806, 0.08038370892978197, 0.5965601809348549]";

    #[test]
    fn rejection_keeps_to_the_region() {
        let triangle = |point: &Point2<f64>| point.x + point.y <= 1.0;
        let region = SiteRegion {
            bounds: Bounds {
                min: Point2::new(0.0, 0.0),
                max: Point2::new(1.0, 1.0),
            },
            periodic: [false; 2],
            contains: Box::new(triangle),
            volume: None,
            closer: Box::new(|| None),
            vertices: Box::new(Vec::new),
            stop: None,
        };
        let sites = random_sites(500, 1, &region).expect("half of the square is room");
        assert_eq!(sites.len(), 500);
        assert!(sites.iter().all(triangle));
    }

    #[test]
    fn a_region_without_room_is_refused() {
        let region = SiteRegion {
            contains: Box::new(|_| false),
            ..SiteRegion::of_box(cube(), [false; 3])
        };
        assert!(matches!(
            random_sites(1, 1, &region),
            Err(Error::NoRoom { .. })
        ));
    }

    fn region() -> SiteRegion<'static, 2> {
        let bounds = Bounds {
            min: Point2::new(0.0, 1.0),
            max: Point2::new(2.0, 2.0),
        };
        SiteRegion::of_box(bounds, [false; 2])
    }

    fn grid(jitter: f64) -> Grid {
        Grid {
            counts: vec![2, 2],
            jitter,
            seed: 1,
        }
    }

    #[test]
    fn without_jitter_sites_stand_in_the_middle() {
        let sites = grid_sites(&grid(0.0), &region()).expect("a box holds its grid");
        let expected = [[0.5, 1.25], [0.5, 1.75], [1.5, 1.25], [1.5, 1.75]];
        assert_eq!(sites, expected.map(Point2::from));
    }

    #[test]
    fn jitter_is_the_width_of_the_spread() {
        let exact = grid_sites(&grid(0.0), &region()).expect("a box holds its grid");
        let moved = grid_sites(&grid(0.5), &region()).expect("a box holds its grid");
        for (from, to) in exact.iter().zip(&moved) {
            let step = to - from;
            assert!(step.x.abs() <= 0.25 && step.y.abs() <= 0.125, "{step}");
            assert!(step.x != 0.0 && step.y != 0.0);
        }
    }

    #[test]
    fn the_grid_is_cropped_to_the_region() {
        let left = SiteRegion {
            contains: Box::new(|point: &Point2<f64>| point.x < 1.0),
            ..region()
        };
        assert_eq!(grid_sites(&grid(0.0), &left).expect("two remain").len(), 2);
        let nothing = SiteRegion {
            contains: Box::new(|_| false),
            ..region()
        };
        assert!(matches!(
            grid_sites(&grid(0.0), &nothing),
            Err(Error::EmptyGrid)
        ));
    }

    fn checked(points: &[[f64; 2]], periodic: bool) -> Result<(), Error> {
        let bounds = Bounds {
            min: Point2::new(0.0, 0.0),
            max: Point2::new(1.0, 1.0),
        };
        let points: Vec<Point2<f64>> = points.iter().copied().map(Point2::from).collect();
        check(&points, &SiteRegion::of_box(bounds, [periodic, false]))
    }

    #[test]
    fn good_sites_pass() {
        checked(&[[0.0, 0.0], [1.0, 0.0], [0.5, 1.0]], false).expect("walls belong to the box");
    }

    #[test]
    fn duplicates_are_named_by_both_indices() {
        let points = [[0.5, 0.5], [0.1, 0.2], [0.3, 0.0], [0.1, 0.2], [0.3, -0.0]];
        let error = checked(&points, false).unwrap_err().to_string();
        assert_eq!(
            error,
            "sites 1 and 3 are at the same place (0.1, 0.2) (and 1 more such sites); \
             remove one of them"
        );
    }

    #[test]
    fn opposite_walls_of_a_periodic_axis_are_one_place() {
        let points = [[0.0, 0.5], [1.0, 0.5]];
        checked(&points, false).expect("two walls");
        let error = checked(&points, true).unwrap_err();
        assert!(
            matches!(
                error,
                Error::Duplicate {
                    first: 0,
                    second: 1,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn strays_are_named_by_index_and_point() {
        let error = checked(&[[0.5, 0.5], [1.5, 0.2], [-1.0, 0.0]], false).unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("site 1 (1.5, 0.2) lies outside the domain (and 1 more"),
            "{text}"
        );
    }

    #[test]
    fn strange_numbers_are_refused() {
        let error = checked(&[[0.5, 0.5], [f64::NAN, 0.2]], false).unwrap_err();
        assert_eq!(error.to_string(), "site 1 (NaN, 0.2) is not finite");
        assert!(checked(&[[f64::INFINITY, 0.2]], false).is_err());
    }
}
