//! Words and numbers of a text file, with line numbers.
//!
//! Words are separated by blanks; an optional comment mark hides the rest of its line. A line
//! ends with LF, CR LF or CR, in every file that is read. No word is copied: a file of two million
//! triangles is read in a fraction of a second.

use nalgebra::Point3;

use crate::mesh::formats::error::{ErrorKind, ParseError};

/// Words longer than this are shortened in messages.
const SHOWN: usize = 40;

/// A cursor over the words of a text.
#[derive(Clone, Debug)]
pub(crate) struct Words<'a> {
    bytes: &'a [u8],
    position: usize,
    line: usize,
    comment: Option<u8>,
}

impl<'a> Words<'a> {
    /// A cursor at the start of `bytes`; `comment` starts a comment anywhere on a line.
    pub(crate) fn new(bytes: &'a [u8], comment: Option<u8>) -> Self {
        Self {
            bytes,
            position: 0,
            line: 1,
            comment,
        }
    }

    /// The same cursor, its first line called `line`.
    pub(crate) fn on_line(self, line: usize) -> Self {
        Self { line, ..self }
    }

    /// The one-based line of the cursor.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The cursor's byte offset.
    pub(crate) fn position(&self) -> usize {
        self.position
    }

    /// Whether all bytes are read.
    pub(crate) fn is_at_end(&self) -> bool {
        self.position == self.bytes.len()
    }

    /// The next bytes, whatever they are; `None` if there are fewer. Lines are not counted in them.
    pub(crate) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let taken = self.bytes[self.position..].get(..count)?;
        self.position += count;
        Some(taken)
    }

    /// Moves behind the next occurrence of `pattern`, in any case; false if there is none.
    pub(crate) fn skip_past(&mut self, pattern: &[u8]) -> bool {
        let mut windows = self.bytes[self.position..].windows(pattern.len());
        let found = windows.position(|window| window.eq_ignore_ascii_case(pattern));
        if let Some(start) = found {
            self.position += start + pattern.len();
        }
        found.is_some()
    }

    /// How many elements of at least `width` bytes the rest can hold: a bound for the
    /// memory reserved for an announced count.
    pub(crate) fn capacity_for(&self, announced: usize, width: usize) -> usize {
        announced.min((self.bytes.len() - self.position) / width + 1)
    }

    /// The next word on this line.
    pub(crate) fn word_on_line(&mut self) -> Option<&'a [u8]> {
        let rest = &self.bytes[self.position..];
        let start = rest.iter().position(|&byte| !is_blank(byte))?;
        self.position += start;
        let rest = &rest[start..];
        if is_line_end(rest[0]) || Some(rest[0]) == self.comment {
            return None;
        }
        let comment = self.comment;
        let ends = |&byte: &u8| byte.is_ascii_whitespace() || Some(byte) == comment;
        let length = rest.iter().position(ends).unwrap_or(rest.len());
        self.position += length;
        Some(&rest[..length])
    }

    /// The next word on this or a later line.
    pub(crate) fn word(&mut self) -> Option<&'a [u8]> {
        loop {
            if let Some(word) = self.word_on_line() {
                return Some(word);
            }
            if !self.next_line() {
                return None;
            }
        }
    }

    /// The next word without taking it.
    pub(crate) fn peek(&self) -> Option<&'a [u8]> {
        self.clone().word()
    }

    /// The rest of this line, blanks trimmed, comments included; the cursor moves on to the
    /// next line.
    pub(crate) fn rest_of_line(&mut self) -> &'a [u8] {
        let start = self.position;
        self.next_line();
        self.bytes[start..self.position].trim_ascii()
    }

    /// Moves to the start of the next line; false when there is none.
    pub(crate) fn next_line(&mut self) -> bool {
        let rest = &self.bytes[self.position..];
        let (end, next) = line_end(rest);
        self.position += next;
        self.line += usize::from(next > end);
        next > end
    }

    /// The next word, which must be there.
    pub(crate) fn some_word(&mut self, expected: &'static str) -> Result<&'a [u8], ParseError> {
        self.word().ok_or_else(|| self.truncated(expected))
    }

    /// The next word on this line, which must be there.
    pub(crate) fn some_word_on_line(
        &mut self,
        expected: &'static str,
    ) -> Result<&'a [u8], ParseError> {
        self.word_on_line().ok_or_else(|| self.line_ended(expected))
    }

    /// The error of the line, or the text, ending before `expected`.
    pub(crate) fn line_ended(&self, expected: &'static str) -> ParseError {
        if self.position == self.bytes.len() {
            return self.truncated(expected);
        }
        self.unexpected(expected, b"end of line")
    }

    /// A non-negative integer, on this or a later line.
    pub(crate) fn count(&mut self, expected: &'static str) -> Result<usize, ParseError> {
        let word = self.some_word(expected)?;
        self.parse_count(word, expected)
    }

    /// A non-negative integer on this line.
    pub(crate) fn count_on_line(&mut self, expected: &'static str) -> Result<usize, ParseError> {
        let word = self.some_word_on_line(expected)?;
        self.parse_count(word, expected)
    }

    /// An integer, on this or a later line.
    pub(crate) fn integer(&mut self, expected: &'static str) -> Result<i64, ParseError> {
        let word = self.some_word(expected)?;
        integer(word).ok_or_else(|| self.unexpected(expected, word))
    }

    /// A finite number, on this or a later line.
    pub(crate) fn number(&mut self, expected: &'static str) -> Result<f64, ParseError> {
        let word = self.some_word(expected)?;
        self.parse_number(word, expected)
    }

    /// A finite number on this line.
    pub(crate) fn number_on_line(&mut self, expected: &'static str) -> Result<f64, ParseError> {
        let word = self.some_word_on_line(expected)?;
        self.parse_number(word, expected)
    }

    /// The zero-based index of a vertex numbered from `first`, on this or a later line.
    pub(crate) fn vertex(&mut self, vertices: usize, first: i64) -> Result<u32, ParseError> {
        let word = self.some_word("a vertex index")?;
        self.parse_vertex(word, vertices, first)
    }

    /// The zero-based index of a vertex numbered from `first`, on this line.
    pub(crate) fn vertex_on_line(
        &mut self,
        vertices: usize,
        first: i64,
    ) -> Result<u32, ParseError> {
        let word = self.some_word_on_line("a vertex index")?;
        self.parse_vertex(word, vertices, first)
    }

    /// `word` as a finite number.
    pub(crate) fn parse_number(
        &self,
        word: &[u8],
        expected: &'static str,
    ) -> Result<f64, ParseError> {
        let text = std::str::from_utf8(word).ok();
        let Some(number) = text.and_then(|text| text.parse::<f64>().ok()) else {
            return Err(self.unexpected(expected, word));
        };
        if number.is_finite() {
            return Ok(number);
        }
        let found = shown(word);
        Err(self.error(ErrorKind::NotFinite { found }))
    }

    /// A number on this or a later line that need not be finite, for data that may not be used: NaN
    /// also for what C and Fortran print for such, as `-nan(ind)`, `1.#QNAN` or `Infinity`.
    pub(crate) fn value(&mut self) -> Result<f64, ParseError> {
        let word = self.some_word("a value")?;
        self.parse_value(word)
    }

    /// [`Words::value`] on this line.
    pub(crate) fn value_on_line(&mut self) -> Result<f64, ParseError> {
        let word = self.some_word_on_line("a value")?;
        self.parse_value(word)
    }

    /// `word` as a number that need not be finite.
    pub(crate) fn parse_value(&self, word: &[u8]) -> Result<f64, ParseError> {
        let text = std::str::from_utf8(word).unwrap_or_default();
        let unsigned = text.trim_start_matches(['+', '-']).to_ascii_lowercase();
        let number = text.parse::<f64>().ok();
        let is_none = || (["nan", "inf", "1.#"].iter()).any(|none| unsigned.starts_with(none));
        number
            .or_else(|| is_none().then_some(f64::NAN))
            .ok_or_else(|| self.unexpected("a value", word))
    }

    /// Three coordinates, on this or later lines.
    pub(crate) fn point(&mut self) -> Result<Point3<f64>, ParseError> {
        let mut coordinate = || self.number("a coordinate");
        Ok(Point3::new(coordinate()?, coordinate()?, coordinate()?))
    }

    /// Three coordinates, on one line.
    pub(crate) fn point_on_line(&mut self) -> Result<Point3<f64>, ParseError> {
        let x = self.number("a coordinate")?;
        let mut coordinate = || self.number_on_line("a coordinate");
        Ok(Point3::new(x, coordinate()?, coordinate()?))
    }

    /// The announced number of `what`, which must not be more than can be indexed.
    pub(crate) fn size(
        &mut self,
        expected: &'static str,
        what: &'static str,
    ) -> Result<usize, ParseError> {
        let count = self.count(expected)?;
        self.check_limit(what, count)
    }

    /// Refuses more elements than can be indexed.
    pub(crate) fn check_limit(
        &self,
        what: &'static str,
        count: usize,
    ) -> Result<usize, ParseError> {
        ErrorKind::check_limit(what, count).map_err(|kind| self.error(kind))
    }

    /// Refuses another count than the announced one.
    pub(crate) fn check_count(
        &self,
        what: &'static str,
        announced: usize,
        found: usize,
    ) -> Result<(), ParseError> {
        ErrorKind::check_count(what, announced, found).map_err(|kind| self.error(kind))
    }

    /// A dialect that is not read, at the cursor.
    pub(crate) fn unsupported(&self, what: impl Into<String>, mend: &'static str) -> ParseError {
        self.error(ErrorKind::unsupported(what, mend))
    }

    /// `kind` on the cursor's line.
    pub(crate) fn error(&self, kind: ErrorKind) -> ParseError {
        ParseError::on_line(self.line, kind)
    }

    /// The error of `found` in place of `expected`.
    pub(crate) fn unexpected(&self, expected: &'static str, found: &[u8]) -> ParseError {
        self.error(ErrorKind::expected(expected, shown(found)))
    }

    /// The error of the text ending before `expected`.
    pub(crate) fn truncated(&self, expected: &'static str) -> ParseError {
        self.error(ErrorKind::Truncated { expected })
    }

    /// `word` as a non-negative integer.
    pub(crate) fn parse_count(
        &self,
        word: &[u8],
        expected: &'static str,
    ) -> Result<usize, ParseError> {
        integer(word)
            .and_then(|value| usize::try_from(value).ok())
            .ok_or_else(|| self.unexpected(expected, word))
    }

    fn parse_vertex(&self, word: &[u8], vertices: usize, first: i64) -> Result<u32, ParseError> {
        let index = integer(word).ok_or_else(|| self.unexpected("a vertex index", word))?;
        ErrorKind::check_vertex(index, vertices, first).map_err(|kind| self.error(kind))
    }
}

/// `word` as a decimal integer.
pub(crate) fn integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() {
        return None;
    }
    let mut value = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value
            .checked_mul(10)?
            .checked_add(i64::from(digit - b'0'))?;
    }
    Some(if negative { -value } else { value })
}

/// `word` as it appears in messages.
pub(crate) fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(&word[..word.len().min(SHOWN)]);
    let mut text = text.escape_debug().to_string();
    if word.len() > SHOWN {
        text.push('…');
    }
    text
}

/// The lines of a text, without their ends.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        if rest.is_empty() {
            return None;
        }
        let (end, next) = line_end(rest.as_bytes());
        let line = &rest[..end];
        rest = &rest[next..];
        Some(line)
    })
}

/// The one-based line of a byte.
pub(crate) fn line_of(bytes: &[u8], position: usize) -> usize {
    let mut words = Words::new(&bytes[..position], None);
    while words.next_line() {}
    words.line()
}

/// Where the first line ends and where the next one starts: both at the end of the text if it has
/// no other line.
fn line_end(text: &[u8]) -> (usize, usize) {
    let Some(end) = text.iter().position(|&byte| is_line_end(byte)) else {
        return (text.len(), text.len());
    };
    let width = match text[end..] {
        [b'\r', b'\n', ..] => 2,
        // Text files that were converted from LF to CR LF twice.
        [b'\r', b'\r', b'\n', ..] => 3,
        _ => 1,
    };
    (end, end + width)
}

fn is_line_end(byte: u8) -> bool {
    byte == b'\n' || byte == b'\r'
}

fn is_blank(byte: u8) -> bool {
    !is_line_end(byte) && byte.is_ascii_whitespace()
}
