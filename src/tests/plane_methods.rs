//! The plane beyond plain Lloyd: polygons of any shape, periods, densities, descents and squares.

use nalgebra::{Point2, Vector2};

use crate::domain::planar::PlaneDomain;
use crate::domain::planar_error::PlaneDomainError;
use crate::geometry::bounds::Bounds;
use crate::geometry::polygon::ConvexPolygon;
use crate::geometry::random::{Random, points_inside};
use crate::integrals::polynomial::Polynomial;
use crate::relax::driver::{RunEnd, drive};
use crate::relax::multilevel::levels_for_cubes;
use crate::relax::plan::{Perturbation, PerturbationKind, Plan};
use crate::relax::planar::Plane;
use crate::relax::planar_cell::CellInPlane;
use crate::relax::record::Record;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::state::RunState;
use crate::voronoi::planar::diagram::PlaneDiagram;

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

fn loops(list: &[&[[f64; 2]]]) -> Result<PlaneDomain, PlaneDomainError> {
    let points = list.iter().map(|corners| {
        let corners = corners.iter().map(|&corner| Point2::from(corner));
        corners.collect::<Vec<_>>()
    });
    PlaneDomain::from_loops(&points.collect::<Vec<_>>())
}

fn unit_square() -> PlaneDomain {
    PlaneDomain::rectangle(&Bounds::from_corners([0.0; 2], [1.0; 2])).unwrap()
}

const SQUARE: &[[f64; 2]] = &[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];

/// Polygons that are not convex, with their areas.
fn polygons() -> Vec<(&'static str, PlaneDomain, f64)> {
    let elbow = loops(&[&[
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [0.0, 3.0],
    ]]);
    let star: Vec<[f64; 2]> = (0..14)
        .map(|k| {
            let radius = if k % 2 == 0 { 2.0 } else { 0.8 };
            let angle = f64::from(k) * std::f64::consts::TAU / 14.0 + 0.1;
            [radius * angle.cos(), radius * angle.sin()]
        })
        .collect();
    let of_star = 14.0 * 0.5 * 2.0 * 0.8 * (std::f64::consts::TAU / 14.0).sin();
    let hole: &[[f64; 2]] = &[[1.0, 1.0], [3.0, 1.5], [2.0, 3.0]];
    let island: &[[f64; 2]] = &[[1.8, 1.6], [2.2, 1.6], [2.0, 2.0]];
    let touching: &[[f64; 2]] = &[[0.0, 2.0], [1.0, 1.0], [1.0, 3.0]];
    vec![
        ("elbow", elbow.unwrap(), 5.0),
        ("star", loops(&[&star]).unwrap(), of_star),
        ("hole", loops(&[SQUARE, hole]).unwrap(), 16.0 - 1.75),
        (
            "island",
            loops(&[hole, SQUARE, island]).unwrap(),
            16.0 - 1.75 + 0.08,
        ),
        ("touching", loops(&[SQUARE, touching]).unwrap(), 15.0),
    ]
}

fn random_sites(domain: &PlaneDomain, count: usize, seed: u64) -> Vec<Point2<f64>> {
    let holds = |point: &Point2<f64>| domain.contains(point);
    points_inside(count, seed, &domain.bounds(), holds, || None).unwrap()
}

/// All kinds of domains.
fn planes() -> Vec<(&'static str, Plane)> {
    let wide = PlaneDomain::rectangle(&Bounds::from_corners([-1.0, 2.0], [2.0, 3.5])).unwrap();
    let density: Polynomial = "1 + 3*x^2 + y".parse().unwrap();
    let along_y: Polynomial = "1 + 2*y^2".parse().unwrap();
    let mut all = vec![
        ("rectangle", wide.clone()),
        ("periodic along x", wide.clone().repeated([true, false])),
        ("torus", wide.clone().repeated([true, true])),
        ("weighted", wide.clone().weighted(&density).unwrap()),
        (
            "weighted, periodic",
            (wide.repeated([true, false])).weighted(&along_y).unwrap(),
        ),
    ];
    for (name, domain, _) in polygons() {
        let density: Polynomial = "3 + x + 0.25*x*y".parse().unwrap();
        all.push((name, domain.clone()));
        all.push((name, domain.weighted(&density).unwrap()));
    }
    let plane = |(name, domain)| (name, Plane { domain });
    all.into_iter().map(plane).collect()
}

#[test]
fn polygons_of_any_shape_have_their_area_and_their_cells_fill_them() {
    for (name, domain, area) in polygons() {
        assert!((domain.area() / area - 1.0).abs() < 1e-14, "{name}");
        let pieces: f64 = domain.pieces().iter().map(ConvexPolygon::area).sum();
        assert!((pieces / area - 1.0).abs() < 1e-14, "{name}: {pieces}");
        for count in [1, 2, 3, 30, 200] {
            let sites = random_sites(&domain, count, count as u64);
            let diagram = PlaneDiagram::new(&domain, &sites).unwrap();
            let error = diagram.area() / area - 1.0;
            assert!(error.abs() < 1e-12, "{name}, {count}: {error:e}");
        }
    }
}

#[test]
fn cells_of_degenerate_sites_fill_polygons_and_tori() {
    let lattice = |jitter: f64| -> Vec<Point2<f64>> {
        let mut random = Random::new(7);
        let at = |k: usize| (k as f64 + 0.5) / 6.8;
        let site = |k: usize| Point2::new(at(k % 6), at(k / 6));
        let moved = |k| site(k) + Vector2::new(random.uniform(), random.uniform()) * jitter;
        (0..36).map(moved).collect()
    };
    let line: Vec<Point2<f64>> = (0..20)
        .map(|k| Point2::new(0.04 * f64::from(k) + 0.1, 0.5))
        .collect();
    let ell: &[[f64; 2]] = &[
        [-1.0, -1.0],
        [2.0, -1.0],
        [2.0, 2.0],
        [1.5, 2.0],
        [1.5, 1.5],
        [-1.0, 1.5],
    ];
    let domains = [
        loops(&[ell]).unwrap(),
        unit_square().repeated([true, true]),
        unit_square().repeated([false, true]),
    ];
    let sets = [
        lattice(0.0),
        lattice(1e-15),
        lattice(1e-9),
        lattice(0.1),
        line,
    ];
    for domain in &domains {
        for sites in sets
            .iter()
            .chain([&sets[3][..1].to_vec(), &sets[0][..3].to_vec()])
        {
            let diagram = PlaneDiagram::new(domain, sites).unwrap();
            let error = diagram.area() / domain.area() - 1.0;
            assert!(error.abs() < 1e-12, "{} sites: {error:e}", sites.len());
        }
    }
}

#[test]
fn the_nearest_site_owns_a_place_also_across_periods_and_around_corners() {
    for (name, plane) in planes() {
        let domain = &plane.domain;
        let sites = random_sites(domain, 40, 3);
        let diagram = PlaneDiagram::new(domain, &sites).unwrap();
        for place in random_sites(domain, 200, 4) {
            let distance = |site: &Point2<f64>| plane.displacement(site, &place).norm();
            let nearest = (0..sites.len())
                .min_by(|&a, &b| distance(&sites[a]).total_cmp(&distance(&sites[b])))
                .unwrap();
            let cell = &diagram.cells[nearest];
            let arm = Point2::from(plane.displacement(&sites[nearest], &place));
            let holds = |piece: &ConvexPolygon| {
                let edges = piece.edges();
                edges.fold(true, |inside, edge| {
                    let along = edge.end - edge.start;
                    inside && along.perp(&(arm - edge.start)) >= -1e-9
                })
            };
            assert!(cell.pieces().iter().any(holds), "{name}: {place}");
        }
    }
}

#[test]
fn energies_agree_with_sums_over_a_fine_grid() {
    // Brute force: every grid square's middle to the nearest site.
    for (name, plane) in planes() {
        let domain = &plane.domain;
        let sites = random_sites(domain, 6, 5);
        let fine = 150;
        let (bounds, extent) = (domain.bounds(), domain.bounds().extent());
        let mut sums = vec![0.0; sites.len()];
        for k in 0..fine * fine {
            let share = |k: usize| (k as f64 + 0.5) / fine as f64;
            let at = Vector2::new(share(k % fine), share(k / fine));
            let place = bounds.min + at.component_mul(&extent);
            if !domain.contains(&place) {
                continue;
            }
            let arms: Vec<_> = sites
                .iter()
                .map(|s| plane.displacement(s, &place))
                .collect();
            let nearest = (0..sites.len())
                .min_by(|&a, &b| arms[a].norm().total_cmp(&arms[b].norm()))
                .unwrap();
            let density = domain.density().map_or(1.0, |density| {
                density
                    .about(&Point2::origin())
                    .at(&[place.x, place.y, 0.0].into())
            });
            let square = extent.x * extent.y / (fine * fine) as f64;
            sums[nearest] += density * arms[nearest].amax().powi(2) * square;
        }
        let spec = EnergySpec { order: 2, ..LINF };
        let cells = plane.metrics(&sites, spec).unwrap();
        let total: f64 = sums.iter().sum();
        for (cell, sum) in cells.iter().zip(sums) {
            assert!(
                (cell.energy - sum).abs() < 1.2e-2 * total,
                "{name}: {} {sum}",
                cell.energy
            );
        }
        let exact: f64 = cells.iter().map(|cell| cell.energy).sum();
        assert!(
            (exact / total - 1.0).abs() < 1.2e-2,
            "{name}: {exact} {total}"
        );
    }
}

#[test]
fn derivatives_of_a_cells_energy_agree_with_differences_in_any_domain() {
    for (name, plane) in planes() {
        let domain = &plane.domain;
        let sites = random_sites(domain, 12, 6);
        let diagram = PlaneDiagram::new(domain, &sites).unwrap();
        for cell in &diagram.cells[..4] {
            for order in [1, 2, 3] {
                let mut energy = CellInPlane { domain, cell }.energy(order);
                let center = Point2::new(0.031, -0.017);
                let exact = energy.evaluate(&center);
                let step = 1e-5;
                for axis in 0..2 {
                    let mut shift = Vector2::zeros();
                    shift[axis] = step;
                    let [up, down] = [shift, -shift].map(|by| energy.evaluate(&(center + by)));
                    let slope = (up.value - down.value) / (2.0 * step);
                    let bend = (up.gradient - down.gradient) / (2.0 * step);
                    let scale = exact.gradient.amax() + exact.hessian.amax();
                    assert!(
                        (slope - exact.gradient[axis]).abs() < 1e-8 * scale,
                        "{name} {order}"
                    );
                    let off = (bend - exact.hessian.column(axis)).amax();
                    assert!(off < 1e-4 * scale, "{name} {order}: {off:e}");
                }
            }
        }
    }
}

#[test]
fn the_objectives_gradient_agrees_with_differences_in_any_domain() {
    for (name, plane) in planes() {
        let sites = random_sites(&plane.domain, 15, 8);
        for order in [1, 2, 4] {
            let exact = plane.objective(&sites, order).unwrap();
            let spec = EnergySpec { order, ..LINF };
            let total = plane.energy(&sites, spec).unwrap();
            assert!((total / exact.energy - 1.0).abs() < 1e-13);
            let scale = exact.gradient.iter().map(|g| g.amax()).fold(0.0, f64::max);
            for site in [0, 7, 14] {
                for axis in 0..2 {
                    let step = 1e-6;
                    let at = |by: f64| {
                        let mut moved = sites.clone();
                        moved[site][axis] += by;
                        plane.energy(&moved, spec).unwrap()
                    };
                    let slope = (at(step) - at(-step)) / (2.0 * step);
                    let off = (slope - exact.gradient[site][axis]).abs();
                    assert!(
                        off < 1e-6 * scale,
                        "{name}, order {order}: {off:e} of {scale:e}"
                    );
                }
            }
        }
    }
}

/// Runs a plan and returns its records.
fn run(plane: &Plane, plan: &Plan, sites: &mut Vec<Point2<f64>>) -> (Vec<Record>, RunEnd) {
    let mut state = RunState::new(sites.len(), plan.levels);
    let mut records = Vec::new();
    let ended = drive(plane, plan, sites, &mut state, None, &mut |record, _, _| {
        records.push(record.clone());
        std::ops::ControlFlow::Continue(())
    });
    (records, ended.unwrap())
}

fn squares(count: usize) -> Plan {
    Plan {
        levels: levels_for_cubes::<2>(count),
        ..Plan::perturbed(1, Perturbation::default_of(PerturbationKind::Exchange))
    }
}

#[test]
fn k_squared_random_sites_become_squares() {
    let plane = Plane {
        domain: unit_square(),
    };
    for (k, seeds) in [(5, 1..=5), (10, 1..=2)] {
        for seed in seeds {
            let mut sites = random_sites(&plane.domain, k * k, seed);
            let (records, _) = run(&plane, &squares(k * k), &mut sites);
            let percent = records.last().unwrap().energy_percent;
            assert!(
                (percent - 100.0).abs() < 5e-5,
                "{k}, seed {seed}: {percent}"
            );
            let cells = plane.metrics(&sites, LINF).unwrap();
            assert!(
                cells
                    .iter()
                    .all(|cell| cell.facets == 4 && cell.cubeness > 0.999)
            );
        }
    }
}

#[test]
fn descents_go_downhill_in_every_domain_and_sites_stay_inside() {
    for (name, plane) in planes() {
        let mut sites = random_sites(&plane.domain, 40, 2);
        let plan = Plan::quasi_newton(1, 30);
        let (records, _) = run(&plane, &plan, &mut sites);
        let fell = records.windows(2);
        let mut fell = fell.map(|pair| pair[1].energy_mean <= pair[0].energy_mean);
        assert!(fell.all(|fell| fell), "{name}");
        let (first, last) = (&records[0], records.last().unwrap());
        assert!(last.energy_mean < 0.95 * first.energy_mean, "{name}");
        assert!(
            sites.iter().all(|site| plane.domain.contains(site)),
            "{name}"
        );
    }
}

#[test]
fn lloyd_goes_downhill_in_every_domain_and_sites_stay_inside() {
    for (name, plane) in planes() {
        let mut sites = random_sites(&plane.domain, 40, 2);
        let (records, _) = run(&plane, &Plan::lloyd(LINF, 15), &mut sites);
        let fell = records.windows(2);
        let mut fell = fell.map(|pair| pair[1].energy_mean <= pair[0].energy_mean * (1.0 + 1e-12));
        assert!(fell.all(|fell| fell), "{name}");
        assert!(
            sites.iter().all(|site| plane.domain.contains(site)),
            "{name}"
        );
    }
}

#[test]
fn annealing_and_squares_give_the_same_bits_for_one_thread_and_two() {
    let plane = Plane {
        domain: unit_square().repeated([true, false]),
    };
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let anneal = Perturbation {
            rounds: 3,
            ..Perturbation::default_of(PerturbationKind::Anneal)
        };
        pool.build().unwrap().install(|| {
            let mut sites = random_sites(&plane.domain, 30, 1);
            run(&plane, &Plan::perturbed(1, anneal), &mut sites);
            let numbers = sites.iter().flat_map(|site| [site.x, site.y]);
            numbers.map(f64::to_bits).collect::<Vec<_>>()
        })
    };
    assert_eq!(bits(1), bits(2));
}

#[test]
fn a_density_draws_cells_and_its_mean_and_optimum_are_right() {
    let density: Polynomial = "1 + 8*x".parse().unwrap();
    let plane = Plane {
        domain: unit_square().weighted(&density).unwrap(),
    };
    assert!((plane.varying_density().unwrap() - 5.0).abs() < 1e-13);
    // ∫ (1 + 8x)^(2/3) dx = 3/40 (9^(5/3) − 1).
    let exact = 3.0 / 40.0 * (9.0_f64.powf(5.0 / 3.0) - 1.0) / 5.0_f64.powf(2.0 / 3.0);
    let optimum = plane.optimum();
    assert!(
        (optimum.volume - exact).abs() < 1e-5,
        "{} {exact}",
        optimum.volume
    );
    let mut sites = random_sites(&plane.domain, 100, 1);
    let (records, _) = run(&plane, &Plan::quasi_newton(1, 60), &mut sites);
    let percent = records.last().unwrap().energy_percent;
    assert!((95.0..105.0).contains(&percent), "{percent}");
    let right = sites.iter().filter(|site| site.x > 0.5).count();
    assert!(right > 55, "{right}");
}

#[test]
fn densities_that_are_none_are_refused_with_a_place() {
    let of = |text: &str, domain: PlaneDomain| domain.weighted(&text.parse().unwrap()).unwrap_err();
    let negative = of("x - 0.5", unit_square());
    assert!(
        matches!(negative, PlaneDomainError::Density { value, x, .. } if value < 0.0 && x < 0.5)
    );
    let flat = of("1 + z", unit_square());
    assert_eq!(flat, PlaneDomainError::DensityOfZ);
    let along = of("1 + x", unit_square().repeated([true, false]));
    assert_eq!(along, PlaneDomainError::DensityAlongPeriod { axis: 0 });
    // Negative in the hole only.
    let hole: &[[f64; 2]] = &[[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]];
    let domain = loops(&[SQUARE, hole]).unwrap();
    let dip: Polynomial = "(x-2)^2 + (y-2)^2 - 0.5".parse().unwrap();
    assert!(domain.weighted(&dip).is_ok());
}

#[test]
fn sites_outside_a_polygon_and_twice_in_a_torus_are_refused() {
    let (_, hole, _) = polygons().swap_remove(2);
    let sites = [Point2::new(0.5, 0.5), Point2::new(2.0, 2.0)];
    let error = PlaneDiagram::new(&hole, &sites).unwrap_err().to_string();
    assert_eq!(error, "site 1 lies outside the domain: (2, 2)");
    let torus = unit_square().repeated([true, true]);
    let twice = [
        Point2::new(0.0, 0.3),
        Point2::new(0.5, 0.5),
        Point2::new(1.0, 0.3),
    ];
    let error = PlaneDiagram::new(&torus, &twice).unwrap_err().to_string();
    assert!(
        error.starts_with("sites 0 and 2 are the same point"),
        "{error}"
    );
}

#[test]
fn a_site_of_a_torus_alone_has_the_whole_square() {
    let plane = Plane {
        domain: unit_square().repeated([true, true]),
    };
    let cells = plane.metrics(&[Point2::new(0.9, 0.2)], LINF).unwrap();
    assert!((cells[0].volume - 1.0).abs() < 1e-15);
    assert_eq!(cells[0].facets, 4);
    assert!((cells[0].energy - 1.0 / 3.0).abs() < 1e-15);
}
