//! Mesh files of every format: recognized, read, and checked.
//!
//! An unambiguous signature in the first bytes decides the format, even against the extension;
//! else the extension; else weaker signs in the content. Files packed by gzip are unpacked first. [`read`] takes either kind of mesh, [`read_surface`]
//! and [`read_tets`] one; [`load`] also validates and names the file in every message.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::mesh::elements::{Elements, Groups};
use crate::mesh::formats::error::{ErrorKind, ParseError, ReadError};
use crate::mesh::formats::foreign::{check_extension, check_signature};
use crate::mesh::formats::mesh::{Mesh, MeshFile};
#[cfg(feature = "scene")]
use crate::mesh::formats::polygons;
use crate::mesh::formats::unpack::{extension_of, read_unpacked, without_gz};
use crate::mesh::formats::words::Words;
use crate::mesh::formats::{gmsh, medit, obj, off, ply, stl, tetgen, three_mf, volint, vtk, vtu};
use crate::mesh::report::Refusal;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{Solid, number_surface, number_tets};

/// The formats, as messages name them.
const KNOWN: &str =
    "export it as .off, .obj, .stl, .ply, .3mf, .mesh, .msh, .node/.ele, .vtk, .vtu or .vtp";

/// Reads a mesh file, or standard input where `path` is `-`.
///
/// # Errors
///
/// The file, the line or byte, what is wrong there and what to do.
pub fn read(path: &Path) -> Result<Mesh, ReadError> {
    Ok(read_file(path)?.mesh)
}

/// As [`read`], with what there is to say about the file.
pub(crate) fn read_file(path: &Path) -> Result<MeshFile, ReadError> {
    let bytes = read_bytes(path)?;
    let extension = extension_of(path);
    let parsed = match Format::of(&bytes, &extension) {
        Ok(Some(Format::TetGen)) => return read_pair(path),
        Ok(Some(format)) => format.parse(&bytes),
        Ok(None) => {
            let what = "a mesh format told neither by the first bytes nor the extension";
            let kind = ErrorKind::unsupported(what, KNOWN);
            Err(ParseError::whole(kind))
        }
        Err(foreign) => Err(foreign),
    };
    parsed.map_err(|error| in_file(path, error))
}

/// Reads a surface; of tetrahedra, their boundary.
///
/// # Errors
///
/// As [`read`].
pub fn read_surface(path: &Path) -> Result<SurfaceMesh, ReadError> {
    match read(path)? {
        Mesh::Surface(mesh) => Ok(mesh),
        Mesh::Tets(mesh) => Ok(mesh.boundary()),
    }
}

/// Reads tetrahedra.
///
/// # Errors
///
/// As [`read`], and if the file holds a surface only.
pub fn read_tets(path: &Path) -> Result<TetMesh, ReadError> {
    match read(path)? {
        Mesh::Tets(mesh) => Ok(mesh),
        Mesh::Surface(_) => {
            let mend = "use it as a surface, which needs none";
            Err(in_file(path, ParseError::missing("tetrahedra", mend)))
        }
    }
}

/// A file that gives no solid.
#[derive(Debug, Error)]
pub enum LoadError {
    /// It could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// It was read, but bounds or fills no solid.
    #[error("{} {refusal}", file.display())]
    Refused {
        /// The file as it was named by the caller.
        file: PathBuf,
        /// Why, and what to do.
        refusal: Refusal,
    },
}

/// Reads and checks a mesh file of either kind.
///
/// # Errors
///
/// The file and what is wrong with it, with the mend.
pub fn load(path: &Path) -> Result<Solid, LoadError> {
    load_within(path, 0.0)
}

/// As [`load`]; vertices up to `weld` apart (L) are merged where the mesh is open without.
///
/// # Errors
///
/// As [`load`].
pub fn load_within(path: &Path, weld: f64) -> Result<Solid, LoadError> {
    load_labeled(path, weld).map(|labeled| labeled.solid)
}

/// A solid, and what its file says about the elements that are left.
#[derive(Clone, Debug)]
pub(crate) struct LabeledSolid {
    pub(crate) solid: Solid,
    pub(crate) elements: Elements,
    /// A surface with several groups as it was read: walls that two of them share are no part of the
    /// solid's boundary.
    pub(crate) grouped: Option<Box<GroupedSurface>>,
}

/// A surface as it was read, with the group of every triangle.
#[derive(Clone, Debug)]
pub(crate) struct GroupedSurface {
    pub(crate) mesh: SurfaceMesh,
    pub(crate) groups: Groups,
}

impl LabeledSolid {
    /// Checks a mesh that was read; vertices up to `weld` apart (L) are merged where it is open without.
    ///
    /// # Errors
    /// Why it bounds or fills no solid.
    pub(crate) fn of(file: &MeshFile, weld: f64) -> Result<Self, Refusal> {
        let (mut solid, numbers) = match &file.mesh {
            Mesh::Surface(mesh) => {
                let (surface, report, numbers) = number_surface(mesh, weld)?;
                (Solid::Surface(surface, report), numbers)
            }
            Mesh::Tets(mesh) => {
                let (tets, report, numbers) = number_tets(mesh, weld)?;
                (Solid::Tets(tets, report), numbers)
            }
        };
        solid.set_file_notes(file.notes.clone());
        Ok(Self {
            solid,
            elements: file.elements.of_kept(&numbers),
            grouped: grouped(file),
        })
    }
}

/// The surface of a file with several groups.
fn grouped(file: &MeshFile) -> Option<Box<GroupedSurface>> {
    let groups = &file.elements.groups;
    match &file.mesh {
        Mesh::Surface(mesh) if groups.names().len() > 1 => Some(Box::new(GroupedSurface {
            mesh: mesh.clone(),
            groups: groups.clone(),
        })),
        _ => None,
    }
}

/// As [`load_within`], with what the file says about the elements.
pub(crate) fn load_labeled(path: &Path, weld: f64) -> Result<LabeledSolid, LoadError> {
    LabeledSolid::of(&read_file(path)?, weld).map_err(|refusal| {
        let file = path.to_path_buf();
        LoadError::Refused { file, refusal }
    })
}

/// The formats read here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Gmsh,
    Medit,
    Obj,
    Off,
    Ply,
    #[cfg(feature = "scene")]
    Polygons,
    Stl,
    TetGen,
    ThreeMf,
    VolInt,
    Vtk,
    Vtu,
}

impl Format {
    /// The format, or the refusal of one that is known but not read.
    fn of(bytes: &[u8], extension: &str) -> Result<Option<Self>, ParseError> {
        let is_named_stl = Self::by_extension(extension) == Some(Self::Stl);
        if is_named_stl && stl::may_be_binary(bytes) {
            return Ok(Some(Self::Stl));
        }
        check_signature(bytes)?;
        let format = Self::by_signature(bytes).or_else(|| Self::by_extension(extension));
        if format.is_none() {
            check_extension(extension)?;
        }
        Ok(format.or_else(|| Self::by_guess(bytes)))
    }

    /// The format whose signature the file starts with. A binary STL's first 80 bytes may hold any
    /// remark, so its length counts more, before this.
    fn by_signature(bytes: &[u8]) -> Option<Self> {
        let start = bytes.trim_ascii_start();
        let first = Words::new(bytes, Some(b'#')).word().unwrap_or_default();
        match first.to_ascii_lowercase().as_slice() {
            b"ply" => Some(Self::Ply),
            b"$meshformat" | b"$comments" | b"$nod" => Some(Self::Gmsh),
            _ if bytes.starts_with(b"PK\x03\x04") => Some(Self::ThreeMf),
            b"meshversionformatted" => Some(Self::Medit),
            _ if starts_with_any_case(start, b"# vtk DataFile") => Some(Self::Vtk),
            _ if start.starts_with(b"<?xml") || start.starts_with(b"<VTKFile") => Some(Self::Vtu),
            _ if off::is_header(first) => Some(Self::Off),
            _ => None,
        }
    }

    fn by_extension(extension: &str) -> Option<Self> {
        Some(match extension {
            "off" | "coff" | "noff" => Self::Off,
            "obj" => Self::Obj,
            "stl" | "stla" | "stlb" => Self::Stl,
            "ply" => Self::Ply,
            "mesh" => Self::Medit,
            "msh" => Self::Gmsh,
            "node" | "ele" => Self::TetGen,
            #[cfg(feature = "scene")]
            "json" => Self::Polygons,
            "volint" => Self::VolInt,
            "vtk" => Self::Vtk,
            "vtu" | "vtp" => Self::Vtu,
            "3mf" => Self::ThreeMf,
            _ => return None,
        })
    }

    fn by_guess(bytes: &[u8]) -> Option<Self> {
        let lines = bytes.split(|byte| b"\n\r".contains(byte)).take(2000);
        let mut words = lines.filter_map(|line| line.split(u8::is_ascii_whitespace).next());
        if stl::is_binary(bytes) || stl::is_text(bytes) {
            return Some(Self::Stl);
        }
        if volint::is_likely(bytes) {
            return Some(Self::VolInt);
        }
        words
            .any(|word| word.eq_ignore_ascii_case(b"v"))
            .then_some(Self::Obj)
    }

    fn parse(self, bytes: &[u8]) -> Result<MeshFile, ParseError> {
        let surface = match self {
            Self::Gmsh => return gmsh::read(bytes),
            Self::Medit => return medit::read(bytes),
            Self::ThreeMf => return three_mf::read(bytes),
            Self::Vtk => return vtk::read(bytes),
            Self::Vtu => return vtu::read(bytes),
            Self::Obj => return obj::parse_file(bytes),
            Self::Off => return off::parse_file(bytes),
            #[cfg(feature = "scene")]
            Self::Polygons => return polygons::parse(bytes),
            Self::VolInt => return volint::parse(bytes),
            Self::Ply => ply::parse(bytes),
            Self::Stl => return stl::parse_file(bytes),
            Self::TetGen => {
                let what = "one of TetGen's two files alone";
                let kind = ErrorKind::unsupported(what, "name the .ele file");
                Err(ParseError::whole(kind))
            }
        };
        Ok(MeshFile::plain(Mesh::Surface(surface?)))
    }
}

fn starts_with_any_case(bytes: &[u8], start: &[u8]) -> bool {
    let first = bytes.get(..start.len());
    first.is_some_and(|first| first.eq_ignore_ascii_case(start))
}

/// Reads TetGen's two files, given either; each may be packed.
fn read_pair(path: &Path) -> Result<MeshFile, ReadError> {
    let [nodes, elements] = tetgen_pair(path);
    let parsed = tetgen::parse_nodes(&read_bytes(&nodes)?);
    let parsed = parsed.map_err(|error| in_file(&nodes, error))?;
    tetgen::read_elements(&read_bytes(&elements)?, parsed)
        .map_err(|error| in_file(&elements, error))
}

/// The `.node` and the `.ele` file of a pair, given either: packed where the file is packed and no
/// plain one is there.
pub(crate) fn tetgen_pair(path: &Path) -> [PathBuf; 2] {
    let base = without_gz(path);
    ["node", "ele"].map(|extension| {
        let plain = base.with_extension(extension);
        let packed = base.with_extension(format!("{extension}.gz"));
        if packed.exists() && !plain.exists() {
            packed
        } else {
            plain
        }
    })
}

/// A file's bytes, without a byte order mark; not empty.
fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let whole = |kind| in_file(path, ParseError::whole(kind));
    let mut bytes = read_unpacked(path).map_err(whole)?;
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    if bytes.trim_ascii().is_empty() {
        return Err(whole(ErrorKind::Empty));
    }
    Ok(bytes)
}

fn in_file(path: &Path, error: ParseError) -> ReadError {
    let file = path.to_path_buf();
    ReadError { file, error }
}
