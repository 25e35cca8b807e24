//! Diagrams: cells that fill the domain, whatever the sites.

use std::collections::BTreeSet;

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::error::DomainError;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::random::Random;
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};
use nalgebra::{Point3, Vector3};

fn points(random: &mut Random, count: usize) -> Vec<Point3<f64>> {
    let unit = Cuboid::unit().bounds();
    (0..count).map(|_| random.point(&unit)).collect()
}

/// A k×k×k lattice in the unit cube, each coordinate moved by up to ± noise.
fn lattice(k: usize, noise: f64) -> Vec<Point3<f64>> {
    let (unit, mut random) = (Cuboid::unit().bounds(), Random::new(k as u64));
    (0..k * k * k)
        .map(|n| {
            let cell = Vector3::new((n % k) as f64, (n / k % k) as f64, (n / k / k) as f64);
            let shift = random.point(&unit).coords.add_scalar(-0.5) * (2.0 * noise);
            Point3::from(cell.add_scalar(0.5) / k as f64 + shift)
        })
        .collect()
}

fn octahedron() -> ConvexPolyhedron {
    let walls: Vec<_> = (0..8)
        .map(|signs| {
            let sign = |axis: u32| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
            HalfSpace {
                normal: Vector3::new(sign(0), sign(1), sign(2)),
                offset: 1.0,
            }
        })
        .collect();
    ConvexPolyhedron::new(&walls).unwrap()
}

/// Per cell: its volume and its neighbors across facets of at least `least` area.
fn cells(
    domain: &dyn Domain,
    sites: &[Point3<f64>],
    least: f64,
) -> Vec<(f64, BTreeSet<FacetKind>)> {
    let figures = |(): &mut (), cell: crate::voronoi::cell::Cell<'_>| {
        let facets = cell.polyhedron().facets();
        let large = facets.filter(|facet| facet.area_vector().norm() > least);
        let neighbors = large.map(|facet| FacetKind::of(facet.label())).collect();
        (cell.polyhedron().moments().mass, neighbors)
    };
    Diagram::new(domain, sites).unwrap().map(figures).unwrap()
}

fn assert_fills(domain: &dyn Domain, sites: &[Point3<f64>], what: &str) {
    if let Err(error) = Diagram::new(domain, sites).unwrap().check() {
        panic!("{what}: {error}");
    }
    assert_volumes(domain, sites, what);
}

fn assert_volumes(domain: &dyn Domain, sites: &[Point3<f64>], what: &str) {
    let cells = cells(domain, sites, 0.0);
    let sum: f64 = cells.iter().map(|(volume, _)| volume).sum();
    let error = (sum / domain.volume() - 1.0).abs();
    assert!(
        error <= 1e-12,
        "{what}: the volumes sum to {sum}, off by {error:e}"
    );
    assert!(
        cells.iter().all(|(volume, _)| *volume >= 0.0),
        "{what}: a negative volume"
    );
}

fn periodic(axes: [bool; 3]) -> Cuboid {
    Cuboid::new(Cuboid::unit().bounds(), axes).unwrap()
}

#[test]
fn random_cells_fill_every_domain() {
    for count in [1, 2, 3, 5, 20, 300, 3000] {
        let sites = points(&mut Random::new(count as u64), count);
        for axes in 0..8 {
            let domain = periodic([0, 1, 2].map(|axis| axes >> axis & 1 == 1));
            assert_fills(
                &domain,
                &sites,
                &format!("{count} sites, periodic axes {axes:03b}"),
            );
        }
        let solid = octahedron();
        let inside = |p: &Point3<f64>| solid.contains(&(p * 2.0 - Vector3::repeat(1.0)));
        let sites: Vec<_> = sites
            .iter()
            .filter(|p| inside(p))
            .map(|p| p * 2.0 - Vector3::repeat(1.0))
            .collect();
        if !sites.is_empty() {
            assert_fills(&solid, &sites, &format!("octahedron, {count} sites drawn"));
        }
    }
}

#[test]
fn lattices_with_and_without_noise_fill_the_cube() {
    for k in [2, 3, 6, 10] {
        for noise in [0.0, 1e-16, 1e-15, 1e-14, 1e-12, 1e-9, 1e-6] {
            let sites = lattice(k, noise);
            assert_fills(
                &Cuboid::unit(),
                &sites,
                &format!("lattice {k}, noise {noise:e}"),
            );
            assert_fills(
                &periodic([true; 3]),
                &sites,
                &format!("torus {k}, noise {noise:e}"),
            );
        }
    }
}

#[test]
fn flat_sets_and_sites_on_walls_fill_the_cube() {
    let mut random = Random::new(7);
    let mut sets: Vec<(&str, Vec<Point3<f64>>)> = Vec::new();
    let on_plane = |p: Point3<f64>| Point3::new(p.x, p.y, 0.3);
    sets.push((
        "coplanar",
        points(&mut random, 200).into_iter().map(on_plane).collect(),
    ));
    let on_line = |p: Point3<f64>| Point3::new(p.x, 0.5 * p.x, 1.0 - p.x);
    sets.push((
        "collinear",
        points(&mut random, 100).into_iter().map(on_line).collect(),
    ));
    let on_wall = |p: Point3<f64>| Point3::new(p.x, p.y, p.z.round());
    sets.push((
        "on walls",
        points(&mut random, 200).into_iter().map(on_wall).collect(),
    ));
    let corner = |k: u8| Point3::from([0, 1, 2].map(|axis| f64::from(k >> axis & 1)));
    sets.push(("in the corners", (0..8).map(corner).collect()));
    let on_edge = |p: Point3<f64>| Point3::new(p.x, 0.0, 1.0);
    sets.push((
        "on an edge",
        points(&mut random, 50).into_iter().map(on_edge).collect(),
    ));
    let direction = |p: Point3<f64>| (p.coords.add_scalar(-0.5)).normalize() * 0.4;
    let sphere = points(&mut random, 500).into_iter().map(direction);
    let sphere = sphere.map(|d| Point3::from(d.add_scalar(0.5)));
    sets.push((
        "cospherical",
        sphere.chain([Point3::new(0.5, 0.5, 0.5)]).collect(),
    ));
    let clustered = |p: Point3<f64>| Point3::from(p.coords * 1e-4);
    sets.push((
        "clustered",
        points(&mut random, 500)
            .into_iter()
            .map(clustered)
            .collect(),
    ));
    for (what, sites) in &sets {
        assert_fills(&Cuboid::unit(), sites, what);
    }
}

#[test]
fn sites_next_to_each_other_have_cells() {
    for gap in [1e-3, 1e-9, 1e-12, 1e-15, 1e-150] {
        // Near the origin coordinates resolve any gap. Which of the two is a far site's neighbor may
        // differ between the cells, since the far site cannot tell them apart.
        let mut sites = vec![Point3::new(0.5, 0.5, 0.5), Point3::new(0.25, 0.5, 0.75)];
        sites.push(Point3::origin());
        sites.push(Point3::new(gap, 0.0, 0.0));
        assert_volumes(&Cuboid::unit(), &sites, &format!("gap {gap:e}"));
    }
    let next = Point3::new(0.5_f64.next_up(), 0.5, 0.5);
    assert_volumes(
        &Cuboid::unit(),
        &[Point3::new(0.5, 0.5, 0.5), next],
        "one ulp",
    );
}

/// Compares all cells in the unit cube with those cut by every other site in turn.
fn assert_brute_force_agrees(sites: &[Point3<f64>], what: &str) {
    let domain = Cuboid::unit();
    let mut scratch = ClipScratch::default();
    for (site, (volume, neighbors)) in cells(&domain, sites, 1e-12).iter().enumerate() {
        let mut cell = Polyhedron::default();
        domain.start(&sites[site], site as u32, &mut cell);
        for (other, position) in sites.iter().enumerate().filter(|(other, _)| *other != site) {
            let bisector = HalfSpace::bisector(position - sites[site]);
            let neighbor = FacetKind::Neighbor {
                site: other as u32,
                image: [0; 3],
            };
            clip(&mut cell, &bisector, neighbor.label(), &mut scratch);
        }
        assert!((cell.moments().mass - volume).abs() < 1e-14, "{what}");
        let large = cell
            .facets()
            .filter(|facet| facet.area_vector().norm() > 1e-12);
        let expected: BTreeSet<_> = large.map(|facet| FacetKind::of(facet.label())).collect();
        assert_eq!(&expected, neighbors, "{what}, site {site}");
    }
}

#[test]
fn cells_agree_with_brute_force() {
    assert_brute_force_agrees(&points(&mut Random::new(11), 150), "uniform");
}

#[test]
fn clustered_and_lopsided_cells_agree_with_brute_force() {
    let mut random = Random::new(15);
    let mut of = |place: fn(Point3<f64>) -> Point3<f64>| -> Vec<Point3<f64>> {
        points(&mut random, 400).into_iter().map(place).collect()
    };
    let cluster = of(|p| Point3::from((p.coords * 0.1).add_scalar(0.4)));
    let with_others = [cluster.clone(), of(|p| p)[..20].to_vec()].concat();
    let rod = of(|p| Point3::new(p.x, 0.5 + 1e-3 * p.y, 0.5 + 1e-3 * p.z));
    let layer = of(|p| Point3::new(p.x, p.y, 0.5 + 1e-4 * p.z));
    let graded = of(|p| Point3::from(p.coords.map(|x| x.powi(5))));
    // About the middle, a cell of several hundred facets.
    let toward = |p: Point3<f64>| p.coords.add_scalar(-0.5).normalize();
    let sphere = of(|p| p).into_iter().map(toward);
    let mut sphere: Vec<_> = sphere
        .map(|way| Point3::from((way * 0.4).add_scalar(0.5)))
        .collect();
    sphere.push(Point3::new(0.5, 0.5, 0.5));
    for (what, sites) in [
        ("cluster", cluster),
        ("cluster among few", with_others),
        ("rod", rod),
        ("layer", layer),
        ("graded", graded),
        ("sphere", sphere),
    ] {
        assert_brute_force_agrees(&sites, what);
    }
}

#[test]
fn neighbors_are_mutual_across_periodic_sides_too() {
    let sites = points(&mut Random::new(12), 400);
    for axes in [[false; 3], [true, false, true], [true; 3]] {
        let cells = cells(&periodic(axes), &sites, 1e-10);
        for (site, (_, neighbors)) in cells.iter().enumerate() {
            for neighbor in neighbors {
                let FacetKind::Neighbor { site: other, image } = *neighbor else {
                    continue;
                };
                let back = FacetKind::Neighbor {
                    site: site as u32,
                    image: image.map(|n| -n),
                };
                assert!(
                    cells[other as usize].1.contains(&back),
                    "{site} and {other}"
                );
            }
        }
    }
}

#[test]
fn lattices_have_the_facets_of_their_books() {
    let count_of = |sites: Vec<Point3<f64>>, expected: usize| {
        for (_, neighbors) in cells(&periodic([true; 3]), &sites, 1e-9) {
            assert_eq!(neighbors.len(), expected);
        }
    };
    let shifted = |k: usize, shifts: &[[f64; 3]]| -> Vec<Point3<f64>> {
        let shift = |p: Point3<f64>, s: &[f64; 3]| p + Vector3::from(*s) / k as f64;
        let base = lattice(k, 0.0)
            .into_iter()
            .map(|p| p - Vector3::repeat(0.5 / k as f64));
        base.flat_map(|p| shifts.iter().map(move |s| shift(p, s)).collect::<Vec<_>>())
            .collect()
    };
    count_of(shifted(4, &[[0.0; 3]]), 6);
    count_of(shifted(3, &[[0.0; 3], [0.5; 3]]), 14);
    let faces = [
        [0.0, 0.0, 0.0],
        [0.5, 0.5, 0.0],
        [0.5, 0.0, 0.5],
        [0.0, 0.5, 0.5],
    ];
    count_of(shifted(3, &faces), 12);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let sites = points(&mut Random::new(13), 2000);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| cells(&Cuboid::unit(), &sites, 0.0))
    };
    let one: Vec<_> = with(1)
        .into_iter()
        .map(|(volume, n)| (volume.to_bits(), n))
        .collect();
    for threads in [2, 3, 8] {
        let many = with(threads)
            .into_iter()
            .map(|(volume, n)| (volume.to_bits(), n));
        assert!(many.eq(one.iter().cloned()), "{threads} threads");
    }
}

#[test]
fn a_periodic_diagram_does_not_see_where_its_box_begins() {
    let sites = points(&mut Random::new(14), 200);
    let domain = periodic([true; 3]);
    let moved = sites
        .iter()
        .map(|p| domain.wrap(&(p + Vector3::new(0.3, 0.9, 0.5))));
    let moved: Vec<_> = moved.collect();
    let (here, there) = (cells(&domain, &sites, 1e-9), cells(&domain, &moved, 1e-9));
    for ((one, _), (other, _)) in here.iter().zip(&there) {
        assert!((one - other).abs() < 1e-13);
    }
}

#[test]
fn sites_without_a_diagram_are_named() {
    let domain = Cuboid::unit();
    let good = Point3::new(0.5, 0.5, 0.5);
    let refused = |sites: &[Point3<f64>]| {
        let diagram = Diagram::new(&domain, sites);
        diagram
            .and_then(|d| d.map(|(): &mut (), _| ()))
            .unwrap_err()
    };
    assert_eq!(refused(&[]), DiagramError::NoSites);
    let outside = [0.5, 1.5, 0.5];
    let expected = DiagramError::Outside {
        site: 1,
        position: outside,
    };
    assert_eq!(refused(&[good, Point3::from(outside)]), expected);
    let nan = refused(&[Point3::new(f64::NAN, 0.0, 0.0)]);
    assert!(matches!(nan, DiagramError::NotFinite { site: 0, .. }));
    let other = Point3::new(0.1, 0.1, 0.1);
    let expected = DiagramError::Duplicate {
        first: 1,
        second: 2,
        position: [0.5; 3],
    };
    assert_eq!(refused(&[other, good, good]), expected);
    // Opposite sides of a periodic box are the same place.
    let torus = periodic([true, false, false]);
    let sides = [Point3::new(0.0, 0.5, 0.5), Point3::new(1.0, 0.5, 0.5)];
    let coincident = Diagram::new(&torus, &sides)
        .unwrap()
        .map(|(): &mut (), _| ());
    assert!(matches!(
        coincident,
        Err(DiagramError::Duplicate {
            first: 0,
            second: 1,
            ..
        })
    ));
}

#[test]
fn a_cluster_in_one_place_is_named() {
    let domain = Cuboid::unit();
    let mut sites = points(&mut Random::new(4), 2000);
    for number in 1000..1600 {
        sites[number] = sites[7];
    }
    let diagram = Diagram::new(&domain, &sites).expect("sites in the cube");
    let refused = diagram.map(|(): &mut (), _| ());
    let pair = |error: DiagramError| match error {
        DiagramError::Duplicate { first, second, .. } => (first, second),
        other => panic!("{other}"),
    };
    assert_eq!(refused.map_err(pair), Err((7, 1000)));
}

#[test]
fn what_is_not_a_domain_is_refused() {
    let wall = |normal: [f64; 3], offset: f64| HalfSpace {
        normal: Vector3::from(normal),
        offset,
    };
    let below = wall([0.0, 0.0, 1.0], 1.0);
    let open = ConvexPolyhedron::new(&[below]);
    assert!(matches!(open, Err(DomainError::Unbounded { count: 1, .. })));
    let above = wall([0.0, 0.0, -1.0], -2.0);
    let nothing = ConvexPolyhedron::new(&[below, above]);
    assert!(matches!(
        nothing,
        Err(DomainError::NoInterior { number: 1 })
    ));
    let no_normal = ConvexPolyhedron::new(&[below, wall([0.0; 3], 1.0)]);
    assert_eq!(no_normal.unwrap_err(), DomainError::NoNormal { number: 1 });
    let nan = ConvexPolyhedron::new(&[wall([0.0, f64::NAN, 1.0], 1.0)]);
    assert!(matches!(nan, Err(DomainError::NotFinite { .. })));
    let flat = Bounds {
        min: Point3::origin(),
        max: Point3::new(1.0, 0.0, 1.0),
    };
    let flat = Cuboid::new(flat, [false; 3]);
    assert!(matches!(
        flat,
        Err(DomainError::EmptyExtent { axis: 1, .. })
    ));
}

#[test]
fn the_octahedron_given_by_half_spaces_has_its_volume() {
    let solid = octahedron();
    assert!((solid.volume() - 4.0 / 3.0).abs() < 1e-15);
    assert!((solid.bounds().max - Point3::new(1.0, 1.0, 1.0)).norm() < 1e-15);
}

#[test]
fn answers_are_told_in_site_order_however_many_there_are() {
    let domain = Cuboid::unit();
    let sites = points(&mut Random::new(11), 5000);
    let diagram = Diagram::new(&domain, &sites).expect("sites in the cube");
    let volume = |(): &mut (), cell: Cell<'_>| cell.polyhedron().moments().mass;
    let expected = diagram.map(volume).expect("distinct sites");
    let mut volumes = Vec::new();
    let push = |site: usize, volume: f64| {
        assert_eq!(site, volumes.len());
        volumes.push(volume);
        Ok::<(), DiagramError>(())
    };
    diagram.stream(volume, push).expect("distinct sites");
    assert_eq!(volumes, expected);
}
