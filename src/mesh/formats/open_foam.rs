//! OpenFOAM's `polyMesh`: points, faces, owner, neighbour and boundary, in ASCII or binary, each
//! plain or compressed by gzip.
//!
//! Source: OpenFOAM v1912, user guide, section 4.1; `UList` and `CompactIOList` for the binary form:
//! a count, `(`, the raw numbers, `)`; faces are two such lists, offsets and corners. The widths of
//! numbers stand in the header's `arch`.

use std::fs;
use std::io::{ErrorKind as SystemError, Read};
use std::path::{Path, PathBuf};

use flate2::read::GzDecoder;
use nalgebra::{Point3, Vector3};

use crate::mesh::formats::error::{ErrorKind, ParseError, ReadError};
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};

/// Reads the mesh of a case, or of a `polyMesh` folder.
///
/// # Errors
/// [`ReadError`] naming the file, the place in it and the mend.
pub(crate) fn load_case(path: &Path) -> Result<PolyMesh, ReadError> {
    let case = path.join("constant/polyMesh");
    let folder = if case.is_dir() { case } else { path.to_owned() };
    let mut mesh = PolyMesh::default();
    in_file(&folder, "points", |file| {
        mesh.points = file.points()?;
        Ok(())
    })?;
    in_file(&folder, "faces", |file| {
        let corners_and_ends = file.faces()?;
        for corners in corners_and_ends {
            mesh.push_corners(corners);
        }
        Ok(())
    })?;
    in_file(&folder, "owner", |file| {
        mesh.owner = file.labels()?;
        Ok(())
    })?;
    in_file(&folder, "neighbour", |file| {
        mesh.neighbor = file.labels()?;
        Ok(())
    })?;
    in_file(&folder, "boundary", |file| {
        mesh.patches = file.patches()?;
        Ok(())
    })?;
    // Older files give a neighbor to every face, -1 where there is none.
    mesh.neighbor.retain(|&cell| cell != u32::MAX);
    let cells = mesh.owner.iter().chain(&mesh.neighbor);
    mesh.cell_count = cells.max().map_or(0, |&last| last as usize + 1);
    Ok(mesh)
}

/// Reads one file of the mesh, plain or compressed.
fn in_file(
    folder: &Path,
    name: &str,
    take: impl FnOnce(&mut FoamFile<'_>) -> Result<(), ParseError>,
) -> Result<(), ReadError> {
    let (file, bytes) = bytes_of(folder, name)?;
    let read = FoamFile::new(&bytes).and_then(|mut content| take(&mut content));
    read.map_err(|error| ReadError { file, error })
}

fn bytes_of(folder: &Path, name: &str) -> Result<(PathBuf, Vec<u8>), ReadError> {
    let plain = folder.join(name);
    let packed = folder.join(format!("{name}.gz"));
    let refuse = |file: &Path| {
        let file = file.to_owned();
        |error| ReadError {
            file,
            error: ParseError::whole(ErrorKind::Unreadable(error)),
        }
    };
    match fs::read(&plain) {
        Err(error) if error.kind() == SystemError::NotFound && packed.exists() => {
            let mut bytes = Vec::new();
            let file = fs::File::open(&packed).map_err(refuse(&packed))?;
            let mut unpacked = GzDecoder::new(file);
            unpacked.read_to_end(&mut bytes).map_err(refuse(&packed))?;
            Ok((packed, bytes))
        }
        read => Ok((plain.clone(), read.map_err(refuse(&plain))?)),
    }
}

/// The name of the patch one period away, and the way there (L).
type NamedPartner = (String, Vector3<f64>);

/// A file after its header.
struct FoamFile<'a> {
    bytes: &'a [u8],
    position: usize,
    is_binary: bool,
    /// Bytes of a label and of a scalar.
    widths: [usize; 2],
}

impl<'a> FoamFile<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, ParseError> {
        let mut file = Self {
            bytes,
            position: 0,
            is_binary: false,
            widths: [4, 8],
        };
        let start = file.position;
        if file.word("`FoamFile`")? == b"FoamFile" {
            file.header()?;
        } else {
            file.position = start;
        }
        Ok(file)
    }

    fn header(&mut self) -> Result<(), ParseError> {
        self.expect(b"{")?;
        loop {
            let key = self.word("an entry of the header")?;
            if key == b"}" {
                return Ok(());
            }
            let value = self.entry()?;
            match key {
                b"format" => self.is_binary = value == b"binary",
                b"arch" => self.read_widths(value),
                _ => {}
            }
        }
    }

    /// `"LSB;label=32;scalar=64"`.
    fn read_widths(&mut self, arch: &[u8]) {
        let text = String::from_utf8_lossy(arch);
        for (place, name) in ["label=", "scalar="].into_iter().enumerate() {
            let after = text.split(name).nth(1).unwrap_or_default();
            if after.starts_with("64") {
                self.widths[place] = 8;
            } else if after.starts_with("32") {
                self.widths[place] = 4;
            }
        }
    }

    /// The bytes up to the next semicolon outside quotes, without blanks around them.
    fn entry(&mut self) -> Result<&'a [u8], ParseError> {
        let start = self.position;
        let mut is_quoted = false;
        while let Some(&byte) = self.bytes.get(self.position) {
            self.position += 1;
            is_quoted ^= byte == b'"';
            if byte == b';' && !is_quoted {
                return Ok(self.bytes[start..self.position - 1].trim_ascii());
            }
        }
        Err(self.truncated("`;`"))
    }

    fn points(&mut self) -> Result<Vec<Point3<f64>>, ParseError> {
        let count = self.count()?;
        self.expect(b"(")?;
        let mut points = Vec::with_capacity(self.capacity(count));
        for _ in 0..count {
            if self.is_binary {
                points.push(Point3::new(
                    self.raw_real()?,
                    self.raw_real()?,
                    self.raw_real()?,
                ));
            } else {
                points.push(Point3::from(self.triple()?));
            }
        }
        self.expect(b")")?;
        Ok(points)
    }

    fn triple(&mut self) -> Result<Vector3<f64>, ParseError> {
        self.expect(b"(")?;
        let triple = Vector3::new(self.real()?, self.real()?, self.real()?);
        self.expect(b")")?;
        Ok(triple)
    }

    fn faces(&mut self) -> Result<Vec<Vec<u32>>, ParseError> {
        if self.is_binary {
            let (offsets, corners) = (self.labels()?, self.labels()?);
            let face = |pair: &[u32]| {
                let corners = corners.get(pair[0] as usize..pair[1] as usize);
                corners.map(<[u32]>::to_vec)
            };
            let faces: Option<Vec<_>> = offsets.windows(2).map(face).collect();
            return faces.ok_or_else(|| self.truncated("the corners of a face"));
        }
        let count = self.count()?;
        self.expect(b"(")?;
        let mut faces = Vec::with_capacity(self.capacity(count));
        for _ in 0..count {
            faces.push(self.labels()?);
        }
        self.expect(b")")?;
        Ok(faces)
    }

    /// A list of numbers; -1 becomes the greatest.
    fn labels(&mut self) -> Result<Vec<u32>, ParseError> {
        let count = self.count()?;
        self.expect(b"(")?;
        let mut labels = Vec::with_capacity(self.capacity(count));
        for _ in 0..count {
            labels.push(match self.is_binary {
                true => self.raw_label()?,
                false => self.label()?,
            });
        }
        self.expect(b")")?;
        Ok(labels)
    }

    /// The patches; those of a period with their partners.
    fn patches(&mut self) -> Result<Vec<MeshPatch>, ParseError> {
        let count = self.count()?;
        self.expect(b"(")?;
        let (mut patches, mut partners) = (Vec::new(), Vec::new());
        for _ in 0..count {
            let (patch, partner) = self.patch()?;
            patches.push(patch);
            partners.push(partner);
        }
        self.expect(b")")?;
        let names: Vec<String> = patches.iter().map(|patch| patch.name.clone()).collect();
        for (patch, partner) in patches.iter_mut().zip(partners) {
            let Some((name, way)) = partner else { continue };
            let number = names.iter().position(|other| *other == name);
            patch.partner = number.map(|number| (number, way));
        }
        Ok(patches)
    }

    fn patch(&mut self) -> Result<(MeshPatch, Option<NamedPartner>), ParseError> {
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        let name = text(self.word("the name of a patch")?);
        self.expect(b"{")?;
        let (mut counts, mut way, mut partner) = ([0; 2], None, None);
        loop {
            let key = self.word("an entry of a patch")?;
            match key {
                b"}" => break,
                b"nFaces" => counts[0] = self.count()?,
                b"startFace" => counts[1] = self.count()?,
                b"separationVector" => way = Some(self.triple()?),
                b"neighbourPatch" => partner = Some(text(self.word("the name of a patch")?)),
                _ => {}
            }
            self.entry()?;
        }
        let patch = MeshPatch {
            name,
            start: counts[1],
            count: counts[0],
            partner: None,
        };
        Ok((patch, partner.zip(way)))
    }

    fn capacity(&self, announced: usize) -> usize {
        announced.min(self.bytes.len() - self.position)
    }

    fn count(&mut self) -> Result<usize, ParseError> {
        let word = self.word("a count")?;
        let number = std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse().ok());
        number.ok_or_else(|| self.unexpected("a count", word))
    }

    fn label(&mut self) -> Result<u32, ParseError> {
        let word = self.word("a number")?;
        let number = std::str::from_utf8(word).ok().and_then(|text| match text {
            "-1" => Some(u32::MAX),
            _ => text.parse().ok(),
        });
        number.ok_or_else(|| self.unexpected("a number", word))
    }

    fn real(&mut self) -> Result<f64, ParseError> {
        let word = self.word("a coordinate")?;
        let number = std::str::from_utf8(word)
            .ok()
            .and_then(|text| text.parse::<f64>().ok());
        let finite = number.filter(|number| number.is_finite());
        finite.ok_or_else(|| self.unexpected("a finite coordinate", word))
    }

    fn raw<const N: usize>(&mut self) -> Result<[u8; N], ParseError> {
        let raw = self.bytes[self.position..].first_chunk::<N>().copied();
        self.position += N;
        raw.ok_or_else(|| self.truncated("a binary number"))
    }

    fn raw_label(&mut self) -> Result<u32, ParseError> {
        let number = match self.widths[0] {
            8 => i64::from_le_bytes(self.raw()?),
            _ => i64::from(i32::from_le_bytes(self.raw()?)),
        };
        Ok(u32::try_from(number).unwrap_or(u32::MAX))
    }

    fn raw_real(&mut self) -> Result<f64, ParseError> {
        Ok(match self.widths[1] {
            8 => f64::from_le_bytes(self.raw()?),
            _ => f64::from(f32::from_le_bytes(self.raw()?)),
        })
    }

    fn expect(&mut self, wanted: &'static [u8]) -> Result<(), ParseError> {
        let shown = std::str::from_utf8(wanted).unwrap_or_default();
        let word = self.word(shown)?;
        match word == wanted {
            true => Ok(()),
            false => Err(self.unexpected(shown, word)),
        }
    }

    /// The next word: one of ( ) { }, or bytes up to one of these, a semicolon or a blank.
    fn word(&mut self, expected: &'static str) -> Result<&'a [u8], ParseError> {
        self.skip_blanks();
        let rest = self.bytes.get(self.position..).unwrap_or_default();
        let is_mark = |byte: &u8| b"(){}".contains(byte);
        let ends = |byte: &u8| is_mark(byte) || *byte == b';' || byte.is_ascii_whitespace();
        let length = match rest.first() {
            None => return Err(self.truncated(expected)),
            Some(first) if is_mark(first) => 1,
            Some(_) => rest.iter().position(ends).unwrap_or(rest.len()).max(1),
        };
        self.position += length;
        Ok(&rest[..length])
    }

    /// Skips white space and comments.
    fn skip_blanks(&mut self) {
        loop {
            let rest = self.bytes.get(self.position..).unwrap_or_default();
            let blanks = rest
                .iter()
                .take_while(|byte| byte.is_ascii_whitespace())
                .count();
            let rest = &rest[blanks..];
            self.position += blanks;
            let (end, extra): (&[u8], usize) = match rest {
                [b'/', b'/', ..] => (b"\n", 1),
                [b'/', b'*', ..] => (b"*/", 2),
                _ => return,
            };
            let length = rest.windows(end.len()).position(|window| window == end);
            self.position += length.map_or(rest.len(), |length| length + extra);
        }
    }

    fn line(&self) -> usize {
        let before = &self.bytes[..self.position.min(self.bytes.len())];
        1 + before.iter().filter(|&&byte| byte == b'\n').count()
    }

    fn truncated(&self, expected: &'static str) -> ParseError {
        ParseError::on_line(self.line(), ErrorKind::Truncated { expected })
    }

    fn unexpected(&self, expected: &'static str, found: &[u8]) -> ParseError {
        let found = String::from_utf8_lossy(&found[..found.len().min(40)]).into_owned();
        ParseError::on_line(self.line(), ErrorKind::Expected { expected, found })
    }
}
