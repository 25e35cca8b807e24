//! `chebloyd mass`: named groups, cell data, placements, masses left to densities, SI.

use serde_json::Value;

use crate::test_dir::{TestDir, assert_all_in};

/// The quads of a unit cube, counter-clockwise seen from outside, and its corners from `x` on.
const QUADS: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

fn corners(x: usize) -> Vec<[usize; 3]> {
    let corner = |bits: usize| [x + (bits & 1), bits >> 1 & 1, bits >> 2];
    (0..8).map(corner).collect()
}

/// Two unit cubes side by side, each a group called by `keyword`.
fn obj(keyword: &str) -> String {
    let mut text = String::new();
    for (cube, name) in ["steel", "cork"].into_iter().enumerate() {
        text += &format!("{keyword} {name}\n");
        for [x, y, z] in corners(cube) {
            text += &format!("v {x} {y} {z}\n");
        }
        for quad in QUADS {
            let [a, b, c, d] = quad.map(|corner| 8 * cube + corner + 1);
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

fn stl() -> String {
    let mut text = String::new();
    for (cube, name) in ["steel", "cork"].into_iter().enumerate() {
        text += &format!("solid {name}\n");
        let corners = corners(cube);
        for [a, b, c, d] in QUADS {
            for triangle in [[a, b, c], [a, c, d]] {
                text += "facet normal 0 0 0\nouter loop\n";
                for [x, y, z] in triangle.map(|corner| corners[corner]) {
                    text += &format!("vertex {x} {y} {z}\n");
                }
                text += "endloop\nendfacet\n";
            }
        }
        text += &format!("endsolid {name}\n");
    }
    text
}

/// Two tetrahedra that share a facet, of volumes 1/6 and 1/3.
const POINTS: [[i32; 3]; 5] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]];

fn msh(version: &str) -> String {
    let nodes = |order: &str| -> String {
        let line = |(k, [x, y, z]): (usize, &[i32; 3])| {
            format!("{}{x} {y} {z}\n", order.replace('k', &(k + 1).to_string()))
        };
        POINTS.iter().enumerate().map(line).collect()
    };
    let names = "$PhysicalNames\n2\n3 7 \"steel\"\n3 9 \"cork oak\"\n$EndPhysicalNames\n";
    let data = "$ElementData\n1\n\"rho\"\n1\n0.0\n3\n0\n1\n2\n11 6\n12 3\n$EndElementData\n";
    if version == "2.2" {
        let elements = "$Elements\n2\n11 4 2 7 1 1 2 3 4\n12 4 2 9 2 2 3 4 5\n$EndElements\n";
        return format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}$Nodes\n5\n{}$EndNodes\n{elements}{data}",
            nodes("k ")
        );
    }
    let entities = "$Entities\n0 0 0 2\n1 0 0 0 1 1 1 1 7 0\n2 0 0 0 1 1 1 1 9 0\n$EndEntities\n";
    let elements = "$Elements\n2 2 11 12\n3 1 4 1\n11 1 2 3 4\n3 2 4 1\n12 2 3 4 5\n$EndElements\n";
    format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{names}{entities}$Nodes\n1 5 1 5\n3 1 0 5\n1\n2\n3\n4\n5\n{}$EndNodes\n{elements}{data}",
        nodes("")
    )
}

fn medit() -> String {
    let points: String = POINTS
        .iter()
        .map(|[x, y, z]| format!("{x} {y} {z} 0\n"))
        .collect();
    format!(
        "MeshVersionFormatted 2\nDimension 3\nVertices\n5\n{points}Tetrahedra\n2\n1 2 3 4 7\n2 3 4 5 9\nEnd\n"
    )
}

fn vtk() -> String {
    let points: String = POINTS
        .iter()
        .map(|[x, y, z]| format!("{x} {y} {z}\n"))
        .collect();
    format!(
        "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n{points}\
         CELLS 3 13\n2 0 1\n4 0 1 2 3\n4 1 2 3 4\nCELL_TYPES 3\n3\n10\n10\n\
         CELL_DATA 3\nSCALARS rho double 1\nLOOKUP_TABLE default\n100\n6\n3\n"
    )
}

fn vtu() -> String {
    let points: String = POINTS
        .iter()
        .map(|[x, y, z]| format!("{x} {y} {z} "))
        .collect();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"5\" NumberOfCells=\"2\">\n\
         <CellData><DataArray type=\"Float64\" Name=\"rho\" format=\"ascii\">6 3</DataArray></CellData>\n\
         <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray></Points>\n\
         <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 1 2 3 4</DataArray>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">4 8</DataArray>\n\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 10</DataArray></Cells>\n\
         </Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
    )
}

fn dir() -> TestDir {
    let dir = TestDir::new();
    dir.write("two.obj", obj("g"))
        .write("objects.obj", obj("o"))
        .write("two.stl", stl())
        .write("two.msh", msh("2.2"))
        .write("four.msh", msh("4.1"))
        .write("two.mesh", medit())
        .write("two.vtk", vtk())
        .write("two.vtu", vtu());
    dir
}

fn mass(dir: &TestDir, arguments: &[&str]) -> Value {
    let arguments = [&["mass", "--json"], arguments].concat();
    serde_json::from_str(&dir.stdout(&arguments)).expect("JSON")
}

fn near(value: &Value, expected: f64) {
    let got = value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is not {expected}"));
    let scale = expected.abs().max(1.0);
    assert!(
        (got - expected).abs() < 1e-13 * scale,
        "{got} is not {expected}"
    );
}

#[test]
fn groups_of_surfaces_have_rows_and_densities_of_their_own() {
    let dir = dir();
    for file in ["two.obj", "objects.obj", "two.stl"] {
        let plain = mass(&dir, &[file, "--density", "2"]);
        near(&plain["mass"], 4.0);
        let groups = &plain["parts"][0]["groups"];
        assert_eq!(groups[0]["name"], "steel", "{file}");
        near(&groups[1]["center_of_mass"][0], 1.5);
        near(&groups[1]["mass"], 2.0);
        let own = mass(&dir, &[file, "--density", "steel=7", "--density", "cork=1"]);
        near(&own["mass"], 8.0);
        near(&own["center_of_mass"][0], (7.0 * 0.5 + 1.5) / 8.0);
        near(
            &own["surface_area"],
            plain["surface_area"].as_f64().expect("an area"),
        );
        let groups = &own["parts"][0]["groups"];
        assert_eq!(groups[0]["density"], "7");
        near(&groups[0]["mass"], 7.0);
        let rest = mass(&dir, &[file, "--density", "3", "--density", "cork=x"]);
        near(&rest["mass"], 3.0 + 1.5);
        let given = mass(&dir, &[file, "--mass", "cork=5"]);
        near(&given["mass"], 6.0);
    }
    let table = dir.stdout(&["mass", "two.obj", "--density", "steel=7"]);
    assert_all_in(
        &table,
        &[
            "part",
            "  steel",
            "  cork",
            "(by groups)",
            "negative products of inertia",
        ],
    );
}

#[test]
fn groups_of_tetrahedra_have_densities_of_their_own() {
    let dir = dir();
    let small = 1.0 / 6.0;
    let large = 1.0 / 3.0;
    for (file, steel, cork) in [
        ("two.msh", "steel", "cork oak"),
        ("four.msh", "steel", "cork oak"),
        ("two.mesh", "7", "9"),
    ] {
        let (steel, cork) = (format!("{steel}=6"), format!("{cork}=3"));
        let own = mass(&dir, &[file, "--density", &steel, "--density", &cork]);
        near(&own["volume"], small + large);
        near(&own["mass"], 6.0 * small + 3.0 * large);
        near(&own["parts"][0]["groups"][1]["mass"], 3.0 * large);
        near(
            &own["center_of_mass"][0],
            (0.25 * 6.0 * small + 0.5 * 3.0 * large) / 2.0,
        );
    }
}

#[test]
fn cell_data_are_one_constant_per_tetrahedron() {
    let dir = dir();
    for file in ["two.vtu", "two.vtk", "two.msh", "four.msh"] {
        for density in ["cell:rho", "cell"] {
            let body = mass(&dir, &[file, "--density", density]);
            near(&body["mass"], 2.0);
            near(&body["center_of_mass"][2], (0.25 + 0.5) / 2.0);
        }
    }
    dir.stdout(&["mass", "two.vtu", "--density", "cell:rho", "--out", "drawn"]);
    let again = mass(&dir, &["drawn/density.vtu", "--density", "vertex:density"]);
    near(&again["mass"], 2.0);
    let negative = vtu().replace("6 3</DataArray>", "6 -1</DataArray>");
    dir.write("negative.vtu", negative);
    let body = mass(&dir, &["negative.vtu", "--density", "cell:rho"]);
    assert_all_in(
        &body["notes"].to_string(),
        &["the density is -1 at (0.5, 0.5, 0.5)"],
    );
}

#[test]
fn parts_without_a_mass_keep_their_density() {
    let dir = dir();
    let both = mass(
        &dir,
        &[
            "two.obj",
            "two.vtu",
            "--density",
            "3",
            "--mass",
            "_",
            "--mass",
            "10",
        ],
    );
    near(&both["parts"][0]["mass"], 6.0);
    near(&both["parts"][1]["mass"], 10.0);
    let named = mass(&dir, &["two.obj", "two.vtu", "--mass", "two.vtu=10"]);
    near(&named["mass"], 12.0);
}

#[test]
fn placements_move_turn_scale_and_mirror_files() {
    let dir = dir();
    // A quarter turn about z, then 5 along x.
    let turned = "0 -1 0 5  1 0 0 0  0 0 1 0  0 0 0 1";
    let moved = mass(
        &dir,
        &["two.vtu", "--density", "cell:rho", "--place", turned],
    );
    near(&moved["mass"], 2.0);
    near(&moved["center_of_mass"][0], 5.0 - 0.375);
    near(&moved["center_of_mass"][1], 0.375);
    dir.write("mirror.txt", "-2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
    for file in ["two.obj", "two.stl", "two.mesh"] {
        let plain = mass(&dir, &[file]);
        let mirrored = mass(&dir, &[file, "--place", "mirror.txt"]);
        near(
            &mirrored["volume"],
            2.0 * plain["volume"].as_f64().expect("a volume"),
        );
        near(
            &mirrored["center_of_mass"][0],
            -2.0 * plain["center_of_mass"][0].as_f64().expect("x"),
        );
        assert_eq!(mirrored.get("notes"), plain.get("notes"), "{file}");
    }
    let both = mass(
        &dir,
        &[
            "two.obj",
            "two.mesh",
            "--place",
            "_",
            "--place",
            "1,0,0,9,0,1,0,0,0,0,1,0,0,0,0,1",
        ],
    );
    near(&both["parts"][0]["center_of_mass"][0], 1.0);
    near(
        &both["parts"][1]["center_of_mass"][0],
        9.0 + (0.25 / 6.0 + 0.5 / 3.0) / 0.5,
    );
}

#[test]
fn si_converts_lengths_densities_and_masses() {
    let dir = dir();
    let si = [
        "two.obj",
        "--units",
        "mm",
        "--si",
        "--density-units",
        "g/cm3",
        "--density",
        "7.85",
    ];
    let body = mass(&dir, &si);
    near(&body["volume"], 2e-9);
    near(&body["surface_area"], 12e-6);
    near(&body["mass"], 7850.0 * 2e-9);
    let mass_kg = 7850.0 * 2e-9;
    let center = &body["inertia_center"];
    let relative = |got: &Value, expected: f64| {
        let got = got.as_f64().expect("a number");
        assert!(
            (got / expected - 1.0).abs() < 1e-12,
            "{got} is not {expected}"
        );
    };
    relative(&body["mass"], mass_kg);
    relative(&body["volume"], 2e-9);
    relative(&center[0][0], mass_kg * 2.0e-6 / 12.0);
    relative(&body["center_of_mass"][0], 1e-3);
    assert_all_in(&body["units"].to_string(), &["SI", "in mm", "g/cm3"]);
    let given = mass(&dir, &["two.obj", "--units", "in", "--si", "--mass", "3"]);
    relative(&given["mass"], 3.0);
    relative(&given["center_of_mass"][0], 0.0254);
}

#[test]
fn what_is_no_part_is_refused_with_the_mend() {
    let dir = dir();
    let patches = obj("g").replace("f 13 14 16 15\n", "g lid\nf 13 14 16 15\n");
    dir.write("patches.obj", patches);
    let singular = "1 0 0 0 0 0 0 0 0 0 1 0 0 0 0 1";
    for (arguments, parts) in [
        (
            &["two.obj", "--density", "stele=7"][..],
            &["no file or group `stele`", "`steel`"][..],
        ),
        (
            &["patches.obj", "--density", "lid=7"],
            &["patches.obj", "group `cork` is not closed", "one density"],
        ),
        (
            &["two.obj", "--density", "cell:rho"],
            &["two.obj", "tetrahedral mesh"],
        ),
        (
            &["two.vtu", "--density", "cell:sigma"],
            &["no cell data `sigma`", "`rho`"],
        ),
        (&["two.mesh", "--density", "cell"], &["none"]),
        (
            &["two.obj", "--place", "1 2 3"],
            &["16 numbers are needed, not 3"],
        ),
        (&["two.obj", "--place", singular], &["determinant is 0"]),
        (
            &["two.obj", "--place", "1 0 0 0 0 1 0 0 0 0 1 0 5 0 0 1"],
            &["last row", "row by row"],
        ),
        (
            &["two.obj", "--place", "none.txt"],
            &["none.txt", "16 numbers"],
        ),
        (&["two.obj", "--mass", "-3"], &["--mass"]),
        (&["two.obj", "--mass", "cork=no"], &["--mass no", "_"]),
        (&["two.obj", "--si"], &["--units"]),
        (
            &["two.obj", "--si", "--units", "furlong"],
            &["furlong", "mm"],
        ),
        (&["two.obj", "--density-units", "g/cm3"], &["--si"]),
    ] {
        let message = dir.refusal(&[&["mass"], arguments].concat());
        assert_all_in(&message, parts);
    }
}
