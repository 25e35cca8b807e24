//! Arrays that grow element by element and may become too long for memory.

use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::Path;

use tempfile::{SpooledTempFile, spooled_tempfile_in};

/// An array longer than this (bytes) moves from memory to a nameless scratch file, which the
/// system removes even after a kill.
const IN_MEMORY: usize = 1 << 20;

/// One array, little-endian, of a length that shows at the end.
#[derive(Debug)]
pub(crate) struct Spool {
    file: BufWriter<SpooledTempFile>,
    bytes: u64,
}

impl Spool {
    /// An empty array that may spill to a scratch file in `folder`.
    pub(crate) fn new(folder: &Path) -> Self {
        Self {
            file: BufWriter::new(spooled_tempfile_in(IN_MEMORY, folder)),
            bytes: 0,
        }
    }

    /// The array's length so far.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    pub(crate) fn real(&mut self, value: f64) -> io::Result<()> {
        self.push(&value.to_le_bytes())
    }

    pub(crate) fn integer(&mut self, value: i64) -> io::Result<()> {
        self.push(&value.to_le_bytes())
    }

    pub(crate) fn byte(&mut self, value: u8) -> io::Result<()> {
        self.push(&[value])
    }

    fn push(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.bytes += bytes.len() as u64;
        self.file.write_all(bytes)
    }

    /// Copies the array, behind its length in bytes, to the end of `file`.
    pub(crate) fn pour_into(&mut self, file: &mut impl Write) -> io::Result<()> {
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
