//! Files of formats that are not read here, recognized by their first bytes or their extension, with
//! what to export instead.

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::xml::next_tag;

const CAD: &str =
    "export the solid from the CAD program as STL, OBJ, PLY or 3MF, with a fine chordal tolerance";
const SCENE: &str = "export the mesh alone as OBJ, PLY, STL or 3MF (Blender: File > Export)";
const SOLVER: &str = "convert it to Gmsh .msh, MEDIT .mesh or VTK .vtu (meshio convert IN OUT.vtu)";
const GRID: &str =
    "export an UnstructuredGrid of tetrahedra or PolyData (ParaView: File > Save Data)";
const WHOLE: &str = "save all pieces as one .vtu or .vtp (ParaView: File > Save Data)";

/// The first bytes of a format, what it is, and the mend.
const SIGNATURES: [(&[u8], &str, &str); 28] = [
    (b"ISO-10303-21", "a STEP file", CAD),
    (b"**ABCDEFGHIJKLMNOPQRSTUVWXYZ", "a Parasolid file", CAD),
    (b"PS\0\0", "a Parasolid file", CAD),
    (b"DBRep_DrawableShape", "an OpenCASCADE BREP file", CAD),
    (b"CASCADE Topology", "an OpenCASCADE BREP file", CAD),
    (b"ACIS BinaryFile", "an ACIS file", CAD),
    (b"V5_CFV2", "a CATIA file", CAD),
    (
        b"\xd0\xcf\x11\xe0",
        "a file of a CAD program (SolidWorks, Inventor)",
        CAD,
    ),
    (b"3D Geometry File Format", "a Rhino file", CAD),
    (b"AC10", "a DWG drawing", CAD),
    (b"Kaydara FBX Binary", "an FBX file", SCENE),
    (b"; FBX", "an FBX file", SCENE),
    (b"glTF", "a glTF file", SCENE),
    (b"BLENDER", "a Blender file", SCENE),
    (b"#VRML", "a VRML file", SCENE),
    (b"#X3D", "an X3D file", SCENE),
    (b"#usda", "a USD file", SCENE),
    (b"PXR-USDC", "a USD file", SCENE),
    (b"MM\0\0", "a TIFF picture", SCENE),
    (b"\x89PNG", "a picture", SCENE),
    (
        b"\x89HDF",
        "an HDF5 file (CGNS, MED, Exodus, VTKHDF)",
        SOLVER,
    ),
    (b"CDF\x01", "a netCDF file (Exodus)", SOLVER),
    (b"CDF\x02", "a netCDF file (Exodus)", SOLVER),
    (b"mesh3d", "a Netgen .vol file", SOLVER),
    (b"NDIME=", "an SU2 mesh", SOLVER),
    (b"$NOE", "a file of an old solver", SOLVER),
    (b"BEGIN BULK", "a Nastran deck", SOLVER),
    (b"*HEADING", "an Abaqus deck", SOLVER),
];

/// The first element of an XML file, what it is, and the mend.
const ELEMENTS: [(&[u8], &str, &str); 6] = [
    (b"COLLADA", "a Collada file", SCENE),
    (b"X3D", "an X3D file", SCENE),
    (b"svg", "an SVG drawing", SCENE),
    (b"amf", "an AMF file", "export it as 3MF or STL"),
    (b"Xdmf", "an XDMF file", SOLVER),
    (
        b"model",
        "the model of a 3MF package alone",
        "give the whole .3mf file",
    ),
];

/// Extensions, what they stand for, and the mend.
const EXTENSIONS: [(&[&str], &str, &str); 19] = [
    (&["step", "stp", "p21", "stpz"], "a STEP file", CAD),
    (&["iges", "igs"], "an IGES file", CAD),
    (
        &["x_t", "x_b", "xmt_txt", "xmt_bin"],
        "a Parasolid file",
        CAD,
    ),
    (&["sat", "sab"], "an ACIS file", CAD),
    (&["brep", "brp"], "an OpenCASCADE BREP file", CAD),
    (
        &[
            "sldprt", "sldasm", "ipt", "iam", "prt", "catpart", "f3d", "fcstd", "3dm", "jt", "scad",
        ],
        "a file of a CAD program",
        CAD,
    ),
    (&["dxf", "dwg"], "a drawing", CAD),
    (&["dae"], "a Collada file", SCENE),
    (&["fbx"], "an FBX file", SCENE),
    (&["gltf", "glb"], "a glTF file", SCENE),
    (&["blend"], "a Blender file", SCENE),
    (
        &[
            "3ds", "max", "c4d", "lwo", "ma", "mb", "skp", "usd", "usda", "usdc", "usdz", "abc",
        ],
        "a file of a modelling program",
        SCENE,
    ),
    (&["wrl", "vrml", "x3d"], "a VRML or X3D file", SCENE),
    (&["inp"], "an Abaqus deck", SOLVER),
    (&["bdf", "nas", "dat", "fem"], "a Nastran deck", SOLVER),
    (
        &[
            "cgns", "med", "exo", "e", "g", "vtkhdf", "h5m", "xdmf", "cas", "su2", "vol", "unv",
            "mphtxt",
        ],
        "a file of a solver",
        SOLVER,
    ),
    (
        &["meshb"],
        "a binary MEDIT file",
        "convert it to .mesh (transmesh IN.meshb OUT.mesh)",
    ),
    (&["vti", "vtr", "vts"], "a structured grid of VTK", GRID),
    (
        &["pvtu", "pvtp", "vtm", "pvd"],
        "an index of VTK files",
        WHOLE,
    ),
];

/// Refuses a file whose first bytes are those of a format that is not read.
pub(crate) fn check_signature(bytes: &[u8]) -> Result<(), ParseError> {
    let start = bytes.trim_ascii_start();
    let starts = |(signature, ..): &&(&[u8], _, _)| start.starts_with(signature);
    if let Some(&(_, what, mend)) = SIGNATURES.iter().find(starts) {
        return refuse(what, mend);
    }
    if is_iges(bytes) {
        return refuse("an IGES file", CAD);
    }
    if is_gltf(start) {
        return refuse("a glTF file", SCENE);
    }
    if is_fluent(start) {
        return refuse("a mesh of ANSYS Fluent", SOLVER);
    }
    check_element(start)
}

/// Refuses a text whose first element is that of a format of XML that is not read.
fn check_element(start: &[u8]) -> Result<(), ParseError> {
    let element = || next_tag(start, 0).map(|tag| tag.name);
    let is_named =
        |(name, ..): &&(&[u8], _, _)| start.starts_with(b"<") && element() == Some(*name);
    match ELEMENTS.iter().find(is_named) {
        Some(&(_, what, mend)) => refuse(what, mend),
        None => Ok(()),
    }
}

/// Refuses a file whose content says nothing by its extension.
pub(crate) fn check_extension(extension: &str) -> Result<(), ParseError> {
    let is_known = |(names, ..): &&(&[&str], _, _)| names.contains(&extension);
    match EXTENSIONS.iter().find(is_known) {
        Some(&(_, what, mend)) => refuse(what, mend),
        None => Ok(()),
    }
}

fn refuse(what: &str, mend: &'static str) -> Result<(), ParseError> {
    Err(ParseError::whole(ErrorKind::unsupported(what, mend)))
}

/// Lines of 80 columns whose 73rd is the section's letter, `S` for the first, followed by a number.
fn is_iges(bytes: &[u8]) -> bool {
    let Some(line) = bytes.get(..80) else {
        return false;
    };
    let number = line[73..80].trim_ascii();
    line[72] == b'S' && [&b"1"[..], b"0000001"].contains(&number)
}

/// JSON with the object `asset`, which glTF demands.
fn is_gltf(start: &[u8]) -> bool {
    let head = &start[..start.len().min(4096)];
    let has = |word: &[u8]| head.windows(word.len()).any(|window| window == word);
    start.starts_with(b"{") && has(b"\"asset\"") && has(b"\"version\"")
}

/// Sections in round brackets, each with its number first: `(0 "remark")`, `(2 3)`.
fn is_fluent(start: &[u8]) -> bool {
    matches!(start, [b'(', b'0'..=b'9', b' ' | b'0'..=b'9', ..])
}
