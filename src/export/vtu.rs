//! `cells.vtu`: cells as VTK polyhedra, for ParaView and every other reader of VTK files.
//!
//! An `UnstructuredGrid` of the XML format, version 1.0: cells of type `VTK_POLYHEDRON` with the
//! classic `faces` and `faceoffsets` arrays, or `VTK_POLYGON` for cells of the plane (source: VTK
//! file formats, docs.vtk.org, and `vtkXMLUnstructuredDataReader`). The arrays are appended as raw
//! little-endian binary, so coordinates are exact and the file is as small as it can be
//! without compression: about 2 kB per cell.
//!
//! Cells are added one at a time and need not fit in memory together. The format stores array
//! after array, so each array is collected in its own unnamed scratch file (in memory while it is
//! short); the file is assembled at the end and renamed when complete.
//!
//! Every cell has its own points: neighbors do not share them.

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};

use nalgebra::Point3;
use tempfile::{SpooledTempFile, spooled_tempfile_in};

use crate::export::atomic_write;
use crate::geometry::shell::Shell;

/// A cell with the data written for it.
#[derive(Clone, Debug, PartialEq)]
pub struct CellGeometry {
    /// The index of the cell's site.
    pub site: usize,
    /// The cell's surface; in the plane the cell itself.
    pub shell: Shell,
    /// The energy at the site (L^(D+p)).
    pub energy: f64,
    /// The cell's volume (L^D).
    pub volume: f64,
    /// The share of cell and cube of the same volume that they have in common, 0 to 1.
    pub cubeness: f64,
    /// The number of facets, as counted for the histogram of `measure`.
    pub facet_count: usize,
}

/// The reason why no file of cells is written.
#[derive(Debug, thiserror::Error)]
pub enum VtuError {
    /// The file or its scratch files cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
}

/// A fragment of a cell: the points whose Chebyshev distance from the site lies along one axis and
/// direction.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FragmentGeometry {
    /// Its surface, energy and volume; `cubeness` means nothing and is not written.
    pub(crate) cell: CellGeometry,
    /// Axis and direction.
    pub(crate) sector: FragmentSector,
    /// The Chebyshev distance of every vertex from the site (L).
    pub(crate) distances: Vec<f64>,
}

/// The axis, 0 to 2, and the direction, −1 or 1, along which a fragment's distances lie.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct FragmentSector {
    pub(crate) axis: i64,
    pub(crate) sign: i64,
}

/// Tetrahedra of one fragment on points of their own.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FragmentTets {
    pub(crate) site: usize,
    pub(crate) sector: FragmentSector,
    pub(crate) points: Vec<Point3<f64>>,
    /// The Chebyshev distance of every point from the site (L).
    pub(crate) distances: Vec<f64>,
    pub(crate) tets: Vec<[u32; 4]>,
    /// The volume of every tetrahedron (L³).
    pub(crate) volumes: Vec<f64>,
}

/// Writes all `cells` to `path` and returns how many they were.
///
/// # Errors
/// [`VtuError`] naming the file, which is then as it was before.
pub fn write_cells(
    path: &Path,
    cells: impl IntoIterator<Item = CellGeometry>,
) -> Result<u64, VtuError> {
    let mut writer = VtuWriter::new(path);
    for cell in cells {
        writer.push(&cell)?;
    }
    writer.finish()
}

/// A file of cells under construction; dropped before [`VtuWriter::finish`] it leaves nothing behind.
#[derive(Debug)]
pub struct VtuWriter {
    path: PathBuf,
    cells: u64,
    points: u64,
    arrays: Arrays,
}

impl VtuWriter {
    /// Begins the file that will be called `path`.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        Self {
            path: path.to_owned(),
            cells: 0,
            points: 0,
            arrays: Arrays::new(folder),
        }
    }

    /// Adds a cell.
    ///
    /// # Errors
    /// [`VtuError`] when a scratch file cannot be written.
    pub fn push(&mut self, cell: &CellGeometry) -> Result<(), VtuError> {
        let first = self.points;
        self.points += cell.shell.vertices().len() as u64;
        self.cells += 1;
        let pushed = self.arrays.push(cell, first);
        pushed.map_err(|source| self.refuse(source))
    }

    /// Adds a fragment. A file holds cells, fragments or tetrahedra, not several of them.
    ///
    /// # Errors
    /// As [`VtuWriter::push`].
    pub(crate) fn push_fragment(&mut self, fragment: &FragmentGeometry) -> Result<(), VtuError> {
        self.push(&fragment.cell)?;
        let pushed = self.arrays.push_sector(fragment.sector);
        let pushed = pushed.and_then(|()| self.arrays.push_distances(&fragment.distances));
        pushed.map_err(|source| self.refuse(source))
    }

    /// Adds tetrahedra.
    ///
    /// # Errors
    /// As [`VtuWriter::push`].
    pub(crate) fn push_tets(&mut self, part: &FragmentTets) -> Result<(), VtuError> {
        let first = self.points;
        self.points += part.points.len() as u64;
        self.cells += part.tets.len() as u64;
        let pushed = self.arrays.push_tets(part, first);
        pushed.map_err(|source| self.refuse(source))
    }

    /// Puts the file together, gives it its name and returns the number of cells.
    ///
    /// # Errors
    /// [`VtuError`] naming the file, which is then as it was before.
    pub fn finish(mut self) -> Result<u64, VtuError> {
        let (cells, points) = (self.cells, self.points);
        let arrays = &mut self.arrays;
        atomic_write::write(&self.path, |file| assemble(file, cells, points, arrays))
            .map_err(|source| self.refuse(source))?;
        Ok(cells)
    }

    fn refuse(&self, source: io::Error) -> VtuError {
        VtuError::Write {
            path: self.path.clone(),
            source,
        }
    }
}

/// VTK's numbers for kinds of cells (vtkCellType.h).
const EMPTY_CELL: u8 = 0;
const POLYGON: u8 = 7;
const TETRAHEDRON: u8 = 10;
const POLYHEDRON: u8 = 42;

/// `faceoffsets` of a cell that is no polyhedron.
const NO_FACES: i64 = -1;

/// The elements of a piece that hold arrays.
const POINTS: &str = "Points";
const CELLS: &str = "Cells";
const POINT_DATA: &str = "PointData";
const CELL_DATA: &str = "CellData";

/// The arrays of the file.
#[derive(Debug)]
struct Arrays {
    points: Spool,
    connectivity: Spool,
    offsets: Spool,
    types: Spool,
    faces: Spool,
    face_offsets: Spool,
    site: Spool,
    energy: Spool,
    volume: Spool,
    cubeness: Spool,
    facets: Spool,
    axis: Spool,
    sign: Spool,
    distance: Spool,
}

impl Arrays {
    fn new(folder: &Path) -> Self {
        let spool = || Spool::new(folder);
        Self {
            points: spool(),
            connectivity: spool(),
            offsets: spool(),
            types: spool(),
            faces: spool(),
            face_offsets: spool(),
            site: spool(),
            energy: spool(),
            volume: spool(),
            cubeness: spool(),
            facets: spool(),
            axis: spool(),
            sign: spool(),
            distance: spool(),
        }
    }

    /// Adds a cell whose first point has number `first`.
    fn push(&mut self, cell: &CellGeometry, first: u64) -> io::Result<()> {
        for vertex in cell.shell.vertices() {
            for coordinate in vertex.iter() {
                self.points.real(*coordinate)?;
            }
        }
        match cell.shell.facet_count() {
            0 => self.types.byte(EMPTY_CELL)?,
            1 => self.push_polygon(&cell.shell, first)?,
            _ => self.push_polyhedron(&cell.shell, first)?,
        }
        self.offsets
            .integer((self.connectivity.bytes() / 8) as i64)?;
        if cell.shell.facet_count() < 2 {
            self.face_offsets.integer(NO_FACES)?;
        }
        self.site.integer(cell.site as i64)?;
        self.energy.real(cell.energy)?;
        self.volume.real(cell.volume)?;
        self.cubeness.real(cell.cubeness)?;
        self.facets.integer(cell.facet_count as i64)
    }

    fn push_sector(&mut self, sector: FragmentSector) -> io::Result<()> {
        self.axis.integer(sector.axis)?;
        self.sign.integer(sector.sign)
    }

    fn push_distances(&mut self, distances: &[f64]) -> io::Result<()> {
        let mut distances = distances.iter();
        distances.try_for_each(|distance| self.distance.real(*distance))
    }

    /// Adds tetrahedra whose first point has number `first`.
    fn push_tets(&mut self, part: &FragmentTets, first: u64) -> io::Result<()> {
        for coordinate in part.points.iter().flat_map(|point| point.iter()) {
            self.points.real(*coordinate)?;
        }
        self.push_distances(&part.distances)?;
        for (tet, volume) in part.tets.iter().zip(&part.volumes) {
            for corner in tet {
                self.connectivity
                    .integer((first + u64::from(*corner)) as i64)?;
            }
            self.offsets
                .integer((self.connectivity.bytes() / 8) as i64)?;
            self.types.byte(TETRAHEDRON)?;
            self.site.integer(part.site as i64)?;
            self.volume.real(*volume)?;
            self.push_sector(part.sector)?;
        }
        Ok(())
    }

    fn push_polygon(&mut self, shell: &Shell, first: u64) -> io::Result<()> {
        for corner in shell.facets().flatten() {
            self.connectivity
                .integer((first + u64::from(*corner)) as i64)?;
        }
        self.types.byte(POLYGON)
    }

    /// A polyhedron's connectivity is the list of its points; its faces are a stream
    /// `count, (corners, corner, corner, …), (corners, …), …`.
    fn push_polyhedron(&mut self, shell: &Shell, first: u64) -> io::Result<()> {
        for number in 0..shell.vertices().len() as u64 {
            self.connectivity.integer((first + number) as i64)?;
        }
        self.faces.integer(shell.facet_count() as i64)?;
        for facet in shell.facets() {
            self.faces.integer(facet.len() as i64)?;
            for corner in facet {
                self.faces.integer((first + u64::from(*corner)) as i64)?;
            }
        }
        self.face_offsets.integer((self.faces.bytes() / 8) as i64)?;
        self.types.byte(POLYHEDRON)
    }

    /// The arrays in file order, each with its section, type and name. Without a polyhedron there
    /// are no `faces`.
    fn in_order(&mut self) -> Vec<(&'static str, &'static str, &'static str, &mut Spool)> {
        let mut all = vec![
            (POINTS, "Float64", "Points", &mut self.points),
            (CELLS, "Int64", "connectivity", &mut self.connectivity),
            (CELLS, "Int64", "offsets", &mut self.offsets),
            (CELLS, "UInt8", "types", &mut self.types),
        ];
        if self.faces.bytes() > 0 {
            all.push((CELLS, "Int64", "faces", &mut self.faces));
            all.push((CELLS, "Int64", "faceoffsets", &mut self.face_offsets));
        }
        if self.distance.bytes() > 0 {
            all.push((POINT_DATA, "Float64", "distance", &mut self.distance));
        }
        // Tetrahedra have neither energies nor facets, fragments no cubeness.
        let (are_fragments, are_tets) = (
            self.axis.bytes() > 0,
            self.axis.bytes() > self.facets.bytes(),
        );
        all.push((CELL_DATA, "Int64", "site", &mut self.site));
        if !are_tets {
            all.push((CELL_DATA, "Float64", "energy", &mut self.energy));
        }
        all.push((CELL_DATA, "Float64", "volume", &mut self.volume));
        if are_fragments {
            all.push((CELL_DATA, "Int64", "axis", &mut self.axis));
            all.push((CELL_DATA, "Int64", "sign", &mut self.sign));
        } else {
            all.push((CELL_DATA, "Float64", "cubeness", &mut self.cubeness));
        }
        if !are_tets {
            all.push((CELL_DATA, "Int64", "facets", &mut self.facets));
        }
        all
    }
}

/// Writes the XML head with every array's place, then the arrays, each behind its length.
fn assemble(
    file: &mut BufWriter<File>,
    cells: u64,
    points: u64,
    arrays: &mut Arrays,
) -> io::Result<()> {
    let mut arrays = arrays.in_order();
    let has_energy = arrays.iter().any(|(.., name, _)| *name == "energy");
    writeln!(file, "<?xml version=\"1.0\"?>")?;
    writeln!(
        file,
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<UnstructuredGrid>\n\
         <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">"
    )?;
    let mut offset = 0;
    let mut open: Option<&str> = None;
    for (section, kind, name, spool) in &arrays {
        if open != Some(*section) {
            if let Some(before) = open {
                writeln!(file, "</{}>", before)?;
            }
            let scalars = match *section {
                CELL_DATA if has_energy => " Scalars=\"energy\"",
                POINT_DATA => " Scalars=\"distance\"",
                _ => "",
            };
            writeln!(file, "<{}{scalars}>", section)?;
            open = Some(*section);
        }
        let components = if *section == POINTS { 3 } else { 1 };
        writeln!(
            file,
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" \
             format=\"appended\" offset=\"{offset}\"/>"
        )?;
        offset += size_of::<u64>() as u64 + spool.bytes();
    }
    writeln!(file, "</{}>", CELL_DATA)?;
    write!(
        file,
        "</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_"
    )?;
    for (.., spool) in &mut arrays {
        spool.copy_to(file)?;
    }
    write!(file, "\n</AppendedData>\n</VTKFile>\n")
}

/// An array longer than this (bytes) moves from memory to a nameless scratch file, which the
/// system removes even after a kill.
const IN_MEMORY: usize = 1 << 20;

/// One array, little-endian, of a length that shows at the end.
#[derive(Debug)]
struct Spool {
    file: BufWriter<SpooledTempFile>,
    bytes: u64,
}

impl Spool {
    /// An empty array that may spill to a scratch file in `folder`.
    fn new(folder: &Path) -> Self {
        Self {
            file: BufWriter::new(spooled_tempfile_in(IN_MEMORY, folder)),
            bytes: 0,
        }
    }

    /// The array's length so far.
    fn bytes(&self) -> u64 {
        self.bytes
    }

    fn real(&mut self, value: f64) -> io::Result<()> {
        self.push(&value.to_le_bytes())
    }

    fn integer(&mut self, value: i64) -> io::Result<()> {
        self.push(&value.to_le_bytes())
    }

    fn byte(&mut self, value: u8) -> io::Result<()> {
        self.push(&[value])
    }

    fn push(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.bytes += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    /// Copies the array, behind its length in bytes, to the end of `file`.
    fn copy_to(&mut self, file: &mut impl Write) -> io::Result<()> {
        file.write_all(&self.bytes.to_le_bytes())?;
        self.file.rewind()?;
        let copied = io::copy(&mut self.file.get_mut().take(self.bytes), file)?;
        if copied == self.bytes {
            Ok(())
        } else {
            Err(io::ErrorKind::UnexpectedEof.into())
        }
    }
}
