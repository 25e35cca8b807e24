//! Damaged meshes, site files, scenes and checkpoints: each is refused, or means what is in the file.
//! No panic, no hang, no memory that the file does not warrant.
//!
//! `CHEBLOYD_MUTANTS=100000 cargo test --test mutants` tries so many of them (2000 without), from
//! `CHEBLOYD_MUTANTS_SEED` on. A mutant that fails is left under `target/mutants/`.

#[path = "common/exact_volume.rs"]
mod exact_volume;
#[path = "common/mutator.rs"]
mod mutator;

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc;
use std::time::Duration;

use chebloyd::export::run::checkpoint;
use chebloyd::mesh::formats::mesh::Mesh;
use chebloyd::mesh::formats::read::{load, read};
use chebloyd::mesh::validate::Solid;
use chebloyd::mesh::{formats::medit, formats::off, shapes};
use chebloyd::scene::run::{RunSpace, plane, space};
use chebloyd::scene::sites::Sites;
use chebloyd::scene::{read as scene_text, site_file};
use exact_volume::ExactPoints;
use mutator::{Dice, mutant};
use peak_alloc::PeakAlloc;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// What a mutant may take of the heap beyond a thousand times its own size (bytes): the sites'
/// search trees and the workers' scratch.
const MOST_MEMORY: usize = 64 << 20;

/// A mutant that takes longer hangs.
const LONGEST: Duration = Duration::from_secs(60);

/// A file by its name, and another that belongs to it.
type Seed = (String, Vec<u8>);

fn text(name: &str, content: impl Into<String>) -> Seed {
    (name.to_owned(), content.into().into_bytes())
}

fn cases() -> Vec<Seed> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases");
    let mut paths: Vec<PathBuf> = fs::read_dir(folder)
        .expect("cases")
        .map(|entry| entry.expect("a case").path())
        .collect();
    paths.sort();
    let known = [
        "off", "stl", "ply", "msh", "vtk", "vtu", "vtp", "3mf", "gz", "xyz",
    ];
    // The thin rods have fewer digits and tests of their own.
    paths.retain(|path| {
        let extension = path
            .extension()
            .and_then(|e| e.to_str())
            .unwrap_or_default();
        let size = fs::metadata(path).map_or(0, |file| file.len());
        let is_any = |words: &[&str]| {
            words
                .iter()
                .any(|word| path.to_string_lossy().contains(word))
        };
        let is_refused = is_any(&["diagonal-rod", "lzma", "curved"]);
        known.contains(&extension) && size < 6000 && !is_refused
    });
    paths
        .into_iter()
        .map(|path| {
            let name = path.file_name().expect("a name").to_string_lossy();
            (name.into_owned(), fs::read(&path).expect("a case"))
        })
        .collect()
}

/// Small files of every format.
#[allow(clippy::too_many_lines, reason = "a list of files")]
fn seeds() -> Vec<Seed> {
    let cube = shapes::unit_cube();
    let tets = shapes::unit_cube_five_tets();
    let mut obj = String::new();
    cube.vertices
        .iter()
        .for_each(|p| obj += &format!("v {} {} {}\n", p.x, p.y, p.z));
    for triangle in &cube.triangles {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        obj += &format!("f {a}/1 {b}//2 {c}\n");
    }
    let mut ply = b"ply\nformat binary_little_endian 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nelement face 12\nproperty list uchar int vertex_indices\nend_header\n".to_vec();
    for p in &cube.vertices {
        ply.extend(p.iter().flat_map(|x| x.to_le_bytes()));
        ply.push(9);
    }
    let mut stl = vec![b' '; 80];
    stl.extend(12_u32.to_le_bytes());
    for (triangle, corners) in cube.triangles.iter().zip(cube.all_corners()) {
        ply.push(3);
        ply.extend(triangle.iter().flat_map(|vertex| vertex.to_le_bytes()));
        stl.extend([0; 12]);
        stl.extend(
            corners
                .iter()
                .flat_map(|p| p.iter().flat_map(|&x| (x as f32).to_le_bytes())),
        );
        stl.extend([0; 2]);
    }
    let mut gmsh = String::from(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 8 1 8\n3 1 0 8\n1\n2\n3\n4\n5\n6\n7\n8\n",
    );
    tets.vertices
        .iter()
        .for_each(|p| gmsh += &format!("{} {} {}\n", p.x, p.y, p.z));
    gmsh += "$EndNodes\n$Elements\n1 5 1 5\n3 1 4 5\n";
    for (number, tet) in tets.tets.iter().enumerate() {
        let [a, b, c, d] = tet.map(|vertex| vertex + 1);
        gmsh += &format!("{} {a} {b} {c} {d}\n", number + 1);
    }
    gmsh += "$EndElements\n$NodeData\n1\n\"rho\"\n1\n0\n3\n0\n1\n2\n1 5\n2 6\n$EndNodeData\n";
    let vtu = "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" header_type=\"UInt32\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"1\"><PointData><DataArray type=\"Float32\" Name=\"rho\" format=\"ascii\">1 2 3 4</DataArray></PointData><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells><DataArray type=\"Int32\" Name=\"connectivity\" format=\"binary\">EAAAAAAAAAABAAAAAgAAAAMAAAA=</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">4</DataArray><DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10</DataArray></Cells></Piece></UnstructuredGrid></VTKFile>";
    let mut npy = b"\x93NUMPY\x01\x00\x46\x00".to_vec();
    npy.extend(
        format!(
            "{:<69}\n",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }"
        )
        .bytes(),
    );
    npy.extend(
        [0.1, 0.2, 0.3, 0.4, 0.5, 0.6_f64]
            .iter()
            .flat_map(|x| x.to_le_bytes()),
    );
    let mut all = vec![
        text("cube.off", off::write(&cube)),
        text("torus.off", off::write(&shapes::torus(1.0, 0.25, 5, 4))),
        text("cube.obj", obj),
        text("cube.volint", include_str!("../scenes/mirtich-cube.volint")),
        ("cube.ply".to_owned(), ply),
        ("cube.stl".to_owned(), stl),
        text("cube.mesh", medit::write(&tets)),
        text("cube.msh", gmsh),
        text("one.vtu", vtu),
        text(
            "one.node",
            "# nodes\n4 3 1 0\n1 0 0 0 1.5\n2 1 0 0 2\n3 0 1 0 3\n4 0 0 1 4\n",
        ),
        text("one.ele", "1 4 0\n1 1 2 3 4\n"),
        ("two.npy".to_owned(), npy),
        text("two.csv", "id,x,y,z\n7,0.1,0.2,0.3\n8,0.4,0.5,0.6\n"),
        text("two.txt", "# two\n0.1 0.2 0.3\n0.4 0.5 0.6\n"),
        text(
            "two.xyz",
            "2\nProperties=species:S:1:pos:R:3\nC 0.1 0.2 0.3\nO 0.4 0.5 0.6\n",
        ),
        text("two.json", "[[0.1, 0.2, 0.3],\n [0.4, 0.5, 0.6]]\n"),
        text(
            "box.scene",
            "{\n \"domain\": {\"box\": {\"min\": [0, -1, 0.5], \"max\": [1, 1, 2], \"periodic\": [true, false, false]}},\n \"sites\": {\"random\": {\"count\": 9, \"seed\": 3}},\n \"method\": {\"lloyd\": {\"iterations\": 3, \"tolerance\": 0.5}}, \"order\": 2\n}\n",
        ),
        text(
            "grid.scene",
            "{\"domain\": {\"half_spaces\": [[1,1,1,1],[-1,0,0,0],[0,-1,0,0],[0,0,-1,0]]},\n \"sites\": {\"grid\": {\"counts\": [3, 3, 3], \"jitter\": 0.5}}, \"density\": \"1 + 2*x + y^2*z\"}\n",
        ),
        text(
            "flat.scene",
            "{\"dimension\": 2, \"domain\": {\"polygon\": [[0,0],[2,0],[1,1]]},\n \"sites\": {\"list\": [[0.5,0.25],[1,0.5]]}, \"norm\": \"l2\"}\n",
        ),
        text(
            "mesh.scene",
            "{\"domain\": {\"surface\": \"whole.off\"}, \"sites\": {\"random\": {\"count\": 4}},\n \"density\": {\"size\": \"0.5 + 0.1*x\"}}\n",
        ),
    ];
    all.push(("two.checkpoint".to_owned(), checkpoint_bytes()));
    all.extend(cases());
    all
}

fn checkpoint_bytes() -> Vec<u8> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("checkpoint.bin");
    let sites = [[0.1, 0.2, 0.3].into(), [0.4, 0.5, 0.6].into()];
    let record = r#"{"iteration":7,"energy_mean":0.1,"energy_max":0.2,"energy_percent":104.0,
        "movement_mean":0.01,"movement_max":0.02,"movement_percent":1.0,"evaluations":3.5,"seconds":0.25}"#;
    let record: chebloyd::Record = serde_json::from_str(record).expect("a record");
    let memory = [1.0, 2.0];
    checkpoint::write::<3>(&path, "a run", &record, &sites, memory.into_iter())
        .expect("a checkpoint");
    fs::read(&path).expect("a checkpoint")
}

/// The signed sum of a mesh's cones or tetrahedra, and the sum of their sizes.
fn exact(vertices: &[nalgebra::Point3<f64>], elements: Elements<'_>) -> (f64, f64) {
    let mut points: Vec<[f64; 3]> = vertices.iter().map(|&point| point.into()).collect();
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let used: Vec<u32> = match elements {
        Elements::Triangles(triangles) => triangles.iter().flatten().copied().collect(),
        Elements::Tets(tets) => tets.iter().flatten().copied().collect(),
    };
    for point in used.iter().map(|&vertex| points[vertex as usize]) {
        for axis in 0..3 {
            low[axis] = low[axis].min(point[axis]);
            high[axis] = high[axis].max(point[axis]);
        }
    }
    // Signed sums do not depend on the apex; their sizes are those about the middle.
    let apex = points.len() as u32;
    points.push([0, 1, 2].map(|axis| low[axis] / 2.0 + high[axis] / 2.0));
    let points = ExactPoints::of(&points);
    match elements {
        Elements::Triangles(triangles) => {
            points.volume(triangles.iter().map(|&[a, b, c]| [apex, a, b, c]))
        }
        Elements::Tets(tets) => points.volume(tets.iter().copied()),
    }
}

#[derive(Clone, Copy)]
enum Elements<'a> {
    Triangles(&'a [[u32; 3]]),
    Tets(&'a [[u32; 4]]),
}

fn check_mesh(path: &Path) {
    let Ok(solid) = load(path) else { return };
    let volume = solid.volume();
    assert!(volume > 0.0 && volume.is_finite(), "volume {volume}");
    let (own, size) = match &solid {
        Solid::Surface(valid, _) => {
            let mesh = valid.mesh();
            exact(&mesh.vertices, Elements::Triangles(&mesh.triangles))
        }
        Solid::Tets(valid, _) => exact(&valid.mesh().vertices, Elements::Tets(&valid.mesh().tets)),
    };
    assert!(
        (volume - own).abs() <= 1e-12 * size,
        "{volume}, exactly {own} of {size}"
    );
    // Where nothing was repaired, the same follows from the file as read.
    if !solid.notes().is_empty() {
        return;
    }
    let raw = read(path).expect("it was loaded");
    let (raw, size) = match &raw {
        Mesh::Surface(mesh) => exact(&mesh.vertices, Elements::Triangles(&mesh.triangles)),
        Mesh::Tets(mesh) => exact(&mesh.vertices, Elements::Tets(&mesh.tets)),
    };
    assert!(
        (volume - raw).abs() <= 1e-12 * size,
        "{volume}, in the file {raw} of {size}"
    );
    if let Some((numbers, size)) = own_reading(path) {
        assert!(
            (volume - numbers).abs() <= 1e-12 * size,
            "{volume}, by the numbers {numbers}"
        );
    }
}

/// The volume by the numbers of a plain OFF file of triangles or of a binary STL, read here.
fn own_reading(path: &Path) -> Option<(f64, f64)> {
    let bytes = fs::read(path).ok()?;
    let mut points: Vec<[f64; 3]> = vec![[0.0; 3]];
    let mut tets: Vec<[u32; 4]> = Vec::new();
    if path.extension()? == "stl" && bytes.get(80..84) == Some(&12_u32.to_le_bytes()) {
        for record in bytes.get(84..684)?.chunks_exact(50) {
            let first = points.len() as u32;
            for corner in record[12..48].chunks_exact(12) {
                let number = |at: usize| {
                    corner[4 * at..4 * at + 4]
                        .try_into()
                        .map(f32::from_le_bytes)
                };
                points.push([number(0).ok()?, number(1).ok()?, number(2).ok()?].map(f64::from));
            }
            tets.push([0, first, first + 1, first + 2]);
        }
    } else if path.extension()? == "off" {
        let text = String::from_utf8(bytes).ok()?;
        let mut words = text.strip_prefix("OFF")?.split_whitespace();
        let mut number = || words.next()?.parse::<f64>().ok();
        let (vertices, faces) = (number()? as usize, number()? as usize);
        number()?;
        for _ in 0..vertices {
            points.push([number()?, number()?, number()?]);
        }
        for _ in 0..faces {
            let face = [number()?, number()? + 1.0, number()? + 1.0, number()? + 1.0];
            let [3.0, a, b, c] = face else { return None };
            tets.push([0, a as u32, b as u32, c as u32]);
        }
        let is_known = |&vertex: &u32| (vertex as usize) < points.len();
        if words.next().is_some() || !tets.iter().flatten().all(is_known) {
            return None;
        }
    } else {
        return None;
    }
    Some(ExactPoints::of(&points).volume(tets))
}

fn check_sites(path: &Path) {
    if let Ok(sites) = site_file::read::<3>(path) {
        let bytes = fs::read(path).expect("it was read");
        assert!(!sites.is_empty() && 5 * sites.len() <= bytes.len());
        assert!(sites.iter().all(|site| site.iter().all(|x| x.is_finite())));
    }
    drop(site_file::read::<2>(path));
}

fn check_scene(path: &Path) {
    let Ok(scene) = scene_text::scene(path) else {
        return;
    };
    // Sites that were asked for by the million are no mistake of the reader.
    let is_small = match &scene.sites {
        Sites::Random(random) => random.count.is_some_and(|count| count <= 1000),
        Sites::Grid(grid) => grid
            .counts
            .iter()
            .try_fold(1_usize, |all, n| all.checked_mul(*n))
            .is_some_and(|all| all <= 1000),
        Sites::List(_) | Sites::File(_) | Sites::Given(_) => true,
    };
    if !is_small {
        return;
    }
    if scene.dimension == 2 {
        if let Ok(plane) = plane(&scene) {
            drop(plane.place(&scene));
        }
        return;
    }
    let Ok((solid, _)) = scene.solid() else {
        return;
    };
    let volume = solid.shape().volume();
    assert!(volume > 0.0 && volume.is_finite(), "volume {volume}");
    let text = fs::read_to_string(path).expect("it was read");
    if let Some(own) = box_volume(&text) {
        assert!(
            (volume / own - 1.0).abs() < 1e-12,
            "{volume}, by the numbers {own}"
        );
    }
    if let Ok((space, _)) = space(&scene) {
        drop(space.place(&scene));
    }
}

/// The volume of a scene's box by its own numbers.
fn box_volume(text: &str) -> Option<f64> {
    let value: serde_json::Value = serde_json::from_str(text).ok()?;
    let sides = value.get("domain")?.get("box")?;
    let end = |name: &str, otherwise: f64| -> Option<[f64; 3]> {
        let Some(end) = sides.get(name) else {
            return Some([otherwise; 3]);
        };
        Some([end[0].as_f64()?, end[1].as_f64()?, end[2].as_f64()?])
    };
    let (min, max) = (end("min", 0.0)?, end("max", 1.0)?);
    Some((0..3).map(|axis| max[axis] - min[axis]).product())
}

fn check_checkpoint(path: &Path) {
    if let Ok(Some(saved)) = checkpoint::read::<3>(path) {
        let bytes = fs::read(path).expect("it was read");
        assert!(24 * saved.sites.len() + 8 * saved.memory.len() <= bytes.len());
    }
}

/// Writes a mutant beside what belongs to it and tries it.
fn try_one(folder: &Path, name: &str, bytes: &[u8], seeds: &[Seed]) -> PathBuf {
    let path = folder.join(name);
    for pair in ["one.node", "one.ele"] {
        if name.starts_with("one.") && name != pair {
            let (_, whole) = seeds.iter().find(|seed| seed.0 == pair).expect("a pair");
            fs::write(folder.join(pair), whole).expect("room");
        }
    }
    fs::write(&path, bytes).expect("room");
    path
}

fn check(path: &Path) {
    let extension = path
        .extension()
        .and_then(|e| e.to_str())
        .unwrap_or_default();
    match extension {
        "scene" => check_scene(path),
        "checkpoint" => check_checkpoint(path),
        "npy" | "csv" | "txt" | "xyz" | "json" => check_sites(path),
        _ => check_mesh(path),
    }
}

/// Tries mutants and reports the number of each before and after it, with the fault if there is one.
fn work(count: usize, seed: u64, report: &mpsc::Sender<(usize, Option<String>)>) {
    let seeds = seeds();
    let folder = tempfile::tempdir().expect("a folder");
    let whole = off::write(&shapes::unit_cube());
    fs::write(folder.path().join("whole.off"), whole).expect("room");
    for number in 0..count {
        let mut dice = Dice(seed.wrapping_add((number as u64) << 20));
        let (name, bytes) = &seeds[number % seeds.len()];
        let (_, other) = &seeds[dice.below(seeds.len())];
        let bytes = mutant(bytes, other, &mut dice);
        let path = try_one(folder.path(), name, &bytes, &seeds);
        keep(number, name, &bytes);
        if report.send((number, None)).is_err() {
            return;
        }
        let before = HEAP.current_usage();
        HEAP.reset_peak_usage();
        let outcome = catch_unwind(AssertUnwindSafe(|| check(&path)));
        let taken = HEAP.peak_usage().saturating_sub(before);
        let fault = match outcome {
            Err(panic) => Some(said(panic.as_ref())),
            Ok(()) if taken > MOST_MEMORY + 1000 * bytes.len() => Some(format!("{taken} bytes")),
            Ok(()) => None,
        };
        match fault {
            None => forget(number, name),
            Some(fault) => drop(report.send((number, Some(format!("{name}: {fault}"))))),
        }
    }
}

fn said(panic: &(dyn std::any::Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().cloned();
    text.or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string))
        .unwrap_or_default()
}

fn kept(number: usize, name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("mutants");
    folder.join(format!("{number}-{name}"))
}

fn keep(number: usize, name: &str, bytes: &[u8]) {
    let path = kept(number, name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    fs::write(path, bytes).expect("room");
}

fn forget(number: usize, name: &str) {
    fs::remove_file(kept(number, name)).expect("it was kept");
}

#[test]
fn mutants_are_refused_or_mean_what_is_in_them() {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let count = number("CHEBLOYD_MUTANTS").unwrap_or(2000) as usize;
    let seed = number("CHEBLOYD_MUTANTS_SEED").unwrap_or(1);
    let (report, reports) = mpsc::channel();
    let worker = std::thread::spawn(move || work(count, seed, &report));
    let (mut last, mut faults) = (0, Vec::new());
    loop {
        match reports.recv_timeout(LONGEST) {
            Ok((number, None)) => last = number,
            Ok((number, Some(fault))) => faults.push(format!("{number}: {fault}")),
            Err(mpsc::RecvTimeoutError::Timeout) => panic!("mutant {last} hangs; {faults:#?}"),
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
        }
    }
    worker.join().expect("the worker's own steps");
    assert_eq!(last + 1, count);
    assert!(faults.is_empty(), "{} faults: {faults:#?}", faults.len());
}

/// Every seed is good, so that its mutants are near what is read.
#[test]
fn what_mutants_are_made_of_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let seeds = seeds();
    fs::write(
        folder.path().join("whole.off"),
        off::write(&shapes::unit_cube()),
    )
    .expect("room");
    for (name, bytes) in &seeds {
        let path = try_one(folder.path(), name, bytes, &seeds);
        match name.rsplit('.').next().unwrap_or_default() {
            "scene" => drop(scene_text::scene(&path).expect(name)),
            "checkpoint" => drop(checkpoint::read::<3>(&path).expect(name).expect(name)),
            "npy" | "csv" | "txt" | "xyz" | "json" => {
                drop(site_file::read::<3>(&path).expect(name))
            }
            _ => drop(read(&path).expect(name)),
        }
        check(&path);
    }
}
