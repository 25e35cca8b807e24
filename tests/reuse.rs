//! Cells carried from one diagram to the next are those of a cold build, to the bit.

use std::ops::ControlFlow;

use chebloyd::domain::convex::ConvexPolyhedron;
use chebloyd::domain::cuboid::Cuboid;
use chebloyd::domain::domain::Domain;
use chebloyd::domain::shape::DomainShape;
use chebloyd::geometry::bounds::Bounds;
use chebloyd::geometry::half_space::HalfSpace;
use chebloyd::geometry::random::Random;
use chebloyd::relax::cell_memory::CellMemory;
use chebloyd::relax::lloyd::{LloydOptions, lloyd};
use chebloyd::relax::record::Record;
use chebloyd::relax::space::Space;
use chebloyd::relax::tessellation::{Minimizer, Norm, Question, Tessellation};
use chebloyd::voronoi::carried::Carried;
use chebloyd::voronoi::cell::Cell;
use chebloyd::voronoi::diagram::{Diagram, DiagramError};
use nalgebra::{Point3, Vector3};
use rayon::ThreadPoolBuilder;

const QUESTION: Question = Question {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

/// A vector in [−1, 1]³.
fn step(random: &mut Random) -> Vector3<f64> {
    Vector3::from_fn(|_, _| 2.0 * random.uniform() - 1.0)
}

/// All bits of a cell, and what it is worth.
#[derive(Clone, Debug, PartialEq)]
struct Digest {
    labels: Vec<u64>,
    corners: Vec<[u64; 3]>,
    volume: f64,
    energy: f64,
}

fn digest(domain: &dyn Domain, memory: &mut CellMemory, cell: &Cell<'_>) -> Digest {
    memory.load(domain, cell);
    let bits = |corner: Point3<f64>| [corner.x, corner.y, corner.z].map(f64::to_bits);
    Digest {
        labels: cell.polyhedron().facets().map(|f| f.label()).collect(),
        corners: cell
            .polyhedron()
            .facets()
            .flat_map(|f| f.corners())
            .map(bits)
            .collect(),
        volume: memory.volume(),
        energy: memory.evaluate(&Vector3::zeros(), 1).value,
    }
}

fn carried(domain: &dyn Domain, sites: &[Point3<f64>], carried: &mut Carried) -> Vec<Digest> {
    let diagram = Diagram::new(domain, sites).unwrap();
    let ask = |memory: &mut CellMemory, cell: Cell<'_>| digest(domain, memory, &cell);
    diagram.map_carried(carried, ask).unwrap()
}

/// Checks carried cells against those realized from a cold build, to the bit, and against those
/// that were only cut; returns how many had to be rebuilt.
fn check(domain: &dyn Domain, sites: &[Point3<f64>], from_before: &mut Carried) -> usize {
    let found = carried(domain, sites, from_before);
    let cold = carried(domain, sites, &mut Carried::default());
    assert!(found == cold, "carried cells differ from cold ones");
    let diagram = Diagram::new(domain, sites).unwrap();
    let ask = |memory: &mut CellMemory, cell: Cell<'_>| digest(domain, memory, &cell);
    let cut = diagram.map(ask).unwrap();
    for (site, (found, cut)) in found.iter().zip(&cut).enumerate() {
        let sorted = |labels: &[u64]| {
            let mut labels = labels.to_vec();
            labels.sort_unstable();
            labels
        };
        assert_eq!(sorted(&found.labels), sorted(&cut.labels), "site {site}");
        for (found, cut) in [(found.volume, cut.volume), (found.energy, cut.energy)] {
            assert!(
                (found - cut).abs() <= 1e-13 * cut,
                "site {site}: {found} {cut}"
            );
        }
    }
    from_before.rebuilt()
}

fn tilted() -> ConvexPolyhedron {
    let walls: Vec<_> = (0..8)
        .map(|signs| {
            let sign = |axis: u32| if signs >> axis & 1 == 1 { -1.0 } else { 1.0 };
            HalfSpace {
                normal: Vector3::new(sign(0), 1.1 * sign(1), 0.9 * sign(2)),
                offset: 1.0,
            }
        })
        .collect();
    ConvexPolyhedron::new(&walls).unwrap()
}

fn periodic(axes: [bool; 3]) -> Cuboid {
    let bounds = Bounds {
        min: Point3::new(-0.25, 0.0, 1.0),
        max: Point3::new(0.75, 1.0, 2.0),
    };
    Cuboid::new(bounds, axes).unwrap()
}

fn random_sites(domain: &dyn Domain, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let (bounds, mut sites) = (domain.bounds(), Vec::new());
    while sites.len() < count {
        let inside = 0.5 * step(&mut random).component_mul(&bounds.extent());
        let site = bounds.center() + inside;
        if domain.contains(&site) {
            sites.push(site);
        }
    }
    sites
}

/// Moves every site by up to `share` of the mean spacing along each axis.
fn shaken(
    domain: &dyn Domain,
    sites: &[Point3<f64>],
    share: f64,
    random: &mut Random,
) -> Vec<Point3<f64>> {
    let spacing = (domain.volume() / sites.len() as f64).cbrt();
    let moved = |site: &Point3<f64>| {
        let there = site + step(random) * (share * spacing);
        let is_inside = domain.contains(&there);
        domain.wrap(if is_inside { &there } else { site })
    };
    sites.iter().map(moved).collect()
}

#[test]
fn carried_cells_are_cold_cells_all_along_a_relaxation() {
    let space = Space::new(Box::new(Cuboid::unit()));
    let count = 2000;
    let mut sites = random_sites(space.domain(), count, 1);
    let mut from_before = Carried::default();
    let diagonal = 3.0_f64.sqrt() * (1.0 / count as f64).cbrt();
    let mut percent = f64::INFINITY;
    let mut carried_cells = 0;
    for iteration in 0..100 {
        let rebuilt = check(space.domain(), &sites, &mut from_before);
        // Twice what was measured.
        let most = (0.2 + 0.9 * percent).min(1.0) * count as f64;
        assert!(rebuilt as f64 <= most, "{rebuilt} rebuilt in {iteration}");
        carried_cells += count - rebuilt;
        let cells = space.assess(&sites, QUESTION).unwrap();
        let targets: Vec<_> = cells.iter().map(|cell| cell.target).collect();
        let ways = sites.iter().zip(&targets);
        let way: f64 = ways.map(|(from, to)| (to - from).norm()).sum();
        percent = 100.0 * way / count as f64 / diagonal;
        sites = targets;
    }
    assert!(carried_cells > 70 * count, "{carried_cells} carried");
}

#[test]
fn cells_that_change_partners_are_flipped_and_not_rebuilt() {
    let domain = Cuboid::unit();
    let mut random = Random::new(21);
    let mut sites = random_sites(&domain, 3000, 20);
    let mut from_before = Carried::default();
    check(&domain, &sites, &mut from_before);
    // Cells in doubt are always rebuilt.
    let steady = check(&domain, &sites, &mut from_before);
    for share in [1e-3, 3e-3, 1e-2] {
        let labels = |digests: Vec<Digest>| digests.into_iter().map(|digest| digest.labels);
        let before = carried(&domain, &sites, &mut Carried::default());
        sites = shaken(&domain, &sites, share, &mut random);
        let after = carried(&domain, &sites, &mut Carried::default());
        let pairs = labels(before).zip(labels(after));
        let changed = pairs.filter(|(before, after)| before != after).count();
        let rebuilt = check(&domain, &sites, &mut from_before);
        assert!(changed > 50, "{changed} changed at {share}");
        let more = rebuilt.saturating_sub(steady);
        assert!(4 * more < changed, "{more} of {changed} rebuilt at {share}");
    }
}

#[test]
fn flips_that_cells_take_back_mislead_nobody() {
    // Out of two thousand seeds, some in which a cell makes a flip in vain on its way to others.
    for (seed, count) in [(15, 1000), (65, 1000), (101, 60), (142, 1000), (145, 2500)] {
        let domain: Box<dyn Domain> = match seed % 5 {
            0 | 1 => Box::new(Cuboid::unit()),
            2 => Box::new(periodic([true; 3])),
            _ => Box::new(tilted()),
        };
        let mut random = Random::new(seed);
        let mut sites = random_sites(domain.as_ref(), count, seed);
        let mut from_before = Carried::default();
        check(domain.as_ref(), &sites, &mut from_before);
        for share in [1e-4, 1e-3, 1e-2, 2e-2, 3e-3, 1.4e-2, 2e-2, 5e-3] {
            sites = shaken(domain.as_ref(), &sites, share, &mut random);
            check(domain.as_ref(), &sites, &mut from_before);
        }
    }
}

#[test]
fn cells_are_carried_in_every_convex_domain() {
    let periodic_box: Box<dyn Domain> = Box::new(periodic([true; 3]));
    let slab: Box<dyn Domain> = Box::new(periodic([false, true, false]));
    let polyhedron: Box<dyn Domain> = Box::new(tilted());
    for (seed, domain) in [periodic_box, slab, polyhedron].into_iter().enumerate() {
        let mut random = Random::new(seed as u64);
        let mut sites = random_sites(domain.as_ref(), 800, seed as u64);
        let mut from_before = Carried::default();
        check(domain.as_ref(), &sites, &mut from_before);
        for share in [1e-3, 1e-4, 3e-4, 1e-2, 1e-5] {
            sites = shaken(domain.as_ref(), &sites, share, &mut random);
            let rebuilt = check(domain.as_ref(), &sites, &mut from_before);
            let most = 800.0 * (0.1 + 60.0 * share);
            assert!((rebuilt as f64) < most, "{rebuilt} rebuilt at {share}");
        }
    }
}

#[test]
fn a_jump_is_survived() {
    let domain = Cuboid::unit();
    let mut sites = random_sites(&domain, 500, 3);
    let mut from_before = Carried::default();
    check(&domain, &sites, &mut from_before);
    // The mean moves little, but one site moves far and two change places.
    sites[3] = sites[100] + Vector3::repeat(1e-3);
    let nearest = |a: &&usize, b: &&usize| {
        let [a, b] = [**a, **b].map(|other| (sites[other] - sites[10]).norm());
        a.total_cmp(&b)
    };
    let others: Vec<usize> = (11..500).collect();
    let other = *others.iter().min_by(nearest).unwrap();
    sites.swap(10, other);
    let rebuilt = check(&domain, &sites, &mut from_before);
    assert!(rebuilt < 250, "{rebuilt}");
    // Other sites, more sites, the same sites.
    let others = random_sites(&domain, 500, 4);
    assert_eq!(check(&domain, &others, &mut from_before), 500);
    let more = random_sites(&domain, 501, 4);
    assert_eq!(check(&domain, &more, &mut from_before), 501);
    let rebuilt = check(&domain, &more, &mut from_before);
    assert!(rebuilt < 80, "{rebuilt}");
    assert!(from_before.memory() < 800 * 501);
}

#[test]
fn patterns_are_not_kept_where_memory_is_short() {
    let domain = Cuboid::unit();
    let sites = random_sites(&domain, 500, 7);
    let near = shaken(&domain, &sites, 1e-4, &mut Random::new(7));
    for (bytes_per_site, is_kept) in [(0, false), (799, false), (800, true)] {
        let mut from_before = Carried::within(500 * bytes_per_site);
        assert_eq!(check(&domain, &sites, &mut from_before), 500);
        // The sites' numbers and places are all that is left.
        assert_eq!(from_before.memory() > 40 * 500, is_kept);
        let rebuilt = check(&domain, &near, &mut from_before);
        assert_eq!(rebuilt < 500, is_kept, "{rebuilt} of {bytes_per_site}");
    }
}

#[test]
fn lattices_with_any_noise_stay_as_they_are_cut() {
    let domain = Cuboid::unit();
    let lattice = |k: usize| {
        let at = move |n: usize| (n as f64 + 0.5) / k as f64;
        move |n: usize| Point3::new(at(n % k), at(n / k % k), at(n / k / k))
    };
    let mut random = Random::new(5);
    for noise in [0.0, 1e-16, 1e-14, 1e-12, 1e-9, 1e-7, 1e-6, 1e-5] {
        let mut sites: Vec<_> = (0..216).map(lattice(6)).collect();
        let mut from_before = Carried::default();
        for _ in 0..4 {
            check(&domain, &sites, &mut from_before);
            sites = shaken(&domain, &sites, noise, &mut random);
        }
    }
}

/// The sites of a lattice of k³ cubes that hold some sites each.
fn lattice(k: usize, in_cube: &[[f64; 3]]) -> Vec<Point3<f64>> {
    let cubes = (0..k.pow(3)).map(|n| [n % k, n / k % k, n / k / k].map(|n| n as f64));
    let sites = cubes.flat_map(|[x, y, z]| {
        let at = move |[a, b, c]: [f64; 3]| Point3::new(x + a, y + b, z + c) / k as f64;
        in_cube.iter().map(move |&place| at(place))
    });
    sites.collect()
}

#[test]
fn what_leaves_an_exact_lattice_is_right() {
    // Places that are binary fractions, so that sites touch others' cells to the last bit.
    let (cubic, body_centered) = ([[0.5; 3]], [[0.25; 3], [0.75; 3]]);
    let [low, high] = [0.25, 0.75];
    let face_centered = [
        [low, low, low],
        [low, high, high],
        [high, low, high],
        [high, high, low],
    ];
    let lattices = [2, 4, 7, 8].map(|k| lattice(k, &cubic)).into_iter();
    let others = [lattice(4, &body_centered), lattice(4, &face_centered)];
    for (number, sites) in lattices.chain(others).enumerate() {
        for share in [1e-9, 1e-4, 1e-3, 1e-2] {
            let (domain, mut random) = (Cuboid::unit(), Random::new(number as u64));
            let mut from_before = Carried::default();
            for _ in 0..2 {
                check(&domain, &sites, &mut from_before);
            }
            let left = shaken(&domain, &sites, share, &mut random);
            check(&domain, &left, &mut from_before);
        }
    }
}

#[test]
fn a_lattice_is_not_carried() {
    let domain = Cuboid::unit();
    let at = |n: usize| (n as f64 + 0.5) / 9.0;
    let lattice = (0..729).map(|n| Point3::new(at(n % 9), at(n / 9 % 9), at(n / 81)));
    let sites: Vec<_> = lattice.collect();
    let diagram = Diagram::new(&domain, &sites).unwrap();
    let ask = |memory: &mut CellMemory, cell: Cell<'_>| digest(&domain, memory, &cell);
    let cut = diagram.map(ask).unwrap();
    let mut from_before = Carried::default();
    for _ in 0..2 {
        assert!(carried(&domain, &sites, &mut from_before) == cut);
        assert_eq!(from_before.rebuilt(), 729);
        // Where the sites were, and how they are numbered.
        assert!(from_before.memory() < 40 * 729);
    }
    // Sites that leave it are carried as ever.
    let mut random = Random::new(3);
    let left = shaken(&domain, &sites, 0.2, &mut random);
    assert_eq!(check(&domain, &left, &mut from_before), 729);
    let near = shaken(&domain, &left, 1e-6, &mut random);
    assert!(check(&domain, &near, &mut from_before) < 365);
}

#[test]
fn sites_beside_and_above_each_other_are_told_apart() {
    let domain = Cuboid::unit();
    let mut random = Random::new(6);
    let mut sites = random_sites(&domain, 300, 6);
    // Pairs at all distances down to rounding, and many sites on one sphere.
    for pair in 0..40 {
        let apart = 0.05 * 0.4_f64.powi(pair);
        let there = sites[pair as usize] + step(&mut random) * apart;
        if domain.contains(&there) && there != sites[pair as usize] {
            sites.push(there);
        }
    }
    let middle = Point3::new(0.5, 0.5, 0.5);
    sites.retain(|site| (site - middle).norm() > 0.3);
    for _ in 0..100 {
        sites.push(middle + step(&mut random).normalize() * 0.2);
    }
    let mut from_before = Carried::default();
    for share in [0.0, 1e-15, 1e-12, 1e-8, 1e-5, 1e-4] {
        sites = shaken(&domain, &sites, share, &mut random);
        check(&domain, &sites, &mut from_before);
    }
}

#[test]
fn a_crowd_among_others_is_carried() {
    let (domain, mut random) = (Cuboid::unit(), Random::new(13));
    let mut sites = random_sites(&domain, 600, 12);
    let middle = Point3::new(0.4, 0.5, 0.6);
    sites.extend((0..400).map(|_| middle + step(&mut random) * 0.02));
    let mut from_before = Carried::default();
    let mut rebuilt = Vec::new();
    for share in [0.0, 0.0, 1e-7, 1e-6, 1e-5, 1e-4] {
        sites = shaken(&domain, &sites, share, &mut random);
        rebuilt.push(check(&domain, &sites, &mut from_before));
    }
    assert!(rebuilt[0] == 1000 && rebuilt[1] < 200 && rebuilt[4] > rebuilt[1]);
}

#[test]
fn duplicates_are_named_as_ever() {
    let domain = Cuboid::unit();
    let mut sites = random_sites(&domain, 200, 8);
    let mut from_before = Carried::default();
    check(&domain, &sites, &mut from_before);
    sites[150] = sites[20];
    let diagram = Diagram::new(&domain, &sites).unwrap();
    let told = diagram.map_carried(&mut from_before, |(): &mut (), _| ());
    let pair = |error: DiagramError| match error {
        DiagramError::Duplicate { first, second, .. } => (first, second),
        other => panic!("{other}"),
    };
    assert_eq!(told.map_err(pair), Err((20, 150)));
    sites[150] = Point3::new(0.5, 0.5, 0.5);
    check(&domain, &sites, &mut from_before);
}

/// Energies after some of Lloyd's moves, with so many threads.
fn run(threads: usize, carries: bool) -> Vec<Point3<f64>> {
    let pool = ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        let space = Space::new(Box::new(Cuboid::unit()));
        let mut sites = random_sites(space.domain(), 1000, 9);
        for _ in 0..20 {
            let cold = Space::new(Box::new(Cuboid::unit()));
            let space = if carries { &space } else { &cold };
            let cells = space.assess_near(&sites, QUESTION).unwrap();
            sites = cells.iter().map(|cell| cell.target).collect();
        }
        sites
    })
}

#[test]
fn neither_threads_nor_carrying_shows_in_the_sites() {
    let once = run(1, true);
    for (threads, carries) in [(2, true), (3, true), (2, false)] {
        assert_eq!(run(threads, carries), once);
    }
}

#[test]
fn the_objective_of_near_sites_is_that_of_any() {
    let space = Space::new(Box::new(Cuboid::unit()));
    let mut sites = random_sites(space.domain(), 800, 12);
    for turn in 0..4 {
        let near = space.global_near(&sites, 1).unwrap();
        let fresh = Space::new(Box::new(Cuboid::unit()));
        assert_eq!(near, fresh.global_near(&sites, 1).unwrap(), "{turn}");
        let cold = space.global(&sites, 1).unwrap();
        let difference = (near.energy - cold.energy).abs();
        assert!(difference < 1e-13 * cold.energy, "{turn}: {difference:e}");
        // Gradients are sums of volumes of about 1/800.
        for (one, other) in near.gradient.iter().zip(&cold.gradient) {
            assert!((one - other).amax() < 1e-15, "{turn}");
        }
        assert!(turn == 0 || space.rebuilt() < 400, "{}", space.rebuilt());
        let cells = space.assess(&sites, QUESTION).unwrap();
        for (site, cell) in sites.iter_mut().zip(&cells) {
            *site += (cell.target - *site) * 0.02;
        }
    }
}

fn check_resumption(is_accelerated: bool) {
    let options = LloydOptions {
        iterations: 60,
        tolerance: 0.0,
        question: QUESTION,
        is_accelerated,
    };
    let space = || Space::new(Box::new(Cuboid::unit()));
    let whole = space();
    let mut sites = random_sites(whole.domain(), 400, 10);
    let mut records: Vec<(Record, Vec<Point3<f64>>)> = Vec::new();
    let mut keep = |record: &Record, sites: &[Point3<f64>]| {
        records.push((record.clone(), sites.to_vec()));
        ControlFlow::Continue(())
    };
    lloyd(&whole, &mut sites, &options, None, &mut keep).unwrap();
    assert!(whole.rebuilt() < 300, "{}", whole.rebuilt());
    for stop in [5, 17, 41] {
        let (record, mut sites) = records[stop].clone();
        let mut at = stop;
        let mut compare = |record: &Record, sites: &[Point3<f64>]| {
            at += 1;
            let (whole, whole_sites) = &records[at];
            assert_eq!(record.energy_mean.to_bits(), whole.energy_mean.to_bits());
            assert_eq!(sites, whole_sites);
            ControlFlow::Continue(())
        };
        lloyd(&space(), &mut sites, &options, Some(&record), &mut compare).unwrap();
        assert_eq!(at, 60);
    }
}

#[test]
fn a_run_goes_on_without_patterns_to_the_same_bits() {
    check_resumption(false);
    check_resumption(true);
}
