//! Files in a ZIP archive, stored or deflated, found by the central directory.
//!
//! Format: APPNOTE.TXT, PKWARE, sections 4.3.7 (local header), 4.3.12 (central directory), 4.3.14-16
//! (its end) and 4.5.3 (64-bit sizes). Names are unique in what is read here; checksums are compared.

use std::io::Read;

use flate2::Crc;
use flate2::read::DeflateDecoder;

use crate::mesh::formats::binary::Scalar;
use crate::mesh::formats::error::ErrorKind;

/// The end of a central directory without remark is so long (bytes).
const END: usize = 22;

/// A remark is at most so long (bytes).
const LONGEST_REMARK: usize = 65535;

/// A file in an archive.
#[derive(Clone, Debug)]
struct ZipEntry {
    name: String,
    method: usize,
    crc: u32,
    packed: usize,
    size: usize,
    /// Where its local header starts.
    start: usize,
}

/// An archive by its directory.
#[derive(Debug)]
pub(crate) struct ZipArchive<'a> {
    bytes: &'a [u8],
    entries: Vec<ZipEntry>,
}

impl<'a> ZipArchive<'a> {
    /// Reads the directory.
    pub(crate) fn new(bytes: &'a [u8]) -> Result<Self, ErrorKind> {
        let last = bytes.len().checked_sub(END).ok_or_else(truncated)?;
        let first = last.saturating_sub(LONGEST_REMARK);
        let end = (first..=last).rev();
        let mut end = end.filter(|&at| bytes[at..].starts_with(b"PK\x05\x06"));
        let end = end.next().ok_or_else(truncated)?;
        let mut at = number(bytes, end + 16, 4)?;
        if at == u32::MAX as usize {
            at = wide_directory(bytes, end)?;
        }
        let mut entries = Vec::new();
        while bytes
            .get(at..)
            .is_some_and(|rest| rest.starts_with(b"PK\x01\x02"))
        {
            let (entry, next) = entry(bytes, at)?;
            entries.push(entry);
            at = next;
        }
        Ok(Self { bytes, entries })
    }

    /// The names of all files.
    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
    }

    /// The content of the file of this name, without regard to case and to a leading slash; `None` if
    /// there is none.
    pub(crate) fn file(&self, name: &str) -> Result<Option<Vec<u8>>, ErrorKind> {
        let name = name.trim_start_matches('/');
        let is_named = |entry: &&ZipEntry| entry.name.eq_ignore_ascii_case(name);
        let Some(entry) = self.entries.iter().find(is_named) else {
            return Ok(None);
        };
        let [name_length, extra] =
            [26, 28].map(|at| number(self.bytes, entry.start.saturating_add(at), 2));
        let start = entry.start + 30 + name_length? + extra?;
        let packed = self.bytes.get(start..).and_then(|b| b.get(..entry.packed));
        let packed = packed.ok_or_else(truncated)?;
        let content = entry.unpack(packed)?;
        let mut crc = Crc::new();
        crc.update(&content);
        if content.len() != entry.size || crc.sum() != entry.crc {
            let name = &entry.name;
            let damage = format!("{name} has another length or checksum than announced");
            return Err(ErrorKind::Damaged(damage));
        }
        Ok(Some(content))
    }
}

impl ZipEntry {
    /// The content; no more of it than the directory announces is unpacked.
    fn unpack(&self, packed: &[u8]) -> Result<Vec<u8>, ErrorKind> {
        match self.method {
            0 => Ok(packed.to_vec()),
            8 => {
                let mut content = Vec::new();
                DeflateDecoder::new(packed)
                    .take((self.size as u64).saturating_add(1))
                    .read_to_end(&mut content)
                    .map_err(|error| ErrorKind::Damaged(format!("{}: {error}", self.name)))?;
                Ok(content)
            }
            other => {
                let what = format!("{}, packed by method {other},", self.name);
                let mend = "pack it anew by deflate, as every ZIP program can";
                Err(ErrorKind::unsupported(what, mend))
            }
        }
    }
}

/// The entry at `at` of the central directory, and where the next one starts.
fn entry(bytes: &[u8], at: usize) -> Result<(ZipEntry, usize), ErrorKind> {
    let field = |offset: usize, width| number(bytes, at + offset, width);
    let lengths = [field(28, 2)?, field(30, 2)?, field(32, 2)?];
    let name = at + 46;
    let extra = name + lengths[0];
    let next = extra + lengths[1] + lengths[2];
    let text = bytes.get(name..extra).ok_or_else(truncated)?;
    let mut sizes = [field(24, 4)?, field(20, 4)?, field(42, 4)?];
    let wide = bytes.get(extra..extra + lengths[1]);
    widen(&mut sizes, wide.ok_or_else(truncated)?)?;
    let [size, packed, start] = sizes;
    let entry = ZipEntry {
        name: String::from_utf8_lossy(text).replace('\\', "/"),
        method: field(10, 2)?,
        crc: field(16, 4)? as u32,
        packed,
        size,
        start,
    };
    Ok((entry, next))
}

/// Replaces sizes that do not fit 32 bits by those of the extra field 1, which holds them in order.
fn widen(sizes: &mut [usize; 3], mut extra: &[u8]) -> Result<(), ErrorKind> {
    while extra.len() >= 4 {
        let (kind, length) = (number(extra, 0, 2)?, number(extra, 2, 2)?);
        let content = extra.get(4..4 + length).ok_or_else(truncated)?;
        if kind == 1 {
            let unknown = sizes.iter_mut().filter(|size| **size == u32::MAX as usize);
            for (place, size) in unknown.enumerate() {
                *size = number(content, 8 * place, 8)?;
            }
        }
        extra = &extra[4 + length..];
    }
    Ok(())
}

/// Where the central directory starts, by the 64-bit records before its end.
fn wide_directory(bytes: &[u8], end: usize) -> Result<usize, ErrorKind> {
    let locator = end.checked_sub(20).ok_or_else(truncated)?;
    let record = number(bytes, locator + 8, 8)?;
    number(bytes, record.saturating_add(48), 8)
}

/// A little-endian number of 2, 4 or 8 bytes.
fn number(bytes: &[u8], at: usize, width: usize) -> Result<usize, ErrorKind> {
    let found = bytes.get(at..).and_then(|rest| rest.get(..width));
    let found = found.ok_or_else(truncated)?;
    let kind = match width {
        2 => Scalar::UInt16,
        4 => Scalar::UInt32,
        _ => Scalar::UInt64,
    };
    Ok(kind.decode(found, false) as usize)
}

fn truncated() -> ErrorKind {
    let expected = "the directory of a ZIP archive";
    ErrorKind::Truncated { expected }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_archives_are_refused() {
        for bytes in [&b"PK\x03\x04"[..], &[0; 40], b"PK\x05\x06"] {
            assert!(ZipArchive::new(bytes).is_err());
        }
        // An archive without files.
        let mut empty = b"PK\x05\x06".to_vec();
        empty.resize(END, 0);
        let archive = ZipArchive::new(&empty).unwrap();
        assert_eq!(archive.names().count(), 0);
        assert!(archive.file("a").unwrap().is_none());
    }
}
