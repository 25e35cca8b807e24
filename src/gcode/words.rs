//! One line of G-code: its command, and its words with their places in the line.
//!
//! Words are a letter and a number: sign, digits and one point, no exponent (`X1E5` is X1 and E5).
//! Blanks may stand anywhere between them, or nowhere.

use std::ops::Range;

use nalgebra::Point3;

use crate::gcode::error::Fault;

/// Coordinates and filament beyond this (mm) are mistakes: a kilometer.
pub(crate) const REACH: f64 = 1e6;

/// The largest number of a word; absolute E counts filament of many spools.
const LARGEST: f64 = 1e9;

/// A letter with a number at the beginning of a line, as G92.1 or T0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Command {
    /// `G`, `M` or `T`.
    pub(crate) letter: u8,
    pub(crate) number: u32,
    /// The digit behind the point of G92.1; 0 where there is none.
    pub(crate) fraction: u32,
    /// Where its name begins in the line.
    pub(crate) name: usize,
    /// Where its words begin.
    words: usize,
    /// Where they end: at a checksum, or where the line does.
    end: usize,
}

/// What a line holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Content<'a> {
    /// Nothing.
    Blank,
    /// What follows the semicolon of a line without a command.
    Comment(&'a [u8]),
    /// G, M or T with a number.
    Command(Command),
    /// Anything else, a macro for instance, without its comment.
    Foreign(&'a [u8]),
}

impl Command {
    /// `G92.1`.
    pub(crate) fn title(&self) -> String {
        let (letter, number) = (self.letter as char, self.number);
        match self.fraction {
            0 => format!("{letter}{number}"),
            fraction => format!("{letter}{number}.{fraction}"),
        }
    }

    /// G0 to G3: a motion.
    pub(crate) fn is_motion(&self) -> bool {
        self.letter == b'G' && self.number <= 3 && self.fraction == 0
    }

    /// What follows it, up to a comment.
    pub(crate) fn rest<'a>(&self, text: &'a [u8]) -> &'a [u8] {
        before_comment(&text[self.words..self.end])
    }
}

/// Why the motion of G and this number is unknown, if it is.
pub(crate) fn unknown_motion(number: u32) -> Option<&'static str> {
    match number {
        0..=3 => Some("a motion that only some machines know"),
        5 => Some("a spline, whose points are not weighed; export without it"),
        6 => Some("it moves motors, not coordinates"),
        41 | 42 => Some("it moves the path sideways"),
        51 => Some("it scales coordinates"),
        52 | 53 | 55..=59 => Some("it changes the coordinates' origin"),
        68 => Some("it rotates coordinates"),
        _ => None,
    }
}

/// What the line `text` holds.
pub(crate) fn content(text: &[u8]) -> Result<Content<'_>, Fault> {
    let name = skip_blanks(text, 0);
    match text.get(name) {
        None => Ok(Content::Blank),
        Some(b';') => Ok(Content::Comment(&text[name + 1..])),
        Some(b'N' | b'n') if text.get(name + 1).is_some_and(u8::is_ascii_digit) => {
            numbered(text, name)
        }
        Some(_) => command(text, name, text.len()),
    }
}

/// A line that begins with its number, and ends with a checksum in most files.
fn numbered(text: &[u8], first: usize) -> Result<Content<'_>, Fault> {
    let code = before_comment(text).len();
    let end = match text[..code].iter().rposition(|&byte| byte == b'*') {
        Some(star) => {
            check(text, first, star)?;
            star
        }
        None => text.len(),
    };
    let digits = text[first + 1..end]
        .iter()
        .take_while(|byte| byte.is_ascii_digit());
    let name = skip_blanks(&text[..end], first + 1 + digits.count());
    if name == end || text[name] == b';' {
        return Ok(Content::Blank);
    }
    command(text, name, end)
}

/// Compares the checksum behind `star` with the exclusive or of the bytes from `first` up to it.
fn check(text: &[u8], first: usize, star: usize) -> Result<(), Fault> {
    let computed = text[first..star].iter().fold(0, |sum, byte| sum ^ byte);
    let digits = before_comment(&text[star + 1..]).trim_ascii();
    let written = std::str::from_utf8(digits)
        .ok()
        .and_then(|digits| digits.parse().ok());
    match written {
        Some(written) if written == u64::from(computed) => Ok(()),
        Some(written) => Err(Fault::Checksum { written, computed }),
        None => Err(Fault::NoNumber {
            letter: '*',
            column: star + 1,
        }),
    }
}

/// The command whose name begins at `name`; words end at `end`.
fn command(text: &[u8], name: usize, end: usize) -> Result<Content<'_>, Fault> {
    let foreign = || foreign(&text[..end], name);
    let letter = text[name].to_ascii_uppercase();
    if !matches!(letter, b'G' | b'M' | b'T') {
        return foreign();
    }
    let digits = skip_blanks(&text[..end], name + 1);
    let Some((number, mut at)) = whole(&text[..end], digits) else {
        return if before_comment(&text[digits..end]).is_empty() {
            Err(no_number(letter, name))
        } else {
            foreign()
        };
    };
    let mut fraction = 0;
    if text[..end].get(at) == Some(&b'.') {
        (fraction, at) = whole(&text[..end], at + 1).unwrap_or((0, at + 1));
    }
    if text[..end]
        .get(at)
        .is_some_and(|&byte| byte == b'_' || byte == b'.')
    {
        return foreign();
    }
    Ok(Content::Command(Command {
        letter,
        number,
        fraction,
        name,
        words: at,
        end,
    }))
}

/// A line that is no command passes, unless it is not even text.
fn foreign(text: &[u8], name: usize) -> Result<Content<'_>, Fault> {
    let code = before_comment(text);
    let is_alien = |&byte: &u8| byte.is_ascii_control() && byte != b'\t';
    let alien = code.iter().position(is_alien);
    let begins = code.get(name).copied().unwrap_or(b' ');
    let alien = alien.or_else(|| (!begins.is_ascii()).then_some(name));
    match alien {
        Some(at) => Err(Fault::Byte {
            byte: code[at],
            column: at + 1,
        }),
        None => Ok(Content::Foreign(&code[name.min(code.len())..])),
    }
}

fn no_number(letter: u8, at: usize) -> Fault {
    Fault::NoNumber {
        letter: letter.to_ascii_uppercase() as char,
        column: at + 1,
    }
}

/// How the numbers of the next motion are read: what writing motions anew needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reading {
    /// The nozzle (mm).
    pub(crate) from: Point3<f64>,
    /// Whether X, Y and Z are offsets.
    pub(crate) relative: bool,
    /// Whether E is an offset.
    pub(crate) relative_e: bool,
    /// The register of E (mm, mm³).
    pub(crate) register: f64,
    /// mm of a unit of X, Y, Z, I, J and F.
    pub(crate) unit: f64,
    /// mm or mm³ of a unit of E.
    pub(crate) unit_e: f64,
    /// mm³ that come out for a mm or mm³ of the register.
    pub(crate) rate: f64,
    /// What has been drawn back and not yet pushed again (mm³).
    pub(crate) drawn: f64,
    /// Whether I and J are coordinates.
    pub(crate) absolute_centers: bool,
}

/// The words of one command, kept by letter.
#[derive(Clone, Debug)]
pub(crate) struct Words {
    /// One bit for each letter that is there.
    there: u32,
    /// NaN for a letter alone.
    values: [f64; 26],
    /// The places of letter and number in the line.
    places: [(u32, u32); 26],
}

impl Words {
    pub(crate) fn new() -> Self {
        Self {
            there: 0,
            values: [0.0; 26],
            places: [(0, 0); 26],
        }
    }

    /// Reads the words of `command` in the line `text`. Letters alone are flags; [`Self::number`]
    /// refuses them.
    pub(crate) fn read(&mut self, text: &[u8], command: &Command) -> Result<(), Fault> {
        self.there = 0;
        let (line, text) = (text, &text[..command.end]);
        let mut at = command.words;
        while let Some(&byte) = text.get(at) {
            match byte {
                b' ' | b'\t' => at += 1,
                b';' => break,
                b'(' => at = after_parenthesis(text, at),
                // RepRapFirmware lists values of several tools: `M200 D1.75:2.85`.
                b':' if command.letter == b'M' => {
                    at = decimal(text, at + 1).map_or(at + 1, |(_, end)| end);
                }
                b'*' => {
                    check(line, command.name, at)?;
                    break;
                }
                _ if byte.is_ascii_alphabetic() => at = self.word(text, at)?,
                _ => return Err(unexpected(byte, at)),
            }
        }
        Ok(())
    }

    /// Reads the word at `at` and returns where it ends.
    fn word(&mut self, text: &[u8], at: usize) -> Result<usize, Fault> {
        let letter = text[at].to_ascii_uppercase();
        let slot = usize::from(letter - b'A');
        let digits = skip_blanks(text, at + 1);
        let (value, end) = decimal(text, digits).unwrap_or((f64::NAN, at + 1));
        let name = letter as char;
        if self.there >> slot & 1 == 1 {
            return Err(Fault::Twice {
                letter: name,
                first: self.values[slot],
                second: value,
            });
        }
        if value.abs() > LARGEST {
            return Err(Fault::OutOfReach {
                letter: name,
                value,
                limit: LARGEST,
            });
        }
        self.there |= 1 << slot;
        self.values[slot] = value;
        self.places[slot] = (at as u32, end as u32);
        Ok(end)
    }

    /// Whether `letter` is there, with a number or alone.
    pub(crate) fn has(&self, letter: u8) -> bool {
        self.there >> (letter - b'A') & 1 == 1
    }

    /// The number of `letter`, if it is there.
    pub(crate) fn number(&self, letter: u8) -> Result<Option<f64>, Fault> {
        if !self.has(letter) {
            return Ok(None);
        }
        let value = self.values[usize::from(letter - b'A')];
        if value.is_nan() {
            return Err(no_number(letter, self.place(letter).start));
        }
        Ok(Some(value))
    }

    /// Where `letter` and its number stand in the line.
    pub(crate) fn place(&self, letter: u8) -> Range<usize> {
        let (from, to) = self.places[usize::from(letter - b'A')];
        from as usize..to as usize
    }

    /// The first letter without a number.
    pub(crate) fn lone(&self) -> Option<Fault> {
        let lone = |&letter: &u8| self.has(letter) && self.number(letter).is_err();
        let letter = (b'A'..=b'Z').find(lone)?;
        self.number(letter).err()
    }
}

fn unexpected(byte: u8, at: usize) -> Fault {
    let column = at + 1;
    if byte.is_ascii_graphic() {
        let sign = byte as char;
        Fault::Sign { sign, column }
    } else {
        Fault::Byte { byte, column }
    }
}

fn skip_blanks(text: &[u8], from: usize) -> usize {
    let blank = |byte: &&u8| matches!(byte, b' ' | b'\t');
    from + text[from..].iter().take_while(blank).count()
}

fn after_parenthesis(text: &[u8], open: usize) -> usize {
    let close = text[open..].iter().position(|&byte| byte == b')');
    close.map_or(text.len(), |length| open + length + 1)
}

/// What stands before the semicolon.
pub(crate) fn before_comment(text: &[u8]) -> &[u8] {
    let semicolon = text.iter().position(|&byte| byte == b';');
    text[..semicolon.unwrap_or(text.len())].trim_ascii_end()
}

/// A whole number of at most nine digits, and where it ends.
fn whole(text: &[u8], from: usize) -> Option<(u32, usize)> {
    let digits = text
        .get(from..)?
        .iter()
        .take_while(|byte| byte.is_ascii_digit());
    let end = from + digits.count();
    let number = std::str::from_utf8(&text[from..end]).ok()?.parse().ok()?;
    (end - from <= 9).then_some((number, end))
}

/// The powers of ten that are whole numbers in f64.
const TENS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

/// A decimal number and where it ends. Below 2⁵³ and with up to 22 places its digits and the power
/// of ten are exact, and their quotient is the nearest number (Clinger 1990); others take the
/// library's way.
fn decimal(text: &[u8], from: usize) -> Option<(f64, usize)> {
    let negative = text.get(from) == Some(&b'-');
    let first = from + usize::from(matches!(text.get(from), Some(b'-' | b'+')));
    let (mut digits, mut count, mut point, mut at) = (0_u64, 0_usize, None, first);
    while let Some(&byte) = text.get(at) {
        match byte {
            b'0'..=b'9' => {
                digits = digits.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                count += 1;
            }
            b'.' if point.is_none() => point = Some(count),
            _ => break,
        }
        at += 1;
    }
    if count == 0 {
        return None;
    }
    let places = count - point.unwrap_or(count);
    if count > 15 {
        let number = std::str::from_utf8(&text[from..at]).ok()?.parse().ok()?;
        return Some((number, at));
    }
    let size = digits as f64 / TENS[places];
    Some((if negative { -size } else { size }, at))
}
