//! Cells in solids: meshes as domains.

use std::collections::BTreeMap;
use std::ops::ControlFlow;

use crate::domain::convex::ConvexPolyhedron;
use crate::domain::cuboid::Cuboid;
use crate::domain::domain::{Domain, WeightedDomain};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::domain::tet_mesh::TetSolid;
use crate::domain::tri_surface::clip_cell::{ClipStatus, ClippedCell};
use crate::domain::tri_surface::signed_prisms::signed_prisms;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::energy::center::Minimizer;
use crate::energy::evaluation::EnergyScratch;
use crate::energy::evaluation::{SignedPiece, energy};
use crate::energy::prepared::PreparedPiece;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::random::Random;
use crate::geometry::shell::Shell;
use crate::mesh::formats::read::load;
use crate::mesh::shapes::{
    bracket, cuboid, icosphere, torus, trefoil, unit_cube, unit_cube_five_tets, unit_cube_tets,
};
use crate::mesh::similarity::Similarity;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{Solid, validate_surface, validate_tets};
use crate::minimize::problem::Evaluation;
use crate::relax::driver::drive;
use crate::relax::plan::Plan;
use crate::relax::relaxation_space::{EnergySpec, Norm};
use crate::relax::space::Space;
use crate::relax::space::shell;
use crate::relax::state::RunState;
use crate::tests::models::shared_model;
use crate::voronoi::diagram::Diagram;
use nalgebra::{Point3, Vector3};

/// The closed models of the shared folder.
const MODELS: [&str; 8] = [
    "3torus.off",
    "anchor.off",
    "bunny.off",
    "casting.off",
    "couplingdown.off",
    "fandisk.off",
    "femur.off",
    "rocker-arm.obj",
];

const LINF: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

/// Uniform random points of the domain.
fn random_sites(domain: &dyn Domain, count: usize, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let bounds = domain.bounds();
    let mut sites = Vec::new();
    while sites.len() < count {
        let share = Vector3::from_fn(|_, _| random.uniform());
        let point = bounds.min + bounds.extent().component_mul(&share);
        if domain.contains(&point) {
            sites.push(point);
        }
    }
    sites
}

/// The middles of an n³ grid over the domain's bounds that the domain holds.
fn grid_sites(domain: &dyn Domain, n: u32) -> Vec<Point3<f64>> {
    let bounds = domain.bounds();
    let middle = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
    let share = |k: u32| Vector3::new(middle(k % n), middle(k / n % n), middle(k / n / n));
    (0..n.pow(3))
        .map(|k| bounds.min + bounds.extent().component_mul(&share(k)))
        .filter(|point| domain.contains(point))
        .collect()
}

fn solid(mesh: &SurfaceMesh) -> SurfaceSolid {
    SurfaceSolid::new(&validate_surface(mesh).expect("the mesh is closed").0)
        .expect("it has a volume")
}

fn tets(mesh: &TetMesh) -> TetSolid {
    TetSolid::new(&validate_tets(mesh).expect("the mesh is valid").0).expect("it bounds a solid")
}

/// The same solid, of which every cell is cut tetrahedron by tetrahedron.
fn with_density_one(tets: TetSolid) -> WeightedDomain {
    let ones = vec![1.0; tets.mesh().vertices.len()];
    tets.with_density(&ones).expect("one is positive")
}

/// A model of the shared folder in the unit cube.
fn model(name: &str) -> Solid {
    let mut solid = load(&shared_model(name)).expect("the model is valid");
    let bounds = match &solid {
        Solid::Surface(surface, _) => surface.mesh().bounds(),
        Solid::Tets(tets, _) => tets.mesh().bounds(),
    };
    solid.transform(&Similarity::into_unit_cube(&bounds));
    solid
}

fn surface_model(name: &str) -> SurfaceSolid {
    match model(name) {
        Solid::Surface(surface, _) => SurfaceSolid::new(&surface).expect("it has a volume"),
        Solid::Tets(..) => panic!("{name} is no surface"),
    }
}

fn shapes() -> [(&'static str, SurfaceSolid); 6] {
    let cavity = |mut outer: SurfaceMesh, inner: SurfaceMesh| {
        let first = outer.vertices.len() as u32;
        outer
            .vertices
            .extend(inner.vertices.iter().map(|v| v * 0.5));
        let turned = inner
            .triangles
            .iter()
            .map(|&[a, b, c]| [a, c, b].map(|v| v + first));
        outer.triangles.extend(turned);
        outer
    };
    [
        ("cube", solid(&unit_cube())),
        ("torus", solid(&torus(1.0, 0.4, 24, 12))),
        ("trefoil", solid(&trefoil(0.4, 64, 8))),
        ("bracket", solid(&bracket(4))),
        ("sphere", solid(&icosphere(2))),
        ("shell", solid(&cavity(icosphere(2), icosphere(1)))),
    ]
}

/// The sum of the cells' volumes, and how many cells there are of each kind.
fn fill(domain: &SurfaceSolid, sites: &[Point3<f64>]) -> (f64, [usize; 3]) {
    let diagram = Diagram::new(domain, sites).expect("a diagram");
    let cells = diagram
        .map(
            |(clipped, scratch): &mut (ClippedCell, PieceScratch), cell| {
                let mut volume = 0.0;
                let mut add = |sign: f64, piece: Piece<'_>| volume += sign * piece.moments().mass;
                domain.pieces(&cell.position, cell.polyhedron(), scratch, &mut add);
                (
                    volume,
                    clipped.clip(domain.indexed(), &cell.position, cell.polyhedron()),
                )
            },
        )
        .expect("no duplicates");
    let count = |kind: ClipStatus| cells.iter().filter(|cell| cell.1 == kind).count();
    let kinds = [
        ClipStatus::Disjoint,
        ClipStatus::Clipped,
        ClipStatus::Inconsistent,
    ]
    .map(count);
    (cells.iter().map(|cell| cell.0).sum(), kinds)
}

fn assert_filled(domain: &SurfaceSolid, sites: &[Point3<f64>], what: &str) -> [usize; 3] {
    let (volume, kinds) = fill(domain, sites);
    let error = volume / domain.volume() - 1.0;
    let count = sites.len();
    assert!(
        error.abs() < 1e-11,
        "{what}, {count} sites: {error:e}, {kinds:?}"
    );
    kinds
}

fn signed(sign: f64, piece: Piece<'_>) -> SignedPiece {
    let mut prepared = PreparedPiece::default();
    prepared.assign(piece);
    SignedPiece {
        sign,
        piece: prepared,
    }
}

#[test]
fn cells_fill_generated_solids_without_the_fallback() {
    for (name, domain) in shapes() {
        for (count, seed) in [(1, 1), (2, 2), (7, 3), (40, 4), (500, 5)] {
            let sites = random_sites(&domain, count, seed);
            let [_, _, tangled] = assert_filled(&domain, &sites, name);
            assert_eq!(tangled, 0, "{name}, {count} sites");
        }
    }
}

#[test]
fn cells_fill_solids_whose_walls_lie_on_bisectors_and_through_vertices() {
    for (name, domain) in shapes() {
        for n in [2, 4, 5, 8] {
            let sites = grid_sites(&domain, n);
            if !sites.is_empty() {
                assert_filled(&domain, &sites, name);
            }
        }
    }
}

#[test]
fn sites_on_walls_edges_and_corners_have_cells() {
    let domain = solid(&unit_cube());
    let mut sites = random_sites(&domain, 50, 1);
    for place in [
        [0.0; 3],
        [1.0, 0.5, 0.0],
        [0.5, 0.5, 1.0],
        [0.25, 0.25, 0.0],
        [1.0; 3],
    ] {
        sites.push(Point3::from(place));
    }
    assert_filled(&domain, &sites, "cube");
}

#[test]
fn a_cell_is_worth_the_same_by_its_boundary_and_by_signed_prisms() {
    for (name, domain) in shapes() {
        for (count, seed) in [(3, 6), (60, 7)] {
            let sites = random_sites(&domain, count, seed);
            let diagram = Diagram::new(&domain, &sites).expect("a diagram");
            let worst = diagram
                .map(
                    |(scratch, energy_scratch): &mut (PieceScratch, EnergyScratch), cell| {
                        let mut whole = Vec::new();
                        domain.pieces(
                            &cell.position,
                            cell.polyhedron(),
                            scratch,
                            &mut |sign, piece| {
                                whole.push(signed(sign, piece));
                            },
                        );
                        let mut parts = Vec::new();
                        let (at, cell) = (&cell.position, cell.polyhedron());
                        signed_prisms(domain.indexed(), at, cell, scratch, &mut |sign, part| {
                            parts.push(signed(sign, part));
                        });
                        let size = cell.radius_squared().sqrt();
                        let mut worst: f64 = 0.0;
                        for (center, order) in
                            [([0.0; 3], 1), ([0.1, 0.2, -0.3], 1), ([0.3, -0.4, 0.2], 3)]
                        {
                            let center = Vector3::from(center) * size;
                            let [one, other] = [&whole, &parts]
                                .map(|pieces| energy(pieces, &center, order, energy_scratch));
                            let Evaluation {
                                value,
                                gradient,
                                hessian,
                            } = one;
                            let scale = size.powi(3 + order as i32);
                            worst = worst
                                .max((value - other.value).abs() / scale)
                                .max((gradient - other.gradient).amax() / scale * size)
                                .max((hessian - other.hessian).amax() / scale * size * size);
                        }
                        worst
                    },
                )
                .expect("no duplicates");
            let worst = worst.into_iter().fold(0.0, f64::max);
            assert!(worst < 1e-11, "{name}, {count} sites: {worst:e}");
        }
    }
}

#[test]
fn the_unit_cube_is_the_same_in_every_form() {
    let half_spaces = [0, 1, 2].map(|axis| {
        let mut normal = Vector3::zeros();
        normal[axis] = 1.0;
        [
            HalfSpace {
                normal,
                offset: 1.0,
            },
            HalfSpace {
                normal: -normal,
                offset: 0.0,
            },
        ]
    });
    let convex = ConvexPolyhedron::new(half_spaces.as_flattened()).expect("a cube");
    let cut = |mesh: &TetMesh| Box::new(with_density_one(tets(mesh)));
    let forms: [(&str, Box<dyn Domain>); 6] = [
        ("half-spaces", Box::new(convex)),
        ("surface", Box::new(solid(&unit_cube()))),
        ("five tets", Box::new(tets(&unit_cube_five_tets()))),
        ("many tets", Box::new(tets(&unit_cube_tets(3)))),
        ("five tets, one by one", cut(&unit_cube_five_tets())),
        ("many tets, one by one", cut(&unit_cube_tets(3))),
    ];
    let reference = Space::new(Box::new(Cuboid::unit()));
    let start = random_sites(reference.domain(), 60, 8);
    let expected = reference.metrics(&start, LINF).expect("a diagram");
    let relaxed = relax(&reference, &start, Norm::Linf, 20).1;
    for (name, domain) in forms {
        let space = Space::new(domain);
        let figures = space.metrics(&start, LINF).expect("a diagram");
        for (cell, expected) in figures.iter().zip(&expected) {
            let differences = [
                cell.volume - expected.volume,
                cell.energy - expected.energy,
                (cell.gradient - expected.gradient).amax(),
                (cell.center - expected.center).amax(),
                cell.center_energy - expected.center_energy,
                cell.cubeness - expected.cubeness,
                cell.axis_aligned - expected.axis_aligned,
            ];
            let worst = differences
                .into_iter()
                .fold(0.0, |far: f64, d| far.max(d.abs()));
            assert!(worst < 1e-11, "{name}: {differences:?}");
            assert_eq!(cell.facets, expected.facets, "{name}");
        }
        let sites = relax(&space, &start, Norm::Linf, 20).1;
        let pairs = sites.iter().zip(&relaxed);
        let worst = pairs.fold(0.0, |far: f64, (a, b)| far.max((a - b).amax()));
        assert!(worst < 1e-8, "{name}: {worst:e}");
    }
}

/// The energies in percent and the last sites of a run.
fn relax(
    space: &Space,
    start: &[Point3<f64>],
    norm: Norm,
    iterations: u64,
) -> (Vec<f64>, Vec<Point3<f64>>) {
    let mut sites = start.to_vec();
    let mut energies = Vec::new();
    let options = Plan::lloyd(EnergySpec { norm, ..LINF }, iterations);
    let mut state = RunState::new(sites.len(), 0);
    drive(
        space,
        &options,
        &mut sites,
        &mut state,
        None,
        &mut |record, sites, _| {
            energies.push(record.energy_percent);
            assert!(sites.iter().all(|site| space.domain().contains(site)));
            ControlFlow::Continue(())
        },
    )
    .expect("sites stay in the solid");
    (energies, sites)
}

#[test]
fn the_shells_of_all_cells_have_the_solids_volume_each_closed() {
    for (name, domain) in shapes() {
        for sites in [random_sites(&domain, 40, 12), grid_sites(&domain, 8)] {
            let diagram = Diagram::new(&domain, &sites).expect("a diagram");
            let shells = diagram
                .map(|scratch: &mut PieceScratch, cell| shell(&domain, &cell, scratch))
                .expect("no duplicates");
            let volume: f64 = shells.iter().map(Shell::volume).sum();
            let error = volume / domain.volume() - 1.0;
            assert!(
                error.abs() < 1e-9,
                "{name}, {} sites: {error:e}",
                sites.len()
            );
            for shell in &shells {
                assert!(is_watertight(shell), "{name}");
            }
        }
    }
}

/// The points of a body-centered or face-centered lattice of n³ cubes that the domain holds, walls
/// included.
fn lattice_sites(domain: &dyn Domain, n: u32, shifts: &[[f64; 3]]) -> Vec<Point3<f64>> {
    let bounds = domain.bounds();
    let step = bounds.extent().max() / f64::from(n);
    let mut sites = Vec::new();
    for k in 0..(n + 1).pow(3) {
        let corner = [k % (n + 1), k / (n + 1) % (n + 1), k / (n + 1) / (n + 1)];
        for shift in shifts {
            let share = |axis: usize| f64::from(corner[axis]) + shift[axis];
            let share = Vector3::from([0, 1, 2].map(share));
            let place = bounds.min + share * step;
            if domain.contains(&place) {
                sites.push(place);
            }
        }
    }
    sites
}

#[test]
fn lattices_in_solids_have_shells_and_volumes() {
    const LATTICES: [&[[f64; 3]]; 4] = [
        &[[0.0; 3]],
        &[[0.5; 3]],
        &[[0.0; 3], [0.5; 3]],
        &[[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]],
    ];
    for (name, domain) in shapes() {
        for shifts in LATTICES {
            for n in [2, 3, 4, 6, 8] {
                let sites = lattice_sites(&domain, n, shifts);
                if sites.is_empty() {
                    continue;
                }
                let kinds = assert_filled(&domain, &sites, name);
                let diagram = Diagram::new(&domain, &sites).expect("a diagram");
                let shells = diagram
                    .map(|scratch: &mut PieceScratch, cell| shell(&domain, &cell, scratch))
                    .expect("no duplicates");
                let volume: f64 = shells.iter().map(Shell::volume).sum();
                let error = volume / domain.volume() - 1.0;
                let what = format!("{name}, {} sites, {kinds:?}", sites.len());
                assert!(error.abs() < 1e-9, "{what}: {error:e}");
                assert!(shells.iter().all(is_watertight), "{what}");
                assert!(shells.iter().all(|shell| shell.facet_count() > 3), "{what}");
                let area = wall_area(&domain, &diagram) / domain.surface().area() - 1.0;
                assert!(area.abs() < 1e-11, "{what}: {area:e}");
            }
        }
    }
}

/// The area of all cells' walls by their pieces; panics where a piece's other borders do not cancel
/// or belong to no neighbor.
fn wall_area(domain: &SurfaceSolid, diagram: &Diagram<'_>) -> f64 {
    let areas = diagram.map(|scratch: &mut PieceScratch, cell| {
        let mut walls: BTreeMap<u64, Vector3<f64>> = BTreeMap::new();
        let (mut inner, mut all) = (Vector3::zeros(), Vector3::zeros());
        let mut add = |sign: f64, piece: Piece<'_>| {
            piece.visit_facets(|label, _, area| {
                all += area * sign;
                match FacetKind::of(label) {
                    FacetKind::Wall(_) => *walls.entry(label).or_default() += area * sign,
                    FacetKind::Inner => inner += area * sign,
                    FacetKind::Neighbor { .. } => {}
                }
            });
        };
        domain.pieces(&cell.position, cell.polyhedron(), scratch, &mut add);
        let least = 1e-11 * cell.polyhedron().radius_squared();
        assert!(inner.amax() < least && all.amax() < least, "{inner} {all}");
        walls.values().map(Vector3::norm).sum::<f64>()
    });
    areas.expect("no duplicates").iter().sum()
}

/// Whether every edge is run along as often in one direction as in the other.
fn is_watertight(shell: &Shell) -> bool {
    let mut balance: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    for facet in shell.facets() {
        for (k, &from) in facet.iter().enumerate() {
            let to = facet[(k + 1) % facet.len()];
            let key = [from.min(to), from.max(to)];
            *balance.entry(key).or_default() += if from < to { 1 } else { -1 };
        }
    }
    balance.values().all(|&sum| sum == 0)
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn cells_fill_the_closed_models() {
    for name in MODELS {
        let domain = surface_model(name);
        assert_filled(&domain, &random_sites(&domain, 1000, 1), name);
    }
    for name in ["femur.off", "fandisk.off"] {
        let domain = surface_model(name);
        assert_filled(&domain, &random_sites(&domain, 10_000, 1), name);
    }
}

#[test]
fn a_tet_mesh_and_its_boundary_are_one_solid() {
    assert_one_with_its_boundary(tets(&unit_cube_tets(2)));
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_tetrahedral_bunny_and_its_boundary_are_one_solid() {
    let Solid::Tets(mesh, _) = model("bunny.mesh") else {
        panic!("the bunny is made of tetrahedra");
    };
    assert_one_with_its_boundary(TetSolid::new(&mesh).expect("it bounds a solid"));
}

/// Cells of the tetrahedra and of their boundary are worth the same.
fn assert_one_with_its_boundary(filled: TetSolid) {
    let boundary = filled.boundary().clone();
    let filled = with_density_one(filled);
    let sites = random_sites(&boundary, 300, 9);
    let [filled, bounded] = [Space::new(Box::new(filled)), Space::new(Box::new(boundary))]
        .map(|space| space.metrics(&sites, LINF).expect("a diagram"));
    let size = (1.0 / 300.0_f64).cbrt();
    for (one, other) in filled.iter().zip(&bounded) {
        assert!((one.volume - other.volume).abs() < 1e-11 * size.powi(3));
        assert!((one.energy - other.energy).abs() < 1e-11 * size.powi(4));
        assert!((one.gradient - other.gradient).amax() < 1e-11 * size.powi(3));
        assert!((one.center - other.center).amax() < 1e-9 * size);
        assert!((one.cubeness - other.cubeness).abs() < 1e-9);
        assert_eq!(one.facets, other.facets);
    }
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated, and minutes"]
fn ten_thousand_cells_fill_every_closed_model() {
    for name in MODELS {
        let domain = surface_model(name);
        assert_filled(&domain, &random_sites(&domain, 10_000, 1), name);
    }
}

/// Fifty iterations in both norms from the same sites; the Chebyshev energy falls all the way.
fn assert_chebyshev_ends_lower(name: &str, domain: SurfaceSolid, count: usize) {
    let start = random_sites(&domain, count, 10);
    let space = Space::new(Box::new(domain));
    let [linf, l2] = [Norm::Linf, Norm::L2].map(|norm| relax(&space, &start, norm, 50).0);
    let (one, other) = (linf[50], l2[50]);
    assert!(one < other, "{name}: {one} against {other}");
    for pair in linf.windows(2) {
        let falls = pair[1] <= pair[0] * (1.0 + 1e-12);
        assert!(falls, "{name}: the energy rose: {pair:?}");
    }
}

#[test]
fn chebyshev_runs_in_solids_end_below_euclidean_ones() {
    assert_chebyshev_ends_lower("torus", solid(&torus(1.0, 0.4, 24, 12)), 150);
    // A thin tube needs more sites than one a cross-section before cells are more than slices.
    assert_chebyshev_ends_lower("trefoil", solid(&trefoil(0.4, 64, 8)), 400);
    assert_chebyshev_ends_lower("bracket", solid(&bracket(4)), 150);
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn chebyshev_runs_end_lower_in_every_closed_model() {
    assert_chebyshev_ends_lower("femur.off", surface_model("femur.off"), 200);
    for name in MODELS {
        let domain = surface_model(name);
        assert_chebyshev_ends_lower(name, domain, 300);
    }
}

#[test]
fn a_center_outside_the_solid_draws_its_site_to_the_wall_only() {
    // One cell that is the whole ring: its center is the hole's middle.
    let space = Space::new(Box::new(solid(&torus(1.0, 0.3, 48, 24))));
    let start = [Point3::new(1.1, 0.0, 0.0)];
    let (energies, sites) = relax(&space, &start, Norm::Linf, 1);
    assert!(energies[1] < energies[0]);
    assert!(
        (sites[0] - Point3::new(0.7, 0.0, 0.0)).norm() < 0.02,
        "{}",
        sites[0]
    );
}

#[test]
fn a_solid_thinner_than_a_cell_and_a_single_tetrahedron_are_relaxed() {
    let thin = Bounds {
        min: Point3::origin(),
        max: Point3::new(1.0, 1.0, 1e-3),
    };
    let corner = Point3::new(1.0, 1.0, 1.0);
    let single = TetMesh {
        vertices: vec![
            Point3::origin(),
            Point3::new(1.0, 0.0, 0.0),
            Point3::new(0.0, 1.0, 0.0),
            corner,
        ],
        tets: vec![[0, 1, 2, 3]],
        vertex_data: Vec::new(),
    };
    let domains: [Box<dyn Domain>; 2] = [Box::new(solid(&cuboid(&thin))), Box::new(tets(&single))];
    for domain in domains {
        let volume = domain.volume();
        let start = random_sites(domain.as_ref(), 20, 11);
        let space = Space::new(domain);
        let (energies, sites) = relax(&space, &start, Norm::Linf, 30);
        assert!(energies[30] < energies[0]);
        let figures = space.metrics(&sites, LINF).expect("a diagram");
        let sum: f64 = figures.iter().map(|cell| cell.volume).sum();
        assert!((sum / volume - 1.0).abs() < 1e-11);
    }
}
