//! Cells in frames of their own: what one frame gives, many equal ones give to the bit; frames that
//! follow the boundary.

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::shape::DomainShape;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::mesh::shapes::torus;
use crate::mesh::validate::validate_surface;
use crate::relax::driver::drive;
use crate::relax::frames::Frames;
use crate::relax::frames::boundary_frames;
use crate::relax::plan::Plan;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::{Space, SpaceError};
use crate::relax::state::RunState;
use nalgebra::{Matrix3, Point3, Rotation3, Vector3};

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

fn turn() -> Rotation3<f64> {
    Rotation3::from_scaled_axis(Vector3::new(1.0, 2.0, 0.5).normalize() * (TAU / 12.0))
}

/// A box of these half extents about the origin, turned.
fn turned_box(half: [f64; 3], rotation: &Rotation3<f64>) -> Box<dyn Domain> {
    let walls: Vec<_> = (0..6)
        .map(|wall| HalfSpace {
            normal: rotation * Vector3::ith(wall / 2, if wall % 2 == 0 { 1.0 } else { -1.0 }),
            offset: half[wall / 2],
        })
        .collect();
    Box::new(ConvexPolyhedron::new(&walls).unwrap())
}

fn ring() -> Box<dyn Domain> {
    let surface = validate_surface(&torus(1.0, 0.4, 36, 18)).unwrap().0;
    Box::new(SurfaceSolid::new(&surface).unwrap())
}

fn sites_in(domain: &dyn Domain, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut uniform = Random::new(seed);
    let points = std::iter::repeat_with(|| uniform.point(&domain.bounds()));
    points
        .filter(|site| domain.contains(site))
        .take(count)
        .collect()
}

/// How far two frames differ (radians, where they differ little), the 24 equivalents of each being
/// one.
fn angle(a: &Rotation3<f64>, b: &Rotation3<f64>) -> f64 {
    let mut least = f64::INFINITY;
    for x in 0..4 {
        for y in 0..4 {
            for z in 0..4 {
                let angles = [x, y, z].map(|k: i32| f64::from(k) * TAU / 4.0);
                let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
                let rest = a.inverse() * b * turn;
                least = least.min((rest.matrix() - Matrix3::identity()).norm() / 2.0_f64.sqrt());
            }
        }
    }
    least
}

#[test]
fn equal_frames_for_all_sites_are_one_frame_to_the_bit() {
    let sites = sites_in(&Cuboid::unit(), 90, 1);
    let spaces = [Frames::One(turn()), Frames::PerSite(vec![turn(); 90])]
        .map(|frames| Space::with_frames(Box::new(Cuboid::unit()), frames));
    let [one, each] = &spaces;
    assert_eq!(one.objective(&sites, 1), each.objective(&sites, 1));
    assert_eq!(one.metrics(&sites, LINF), each.metrics(&sites, LINF));
    let relaxed = |space: &Space| {
        let mut moved = sites.clone();
        let mut state = RunState::new(moved.len(), 0);
        let plan = Plan::quasi_newton(1, 8);
        let mut watch = |_: &_, _: &[_], _: &_| ControlFlow::Continue(());
        drive(space, &plan, &mut moved, &mut state, None, &mut watch).unwrap();
        moved
    };
    assert_eq!(relaxed(one), relaxed(each));
}

#[test]
fn frames_for_other_sites_are_refused() {
    let sites = sites_in(&Cuboid::unit(), 9, 1);
    for count in [8, 10] {
        let frames = Frames::PerSite(vec![turn(); count]);
        let space = Space::with_frames(Box::new(Cuboid::unit()), frames);
        let error = SpaceError::Frames {
            frames: count,
            sites: 9,
        };
        assert_eq!(space.assess(&sites, LINF), Err(error.clone()));
        assert_eq!(space.metrics(&sites, LINF), Err(error));
        assert!(space.objective(&sites, 1).is_err());
    }
}

#[test]
fn frames_in_a_turned_box_are_those_of_the_box() {
    for rotation in [Rotation3::identity(), turn()] {
        for half in [[0.5, 0.5, 0.5], [1.0, 0.4, 0.3]] {
            let domain = turned_box(half, &rotation);
            let sites = sites_in(domain.as_ref(), 300, 2);
            for frame in boundary_frames(domain.as_ref(), &sites).unwrap() {
                let off = angle(&frame, &rotation);
                assert!(off < 1e-12, "{off:e}");
            }
        }
    }
}

#[test]
fn frames_in_a_turned_box_make_its_cells_those_of_the_upright_one() {
    let rotation = turn();
    let upright = Space::new(turned_box([0.5; 3], &Rotation3::identity()));
    let sites = sites_in(upright.domain(), 150, 3);
    let turned: Vec<_> = sites.iter().map(|site| rotation * site).collect();
    let domain = turned_box([0.5; 3], &rotation);
    let frames = boundary_frames(domain.as_ref(), &turned).unwrap();
    let space = Space::with_frames(domain, Frames::PerSite(frames));
    let cells = upright.metrics(&sites, LINF).unwrap();
    for (a, b) in cells.iter().zip(&space.metrics(&turned, LINF).unwrap()) {
        assert!((a.energy / b.energy - 1.0).abs() < 1e-12);
        assert!((a.center_energy / b.center_energy - 1.0).abs() < 1e-12);
        assert!((a.cubeness - b.cubeness).abs() < 1e-12);
        assert_eq!(a.facets, b.facets);
    }
}

/// On a smooth ring a frame stands across the tube's wall, and neighbors' frames agree.
#[test]
fn frames_in_a_ring_follow_its_wall() {
    let domain = ring();
    let sites = sites_in(domain.as_ref(), 800, 4);
    let frames = boundary_frames(domain.as_ref(), &sites).unwrap();
    let mut near_wall = Vec::new();
    for (site, frame) in sites.iter().zip(&frames) {
        let around = Vector3::new(site.x, site.y, 0.0);
        let from_tube = site.coords - around.normalize();
        if from_tube.norm() > 0.33 {
            near_wall.push((frame.inverse() * from_tube.normalize()).amax());
        }
    }
    // Among all directions the mean of the largest component is 0.83.
    let mean = near_wall.iter().sum::<f64>() / near_wall.len() as f64;
    let off = near_wall.iter().filter(|&&across| across < 0.9).count();
    assert!(
        near_wall.len() > 150 && mean > 0.97 && off * 8 < near_wall.len(),
        "{mean} {off}"
    );
    // Where cells stand along the wall they come nearer to cubes.
    let relaxed = |frames: Frames| {
        let space = Space::with_frames(ring(), frames);
        let mut moved = sites.clone();
        let mut state = RunState::new(moved.len(), 0);
        let plan = Plan::quasi_newton(1, 8);
        let mut watch = |_: &_, _: &[_], _: &_| ControlFlow::Continue(());
        drive(&space, &plan, &mut moved, &mut state, None, &mut watch).unwrap();
        space.objective(&moved, 1).unwrap().energy
    };
    let (follow, stand_still) = (relaxed(Frames::PerSite(frames)), relaxed(Frames::Axes));
    assert!(follow < stand_still, "{follow} {stand_still}");
}

#[test]
fn domains_without_walls_keep_the_axes_of_space() {
    let bounds = Cuboid::unit().bounds();
    let periodic = Cuboid::new(bounds, [true; 3]).unwrap();
    let sites = sites_in(&periodic, 40, 5);
    for frame in boundary_frames(&periodic, &sites).unwrap() {
        assert!(angle(&frame, &Rotation3::identity()) < 1e-12);
    }
}
