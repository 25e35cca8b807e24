//! The plane: diagrams fill their domain, energies are exact, relaxation goes downhill.

use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::domain::planar_error::PlaneDomainError;
use crate::energy::planar::{FragmentTriangle, energy, energy_with_derivatives, visit};
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::minimize::problem::Evaluation;
use crate::relax::metrics::Metrics;
use crate::relax::planar::Plane;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::voronoi::planar::diagram::{PlaneDiagram, PlaneDiagramError};
use nalgebra::{Matrix2, Point2, Vector2};

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

/// The axis and sign of the four fragments, in the order in which they are listed everywhere.
const FRAGMENTS: [(usize, f64); 4] = [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)];

/// The triangles of all fragments about `center`, in the order of the edges.
#[must_use]
fn triangles(polygon: &ConvexPolygon, center: &Point2<f64>) -> Vec<FragmentTriangle> {
    let mut all = Vec::new();
    visit(polygon, center, |triangle| all.push(triangle));
    all
}

/// The four fragments about `center` as polygons, in the order of [`FRAGMENTS`]; the edges where
/// two of them meet carry the label `interface`.
#[must_use]
fn fragments(
    polygon: &ConvexPolygon,
    center: &Point2<f64>,
    interface: Label,
) -> [ConvexPolygon; 4] {
    FRAGMENTS.map(|(axis, sign)| {
        let mut fragment = polygon.clone();
        for side in [-1.0, 1.0] {
            let mut normal = Vector2::repeat(side);
            normal[axis] = -sign;
            let offset = normal.dot(&center.coords);
            fragment.clip(&HalfPlane { normal, offset }, interface);
        }
        fragment
    })
}

/// SplitMix64: a named seed gives the same numbers on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self) -> Point2<f64> {
        let x = self.next();
        Point2::new(x, self.next())
    }

    fn points(&mut self, count: usize) -> Vec<Point2<f64>> {
        (0..count).map(|_| self.point()).collect()
    }

    fn points_in(&mut self, domain: &PlaneDomain, count: usize) -> Vec<Point2<f64>> {
        let bounds = domain.bounds();
        let any = std::iter::repeat_with(|| {
            bounds.min + self.point().coords.component_mul(&bounds.extent())
        });
        any.filter(|p| domain.contains(p)).take(count).collect()
    }
}

fn rectangle(min: [f64; 2], max: [f64; 2]) -> PlaneDomain {
    PlaneDomain::rectangle(&Bounds {
        min: min.into(),
        max: max.into(),
    })
    .unwrap()
}

fn unit_square() -> PlaneDomain {
    rectangle([0.0, 0.0], [1.0, 1.0])
}

fn corners(list: &[[f64; 2]]) -> Result<PlaneDomain, PlaneDomainError> {
    let points: Vec<Point2<f64>> = list.iter().map(|&c| c.into()).collect();
    PlaneDomain::from_corners(&points)
}

fn regular(sides: usize) -> PlaneDomain {
    let angle = |k: usize| k as f64 * std::f64::consts::TAU / sides as f64 + 0.3;
    let list: Vec<[f64; 2]> = (0..sides)
        .map(|k| [angle(k).cos(), angle(k).sin()])
        .collect();
    corners(&list).unwrap()
}

fn domains() -> Vec<(&'static str, PlaneDomain)> {
    vec![
        ("unit square", unit_square()),
        (
            "far and small",
            rectangle([1e6, -1e6], [1e6 + 1.0, 1.0 - 1e6]),
        ),
        ("slender", rectangle([-500.0, 0.0], [500.0, 0.01])),
        (
            "triangle",
            corners(&[[0.0, 0.0], [4.0, 0.5], [1.0, 3.0]]).unwrap(),
        ),
        ("heptagon", regular(7)),
        ("64-gon", regular(64)),
    ]
}

/// Site sets in the unit square that break triangulations.
fn degenerate_sets() -> Vec<(String, Vec<Point2<f64>>)> {
    let mut sets: Vec<_> = (few_sites().into_iter().chain(many_sites()))
        .map(|(name, sites)| (name.to_owned(), sites))
        .collect();
    for exponent in 6..=17 {
        let noise = if exponent == 17 {
            0.0
        } else {
            0.1_f64.powi(exponent)
        };
        sets.push((format!("line, noise {noise:e}"), noisy(line(60), noise)));
        let lattice = noisy(square_lattice(12), noise);
        sets.push((format!("lattice, noise {noise:e}"), lattice));
    }
    sets
}

fn few_sites() -> Vec<(&'static str, Vec<Point2<f64>>)> {
    let list = |sites: &[[f64; 2]]| sites.iter().map(|&s| s.into()).collect();
    let (up, down) = (0.5_f64.next_up(), 0.5_f64.next_down());
    let (tiny, least) = (1e-300, f64::MIN_POSITIVE);
    vec![
        ("one", list(&[[0.3, 0.4]])),
        ("one in a corner", list(&[[0.0, 1.0]])),
        ("two", Random(1).points(2)),
        ("three", Random(2).points(3)),
        (
            "three collinear",
            list(&[[0.2, 0.2], [0.2, 0.4], [0.2, 0.6]]),
        ),
        (
            "corners",
            list(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
        ),
        (
            "neighbors in f64",
            list(&[[0.5, 0.5], [up, 0.5], [0.5, down], [0.7, 0.1]]),
        ),
        (
            "around zero",
            list(&[[0.0, 0.0], [tiny, 0.0], [0.0, least], [0.5, 0.25]]),
        ),
    ]
}

fn many_sites() -> Vec<(&'static str, Vec<Point2<f64>>)> {
    let circle = (0..100)
        .map(|k| f64::from(k) * std::f64::consts::TAU / 100.0)
        .map(|a| Point2::new(0.5 + 0.4 * a.cos(), 0.5 + 0.4 * a.sin()));
    let walls = (0..40)
        .map(|k| f64::from(k) / 40.0)
        .flat_map(|t| [[t, 0.0], [1.0, t], [1.0 - t, 1.0], [0.0, 1.0 - t]]);
    let apart = Vector2::new(1e-13, -1e-13);
    let firsts = Random(3).points(50);
    let cluster = Random(4).points(200);
    vec![
        ("circle", circle.collect()),
        ("walls", walls.map(Point2::from).collect()),
        (
            "close pairs",
            firsts.iter().flat_map(|p| [*p, p + apart]).collect(),
        ),
        (
            "all in a corner",
            cluster.iter().map(|p| p * 1e-6).collect(),
        ),
    ]
}

fn line(count: usize) -> Vec<Point2<f64>> {
    let at = |k: usize| (k as f64 + 0.3) / count as f64;
    (0..count).map(|k| Point2::new(at(k), at(k))).collect()
}

fn noisy(mut sites: Vec<Point2<f64>>, amplitude: f64) -> Vec<Point2<f64>> {
    let mut random = Random(2026);
    for site in &mut sites {
        *site += (random.point() - Point2::new(0.5, 0.5)) * amplitude;
    }
    sites
}

fn square_lattice(side: usize) -> Vec<Point2<f64>> {
    let at = |k: usize| (k as f64 + 0.5) / side as f64;
    (0..side * side)
        .map(|k| Point2::new(at(k % side), at(k / side)))
        .collect()
}

fn neighbor(label: Label) -> Option<usize> {
    match FacetKind::of(label) {
        FacetKind::Neighbor {
            site,
            image: [0, 0, 0],
        } => Some(site as usize),
        _ => None,
    }
}

/// How far Σ area is from the domain's, relative; panics where a vertex of a cell is nearer to
/// another site, or where neighbors do not name each other.
fn diagram_error(domain: &PlaneDomain, sites: &[Point2<f64>], diagram: &PlaneDiagram) -> f64 {
    let extent = domain.bounds().extent().amax();
    for (index, cell) in diagram.cells.iter().enumerate() {
        for vertex in cell.polygon.vertices() {
            let own = vertex.coords.norm();
            for site in sites {
                let other = (vertex - (site - cell.site)).coords.norm();
                assert!(other - own > -1e-9 * extent, "cell {index}: {sites:?}");
            }
        }
        for edge in cell.polygon.edges().filter(|e| e.length() > 1e-6 * extent) {
            if let Some(other) = neighbor(edge.label) {
                // Sites a few ulps apart coincide within rounding for a distant site.
                let near = |a: usize, b: usize| (sites[a] - sites[b]).norm() < 1e-12 * extent;
                let mutual = (0..sites.len()).filter(|&n| near(n, other)).any(|n| {
                    let back = diagram.cells[n].polygon.edges();
                    back.filter_map(|e| neighbor(e.label))
                        .any(|m| near(m, index))
                });
                assert!(mutual, "{index} {other}: {sites:?}");
            }
        }
    }
    (diagram.area() / domain.area() - 1.0).abs()
}

#[test]
fn cells_of_random_sites_fill_every_domain() {
    for (name, domain) in domains() {
        for count in [1, 2, 3, 4, 7, 50, 400] {
            let sites = Random(count as u64).points_in(&domain, count);
            let diagram = PlaneDiagram::new(&domain, &sites).unwrap();
            let error = diagram_error(&domain, &sites, &diagram);
            assert!(error <= 1e-12, "{name}, {count} sites: {error:e}");
        }
    }
}

#[test]
fn cells_of_degenerate_sites_fill_the_square() {
    let domain = unit_square();
    for (name, sites) in degenerate_sets() {
        let diagram = PlaneDiagram::new(&domain, &sites).unwrap();
        let error = diagram_error(&domain, &sites, &diagram);
        assert!(error <= 1e-12, "{name}: {error:e}");
    }
}

#[test]
fn voronator_and_bisectors_alone_give_the_same_cells() {
    for (name, domain) in domains() {
        let sites = Random(5).points_in(&domain, 300);
        let through_voronator = PlaneDiagram::new(&domain, &sites).unwrap();
        let alone = PlaneDiagram::by_bisectors(&domain, &sites).unwrap();
        for (a, b) in through_voronator.cells.iter().zip(&alone.cells) {
            let difference = (a.polygon.area() - b.polygon.area()).abs();
            assert!(difference <= 1e-13 * domain.area(), "{name}");
        }
    }
}

/// The polygons that `voronator` itself cuts, as its users would get them.
#[test]
fn cells_agree_with_the_polygons_of_voronator() {
    use voronator::{VoronoiDiagram, delaunator::Point, polygon::Polygon};
    let sites = Random(6).points(500);
    let cells = PlaneDiagram::new(&unit_square(), &sites).unwrap().cells;
    let points = sites.iter().map(|s| Point { x: s.x, y: s.y }).collect();
    let square = [(-5.0, -5.0), (6.0, -5.0), (6.0, 6.0), (-5.0, 6.0)];
    let square = Polygon::from_points(square.map(Point::from).to_vec());
    let theirs = VoronoiDiagram::with_bounding_polygon(points, &square).unwrap();
    let mut compared = 0;
    for (cell, polygon) in cells.iter().zip(theirs.cells()) {
        if (cell.polygon.edges()).any(|edge| neighbor(edge.label).is_none()) {
            continue;
        }
        let outline = polygon.points().iter().map(|p| Point2::new(p.x, p.y));
        let area = ConvexPolygon::from_corners(outline, 0..).area();
        assert!((area - cell.polygon.area()).abs() < 1e-14);
        compared += 1;
    }
    assert!(compared > 350);
}

#[test]
fn a_square_lattice_has_square_cells_with_four_neighbors_or_walls() {
    let sites = square_lattice(10);
    let plane = Plane {
        domain: unit_square(),
    };
    let figures = plane.metrics(&sites, LINF).unwrap();
    for (cell, site) in figures.iter().zip(&sites) {
        assert!((cell.volume - 0.01).abs() < 1e-15);
        assert_eq!(cell.facets, 4);
        assert!((cell.cubeness - 1.0).abs() < 1e-12);
        assert!((cell.axis_aligned - 1.0).abs() < 1e-12);
        assert!((cell.chebyshev - 0.001 / 3.0).abs() < 1e-17);
        assert!((cell.center - site).norm() < 1e-13);
    }
    let all = Metrics::of(plane.volume(), &plane.optimum(), &figures);
    assert!((all.energy_percent - 100.0).abs() < 1e-10);
    assert!((all.six_facet_fraction - 1.0).abs() < 1e-15);
}

#[test]
fn sites_without_a_diagram_are_named() {
    let domain = unit_square();
    let refusal = |list: &[[f64; 2]]| {
        let sites: Vec<Point2<f64>> = list.iter().map(|&s| s.into()).collect();
        PlaneDiagram::new(&domain, &sites).unwrap_err()
    };
    assert_eq!(refusal(&[]), PlaneDiagramError::NoSites);
    let twice = refusal(&[[0.1, 0.0], [0.5, 0.5], [0.1, -0.0], [0.9, 0.9]]);
    assert!(matches!(
        twice,
        PlaneDiagramError::Duplicate {
            first: 0,
            second: 2,
            ..
        }
    ));
    let outside = refusal(&[[0.5, 0.5], [1.25, 0.5]]);
    assert!(matches!(
        outside,
        PlaneDiagramError::Outside { site: 1, .. }
    ));
    assert_eq!(
        outside.to_string(),
        "site 1 lies outside the domain: (1.25, 0.5)"
    );
    let lost = refusal(&[[0.5, 0.5], [0.5, f64::NAN]]);
    assert!(matches!(lost, PlaneDiagramError::NotFinite { site: 1, .. }));
}

#[test]
fn what_is_not_a_domain_is_refused() {
    use PlaneDomainError as E;
    let flat = corners(&[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]);
    assert!(matches!(flat, Err(E::NoArea { .. })));
    let bow_tie = corners(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]);
    assert!(matches!(
        bow_tie,
        Err(E::Crossing {
            first: 0,
            second: 2,
            ..
        })
    ));
    let fold = corners(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    assert!(matches!(fold, Err(E::Crossing { .. })));
    let twice_around: Vec<[f64; 2]> = (0..5)
        .map(|k| f64::from(2 * k) * std::f64::consts::TAU / 5.0)
        .map(|angle| [angle.cos(), angle.sin()])
        .collect();
    assert!(matches!(corners(&twice_around), Err(E::Crossing { .. })));
    let lost = corners(&[[0.0, 0.0], [f64::INFINITY, 0.0], [0.0, 1.0]]);
    assert!(matches!(lost, Err(E::NotFinite { index: 1, .. })));
    assert!(matches!(
        corners(&[[0.0, 0.0]]),
        Err(E::TooFew { count: 1, .. })
    ));
    let strip = half_planes(&[[0.0, 1.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 1.0]]);
    assert!(matches!(strip, Err(E::Unbounded)));
    let void = half_planes(&[
        [1.0, 0.0, -1.0],
        [-1.0, 0.0, -1.0],
        [0.0, 1.0, 1.0],
        [0.0, -1.0, 1.0],
    ]);
    assert!(matches!(void, Err(E::NoArea { .. })));
    let blind = half_planes(&[[1.0, 0.0, 1.0], [0.0, 0.0, 1.0], [0.0, 1.0, 1.0]]);
    assert!(matches!(blind, Err(E::ZeroNormal { index: 1 })));
}

fn half_planes(list: &[[f64; 3]]) -> Result<PlaneDomain, PlaneDomainError> {
    let planes: Vec<HalfPlane> = list
        .iter()
        .map(|&[x, y, offset]| HalfPlane {
            normal: Vector2::new(x, y),
            offset,
        })
        .collect();
    PlaneDomain::from_half_planes(&planes)
}

#[test]
fn corners_in_either_order_and_half_planes_make_the_same_domain() {
    let list = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [1.0, 2.0]];
    let there = corners(&list).unwrap();
    let mut reversed = list;
    reversed.reverse();
    let back = corners(&reversed).unwrap();
    // The last one is superfluous.
    let cut = half_planes(&[
        [0.0, -2.0, 0.0],
        [1.0, 0.0, 3.0],
        [0.5, 1.0, 2.5],
        [-2.0, 1.0, 0.0],
        [1.0, 1.0, 50.0],
    ])
    .unwrap();
    for domain in [&there, &back, &cut] {
        assert!((domain.area() - 4.0).abs() < 1e-14);
        assert!(domain.contains(&Point2::new(1.0, 2.0)));
        assert!(!domain.contains(&Point2::new(0.5, 1.01)));
    }
}

/// A cell of random sites and centers about it, some of them outside.
fn arbitrary_cell(seed: u64) -> (ConvexPolygon, Vec<Point2<f64>>) {
    let mut random = Random(seed);
    let sites = random.points(12);
    let cells = PlaneDiagram::new(&unit_square(), &sites).unwrap().cells;
    let polygon = cells[seed as usize % 12].polygon.clone();
    let bounds = polygon.bounds();
    let centers = (0..6).map(|_| {
        let share = random.point().coords.add_scalar(-0.5) * 1.6;
        bounds.center() + share.component_mul(&bounds.extent())
    });
    let centers = centers.collect();
    (polygon, centers)
}

/// Five-point Gauss-Legendre on [0, 1]: exact to degree 9.
const GAUSS: [(f64, f64); 5] = [
    (0.046_910_077_030_668, 0.118_463_442_528_094_5),
    (0.230_765_344_947_158_5, 0.239_314_335_249_683_2),
    (0.5, 0.284_444_444_444_444_4),
    (0.769_234_655_052_841_5, 0.239_314_335_249_683_2),
    (0.953_089_922_969_332, 0.118_463_442_528_094_5),
];

fn over_segment(a: Point2<f64>, b: Point2<f64>, f: &dyn Fn(Point2<f64>) -> f64) -> f64 {
    let mean: f64 = GAUSS.iter().map(|(t, w)| w * f(a + (b - a) * *t)).sum();
    mean * (b - a).norm()
}

/// Exact for polynomials up to degree 8, by collapsing the unit square onto the triangle.
fn over_triangle(corners: [Point2<f64>; 3], f: &dyn Fn(Point2<f64>) -> f64) -> f64 {
    let [a, b, c] = corners;
    let mut sum = 0.0;
    for (u, weight_u) in GAUSS {
        for (v, weight_v) in GAUSS {
            let point = a + (b - a) * u + (c - b) * (u * v);
            sum += weight_u * weight_v * u * f(point);
        }
    }
    sum * (b - a).perp(&(c - a))
}

fn over_polygon(polygon: &ConvexPolygon, f: &dyn Fn(Point2<f64>) -> f64) -> f64 {
    let fan = polygon.vertices().windows(2).skip(1);
    fan.map(|pair| over_triangle([polygon.vertices()[0], pair[0], pair[1]], f))
        .sum()
}

/// Energy, gradient and Hessian by quadrature over the fragments as polygons.
fn by_quadrature(polygon: &ConvexPolygon, center: &Point2<f64>, order: i32) -> Evaluation<2> {
    let interface = u64::MAX;
    let p = f64::from(order);
    let distance = |y: Point2<f64>| (y - center).amax();
    let power = move |y: Point2<f64>, exponent: i32| distance(y).powi(exponent);
    let mut value = 0.0;
    let mut gradient = Vector2::zeros();
    let mut hessian = Matrix2::zeros();
    for ((axis, sign), fragment) in FRAGMENTS
        .into_iter()
        .zip(fragments(polygon, center, interface))
    {
        value += over_polygon(&fragment, &|y| power(y, order));
        gradient[axis] -= sign * p * over_polygon(&fragment, &|y| power(y, order - 1));
        if order > 1 {
            hessian[(axis, axis)] +=
                p * (p - 1.0) * over_polygon(&fragment, &|y| power(y, order - 2));
        }
        for edge in fragment.edges().filter(|edge| edge.label == interface) {
            let middle = (edge.start - center) + (edge.end - center);
            let w = Vector2::new(middle.x.signum(), -middle.y.signum());
            let line = over_segment(edge.start, edge.end, &|y| power(y, order - 1));
            // Each interface is met twice, once from either fragment.
            hessian += w * w.transpose() * (0.5 * p / 2.0_f64.sqrt() * line);
        }
    }
    Evaluation {
        value,
        gradient,
        hessian,
    }
}

#[test]
fn energy_gradient_and_hessian_agree_with_quadrature() {
    for seed in 0..24 {
        let (polygon, centers) = arbitrary_cell(seed);
        let width = polygon.bounds().extent().amax();
        for center in &centers {
            for order in [1, 2, 3, 8] {
                let exact = energy_with_derivatives(&polygon, center, order);
                let other = by_quadrature(&polygon, center, order as i32);
                let label = format!("seed {seed}, order {order}");
                assert!((exact.value / other.value - 1.0).abs() < 1e-10, "{label}");
                let unit = other.gradient.norm().max(1e-3 * other.hessian.norm());
                assert!(
                    (exact.gradient - other.gradient).norm() < 1e-10 * unit,
                    "{label}"
                );
                let unit = other.hessian.norm().max(other.value / width.powi(2));
                assert!(
                    (exact.hessian - other.hessian).norm() < 1e-10 * unit,
                    "{label}"
                );
                let alone = energy(&polygon, center, order);
                assert!((alone / exact.value - 1.0).abs() < 1e-14, "{label}");
            }
        }
    }
}

/// Splits triangles until the diagonals through `center` pass between them or they are tiny.
fn by_subdivision(corners: [Point2<f64>; 3], center: &Point2<f64>, order: i32, depth: u32) -> f64 {
    let [a, b, c] = corners;
    let side = |y: &Point2<f64>| {
        let v = y - center;
        (v.x > v.y, v.x > -v.y)
    };
    if depth == 0 || (side(&a) == side(&b) && side(&b) == side(&c)) {
        return over_triangle(corners, &|y| (y - center).amax().powi(order));
    }
    let middle = |p: &Point2<f64>, q: &Point2<f64>| nalgebra::center(p, q);
    let (ab, bc, ca) = (middle(&a, &b), middle(&b, &c), middle(&c, &a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        .iter()
        .map(|part| by_subdivision(*part, center, order, depth - 1))
        .sum()
}

#[test]
fn energy_agrees_with_subdivision() {
    for seed in [3, 8] {
        let (polygon, centers) = arbitrary_cell(seed);
        for order in [1, 2, 3, 8] {
            let exact = energy(&polygon, &centers[0], order);
            let corners = polygon.vertices();
            let other: f64 = (2..corners.len())
                .map(|k| [corners[0], corners[k - 1], corners[k]])
                .map(|t| by_subdivision(t, &centers[0], order as i32, 16))
                .sum();
            assert!(
                (exact / other - 1.0).abs() < 1e-10,
                "seed {seed}, order {order}"
            );
        }
    }
}

#[test]
fn derivatives_agree_with_central_differences() {
    let step = 1e-5;
    for seed in 0..24 {
        let (polygon, centers) = arbitrary_cell(seed);
        let width = polygon.bounds().extent().amax();
        for center in &centers {
            for order in [1, 2, 3, 8] {
                let at = |c: Point2<f64>| energy_with_derivatives(&polygon, &c, order);
                let exact = at(*center);
                let unit = exact.hessian.norm().max(exact.value / width.powi(2));
                for axis in 0..2 {
                    let mut shift = Vector2::zeros();
                    shift[axis] = step;
                    let (up, down) = (at(center + shift), at(center - shift));
                    let slope = (up.value - down.value) / (2.0 * step);
                    assert!((slope - exact.gradient[axis]).abs() < 1e-6 * unit.max(slope.abs()));
                    let quotient = (up.gradient - down.gradient) / (2.0 * step);
                    let difference = (quotient - exact.hessian.column(axis)).norm();
                    assert!(
                        difference < 1e-6 * unit,
                        "seed {seed}, order {order}: {difference:e} of {unit:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn fragments_and_their_triangles_share_out_the_polygon() {
    for seed in 0..12 {
        let (polygon, centers) = arbitrary_cell(seed);
        for center in &centers {
            let parts = fragments(&polygon, center, u64::MAX).map(|f| f.area());
            assert!((parts.iter().sum::<f64>() - polygon.area()).abs() < 1e-14);
            let mut sums = [0.0; 4];
            for triangle in triangles(&polygon, center) {
                let fragment = (triangle.axis, triangle.sign);
                let k = FRAGMENTS.iter().position(|f| *f == fragment).unwrap();
                sums[k] += triangle.signed_area();
            }
            for (sum, part) in sums.iter().zip(&parts) {
                assert!((sum - part).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn no_step_to_a_center_is_uphill_or_leaves_the_cell() {
    for (name, domain) in domains() {
        let sites = Random(9).points_in(&domain, 60);
        let diagram = PlaneDiagram::new(&domain, &sites).unwrap();
        for order in [1, 2, 5] {
            let question = EnergySpec { order, ..LINF };
            let plane = Plane {
                domain: domain.clone(),
            };
            let assessments = plane.assess(&sites, question).unwrap();
            for (cell, assessment) in diagram.cells.iter().zip(&assessments) {
                let target = Point2::from(assessment.target - cell.site);
                let after = energy(&cell.polygon, &target, order);
                assert!(after <= assessment.energy * (1.0 + 1e-12), "{name}");
                let slack = 1e-12 * domain.bounds().extent().amax();
                for edge in cell.polygon.edges().filter(|e| e.length() > 1e-6) {
                    let side = HalfPlane::left_of(&edge.start, &edge.end);
                    assert!(side.height(&target) <= slack * side.normal.norm(), "{name}");
                }
                assert!(
                    assessment.evaluations < 40,
                    "{name}: {}",
                    assessment.evaluations
                );
            }
        }
    }
}

#[test]
fn at_the_center_opposite_fragments_have_equal_area() {
    let sites = Random(10).points(300);
    let diagram = PlaneDiagram::new(&unit_square(), &sites).unwrap();
    let mut evaluations = 0.0;
    let plane = Plane {
        domain: unit_square(),
    };
    let figures = plane.metrics(&sites, LINF).unwrap();
    let assessments = plane.assess(&sites, LINF).unwrap();
    for (cell, figures) in diagram.cells.iter().zip(&figures) {
        let center = Point2::from(figures.center - cell.site);
        let parts = fragments(&cell.polygon, &center, 0).map(|f| f.area());
        assert!((parts[0] - parts[1]).abs() < 1e-9 * figures.volume);
        assert!((parts[2] - parts[3]).abs() < 1e-9 * figures.volume);
        assert!(figures.center_energy <= figures.energy);
    }
    for assessment in &assessments {
        evaluations += f64::from(assessment.evaluations) / 300.0;
    }
    assert!(evaluations < 5.1, "{evaluations} evaluations per cell");
}

#[test]
fn both_minimizers_find_the_same_centers() {
    for (name, domain) in domains() {
        let plane = Plane { domain };
        let sites = Random(11).points_in(&plane.domain, 100);
        for order in [1, 3] {
            let by = |minimizer| {
                let question = EnergySpec {
                    minimizer,
                    order,
                    ..LINF
                };
                plane.metrics(&sites, question).unwrap()
            };
            let both = by(Minimizer::Newton).into_iter().zip(by(Minimizer::Lbfgsb));
            for (newton, lbfgsb) in both {
                // A slender cell has many centers, but they are worth the same.
                let size = newton.volume.sqrt();
                let apart = (newton.center - lbfgsb.center).norm();
                let gain = (newton.center_energy / lbfgsb.center_energy - 1.0).abs();
                assert!(
                    apart < 1e-8 * size || name == "slender",
                    "{name}: {apart:e}"
                );
                assert!(gain < 1e-12, "{name}: {gain:e}");
            }
        }
    }
}

#[test]
fn euclidean_figures_are_those_of_the_second_moment() {
    let plane = Plane {
        domain: unit_square(),
    };
    let sites = Random(13).points(50);
    let question = EnergySpec {
        norm: Norm::L2,
        ..LINF
    };
    let cells = PlaneDiagram::new(&plane.domain, &sites).unwrap().cells;
    for (cell, figures) in cells.iter().zip(plane.metrics(&sites, question).unwrap()) {
        let about = |c: Point2<f64>| {
            let square = |y: Point2<f64>| (y - c).norm_squared();
            over_polygon(&cell.polygon, &square)
        };
        assert!((figures.energy / about(Point2::origin()) - 1.0).abs() < 1e-12);
        let center = Point2::from(figures.center - cell.site);
        assert!((figures.center_energy / about(center) - 1.0).abs() < 1e-12);
        for axis in 0..2 {
            let mut shift = Vector2::zeros();
            shift[axis] = 0.5;
            let slope = about(Point2::from(shift)) - about(Point2::from(-shift));
            assert!((slope - figures.gradient[axis]).abs() < 1e-14);
        }
    }
}

/// Runs `moves` Lloyd moves and returns the energy in percent before each and after the last.
fn lloyd(plane: &Plane, sites: &mut Vec<Point2<f64>>, norm: Norm, moves: usize) -> Vec<f64> {
    let question = EnergySpec { norm, ..LINF };
    let mut percents = Vec::new();
    for left in (0..=moves).rev() {
        let assessments = plane.assess(sites, question).unwrap();
        let count = sites.len() as f64;
        let least = (plane.volume() / count).powf(1.5) / 3.0;
        let mean = assessments.iter().map(|a| a.chebyshev).sum::<f64>() / count;
        percents.push(100.0 * mean / least);
        if left > 0 {
            *sites = assessments.iter().map(|a| a.target).collect();
        }
    }
    percents
}

#[test]
fn the_square_lattice_is_at_one_hundred_percent_and_stays() {
    let plane = Plane {
        domain: unit_square(),
    };
    let mut sites = square_lattice(16);
    for percent in lloyd(&plane, &mut sites, Norm::Linf, 3) {
        assert!((percent - 100.0).abs() < 1e-10);
    }
    let moved = sites
        .iter()
        .zip(square_lattice(16))
        .map(|(a, b)| (a - b).norm());
    assert!(moved.fold(0.0, f64::max) < 1e-12);
}

#[test]
fn relaxation_goes_downhill_to_no_less_than_squares() {
    for (name, domain) in domains().into_iter().filter(|(name, _)| *name != "slender") {
        let plane = Plane { domain };
        let mut sites = Random(1).points_in(&plane.domain, 200);
        let percents = lloyd(&plane, &mut sites, Norm::Linf, 40);
        assert!(
            percents.windows(2).all(|p| p[1] <= p[0] * (1.0 + 1e-12)),
            "{name}"
        );
        assert!(
            percents[40] >= 100.0 && percents[40] < 104.0,
            "{name}: {}",
            percents[40]
        );
        assert!(percents[0] > 110.0, "{name}: {}", percents[0]);
        assert!(
            sites.iter().all(|site| plane.domain.contains(site)),
            "{name}"
        );
    }
}

#[test]
fn the_euclidean_control_lowers_its_own_energy() {
    let plane = Plane {
        domain: unit_square(),
    };
    let question = EnergySpec {
        norm: Norm::L2,
        ..LINF
    };
    let mut sites = Random(4).points(200);
    let mut last = f64::INFINITY;
    for _ in 0..20 {
        let assessments = plane.assess(&sites, question).unwrap();
        let sum: f64 = assessments.iter().map(|a| a.energy).sum();
        assert!(sum < last);
        last = sum;
        sites = assessments.iter().map(|a| a.target).collect();
    }
    let linf = lloyd(&plane, &mut Random(4).points(200), Norm::Linf, 20)[20];
    let l2 = lloyd(&plane, &mut Random(4).points(200), Norm::L2, 20)[20];
    assert!(linf < l2, "{linf} {l2}");
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let plane = Plane {
            domain: unit_square(),
        };
        let mut sites = Random(12).points(1000);
        pool.install(|| lloyd(&plane, &mut sites, Norm::Linf, 5));
        let bits = |p: &Point2<f64>| [p.x.to_bits(), p.y.to_bits()];
        sites.iter().map(bits).collect::<Vec<_>>()
    };
    assert_eq!(run(1), run(2));
}
