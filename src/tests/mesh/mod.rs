//! Meshes: every format gives the same solid, every defect a clear outcome.

mod dialects;
mod faults;
mod formats;
mod overlaps;
mod samples;
mod samples_binary;
mod validation;
mod written;

use std::path::Path;

use crate::mesh::formats::off;
use crate::mesh::formats::read::{load, read_surface, read_tets};
use crate::mesh::shapes;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{Solid, validate_surface, validate_tets};
use crate::tests::models::shared_model;

/// |one − other| in shares of the greater.
fn difference(one: f64, other: f64) -> f64 {
    (one - other).abs() / one.abs().max(other.abs())
}

#[test]
fn generated_surfaces_are_flawless() {
    let shapes: [(SurfaceMesh, i64); 5] = [
        (shapes::unit_cube(), 0),
        (shapes::icosphere(3), 0),
        (shapes::torus(1.0, 0.25, 48, 24), 1),
        (shapes::trefoil(0.4, 120, 12), 1),
        (shapes::bracket(6), 1),
    ];
    for (mesh, genus) in shapes {
        let (closed, report) = validate_surface(&mesh).unwrap();
        assert_eq!(report.notes(), Vec::<String>::new());
        assert_eq!(
            (report.components, report.cavities, report.genus),
            (1, 0, genus)
        );
        assert_eq!(closed.mesh(), &mesh);
    }
}

#[test]
fn generated_solids_have_their_volumes() {
    let turn = std::f64::consts::TAU;
    // A polygonal torus: a regular polygon's area, swept (Pappus) along a polygon.
    let tube = 0.5 * 24.0 * 0.25_f64.powi(2) * (turn / 24.0).sin();
    let ring = 48.0 * (turn / 48.0).sin();
    let hole = 0.5 * 24.0 * 0.25_f64.powi(2) * (turn / 24.0).sin();
    assert!(difference(shapes::unit_cube().volume(), 1.0) < 1e-15);
    assert!(difference(shapes::torus(1.0, 0.25, 48, 24).volume(), tube * ring) < 1e-3);
    assert!(difference(shapes::bracket(6).volume(), 1.5 - 0.5 * hole) < 1e-14);
    assert!(difference(shapes::icosphere(5).volume(), turn * 2.0 / 3.0) < 2e-3);
    assert!(difference(shapes::unit_cube_five_tets().volume(), 1.0) < 1e-15);
    for n in 1..4 {
        let mesh = shapes::unit_cube_tets(n);
        assert!(difference(mesh.volume(), 1.0) < 1e-14);
        assert_eq!(
            validate_tets(&mesh).unwrap().1.notes(),
            Vec::<String>::new()
        );
        assert_eq!(mesh.boundary().triangles.len(), 12 * (n * n) as usize);
    }
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_models_bound_solids_of_their_genus() {
    let models = [
        ("3torus.off", 19, 46, 3),
        ("anchor.off", 519, 1050, 4),
        ("bunny.off", 3485, 6966, 0),
        ("casting.off", 5096, 10224, 9),
        ("couplingdown.off", 1841, 3714, 9),
        ("fandisk.off", 6475, 12946, 0),
        ("femur.off", 3897, 7798, 2),
        ("rocker-arm.obj", 10044, 20088, 1),
    ];
    for (name, vertices, triangles, genus) in models {
        let Solid::Surface(closed, report) = load(&shared_model(name)).unwrap() else {
            panic!("{name} is a surface");
        };
        let mesh = closed.mesh();
        let counts = (mesh.vertices.len(), mesh.triangles.len(), report.genus);
        assert_eq!(counts, (vertices, triangles, genus), "{name}");
        assert_eq!(report.notes(), Vec::<String>::new(), "{name}");
        assert!(mesh.volume() > 0.0);
    }
}

/// The message on an open surface names the file and counts its boundary edges.
fn assert_refused_with_boundary_counted(path: &Path) {
    let mesh = read_surface(path).unwrap();
    let mut uses = std::collections::HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *uses.entry((from.min(to), from.max(to))).or_insert(0) += 1;
        }
    }
    let boundary = uses.values().filter(|&&uses| uses == 1).count();
    let message = load(path).unwrap_err().to_string();
    let name = path.file_name().unwrap().to_str().unwrap();
    let expected = format!("{name} is not closed: {boundary} boundary edges");
    assert!(message.contains(&expected), "{message}");
    assert!(message.contains("Close Holes"), "{message}");
}

#[test]
fn an_open_surface_is_refused_with_its_boundary_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("open-trefoil.off");
    let mut mesh = shapes::trefoil(0.4, 60, 8);
    mesh.triangles.drain(100..140);
    std::fs::write(&path, off::write(&mesh)).unwrap();
    assert_refused_with_boundary_counted(&path);
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_open_model_is_refused_with_its_boundary_counted() {
    assert_refused_with_boundary_counted(&shared_model("open-shark.off"));
}

/// Tetrahedra hold what their boundary encloses, which is also what is read as a surface.
fn assert_boundary_holds_the_same(path: &Path) -> TetMesh {
    let tets = read_tets(path).unwrap();
    let (valid, _) = validate_tets(&tets).unwrap();
    let (closed, _) = validate_surface(&valid.mesh().boundary()).unwrap();
    assert!(difference(valid.mesh().volume(), closed.mesh().volume()) < 1e-13);
    assert_eq!(read_surface(path).unwrap(), tets.boundary());
    tets
}

#[test]
fn tetrahedra_and_their_boundary_hold_the_same_volume() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let tets = assert_boundary_holds_the_same(&scenes.join("cube.mesh"));
    assert_eq!((tets.vertices.len(), tets.tets.len()), (27, 48));
}

#[test]
#[ignore = "needs ../shared/models, whose licenses are not stated"]
fn the_tetrahedral_bunny_and_its_boundary_hold_the_same_volume() {
    let tets = assert_boundary_holds_the_same(&shared_model("bunny.mesh"));
    assert_eq!((tets.vertices.len(), tets.tets.len()), (5433, 34055));
}

#[test]
fn the_scenes_hold_the_generated_solids() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let solids = [
        ("torus.off", shapes::torus(1.0, 0.4, 36, 18)),
        ("trefoil.off", shapes::trefoil(0.45, 96, 12)),
        ("bracket.off", shapes::bracket(8)),
    ];
    for (name, mesh) in solids {
        let solid = load(&scenes.join(name)).unwrap();
        assert_eq!(solid.notes(), Vec::<String>::new(), "{name}");
        // Sines may differ by an ulp between platforms.
        assert!(difference(solid.volume(), mesh.volume()) < 1e-13, "{name}");
    }
    let cube = load(&scenes.join("cube.mesh")).unwrap();
    assert!(difference(cube.volume(), 1.0) < 1e-14);
}
