//! Compression of a VTU file that this crate has written: its raw appended arrays become blocks packed by
//! zlib, the numbers stay the same.
//!
//! A packed array is preceded by the number of its blocks, the size of a block, the size of the last one
//! if that is partial, and every block's packed size (source: VTK file formats, docs.vtk.org). Blocks
//! are packed in parallel, some at a time: neither file need fit in memory.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use tempfile::tempfile_in;

use crate::export::atomic_write;
use crate::parallel::map_runs;

/// Bytes of a block before it is packed.
const BLOCK: usize = 1 << 18;

/// Blocks that are in memory at a time.
const AT_ONCE: usize = 64;

/// How the head of a file begins its appended data, which follow an underscore.
const APPENDED: &str = "<AppendedData encoding=\"raw\">";

/// Packs the file at `path`, which replaces it when it is complete.
///
/// # Errors
/// The error of the system, or that the file is none that this crate writes; it is then as it was before.
pub(crate) fn compress(path: &Path) -> io::Result<()> {
    let mut source = BufReader::new(File::open(path)?);
    let head = head(&mut source)?;
    let arrays = head
        .iter()
        .filter(|line| line.contains(" offset=\""))
        .count();
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let mut packed = tempfile_in(folder.unwrap_or(Path::new(".")))?;
    let mut offsets = Vec::with_capacity(arrays);
    for _ in 0..arrays {
        offsets.push(packed.stream_position()?);
        pack_array(&mut source, &mut packed)?;
    }
    packed.rewind()?;
    atomic_write::write(path, |file| {
        let mut offsets = offsets.iter();
        for line in &head {
            file.write_all(packed_line(line, &mut offsets).as_bytes())?;
        }
        file.write_all(b"_")?;
        io::copy(&mut packed, file)?;
        write!(file, "\n</AppendedData>\n</VTKFile>\n")
    })
}

/// The lines up to the appended data, whose underscore is passed over.
fn head(source: &mut impl BufRead) -> io::Result<Vec<String>> {
    let mut lines = Vec::new();
    loop {
        let mut line = String::new();
        if source.read_line(&mut line)? == 0 {
            return Err(io::ErrorKind::InvalidData.into());
        }
        let is_last = line.starts_with(APPENDED);
        lines.push(line);
        if is_last {
            let mut underscore = [0];
            source.read_exact(&mut underscore)?;
            return Ok(lines);
        }
    }
}

/// A line of the head with the compressor or the new offset of its array.
fn packed_line<'a>(line: &str, offsets: &mut impl Iterator<Item = &'a u64>) -> String {
    const NAME: &str = " compressor=\"vtkZLibDataCompressor\"";
    if let Some(inside) = line.strip_prefix("<VTKFile") {
        return format!("<VTKFile{NAME}{inside}");
    }
    const KEY: &str = " offset=\"";
    let parts = line.split_once(KEY);
    let parts = parts.and_then(|(before, after)| Some((before, after.split_once('"')?.1)));
    let Some((before, after)) = parts else {
        return line.to_owned();
    };
    let offset = offsets.next().copied().unwrap_or_default();
    format!("{before}{KEY}{offset}\"{after}")
}

/// Packs the array at the place of `source` to the end of `target`.
fn pack_array(source: &mut impl Read, target: &mut File) -> io::Result<()> {
    let mut length = [0; 8];
    source.read_exact(&mut length)?;
    let length = u64::from_le_bytes(length);
    let blocks = length.div_ceil(BLOCK as u64);
    let start = target.stream_position()?;
    let mut header = vec![blocks, BLOCK as u64, length % BLOCK as u64];
    header.resize(header.len() + blocks as usize, 0);
    // Its place; the sizes are known later.
    target.write_all(&bytes_of(&header))?;
    let mut rest = source.take(length);
    let mut done = 3;
    while done < header.len() {
        let count = AT_ONCE.min(header.len() - done);
        let mut raw = Vec::new();
        (&mut rest)
            .take((count * BLOCK) as u64)
            .read_to_end(&mut raw)?;
        let packed = map_runs(raw.len(), BLOCK, |run| deflated(&raw[run]));
        let packed = packed.into_iter().collect::<io::Result<Vec<_>>>()?;
        if packed.len() != count {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        for block in packed {
            target.write_all(&block)?;
            header[done] = block.len() as u64;
            done += 1;
        }
    }
    let end = target.stream_position()?;
    target.seek(io::SeekFrom::Start(start))?;
    target.write_all(&bytes_of(&header))?;
    target.seek(io::SeekFrom::Start(end)).map(drop)
}

fn bytes_of(numbers: &[u64]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

fn deflated(block: &[u8]) -> io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(block)?;
    encoder.finish()
}
