//! L∞ cells: they fill the domain whatever the sites, and hold the points nearest to their site.

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::shape::DomainShape;
use crate::energy::evaluation::{EnergyScratch, SignedPiece, energy};
use crate::energy::faceted::FacetedSolid;
use crate::energy::swept::{CornerPath, SweptSolid};
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::random::Random;
use crate::geometry::shell::Shell;
use crate::tests::sites::{grid_sites, random_sites};
use crate::voronoi::diagram::{Diagram, DiagramError};
use crate::voronoi::linf::cell::{Fragment, LinfCell, Ties};
use crate::voronoi::linf::cone::Cone;
use nalgebra::{Point3, Vector3};

fn cuboid(max: [f64; 3], periodic: [bool; 3]) -> Cuboid {
    Cuboid::new(Bounds::from_corners([0.0; 3], max), periodic).expect("a box")
}

fn volumes(domain: &dyn Domain, sites: &[Point3<f64>]) -> Vec<f64> {
    let diagram = Diagram::new(domain, sites).expect("a diagram");
    let cells = diagram.map_linf(Ties::ToSmallerIndex, |(): &mut (), cell| cell.volume());
    cells.expect("no duplicates")
}

fn assert_filled(name: &str, domain: &dyn Domain, sites: &[Point3<f64>]) {
    let sum: f64 = volumes(domain, sites).iter().sum();
    let error = sum / domain.volume() - 1.0;
    assert!(error.abs() < 1e-12, "{name}: {error:e}");
}

fn jittered(count: usize, noise: f64) -> Vec<Point3<f64>> {
    let mut random = Random::new(3);
    let mut moved = |x: f64| (x + noise * (2.0 * random.uniform() - 1.0)).clamp(0.0, 1.0);
    let sites = grid_sites(count).into_iter();
    sites
        .map(|site| Point3::from(site.coords.map(&mut moved)))
        .collect()
}

#[test]
fn random_cells_fill_the_cube() {
    assert_filled("one", &Cuboid::unit(), &random_sites(1, 1));
    for (count, seed) in [(2, 1), (7, 2), (100, 3), (500, 4)] {
        assert_filled("random", &Cuboid::unit(), &random_sites(count, seed));
    }
}

#[test]
fn lattices_fill_the_box_exact_and_jittered() {
    for noise in [0.0, 1e-16, 1e-15, 1e-13, 1e-10, 1e-8, 1e-6] {
        for count in [2, 3, 4] {
            let sites = jittered(count, noise);
            assert_filled(
                &format!("grid {count} ± {noise:e}"),
                &Cuboid::unit(),
                &sites,
            );
        }
        for periodic in [[true; 3], [true, false, false], [false, true, true]] {
            let domain = cuboid([1.0; 3], periodic);
            let name = format!("periodic grid {periodic:?} ± {noise:e}");
            assert_filled(&name, &domain, &jittered(3, noise));
        }
    }
}

#[test]
fn an_exact_lattice_has_cubes() {
    for periodic in [[false; 3], [true; 3]] {
        for volume in volumes(&cuboid([1.0; 3], periodic), &grid_sites(4)) {
            assert!((volume * 64.0 - 1.0).abs() < 1e-13, "{volume}");
        }
    }
}

/// Sites with coordinates of which many are equal.
fn rounded(count: usize, seed: u64, axes: &[usize], steps: f64) -> Vec<Point3<f64>> {
    let mut sites = random_sites(count, seed);
    for site in &mut sites {
        for &axis in axes {
            site[axis] = (site[axis] * steps).round() / steps;
        }
    }
    let mut kept: Vec<Point3<f64>> = Vec::new();
    for site in sites {
        if kept.iter().all(|other| *other != site) {
            kept.push(site);
        }
    }
    kept
}

#[test]
fn sites_that_share_coordinates_fill_the_box() {
    let walls = [[false; 3], [true, true, true], [false, true, false]];
    for periodic in walls {
        let domain = cuboid([1.0; 3], periodic);
        let fill = |name: &str, sites: &[Point3<f64>]| {
            // Along a period the two ends are one place.
            let inside = |site: &&Point3<f64>| (0..3).all(|k| !periodic[k] || site[k] < 1.0);
            let sites: Vec<_> = sites.iter().filter(inside).copied().collect();
            assert_filled(&format!("{name} {periodic:?}"), &domain, &sites);
        };
        for seed in 1..4 {
            fill("one axis", &rounded(60, seed, &[0], 3.0));
            fill("two axes", &rounded(60, seed, &[0, 2], 4.0));
            fill("three axes", &rounded(60, seed, &[0, 1, 2], 3.0));
        }
        let corner = |n: usize| Point3::from([n & 1, n >> 1 & 1, n >> 2].map(|x| x as f64));
        fill("corners", &(0..8).map(corner).collect::<Vec<_>>());
        let planar = random_sites(40, 7)
            .into_iter()
            .map(|site| Point3::new(site.x, site.y, 0.5));
        fill("coplanar", &planar.collect::<Vec<_>>());
        let line = random_sites(20, 8)
            .into_iter()
            .map(|site| Point3::new(site.x, 0.25, 0.5));
        fill("collinear", &line.collect::<Vec<_>>());
        let slope = random_sites(20, 8)
            .into_iter()
            .map(|site| Point3::new(site.x, site.x, 0.5));
        fill("diagonal", &slope.collect::<Vec<_>>());
        let on_wall = random_sites(30, 9)
            .into_iter()
            .map(|site| Point3::new(0.0, site.y, site.z));
        fill("wall", &on_wall.collect::<Vec<_>>());
        fill("one", &[Point3::new(0.1, 0.2, 0.9)]);
        fill("one in a corner", &[Point3::origin()]);
        let close = Point3::new(0.3, 0.4, 0.5);
        for shift in [1e-16, 1e-14, 1e-9] {
            fill(
                "close",
                &[close, close + Vector3::new(shift, 2.0 * shift, 0.0)],
            );
        }
        fill(
            "tiny",
            &[Point3::origin(), Point3::new(1e-300, 1e-310, 0.0)],
        );
    }
}

#[test]
fn long_periodic_boxes_and_their_images_are_filled() {
    for max in [[4.0, 1.0, 1.0], [1.0, 0.3, 2.0]] {
        for count in [1, 2, 5, 30] {
            let scaled = |site: Point3<f64>| Point3::from([0, 1, 2].map(|k| site[k] * max[k]));
            let sites: Vec<_> = random_sites(count, 5).into_iter().map(scaled).collect();
            assert_filled("long", &cuboid(max, [true; 3]), &sites);
            let flat = |site: &Point3<f64>| Point3::new(site.x, 0.25 * max[1], site.z);
            let level: Vec<_> = sites.iter().map(flat).collect();
            assert_filled("level", &cuboid(max, [true; 3]), &level);
        }
    }
}

#[test]
fn convex_polyhedra_are_filled() {
    let walls = (0..8).map(|signs| {
        let sign = |axis: u32| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
        let (normal, offset) = (Vector3::new(sign(0), sign(1), sign(2)), 1.0);
        HalfSpace { normal, offset }
    });
    let octahedron = ConvexPolyhedron::new(&walls.collect::<Vec<_>>()).expect("a solid");
    let inside = |site: &Point3<f64>| octahedron.contains(site);
    let spread = random_sites(400, 3).into_iter();
    let spread = spread.map(|site| site + (site - Point3::new(1.0, 1.0, 1.0)));
    let sites: Vec<_> = spread.filter(inside).collect();
    assert!(sites.len() > 30);
    assert_filled("octahedron", &octahedron, &sites);
    let on_walls = [
        [1.0, 0.0, 0.0],
        [0.5, 0.5, 0.0],
        [0.25, 0.25, -0.5],
        [0.0; 3],
    ];
    assert_filled("its walls", &octahedron, &on_walls.map(Point3::from));
}

#[test]
fn duplicates_are_refused() {
    let unit = Cuboid::unit();
    let diagram = Diagram::new(&unit, &[[0.2; 3], [0.5; 3], [0.2; 3]]).expect("a diagram");
    let cells = diagram.map_linf(Ties::ToSmallerIndex, |(): &mut (), cell| cell.volume());
    let expected = DiagramError::Duplicate {
        first: 0,
        second: 2,
        position: [0.2; 3],
    };
    assert_eq!(cells, Err(expected));
}

fn fragments(domain: &dyn Domain, sites: &[Point3<f64>]) -> Vec<Vec<Fragment>> {
    let list = |(): &mut (), cell: LinfCell<'_>| {
        let mut fragments = Vec::new();
        cell.visit_fragments(|fragment| fragments.push(fragment.clone()));
        fragments
    };
    let diagram = Diagram::new(domain, sites).expect("a diagram");
    diagram
        .map_linf(Ties::ToSmallerIndex, list)
        .expect("no duplicates")
}

/// Whether a point relative to the site lies in the pyramid that a fragment spans with it.
fn holds(fragment: &Fragment, at: &Vector3<f64>) -> bool {
    let corners = &fragment.corners;
    let next = corners.iter().cycle().skip(1);
    let is_within = corners
        .iter()
        .zip(next)
        .all(|(a, b)| a.cross(b).dot(at) > 0.0);
    let twice_area: Vector3<f64> = corners
        .windows(2)
        .map(|ab| (ab[0] - corners[0]).cross(&(ab[1] - corners[0])))
        .sum();
    is_within && twice_area.dot(&(at - corners[0])) <= 0.0
}

/// The cone in which a displacement lies.
fn cone_of(at: &Vector3<f64>) -> usize {
    let axis = at.iamax();
    2 * axis + usize::from(at[axis] < 0.0)
}

/// Per cell and cone, the fragments.
fn fragments_by_cone(domain: &dyn Domain, sites: &[Point3<f64>]) -> Vec<[Vec<Fragment>; 6]> {
    let sorted = |cell: Vec<Fragment>| {
        let mut cones: [Vec<Fragment>; 6] = Default::default();
        for fragment in cell {
            let middle: Vector3<f64> = fragment.corners.iter().sum();
            cones[cone_of(&middle)].push(fragment);
        }
        cones
    };
    fragments(domain, sites).into_iter().map(sorted).collect()
}

/// Checks that random points lie in the cell of the site that is nearest by brute force, and in no
/// cell of the others near them.
fn check_points(domain: &dyn Domain, sites: &[Point3<f64>], points: usize) {
    let (cells, mut random) = (fragments_by_cone(domain, sites), Random::new(77));
    let diagram = Diagram::new(domain, sites).expect("a diagram");
    let mut order: Vec<usize> = (0..sites.len()).collect();
    for _ in 0..points {
        let point = random.point(&domain.bounds());
        if !domain.contains(&point) {
            continue;
        }
        let distance = |site: &usize| (sites[*site] - point).amax();
        let by_distance = |a: &usize, b: &usize| distance(a).total_cmp(&distance(b)).then(a.cmp(b));
        let few = order.len().min(4);
        order.select_nth_unstable_by(few - 1, by_distance);
        order[..few].sort_by(by_distance);
        assert_eq!(diagram.locate_linf(point), Some(order[0]));
        let is_near_tie = few > 1 && distance(&order[1]) - distance(&order[0]) < 1e-9;
        if is_near_tie && distance(&order[1]) > distance(&order[0]) {
            continue;
        }
        let holders = order[..few].iter().filter(|&&site| {
            let at = point - sites[site];
            cells[site][cone_of(&at)]
                .iter()
                .any(|fragment| holds(fragment, &at))
        });
        let holders: Vec<_> = holders.collect();
        assert_eq!(holders, [&order[0]], "{point}");
    }
}

#[test]
fn cells_hold_the_points_nearest_to_their_sites() {
    let unit = Cuboid::unit();
    check_points(&unit, &random_sites(1000, 1), 10_000);
    check_points(&unit, &jittered(6, 1e-3), 10_000);
    check_points(&unit, &rounded(200, 2, &[0, 1, 2], 5.0), 10_000);
    let clustered = random_sites(300, 4)
        .into_iter()
        .enumerate()
        .map(|(n, site)| {
            let scale = [1.0, 0.1, 0.01][n % 3];
            Point3::from(site.coords * scale)
        });
    check_points(&unit, &clustered.collect::<Vec<_>>(), 10_000);
}

/// The cell of a site by subtracting, from the part of the box in each cone, the convex sets that are
/// nearer to another site: its convex parts.
fn parts_by_subtraction(sites: &[Point3<f64>], site: usize) -> Vec<Polyhedron> {
    let here = sites[site].coords;
    let unit = Cuboid::unit().bounds();
    let around = Bounds {
        min: unit.min - here,
        max: unit.max - here,
    };
    let mut kept = Vec::new();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let ahead = Vector3::ith(axis, sign);
            let mut parts = vec![Polyhedron::cuboid(&around, [0; 6])];
            let sides = [1, 2].map(|turn| Vector3::ith((axis + turn) % 3, 1.0));
            for side in [sides[0], -sides[0], sides[1], -sides[1]] {
                parts = divided(&parts, &(side - ahead), 0.0).0;
            }
            for (other, place) in sites.iter().enumerate().filter(|(other, _)| *other != site) {
                let to = place.coords - here;
                let along = ahead.dot(&to);
                if along < 0.0 || along == 0.0 && other > site {
                    continue;
                }
                // The other is nearer where h > D/2, h + y_u > a, h − y_u > −a, and the same with v.
                let mut planes = vec![(-ahead, -0.5 * along)];
                for side in sides {
                    planes.push((-(ahead + side), -side.dot(&to)));
                    planes.push((-(ahead - side), side.dot(&to)));
                }
                let mut left = parts;
                parts = Vec::new();
                for (normal, offset) in planes {
                    let (inside, outside) = divided(&left, &normal, offset);
                    parts.extend(outside);
                    left = inside;
                }
            }
            kept.extend(parts);
        }
    }
    kept
}

/// The parts with normal · y ≤ offset, and those beyond.
fn divided(
    parts: &[Polyhedron],
    normal: &Vector3<f64>,
    offset: f64,
) -> (Vec<Polyhedron>, Vec<Polyhedron>) {
    let mut scratch = ClipScratch::default();
    let mut side = |sign: f64| {
        let plane = HalfSpace {
            normal: normal * sign,
            offset: offset * sign,
        };
        let mut kept = parts.to_vec();
        kept.retain_mut(|part| clip(part, &plane, 0, &mut scratch) != Clip::Emptied);
        kept
    };
    (side(1.0), side(-1.0))
}

#[test]
fn integrals_agree_with_parts_by_subtraction() {
    let all = [
        random_sites(12, 5),
        rounded(12, 6, &[0, 1, 2], 3.0),
        grid_sites(2),
    ];
    for sites in all {
        let unit = Cuboid::unit();
        let diagram = Diagram::new(&unit, &sites).expect("a diagram");
        let found = diagram
            .map_linf(Ties::ToSmallerIndex, |solid: &mut FacetedSolid, cell| {
                solid.clear();
                cell.visit_boundary(|_, corners| solid.push(corners));
                let off = Vector3::new(0.05, -0.02, 0.03);
                [0, 1, 2, 3, 4].map(|order| match order {
                    0..4 => cell.integrals(order).iter().sum::<f64>(),
                    _ => solid.energy(&off, 1).value,
                })
            })
            .expect("no duplicates");
        for (site, integrals) in found.into_iter().enumerate() {
            let parts = parts_by_subtraction(&sites, site);
            let volume: f64 = parts.iter().map(|part| part.moments().mass).sum();
            assert!(
                (integrals[0] - volume).abs() < 1e-12,
                "{} {volume}",
                integrals[0]
            );
            let mut pieces = Vec::new();
            for (number, part) in parts.iter().enumerate() {
                SignedPiece::place(&mut pieces, number, 1.0).assign(Piece::Convex(part));
            }
            let mut scratch = EnergyScratch::default();
            let off = Vector3::new(0.05, -0.02, 0.03);
            for (place, center, order) in [
                (1, Vector3::zeros(), 1),
                (2, Vector3::zeros(), 2),
                (3, Vector3::zeros(), 3),
                (4, off, 1),
            ] {
                let expected = energy(&pieces, &center, order, &mut scratch).value;
                let error = (integrals[place] - expected).abs();
                assert!(
                    error < 1e-10 * expected,
                    "order {order}: {error:e} of {expected}"
                );
            }
        }
    }
}

/// Sums over the ways of corners against sums over the boundary, about centers near and far.
#[test]
fn swept_energies_are_those_of_the_boundary() {
    let unit = Cuboid::unit();
    for sites in [
        random_sites(30, 8),
        rounded(20, 6, &[0, 1, 2], 3.0),
        grid_sites(2),
    ] {
        let diagram = Diagram::new(&unit, &sites).expect("a diagram");
        let errors = |(): &mut (), cell: LinfCell<'_>| {
            let (mut swept, mut solid) = (SweptSolid::default(), FacetedSolid::default());
            for (number, cone) in Cone::all().into_iter().enumerate() {
                cell.visit_corner_paths(number, |ends, is_added| {
                    swept.push(CornerPath { ends, is_added });
                });
                let [u, v] = cone.transverse();
                swept.finish_part([cone.axis, u, v], cone.is_negative);
            }
            cell.visit_boundary(|_, corners| solid.push(corners));
            let centers = [
                [0.0; 3],
                [0.011, -0.023, 0.017],
                [0.2, 0.1, -0.15],
                [1.5, -2.0, 0.7],
            ];
            centers.map(|center| {
                let center = Vector3::from(center);
                let (one, other) = (swept.energy(&center), solid.energy(&center, 1));
                let value = (one.value / other.value - 1.0).abs();
                let gradient = (one.gradient - other.gradient).amax() / cell.volume();
                let hessian = (one.hessian - other.hessian).amax() / cell.volume().powf(2.0 / 3.0);
                // About the site of a lattice, sides of the cell lie on interfaces.
                let hessian = if center.amax() > 0.0 { hessian } else { 0.0 };
                value.max(gradient).max(hessian)
            })
        };
        let errors = diagram.map_linf(Ties::ToSmallerIndex, errors);
        for error in errors.expect("no duplicates").into_iter().flatten() {
            assert!(error < 1e-11, "{error:e}");
        }
    }
}

/// Central differences of the energy of a cell against its gradient, and of that against the Hessian.
#[test]
fn derivatives_of_a_cells_energy_agree_with_differences() {
    let sites = random_sites(20, 9);
    let unit = Cuboid::unit();
    let diagram = Diagram::new(&unit, &sites).expect("a diagram");
    let solid = |(): &mut (), cell: LinfCell<'_>| {
        let mut solid = FacetedSolid::default();
        cell.visit_boundary(|_, corners| solid.push(corners));
        solid
    };
    let solids = diagram
        .map_linf(Ties::ToSmallerIndex, solid)
        .expect("no duplicates");
    for (site, mut solid) in solids.into_iter().enumerate() {
        for order in [1, 2, 3] {
            let center = Vector3::new(0.011, -0.023, 0.017) * (site % 3) as f64;
            let about = solid.energy(&center, order);
            for axis in 0..3 {
                let step = Vector3::ith(axis, 1e-5);
                let [low, high] =
                    [-1.0, 1.0].map(|sign| solid.energy(&(center + step * sign), order));
                let slope = (high.value - low.value) / 2e-5;
                assert!(
                    (slope - about.gradient[axis]).abs() < 1e-8,
                    "order {order}: {slope} {}",
                    about.gradient
                );
                let turn = (high.gradient - low.gradient) / 2e-5;
                let error = (turn - about.hessian.column(axis)).amax();
                assert!(
                    error < 1e-4 * about.hessian.amax(),
                    "order {order}: {error:e} {}",
                    about.hessian
                );
            }
        }
    }
}

#[test]
fn outlines_enclose_the_cells_with_one_facet_per_neighbor_and_plane() {
    let all = [
        ("random", random_sites(60, 3)),
        ("grid", grid_sites(3)),
        ("rounded", rounded(40, 4, &[0, 1, 2], 4.0)),
    ];
    for (name, sites) in all {
        let unit = Cuboid::unit();
        let diagram = Diagram::new(&unit, &sites).expect("a diagram");
        let outline = |(): &mut (), cell: LinfCell<'_>| (cell.volume(), cell.outline());
        let outlines = diagram
            .map_linf(Ties::ToSmallerIndex, outline)
            .expect("no duplicates");
        for (site, (volume, outline)) in outlines.into_iter().enumerate() {
            let outline = outline.unwrap_or_else(|| panic!("{name}: {site} is not closed"));
            let extent = Piece::Brep(&outline).extent();
            assert!(extent.gap.amax() < 1e-12, "{name}: {}", extent.gap);
            assert!(
                (extent.volume - volume).abs() < 1e-12,
                "{name}: {} {volume}",
                extent.volume
            );
            let shell = Shell::from(Piece::Brep(&outline));
            assert!(
                (shell.volume() - volume).abs() < 1e-12,
                "{name}: {} {volume}",
                shell.volume()
            );
            if name == "grid" {
                assert_eq!(outline.facets.len(), 6);
            }
        }
    }
}
