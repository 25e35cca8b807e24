//! Atomic writing: a file is replaced as a whole or not at all.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes `path` through `content` so that a reader, even after a kill or a crash of the machine, finds
/// the old or the complete new content: the bytes go to a partial file beside it, are synced to
/// the disk, and the file is renamed last.
///
/// # Errors
/// The error of the system; `path` is then unchanged.
pub fn write(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let partial = partial(path);
    let written = write_synced(&partial, content).and_then(|()| fs::rename(&partial, path));
    if written.is_err() {
        // The first error is reported.
        let _ = fs::remove_file(&partial);
    }
    written
}

/// The file that holds the bytes of `path` while it is written: `.NAME.partial` beside it.
#[must_use]
pub fn partial(path: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".partial");
    path.with_file_name(name)
}

fn write_synced(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    content(&mut file)?;
    file.flush()?;
    file.get_ref().sync_data()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_leaves_the_old_file_alone() {
        let folder = tempfile::tempdir().expect("a folder for the test");
        let path = folder.path().join("a.txt");
        write(&path, |file| file.write_all(b"old")).expect("room for three bytes");
        let failure = write(&path, |file| {
            file.write_all(b"new")?;
            Err(io::Error::other("no more room"))
        });
        assert!(failure.is_err());
        assert_eq!(fs::read(&path).expect("the file is there"), b"old");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
        write(&path, |file| file.write_all(b"new")).expect("room for three bytes");
        assert_eq!(fs::read(&path).expect("the file is there"), b"new");
    }
}
