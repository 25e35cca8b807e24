//! A G-code file written anew with the flow of its infill modulated, piece by piece.
//!
//! Every bead of infill counts as ⌈length/step⌉ equal pieces, each with the flow's multiplier; neighbors
//! of the same multiplier stay one move. Volumes are right to the rounding of E, which is carried on to
//! the next piece. What is not infill, and infill whose multiplier is 1, stays byte for byte, but for
//! absolute E behind the first change and for what comments say about the whole print.

use std::collections::HashMap;
use std::io::{Read, Seek, Write};

use nalgebra::Point3;
use thiserror::Error;

use crate::gcode::bead::Path;
use crate::gcode::comments::argument;
use crate::gcode::error::{Fault, GcodeError};
use crate::gcode::flow::{Flow, Piece, Stretch};
use crate::gcode::infill::InfillTypes;
use crate::gcode::labels::is_part;
use crate::gcode::lines::{Line, Lines};
use crate::gcode::move_text::MoveText;
use crate::gcode::pace::{Feed, Pace};
use crate::gcode::reader::{Printed, Reader};
use crate::gcode::rewrite::rounded;
use crate::gcode::settings::Filament;
use crate::gcode::stale::Change;
use crate::gcode::survey::Survey;
use crate::gcode::words::{Command, Content, Words, content};
use crate::geometry::moments::Moments;

/// Multipliers closer than this (relative) are the same: E is written to 1e-5 mm.
const SAME: f64 = 1e-9;

/// Pieces of one move at most; longer moves get longer pieces.
const MOST_PIECES: f64 = 10_000.0;

/// An arc in one move spans at most so many radians.
const WIDEST: f64 = 3.0;

/// How a print is modulated.
pub(crate) struct Modulation<'a> {
    /// Which feature types are infill.
    pub(crate) infill: &'a InfillTypes,
    /// The length of pieces (mm).
    pub(crate) step: f64,
    pub(crate) flow: &'a dyn Flow,
    /// Least and greatest multiplier; beyond them it is clipped.
    pub(crate) limits: [f64; 2],
    pub(crate) pace: Pace,
    /// The nozzle's diameter (mm), if it is known.
    pub(crate) nozzle: Option<f64>,
    /// What the whole print's change is, once it is known: comments are corrected by it.
    pub(crate) change: Option<&'a Change>,
    /// Where moments are measured from.
    pub(crate) near: Point3<f64>,
}

/// Why a file was not written.
#[derive(Debug, Error)]
pub(crate) enum ModulateError {
    /// The file that is read.
    #[error(transparent)]
    Gcode(#[from] GcodeError),
    /// The file that is written.
    #[error("{0}")]
    Write(#[source] std::io::Error),
}

/// What was modulated. Moments are of density 1, measured from [`Modulation::near`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Modulated {
    /// The part without its infill.
    pub(crate) fixed: Moments,
    /// The infill as sliced, as the flow wants it, and as it is written.
    pub(crate) sliced: Moments,
    pub(crate) wanted: Moments,
    pub(crate) written: Moments,
    /// Moves of infill, and those that were written anew.
    pub(crate) moves: usize,
    pub(crate) changed: usize,
    /// Pieces of infill, and those that were clipped at the lower and at the upper limit.
    pub(crate) pieces: usize,
    pub(crate) clipped: [usize; 2],
    /// Volume that clipping added and took away (mm³).
    pub(crate) clipped_volume: [f64; 2],
    /// Least and greatest multiplier that the flow wants.
    pub(crate) extremes: Option<[f64; 2]>,
    /// Pieces narrower than half the nozzle and wider than two.
    pub(crate) odd_widths: [usize; 2],
    /// The greatest speed of pieces made faster (mm/s), and of the least made slower.
    pub(crate) speeds: Option<[f64; 2]>,
    pub(crate) change: Change,
}

/// Reads `source`, which `survey` has been through, and writes it modulated.
pub(crate) fn modulate<R: Read + Seek, W: Write>(
    source: &mut R,
    survey: Survey,
    given: Filament,
    modulation: &Modulation<'_>,
    out: W,
) -> Result<Modulated, ModulateError> {
    source.rewind().map_err(GcodeError::from)?;
    let mut lines = Lines::new(source);
    let mut words = Words::new();
    let mut modulator = Modulator::new(modulation, Reader::new(survey, given), out);
    while let Some(line) = lines.next().map_err(ModulateError::Gcode)? {
        modulator.line(&line, &mut words)?;
    }
    if modulator.done.change.tools.is_empty() {
        let lines = lines.count();
        return Err(GcodeError::Nothing { lines }.into());
    }
    modulator.out.flush().map_err(ModulateError::Write)?;
    Ok(modulator.done)
}

struct Modulator<'a, W> {
    modulation: &'a Modulation<'a>,
    reader: Reader,
    out: W,
    /// By what the written file's register of E lies above the read one's (mm, mm³).
    shift: f64,
    /// The same, of states kept by name.
    saved: HashMap<String, f64>,
    /// What rounding of relative E has withheld (mm, mm³).
    carry: f64,
    feed: Feed,
    done: Modulated,
}

impl<'a, W: Write> Modulator<'a, W> {
    fn new(modulation: &'a Modulation<'a>, reader: Reader, out: W) -> Self {
        Self {
            modulation,
            reader,
            out,
            shift: 0.0,
            saved: HashMap::new(),
            carry: 0.0,
            feed: Feed::default(),
            done: Modulated::default(),
        }
    }

    fn line(&mut self, line: &Line<'_>, words: &mut Words) -> Result<(), ModulateError> {
        self.write(line.mark)?;
        let before = self.reader.machine().reading();
        let printed = self.reader.line(line, words)?;
        match content(line.text).map_err(|fault| line.refuse(fault))? {
            Content::Command(command) if command.is_motion() => {
                let here = MoveText {
                    line,
                    command,
                    words,
                    before,
                };
                self.motion(&here, printed)
            }
            Content::Comment(comment) => self.comment(line, comment),
            Content::Blank => self.copy(line),
            Content::Command(command) => {
                self.plain_bead(printed);
                self.setting(line, &command, words)
            }
            Content::Foreign(code) => {
                self.repay_feed(line)?;
                self.named_state(code);
                self.copy(line)
            }
        }
    }

    fn motion(
        &mut self,
        here: &MoveText<'_>,
        printed: Option<Printed>,
    ) -> Result<(), ModulateError> {
        match printed.filter(|one| self.is_infill(one)) {
            Some(printed) => self.infill(here, &printed),
            None => {
                self.plain_bead(printed);
                self.plain(here)
            }
        }
    }

    fn type_of(&self, printed: &Printed) -> &str {
        &self.reader.types.list()[self.reader.kinds[printed.kind].feature]
    }

    fn is_infill(&self, printed: &Printed) -> bool {
        self.modulation.infill.has(self.type_of(printed))
    }

    /// A bead that stays as it is.
    fn plain_bead(&mut self, printed: Option<Printed>) {
        let Some(printed) = printed else { return };
        let volume = printed.bead.volume;
        let tool = self.reader.kinds[printed.kind].tool;
        self.done.change.add(tool, [volume, volume]);
        if is_part(self.type_of(&printed)) {
            let near = &self.modulation.near;
            self.done.fixed += printed.bead.moments(printed.height, near);
        }
    }

    /// A motion that deposits what it did; absolute E follows the register.
    fn plain(&mut self, here: &MoveText<'_>) -> Result<(), ModulateError> {
        if let Some((value, text)) = here.speed() {
            self.feed.say(value, text);
            self.feed.keep();
        } else {
            self.repay_feed(here.line)?;
        }
        let register = self.reader.machine().reading().register;
        match here.shifted(register, self.shift) {
            Some(text) => self.write_line(&text, here.line),
            None => self.copy(here.line),
        }
    }

    /// Commands that are no motion: those of the register matter.
    fn setting(
        &mut self,
        line: &Line<'_>,
        command: &Command,
        words: &Words,
    ) -> Result<(), ModulateError> {
        if command.letter == b'G' && matches!(command.number, 93 | 95) && command.fraction == 0 {
            let name = command.title();
            let why = "its F is no speed; export with G94";
            return Err(line.refuse(Fault::Unknown { name, why }).into());
        }
        if command.letter == b'G' && command.number == 92 && words.has(b'E') {
            self.shift = 0.0;
        }
        self.repay_feed(line)?;
        self.copy(line)
    }

    /// Klipper's states keep the register.
    fn named_state(&mut self, code: &[u8]) {
        let name = code.split(u8::is_ascii_whitespace).next();
        let is = |known: &str| name.is_some_and(|name| name.eq_ignore_ascii_case(known.as_bytes()));
        let state = || argument(code, "NAME").unwrap_or_default();
        if is("SAVE_GCODE_STATE") && self.reader.machine().has_saved(&state()) {
            self.saved.insert(state(), self.shift);
        } else if is("RESTORE_GCODE_STATE")
            && let Some(&shift) = self.saved.get(&state())
        {
            self.shift = shift;
        }
    }

    fn comment(&mut self, line: &Line<'_>, comment: &[u8]) -> Result<(), ModulateError> {
        let so_far = self.done.change.seconds;
        let change = self.modulation.change;
        match change.and_then(|change| change.corrected(comment, so_far)) {
            Some(text) => {
                let before = &line.text[..line.text.len() - comment.len()];
                self.write_line(&[before, text.as_bytes()].concat(), line)
            }
            None => self.copy(line),
        }
    }

    /// Says F again where pieces have changed it and something relies on it.
    fn repay_feed(&mut self, line: &Line<'_>) -> Result<(), ModulateError> {
        match self.feed.owed() {
            Some(text) => self.write_line(format!("G1 F{text}").as_bytes(), line),
            None => Ok(()),
        }
    }

    fn copy(&mut self, line: &Line<'_>) -> Result<(), ModulateError> {
        self.write(line.text)?;
        self.write(line.end)
    }

    /// A line with the end of `line`.
    fn write_line(&mut self, text: &[u8], line: &Line<'_>) -> Result<(), ModulateError> {
        self.write(text)?;
        self.write(if line.end.is_empty() { b"\n" } else { line.end })
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), ModulateError> {
        self.out.write_all(bytes).map_err(ModulateError::Write)
    }
}

/// Infill.
impl<W: Write> Modulator<'_, W> {
    fn infill(&mut self, here: &MoveText<'_>, printed: &Printed) -> Result<(), ModulateError> {
        let stretches = self.stretches(printed);
        let volume = printed.bead.volume;
        self.done.moves += 1;
        self.done.sliced += printed.bead.moments(printed.height, &self.modulation.near);
        let written = self.count_written(printed, &stretches);
        let tool = self.reader.kinds[printed.kind].tool;
        if let [Stretch { multiplier, .. }] = stretches[..]
            && (multiplier - 1.0).abs() <= SAME
        {
            self.done.change.add(tool, [volume, volume]);
            return self.plain(here);
        }
        self.done.change.add(tool, [volume, written]);
        self.done.changed += 1;
        self.write_stretches(here, printed, &stretches)
    }

    /// Adds what the stretches deposit, and returns its volume.
    fn count_written(&mut self, printed: &Printed, stretches: &[Stretch]) -> f64 {
        let mut written = 0.0;
        for one in stretches {
            let mut bead = printed.bead.part(one.from, one.to);
            bead.volume *= one.multiplier;
            written += bead.volume;
            self.done.written += bead.moments(printed.height, &self.modulation.near);
        }
        written
    }

    /// The move's pieces, those of the same multiplier joined.
    fn stretches(&mut self, printed: &Printed) -> Vec<Stretch> {
        let modulation = self.modulation;
        let count = piece_count(&printed.bead.path, modulation.step);
        let mut stretches: Vec<Stretch> = Vec::new();
        for place in 0..count {
            let [from, to] = [place, place + 1].map(|end| end as f64 / count as f64);
            let piece = self.next_piece(printed, [from, to]);
            self.done.wanted += modulation.flow.wanted(&piece, &modulation.near);
            let multiplier = self.limited(&piece);
            let next = Stretch {
                from,
                to,
                multiplier,
            };
            join(&mut stretches, next, sweep(&printed.bead.path));
        }
        stretches
    }

    /// The part of a move between two shares of it, as the next piece of the file.
    fn next_piece(&mut self, printed: &Printed, [from, to]: [f64; 2]) -> Piece {
        let index = self.done.pieces;
        self.done.pieces += 1;
        Piece {
            index,
            bead: printed.bead.part(from, to),
            height: printed.height,
        }
    }

    /// The piece's multiplier within the limits.
    fn limited(&mut self, piece: &Piece) -> f64 {
        let [low, high] = self.modulation.limits;
        let wanted = self.modulation.flow.multiplier(piece);
        let [least, most] = self.done.extremes.unwrap_or([wanted; 2]);
        self.done.extremes = Some([least.min(wanted), most.max(wanted)]);
        let multiplier = if wanted.is_finite() {
            wanted.clamp(low, high)
        } else {
            1.0_f64.clamp(low, high)
        };
        let slack = SAME * wanted.abs().max(1.0);
        let side = usize::from(wanted > multiplier);
        if wanted.is_nan() || (wanted - multiplier).abs() > slack {
            self.done.clipped[side] += 1;
            self.done.clipped_volume[side] += (wanted - multiplier).abs() * piece.bead.volume;
        }
        self.note_width(piece, multiplier);
        multiplier
    }

    /// Counts pieces that become narrow or wide.
    fn note_width(&mut self, piece: &Piece, multiplier: f64) {
        if let Some(nozzle) = self.modulation.nozzle {
            let width = piece.bead.width(piece.height) * multiplier;
            self.done.odd_widths[0] += usize::from(width < nozzle / 2.0);
            self.done.odd_widths[1] += usize::from(width > nozzle * 2.0);
        }
    }

    fn write_stretches(
        &mut self,
        here: &MoveText<'_>,
        printed: &Printed,
        stretches: &[Stretch],
    ) -> Result<(), ModulateError> {
        if let Some((value, text)) = here.speed() {
            self.feed.say(value, text);
        }
        let before = &here.before;
        let register = self.reader.machine().reading().register;
        let mut targets = here.targets(&printed.bead.path, stretches).into_iter();
        let mut pushed = 0.0;
        for (number, stretch) in stretches.iter().enumerate() {
            let is_first = number == 0;
            let drawn = if is_first { before.drawn } else { 0.0 };
            let share = stretch.multiplier * (stretch.to - stretch.from);
            let length = (drawn + share * printed.bead.volume) / before.rate;
            pushed += length;
            let e = self.e_number(here, pushed, length);
            let speed = self.speed(here, printed, stretch);
            let said = speed.filter(|speed| self.feed.differs(*speed));
            if let Some(speed) = speed {
                self.feed.write(speed);
            }
            let words = targets.next().unwrap_or_default();
            self.write_line(&here.piece(is_first, words, &e, said), here.line)?;
        }
        self.shift += pushed - (register - before.register);
        Ok(())
    }

    /// The number of E for a piece that pushes `length`, `pushed` in all since the move began.
    fn e_number(&mut self, here: &MoveText<'_>, pushed: f64, length: f64) -> String {
        if here.before.relative_e {
            let exact = length + self.carry;
            let (value, text) = here.e_number(exact);
            self.carry = exact - value;
            return text;
        }
        here.e_number(here.before.register + self.shift + pushed).1
    }

    /// F of a piece; notes the time that it adds.
    fn speed(&mut self, here: &MoveText<'_>, printed: &Printed, stretch: &Stretch) -> Option<f64> {
        let said = self.feed.said().filter(|said| *said > 0.0)?;
        let length = printed.bead.path.length();
        let mm_per_second = here.before.unit / 60.0;
        if length <= 0.0 {
            return Some(said);
        }
        let section = printed.bead.volume / length;
        let sliced = said * mm_per_second;
        let pace = &self.modulation.pace;
        let factor = pace.factor(stretch.multiplier, section, sliced);
        if (factor - 1.0).abs() <= SAME {
            return Some(said);
        }
        let speed = rounded(said * factor, 3).0.max(1e-3);
        let now = speed * mm_per_second;
        let [least, most] = self.done.speeds.unwrap_or([now; 2]);
        self.done.speeds = Some([least.min(now), most.max(now)]);
        let part = length * (stretch.to - stretch.from);
        self.done.change.seconds += part / now - part / sliced;
        Some(speed)
    }
}

/// Adds a piece, in one with the last where both have the same multiplier; an arc of `sweep` (radians)
/// stays in parts of less than half a circle.
fn join(stretches: &mut Vec<Stretch>, next: Stretch, sweep: f64) {
    let slack = SAME * next.multiplier.abs().max(1.0);
    match stretches.last_mut() {
        Some(last)
            if (last.multiplier - next.multiplier).abs() <= slack
                && sweep * (next.to - last.from) <= WIDEST =>
        {
            last.to = next.to;
        }
        _ => stretches.push(next),
    }
}

/// How many pieces a path has.
pub(crate) fn piece_count(path: &Path, step: f64) -> usize {
    let count = (path.length() / step - 1e-9).ceil();
    count.clamp(1.0, MOST_PIECES) as usize
}

/// The angle that an arc passes over (radians).
fn sweep(path: &Path) -> f64 {
    match path {
        Path::Line { .. } => 0.0,
        Path::Arc(arc) => arc.sweep.abs(),
    }
}
