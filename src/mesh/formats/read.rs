//! Mesh files of every format: recognized, read, and checked.
//!
//! An unambiguous signature in the first bytes decides the format, even against the extension;
//! else the extension; else weaker signs in the content. [`read`] takes either kind of mesh, [`read_surface`]
//! and [`read_tets`] one; [`load`] also validates and names the file in every message.

use std::fs;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::mesh::elements::Elements;
use crate::mesh::formats::error::{ErrorKind, ParseError, ReadError};
use crate::mesh::formats::mesh::{Mesh, MeshFile};
#[cfg(feature = "scene")]
use crate::mesh::formats::polygons;
use crate::mesh::formats::words::Words;
use crate::mesh::formats::{gmsh, medit, obj, off, ply, stl, tetgen, volint, vtk, vtu};
use crate::mesh::report::Refusal;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{Solid, number_surface, number_tets};

/// The formats, as messages name them.
const KNOWN: &str = "export it as .off, .obj, .stl, .ply, .mesh, .msh, .node/.ele, .vtk or .vtu";

/// Reads a mesh file.
///
/// # Errors
///
/// The file, the line or byte, what is wrong there and what to do.
pub fn read(path: &Path) -> Result<Mesh, ReadError> {
    read_file(path).map(|file| file.mesh)
}

/// As [`read`], with what the file says about the elements.
pub(crate) fn read_file(path: &Path) -> Result<MeshFile, ReadError> {
    let bytes = read_bytes(path)?;
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    match Format::of(&bytes, &extension) {
        Some(Format::TetGen) => read_pair(path).map(|tets| Mesh::Tets(tets).into()),
        Some(format) => format.parse(&bytes).map_err(|error| in_file(path, error)),
        None => {
            let what = "a mesh format told neither by the first bytes nor the extension";
            let kind = ErrorKind::unsupported(what, KNOWN);
            Err(in_file(path, ParseError::whole(kind)))
        }
    }
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
    load_labeled(path).map(|labeled| labeled.solid)
}

/// A solid, and what its file says about the elements that are left.
#[derive(Clone, Debug)]
pub(crate) struct LabeledSolid {
    pub(crate) solid: Solid,
    pub(crate) elements: Elements,
}

impl LabeledSolid {
    /// Checks a mesh that was read.
    ///
    /// # Errors
    /// Why it bounds or fills no solid.
    pub(crate) fn of(file: &MeshFile) -> Result<Self, Refusal> {
        let (solid, numbers) = match &file.mesh {
            Mesh::Surface(mesh) => {
                let (surface, report, numbers) = number_surface(mesh)?;
                (Solid::Surface(surface, report), numbers)
            }
            Mesh::Tets(mesh) => {
                let (tets, report, numbers) = number_tets(mesh)?;
                (Solid::Tets(tets, report), numbers)
            }
        };
        let elements = file.elements.of_kept(&numbers);
        Ok(Self { solid, elements })
    }
}

/// As [`load`], with what the file says about the elements.
pub(crate) fn load_labeled(path: &Path) -> Result<LabeledSolid, LoadError> {
    LabeledSolid::of(&read_file(path)?).map_err(|refusal| {
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
    VolInt,
    Vtk,
    Vtu,
}

impl Format {
    fn of(bytes: &[u8], extension: &str) -> Option<Self> {
        Self::by_signature(bytes, extension)
            .or_else(|| Self::by_extension(extension))
            .or_else(|| Self::by_guess(bytes))
    }

    /// The format whose signature the file starts with. A binary STL's first 80 bytes may hold any
    /// remark, so its length counts more.
    fn by_signature(bytes: &[u8], extension: &str) -> Option<Self> {
        let is_named_stl = Self::by_extension(extension) == Some(Self::Stl);
        if is_named_stl && stl::may_be_binary(bytes) {
            return Some(Self::Stl);
        }
        let start = bytes.trim_ascii_start();
        let first = Words::new(bytes, Some(b'#')).word().unwrap_or_default();
        match first.to_ascii_lowercase().as_slice() {
            b"ply" => Some(Self::Ply),
            b"$meshformat" => Some(Self::Gmsh),
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
            "vtu" => Self::Vtu,
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
        match self {
            Self::Gmsh => gmsh::parse(bytes).map(MeshFile::from),
            Self::Medit => medit::parse(bytes).map(MeshFile::from),
            Self::Obj => obj::parse_file(bytes),
            Self::Off => off::parse_file(bytes),
            Self::Ply => ply::parse(bytes).map(|mesh| Mesh::Surface(mesh).into()),
            #[cfg(feature = "scene")]
            Self::Polygons => polygons::parse(bytes),
            Self::Stl => stl::parse(bytes).map(|mesh| Mesh::Surface(mesh).into()),
            Self::VolInt => volint::parse(bytes),
            Self::Vtk => vtk::parse(bytes).map(MeshFile::from),
            Self::Vtu => vtu::parse(bytes).map(MeshFile::from),
            Self::TetGen => {
                let what = "one of TetGen's two files alone";
                let kind = ErrorKind::unsupported(what, "name the .ele file");
                Err(ParseError::whole(kind))
            }
        }
    }
}

fn starts_with_any_case(bytes: &[u8], start: &[u8]) -> bool {
    let first = bytes.get(..start.len());
    first.is_some_and(|first| first.eq_ignore_ascii_case(start))
}

/// Reads TetGen's two files, given either.
fn read_pair(path: &Path) -> Result<TetMesh, ReadError> {
    let (nodes, elements) = (path.with_extension("node"), path.with_extension("ele"));
    let parsed = tetgen::parse_nodes(&read_bytes(&nodes)?);
    let parsed = parsed.map_err(|error| in_file(&nodes, error))?;
    tetgen::parse_elements(&read_bytes(&elements)?, parsed)
        .map_err(|error| in_file(&elements, error))
}

/// A file's bytes, without a byte order mark; not empty.
fn read_bytes(path: &Path) -> Result<Vec<u8>, ReadError> {
    let mut bytes =
        fs::read(path).map_err(|error| in_file(path, ParseError::whole(error.into())))?;
    if bytes.starts_with(b"\xef\xbb\xbf") {
        bytes.drain(..3);
    }
    if bytes.trim_ascii().is_empty() {
        return Err(in_file(path, ParseError::whole(ErrorKind::Empty)));
    }
    Ok(bytes)
}

fn in_file(path: &Path, error: ParseError) -> ReadError {
    let file = path.to_path_buf();
    ReadError { file, error }
}
