//! The bytes of a file or of standard input, unpacked where they are gzip.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

use crate::mesh::formats::error::ErrorKind;

/// The name that stands for standard input.
pub(crate) const STANDARD_INPUT: &str = "-";

/// First bytes of packed files that are not unpacked here, what they are, and the command for it.
const PACKED: [(&[u8], &str, &str); 4] = [
    (b"BZh", "a file packed by bzip2", "unpack it by bunzip2"),
    (b"\xfd7zXZ\0", "a file packed by xz", "unpack it by unxz"),
    (
        b"\x28\xb5\x2f\xfd",
        "a file packed by Zstandard",
        "unpack it by unzstd",
    ),
    (b"7z\xbc\xaf", "a 7z archive", "unpack it by 7z x"),
];

/// Reads `path`, or standard input where it is `-`, and unpacks gzip.
///
/// # Errors
///
/// When it cannot be read or unpacked.
pub(crate) fn read_unpacked(path: &Path) -> Result<Vec<u8>, ErrorKind> {
    if path == Path::new(STANDARD_INPUT) {
        let mut bytes = Vec::new();
        std::io::stdin().lock().read_to_end(&mut bytes)?;
        return unpacked(bytes);
    }
    unpacked(fs::read(path)?)
}

/// `bytes`, unpacked if they are gzip, however often they were packed.
fn unpacked(mut bytes: Vec<u8>) -> Result<Vec<u8>, ErrorKind> {
    while bytes.starts_with(b"\x1f\x8b") {
        let mut plain = Vec::new();
        MultiGzDecoder::new(bytes.as_slice())
            .read_to_end(&mut plain)
            .map_err(|error| ErrorKind::Damaged(error.to_string()))?;
        bytes = plain;
    }
    let packed = PACKED.iter().find(|(start, ..)| bytes.starts_with(start));
    match packed {
        Some(&(_, what, mend)) => Err(ErrorKind::unsupported(what, mend)),
        None => Ok(bytes),
    }
}

/// The path without the extension `.gz`.
pub(crate) fn without_gz(path: &Path) -> PathBuf {
    let extension = path.extension().unwrap_or_default();
    match extension.eq_ignore_ascii_case("gz") {
        true => path.with_extension(""),
        false => path.to_path_buf(),
    }
}

/// The extension in small letters, that of the unpacked file.
pub(crate) fn extension_of(path: &Path) -> String {
    let plain = without_gz(path);
    let extension = plain.extension().unwrap_or_default();
    extension.to_string_lossy().to_ascii_lowercase()
}
