//! A tree of oriented boxes over the triangles of a surface, and the pairs that come near each other.
//!
//! Gottschalk, Lin & Manocha, *OBBTree: a hierarchical structure for rapid interference detection*,
//! 1996: around sheets that run close and parallel, oriented boxes part after a number of levels
//! that does not depend on how the sheets lie in space, while axis-aligned boxes of long diagonal
//! triangles all overlap. Triangles that meet in one corner (a fan) overlap there in any box: groups
//! of them are told apart by cones of directions from the corner. Both make the search for pairs
//! linear in practice.

use nalgebra::{Matrix3, Point3, SymmetricEigen, Vector3};

use crate::geometry::bounds::Bounds;
use crate::mesh::surface::SurfaceMesh;

/// Triangles per leaf: a test of boxes costs as much as those of several pairs of triangles.
const LEAF: usize = 6;

/// From so many triangles on, two halves are worth two threads.
const PARALLEL: usize = 4096;

/// Directions nearer than this (radians) to a cone count as within it.
const CONE_SLACK: f64 = 1e-6;

/// A group of triangles and how it is divided.
#[derive(Debug)]
pub(crate) struct TriangleTree {
    bounds: Bounds<3>,
    oriented: OrientedBox,
    fan: Option<Fan>,
    count: usize,
    content: Content,
}

#[derive(Debug)]
enum Content {
    Triangles(Vec<u32>),
    Halves(Box<[TriangleTree; 2]>),
}

/// A box along three perpendicular axes.
#[derive(Debug)]
struct OrientedBox {
    center: Point3<f64>,
    /// Unit vectors as columns.
    axes: Matrix3<f64>,
    /// Half the extents along them (L).
    half: Vector3<f64>,
}

/// The corner that all triangles share, and the cone of the directions from it to them.
#[derive(Debug)]
struct Fan {
    corner: u32,
    axis: Vector3<f64>,
    /// The cone's half opening (radians).
    opening: f64,
}

impl TriangleTree {
    /// The tree over `triangles` of `mesh`, which must not be empty.
    #[must_use]
    pub(crate) fn new(mesh: &SurfaceMesh, triangles: &mut [u32]) -> Self {
        let corners = || triangles.iter().flat_map(|&t| mesh.corners(t as usize));
        let mut bounds = Bounds::empty();
        corners().for_each(|corner| bounds.include(&corner));
        let oriented = OrientedBox::around(&bounds, corners);
        let fan = Fan::of(mesh, triangles);
        let count = triangles.len();
        let content = if count <= LEAF {
            Content::Triangles(triangles.to_vec())
        } else {
            let (low, high) = halve(mesh, &oriented.axes, triangles);
            let (low, high) = both(count, || Self::new(mesh, low), || Self::new(mesh, high));
            Content::Halves(Box::new([low, high]))
        };
        Self {
            bounds,
            oriented,
            fan,
            count,
            content,
        }
    }

    /// What `test` makes of the pairs of triangles whose groups come nearer than `slack` (L), in an
    /// order that depends on the tree only.
    pub(crate) fn pairs<T: Send>(
        &self,
        slack: f64,
        test: &(impl Fn(u32, u32) -> Option<T> + Sync),
    ) -> Vec<T> {
        let mut found = Vec::new();
        match &self.content {
            Content::Triangles(triangles) => {
                for (at, &one) in triangles.iter().enumerate() {
                    found.extend(triangles[at + 1..].iter().filter_map(|&t| test(one, t)));
                }
            }
            Content::Halves(halves) => {
                let [low, high] = &**halves;
                let within = |half: &Self| half.pairs(slack, test);
                let (in_low, in_high) = both(self.count, || within(low), || within(high));
                found.extend(in_low.into_iter().chain(in_high));
                found.extend(low.pairs_with(high, slack, test));
            }
        }
        found
    }

    fn pairs_with<T: Send>(
        &self,
        other: &Self,
        slack: f64,
        test: &(impl Fn(u32, u32) -> Option<T> + Sync),
    ) -> Vec<T> {
        if self.is_apart(other, slack) {
            return Vec::new();
        }
        let ([low, high], rest) = match (&self.content, &other.content) {
            (Content::Triangles(ours), Content::Triangles(theirs)) => {
                let pairs = ours
                    .iter()
                    .flat_map(|&a| theirs.iter().map(move |&b| [a, b]));
                return pairs.filter_map(|[a, b]| test(a, b)).collect();
            }
            (Content::Halves(halves), Content::Triangles(_)) => (&**halves, other),
            (Content::Halves(halves), Content::Halves(_)) if self.count >= other.count => {
                (&**halves, other)
            }
            (_, Content::Halves(halves)) => (&**halves, self),
        };
        let with_rest = |half: &Self| half.pairs_with(rest, slack, test);
        let count = self.count.min(other.count);
        let (mut found, more) = both(count, || with_rest(low), || with_rest(high));
        found.extend(more);
        found
    }

    fn is_apart(&self, other: &Self, slack: f64) -> bool {
        let grown = self.bounds.grown(&Vector3::repeat(slack));
        !grown.overlaps(&other.bounds)
            || self.oriented.is_apart(&other.oriented, slack)
            || (self.fan.as_ref().zip(other.fan.as_ref()))
                .is_some_and(|(one, two)| one.is_apart(two))
    }
}

/// Both results, by two threads where there is enough to do.
fn both<A: Send, B: Send>(
    count: usize,
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    if count > PARALLEL {
        rayon::join(one, other)
    } else {
        (one(), other())
    }
}

/// Splits triangles in two halves along the axis on which their middles extend farthest.
fn halve<'a>(
    mesh: &SurfaceMesh,
    axes: &Matrix3<f64>,
    triangles: &'a mut [u32],
) -> (&'a mut [u32], &'a mut [u32]) {
    let middle = |triangle: u32| {
        let [a, b, c] = mesh.corners(triangle as usize);
        axes.tr_mul(&(a.coords + b.coords + c.coords))
    };
    let mut extent = Bounds::empty();
    for &triangle in triangles.iter() {
        extent.include(&middle(triangle).into());
    }
    let axis = extent.extent().imax();
    let mut keys: Vec<(f64, u32)> = triangles.iter().map(|&t| (middle(t)[axis], t)).collect();
    let half = keys.len() / 2;
    keys.select_nth_unstable_by(half, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for (triangle, (_, number)) in triangles.iter_mut().zip(keys) {
        *triangle = number;
    }
    triangles.split_at_mut(half)
}

impl OrientedBox {
    /// The box around points along the principal axes of their second moments.
    fn around<I: Iterator<Item = Point3<f64>>>(bounds: &Bounds<3>, points: impl Fn() -> I) -> Self {
        let origin = bounds.center();
        let (mut count, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for point in points() {
            let arm = point - origin;
            count += 1.0;
            first += arm;
            second += arm * arm.transpose();
        }
        let spread = second - first * first.transpose() / count;
        let axes = SymmetricEigen::new(spread).eigenvectors;
        let mut extent = Bounds::<3>::empty();
        for point in points() {
            extent.include(&axes.tr_mul(&(point - origin)).into());
        }
        Self {
            center: origin + axes * extent.center().coords,
            axes,
            half: extent.extent() / 2.0,
        }
    }

    /// Whether a plane along one of the 15 pairs of axes or edges parts the boxes by more than
    /// `slack`: Gottschalk et al., section 5.
    fn is_apart(&self, other: &Self, slack: f64) -> bool {
        let between = self.axes.tr_mul(&(other.center - self.center));
        let turn = self.axes.tr_mul(&other.axes);
        let size = turn.abs();
        let (ours, theirs) = (self.half, other.half);
        let by_face = |axis: usize| {
            let reach = ours[axis] + size.row(axis).transpose().dot(&theirs);
            let back = theirs[axis] + size.column(axis).dot(&ours);
            between[axis].abs() > reach + slack
                || turn.column(axis).dot(&between).abs() > back + slack
        };
        let by_edges = |i: usize, j: usize| {
            let [i1, i2, j1, j2] = [(i + 1) % 3, (i + 2) % 3, (j + 1) % 3, (j + 2) % 3];
            let ours = ours[i1] * size[(i2, j)] + ours[i2] * size[(i1, j)];
            let theirs = theirs[j1] * size[(i, j2)] + theirs[j2] * size[(i, j1)];
            let gap = between[i2] * turn[(i1, j)] - between[i1] * turn[(i2, j)];
            gap.abs() > ours + theirs + slack
        };
        (0..3).any(by_face) || (0..9).any(|pair| by_edges(pair / 3, pair % 3))
    }
}

impl Fan {
    /// The fan that triangles form, if they share a corner.
    fn of(mesh: &SurfaceMesh, triangles: &[u32]) -> Option<Self> {
        let all = || triangles.iter().map(|&t| mesh.triangles[t as usize]);
        let first = mesh.triangles[triangles[0] as usize];
        let corner = (first.into_iter()).find(|corner| all().all(|t| t.contains(corner)))?;
        let apex = mesh.vertices[corner as usize];
        let directions = || {
            let ends = all().flatten().filter(|&end| end != corner);
            ends.map(|end| (mesh.vertices[end as usize] - apex).normalize())
        };
        let axis = directions().sum::<Vector3<f64>>().normalize();
        let opening = directions().map(|d| d.cross(&axis).norm().atan2(d.dot(&axis)));
        Some(Self {
            corner,
            axis,
            opening: opening.fold(
                0.0,
                |widest, angle| if angle > widest { angle } else { widest },
            ),
        })
    }

    /// Whether the cones have only the common corner in common; those of more than a half-space are
    /// not convex, so that nothing is known of what lies between their directions.
    fn is_apart(&self, other: &Self) -> bool {
        let right = std::f64::consts::FRAC_PI_2;
        let angle = (self.axis.cross(&other.axis).norm()).atan2(self.axis.dot(&other.axis));
        self.corner == other.corner
            && self.opening < right
            && other.opening < right
            && angle > self.opening + other.opening + CONE_SLACK
    }
}
