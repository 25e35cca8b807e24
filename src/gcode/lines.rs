//! Lines of a G-code file, one at a time: any line ends, and no byte lost.

use std::io::{ErrorKind, Read};

use crate::gcode::error::{Fault, GcodeError};

/// Bytes read at once.
const CHUNK: usize = 1 << 18;

/// A line is at most so long: slicers write whole macros and lists of objects into one comment.
const LONGEST: usize = 1 << 24;

/// The mark of UTF-8 with which some editors begin a file.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// One line: `mark`, `text` and `end` one after the other are its bytes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Line<'a> {
    /// From 1.
    pub(crate) number: u64,
    /// That of UTF-8, before the first line of some files.
    pub(crate) mark: &'a [u8],
    /// Without its end.
    pub(crate) text: &'a [u8],
    /// LF, CR LF or CR; empty where the file ends without.
    pub(crate) end: &'a [u8],
}

impl Line<'_> {
    /// `fault` in this line.
    pub(crate) fn refuse(&self, fault: Fault) -> GcodeError {
        GcodeError::Line {
            line: self.number,
            fault,
        }
    }
}

/// Reads lines through one buffer.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    source: R,
    buffer: Vec<u8>,
    /// Where the next line begins.
    start: usize,
    /// How much of the buffer has been filled.
    filled: usize,
    exhausted: bool,
    /// Of the last line.
    number: u64,
}

impl<R: Read> Lines<R> {
    pub(crate) fn new(source: R) -> Self {
        Self {
            source,
            buffer: vec![0; CHUNK],
            start: 0,
            filled: 0,
            exhausted: false,
            number: 0,
        }
    }

    /// The number of lines read.
    pub(crate) fn count(&self) -> u64 {
        self.number
    }

    /// The next line, `None` at the file's end.
    pub(crate) fn next(&mut self) -> Result<Option<Line<'_>>, GcodeError> {
        let mut seen = 0;
        let (length, end) = loop {
            let rest = &self.buffer[self.start..self.filled];
            match line_end(&rest[seen..]).map(|at| seen + at) {
                Some(at) if rest[at] == 0 => return Err(self.refuse_next(Fault::Nul)),
                Some(at) if rest[at] == b'\n' => break (at, 1),
                Some(at) if at + 1 < rest.len() => {
                    break (at, 1 + usize::from(rest[at + 1] == b'\n'));
                }
                Some(at) if self.exhausted => break (at, 1),
                None if self.exhausted && rest.is_empty() => return Ok(None),
                None if self.exhausted => break (rest.len(), 0),
                found => {
                    seen = found.unwrap_or(rest.len());
                    self.fill()?;
                }
            }
        };
        let (from, to) = (self.start, self.start + length);
        self.start = to + end;
        self.number += 1;
        let text = &self.buffer[from..to];
        let is_marked = self.number == 1 && text.starts_with(MARK);
        let (mark, text) = text.split_at(if is_marked { MARK.len() } else { 0 });
        Ok(Some(Line {
            number: self.number,
            mark,
            text,
            end: &self.buffer[to..to + end],
        }))
    }

    /// Reads more behind the line that has begun, which moves to the buffer's front.
    fn fill(&mut self) -> Result<(), GcodeError> {
        self.buffer.copy_within(self.start..self.filled, 0);
        self.filled -= self.start;
        self.start = 0;
        if self.filled > LONGEST {
            return Err(self.refuse_next(Fault::Endless { limit: LONGEST }));
        }
        if self.filled + CHUNK / 2 > self.buffer.len() {
            self.buffer.resize(2 * self.buffer.len(), 0);
        }
        match self.source.read(&mut self.buffer[self.filled..]) {
            Ok(0) => self.exhausted = true,
            Ok(count) => self.filled += count,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(error.into()),
        }
        Ok(())
    }

    fn refuse_next(&self, fault: Fault) -> GcodeError {
        GcodeError::Line {
            line: self.number + 1,
            fault,
        }
    }
}

/// The place of the first LF, CR or byte 0.
fn line_end(bytes: &[u8]) -> Option<usize> {
    let is_end = |byte: u8| matches!(byte, b'\n' | b'\r' | 0);
    let mut at = 0;
    while let Some(eight) = bytes.get(at..at + 8) {
        let word = u64::from_le_bytes(eight.try_into().ok()?);
        if has_below_14(word)
            && let Some(place) = eight.iter().position(|&byte| is_end(byte))
        {
            return Some(at + place);
        }
        at += 8;
    }
    let place = bytes[at..].iter().position(|&byte| is_end(byte))?;
    Some(at + place)
}

/// Whether one of eight bytes is below 14, as LF, CR and 0 are: subtracting 14 from each borrows
/// into its highest bit, which was not set before.
fn has_below_14(eight: u64) -> bool {
    const ONES: u64 = 0x0101_0101_0101_0101;
    eight.wrapping_sub(14 * ONES) & !eight & (0x80 * ONES) != 0
}
