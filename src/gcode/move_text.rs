//! The text of a motion written anew, whole or in pieces: coordinates, arcs, E and F.
//!
//! Coordinates have three decimals and E five, two more in inches, or as many as the line's own; the
//! move's end stays as it is written. Pieces of arcs keep the center, as I and J.

use std::ops::Range;

use nalgebra::Vector2;

use crate::gcode::bead::Path;
use crate::gcode::flow::Stretch;
use crate::gcode::lines::Line;
use crate::gcode::rewrite::{Rewrite, decimals, rounded};
use crate::gcode::words::{Command, Reading, Words};

/// Decimals of coordinates in mm, of E, and how many more there are in inches.
const PLACES: usize = 3;
const PLACES_E: usize = 5;
const MORE_IN_INCHES: usize = 2;

/// A motion's line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MoveText<'a> {
    pub(crate) line: &'a Line<'a>,
    pub(crate) command: Command,
    pub(crate) words: &'a Words,
    pub(crate) before: Reading,
}

/// Words with their places in the line; an empty place is behind all others.
type Edits = Vec<(Range<usize>, String)>;

impl<'a> MoveText<'a> {
    fn number(&self, letter: u8) -> Option<f64> {
        self.words.number(letter).ok().flatten()
    }

    /// The word of `letter`; empty where there is none.
    fn word(&self, letter: u8) -> &'a [u8] {
        if self.words.has(letter) {
            &self.line.text[self.words.place(letter)]
        } else {
            b""
        }
    }

    fn place(&self, letter: u8) -> Range<usize> {
        if self.words.has(letter) {
            self.words.place(letter)
        } else {
            0..0
        }
    }

    /// F and its number's text.
    pub(crate) fn speed(&self) -> Option<(f64, &'a str)> {
        let text = self.word(b'F').get(1..)?.trim_ascii();
        Some((self.number(b'F')?, std::str::from_utf8(text).ok()?))
    }

    fn decimals(&self, letter: u8, usual: usize) -> usize {
        let inches = self.before.unit > 1.0;
        let usual = usual + if inches { MORE_IN_INCHES } else { 0 };
        decimals(self.word(letter)).max(usual)
    }

    /// The number of E for what the register should be (mm, mm³).
    pub(crate) fn e_number(&self, register: f64) -> (f64, String) {
        let decimals = self.decimals(b'E', PLACES_E);
        let (value, text) = rounded(register / self.before.unit_e, decimals);
        (value * self.before.unit_e, text)
    }

    /// The line with E for a register that lies `shift` above the `register` it was read with; `None`
    /// where it says so already.
    pub(crate) fn shifted(&self, register: f64, shift: f64) -> Option<Vec<u8>> {
        if self.before.relative_e || shift.abs() <= 0.0 || !self.words.has(b'E') {
            return None;
        }
        let (value, text) = self.e_number(register + shift);
        let said = self.number(b'E')? * self.before.unit_e;
        if (value - said).abs() <= 1e-12 * said.abs() {
            return None;
        }
        let mut rewrite = Rewrite::new(self.line.text, self.command);
        rewrite.put(self.place(b'E'), format!("E{text}"));
        Some(rewrite.whole())
    }

    /// The line of a piece: words of `targets`, then E, then F where it must be said.
    pub(crate) fn piece(
        &self,
        is_first: bool,
        targets: Edits,
        e: &str,
        speed: Option<f64>,
    ) -> Vec<u8> {
        let mut rewrite = Rewrite::new(self.line.text, self.command);
        for (place, words) in targets {
            rewrite.put(place, words);
        }
        rewrite.put(self.place(b'E'), format!("E{e}"));
        let said = self.number(b'F');
        match speed {
            Some(speed) if !is_first || said != Some(speed) => {
                rewrite.put(self.place(b'F'), format!("F{speed}"));
            }
            None if !is_first && said.is_some() => {
                rewrite.put(self.with_blank(b'F'), String::new())
            }
            _ => {}
        }
        if is_first {
            rewrite.whole()
        } else {
            rewrite.command()
        }
    }

    /// The place of a word with the blank before it.
    fn with_blank(&self, letter: u8) -> Range<usize> {
        let place = self.place(letter);
        let start = place.start.saturating_sub(1);
        if self.line.text.get(start) == Some(&b' ') {
            start..place.end
        } else {
            place
        }
    }

    /// The words of coordinates and arcs for each of a move's stretches.
    pub(crate) fn targets(&self, path: &Path, stretches: &[Stretch]) -> Vec<Edits> {
        if let [_] = stretches {
            return vec![Edits::new()];
        }
        let start: [f64; 3] = (self.before.from.coords / self.before.unit).into();
        let mut at = start;
        let mut targets = Vec::with_capacity(stretches.len());
        for (number, stretch) in stretches.iter().enumerate() {
            let is_last = number + 1 == stretches.len();
            let from = at;
            let mut edits = Edits::new();
            for axis in 0..3 {
                self.target(path, stretch, is_last, axis, (&mut at, &start), &mut edits);
            }
            if let Path::Arc(arc) = path {
                let center = arc.center / self.before.unit;
                self.center(center, Vector2::new(from[0], from[1]), &mut edits);
            }
            targets.push(edits);
        }
        targets
    }

    /// The word of one axis; `at` is where the words so far lead, in the file's unit.
    fn target(
        &self,
        path: &Path,
        stretch: &Stretch,
        is_last: bool,
        axis: usize,
        (at, start): (&mut [f64; 3], &[f64; 3]),
        edits: &mut Edits,
    ) {
        let letter = [b'X', b'Y', b'Z'][axis];
        let said = self.number(letter);
        let is_round = axis < 2 && matches!(path, Path::Arc(_));
        if said.is_none() && !is_round || said.is_some() && is_last && !self.before.relative {
            return;
        }
        let goal = match (is_last, said) {
            (true, Some(offset)) => start[axis] + offset,
            (true, None) => start[axis],
            (false, _) => path.at(stretch.to)[axis] / self.before.unit,
        };
        let origin = if self.before.relative { at[axis] } else { 0.0 };
        let decimals = self.decimals(letter, PLACES);
        let (value, text) = rounded(goal - origin, decimals);
        at[axis] = origin + value;
        edits.push((self.place(letter), format!("{}{text}", letter as char)));
    }

    /// I and J of a piece that begins at `from`, in place of the line's own or of R; no full circles.
    fn center(&self, center: Vector2<f64>, from: Vector2<f64>, edits: &mut Edits) {
        let letters = [b'I', b'J', b'R'];
        let usual = letters.map(|letter| self.decimals(letter, PLACES + 1));
        let decimals = usual.into_iter().max().unwrap_or(PLACES);
        let offset = if self.before.absolute_centers {
            center
        } else {
            center - from
        };
        let [i, j] = [offset.x, offset.y].map(|value| rounded(value, decimals).1);
        let mut words = format!("I{i} J{j}");
        for letter in letters {
            if self.words.has(letter) {
                edits.push((self.place(letter), std::mem::take(&mut words)));
            }
        }
        if self.words.has(b'P') {
            edits.push((self.with_blank(b'P'), String::new()));
        }
    }
}
