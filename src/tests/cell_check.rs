//! The second net: tessellations that are none are refused, in every door; those that look odd and are
//! right are not.

use nalgebra::{Point3, Vector3};

use crate::domain::cuboid::Cuboid;
use crate::domain::domain::WeightedDomain;
use crate::domain::planar::PlaneDomain;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::relax::method::Method;
use crate::relax::planar::Plane;
use crate::relax::relaxation::{Relaxation, random_sites};
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};

/// The unit cube that says another volume, and leaves out the pieces of sites left of `lost`.
#[derive(Debug)]
struct Corrupted {
    volume: f64,
    lost: f64,
}

impl DomainShape for Corrupted {
    fn bounds(&self) -> Bounds<3> {
        Cuboid::unit().bounds()
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        Cuboid::unit().contains(point)
    }

    fn start(&self, site: &Point3<f64>, index: u32, cell: &mut Polyhedron) {
        Cuboid::unit().start(site, index, cell);
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn signed_pieces(
        &self,
        site: &Point3<f64>,
        part: &Polyhedron,
        _holds_site: bool,
        _scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        if site.x >= self.lost {
            visit(1.0, Piece::Convex(part));
        }
        if site.x >= 0.95 {
            visit(1.0, Piece::Convex(part));
        }
    }
}

#[test]
fn a_tessellation_that_does_not_fill_the_domain_is_refused_by_every_method() {
    let sites = random_sites(&Cuboid::unit(), 60, 1).expect("a cube");
    for (volume, lost) in [(1.1, 0.0), (1.0, 0.3), (1.0, 0.0)] {
        for method in [
            Method::lloyd(3),
            Method::lloyd(3).norm(Norm::L2),
            Method::quasi_newton(3),
        ] {
            let relaxation = Relaxation::new(Corrupted { volume, lost }).method(method);
            let mut moved = sites.clone();
            let refused = relaxation.run(&mut moved).expect_err("no tessellation");
            let message = refused.to_string();
            assert!(
                message.contains("volumes of the 60 cells sum to"),
                "{message}"
            );
            assert_eq!(moved, sites);
            let measured = relaxation.measure(&sites).expect_err("no tessellation");
            assert!(measured.to_string().contains("sum to"), "{measured}");
        }
    }
}

#[test]
fn one_site_in_a_density_that_vanishes_at_the_walls_passes_below_the_asymptotic_optimum() {
    let density = "x*(1 - x)*y*(1 - y)*z*(1 - z)"
        .parse()
        .expect("a polynomial");
    let domain = WeightedDomain::new(Box::new(Cuboid::unit()), density).expect("positive inside");
    let relaxation = Relaxation::new(domain).method(Method::lloyd(2));
    let figures = relaxation.measure(&[[0.5; 3]]).expect("one cell");
    // ∫ max(|x|, |y|, |z|) ρ by P(max < t) = (3t/2 − 2t³)³ on t in [0, 1/2]: 7/5120. The optimum has
    // (3/8) B(7/4, 7/4)^4, B(7/4, 7/4) = 0.25416....
    assert!((figures.energy_mean - 7.0 / 5120.0).abs() < 1e-15);
    assert!(
        (figures.energy_percent - 87.4).abs() < 0.2,
        "{}",
        figures.energy_percent
    );
    let mut sites = vec![[0.5; 3]];
    let outcome = relaxation.run(&mut sites).expect("it is right");
    assert_eq!(outcome.records.len(), 3);
}

#[test]
fn orders_and_sizes_that_no_float_holds_are_refused_with_numbers() {
    let boxed = |side: f64| {
        let bounds = Bounds::from_corners([0.0; 3], [side; 3]);
        Cuboid::new(bounds, [false; 3]).expect("a box")
    };
    for (side, order) in [(1e-9, 40), (1e80, 1), (1e-80, 1), (1e9, 40)] {
        for method in [Method::lloyd(2), Method::quasi_newton(2)] {
            let cube = boxed(side);
            let mut sites = random_sites(&cube, 20, 1).expect("a cube");
            let relaxation = Relaxation::new(cube).method(method.order(order));
            let refused = relaxation.run(&mut sites).expect_err("out of range");
            assert!(refused.to_string().contains("64-bit float"), "{refused}");
            assert!(relaxation.measure(&sites).is_err());
        }
    }
    // Clustered sites underflow where the mean cell does not.
    let mut sites = vec![[0.5; 3], [0.5, 0.5, 0.5 + 1e-9], [0.5, 0.5 + 1e-9, 0.5]];
    sites.push([0.5 + 1e-9, 0.5, 0.5]);
    sites.extend([
        [0.5 - 1e-9, 0.5, 0.5],
        [0.5, 0.5 - 1e-9, 0.5],
        [0.5, 0.5, 0.5 - 1e-9],
    ]);
    let relaxation = Relaxation::new(Cuboid::unit()).method(Method::lloyd(2).order(40));
    let refused = relaxation.run(&mut sites).expect_err("an energy of 1e-390");
    assert!(refused.to_string().contains("site 0"), "{refused}");
    let plane = Bounds::from_corners([0.0; 2], [1e120; 2]);
    let plane = Plane {
        domain: PlaneDomain::rectangle(&plane).expect("a rectangle"),
    };
    let spec = EnergySpec {
        norm: Norm::Linf,
        order: 1,
        minimizer: Minimizer::Newton,
    };
    let site = [5e119, 5e119].into();
    assert!(plane.assess(&[site], spec).is_err());
    assert!(plane.metrics(&[site], spec).is_err());
}

#[test]
fn cells_are_the_same_far_from_the_origin_or_refused() {
    use crate::domain::convex::ConvexPolyhedron;
    use crate::geometry::half_space::HalfSpace;

    let near: Vec<Point3<f64>> = (0..40_u32)
        .map(|k| {
            [k * 37 % 97, k * 59 % 89, k * 23 % 83]
                .map(|n| f64::from(n + 1) / 128.0)
                .into()
        })
        .collect();
    let volumes = |relaxation: Relaxation, sites: &[Point3<f64>]| {
        relaxation
            .measure(sites)
            .map(|figures| (figures.volume_sd, figures.energy_percent))
    };
    let base = volumes(Relaxation::new(Cuboid::unit()), &near).expect("a diagram");
    for power in [10, 20, 30, 38, 45] {
        let offset = Vector3::new(1.0, -1.0, 1.0) * 2.0_f64.powi(power);
        let bounds = Cuboid::unit().bounds().translated(&offset);
        let sites: Vec<_> = near.iter().map(|site| site + offset).collect();
        let walls: Vec<_> = (0..6)
            .map(|side: usize| {
                let axis = side / 2;
                let sign = if side.is_multiple_of(2) { 1.0 } else { -1.0 };
                let mut normal = Vector3::zeros();
                normal[axis] = sign;
                let end = if sign > 0.0 { bounds.max } else { bounds.min };
                let offset = sign * end[axis];
                HalfSpace { normal, offset }
            })
            .collect();
        let (cuboid, convex) = (
            Cuboid::new(bounds, [false; 3]),
            ConvexPolyhedron::new(&walls),
        );
        if power > 40 {
            let refused = cuboid.expect_err("too far").to_string();
            assert!(refused.contains("shift it towards the origin"), "{refused}");
            assert!(convex.is_err());
            continue;
        }
        let cuboid = Relaxation::new(cuboid.expect("a box"));
        let convex = Relaxation::new(convex.expect("a box"));
        for relaxation in [cuboid, convex] {
            let (spread, energy) = volumes(relaxation, &sites).expect("a diagram");
            assert!((spread - base.0).abs() < 1e-12, "2^{power}");
            assert!((energy - base.1).abs() < 1e-9, "2^{power}");
        }
    }
}
