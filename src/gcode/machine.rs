//! A printer as far as weighing needs it: modes, units, position, registers, and what each tool has
//! pushed.
//!
//! Volume = filament pushed beyond what had been pushed before, tool by tool: retraction, its undoing
//! and wipes cancel by themselves. Firmwares differ in whether G90 and G91 hold for E: here, as in
//! Klipper, PrusaSlicer and Marlin 1, G91 makes E relative until G90, and G90 leaves M82 or M83 as
//! they were; M82 or M83 said after G91 hold at once, as in Marlin 2 and RepRapFirmware. Where the
//! numbers tell that E is absolute under G91 ([`crate::gcode::survey`]), it is.

use std::collections::HashMap;

use nalgebra::{Point3, Vector2};

use crate::gcode::arc::{Arc, Round};
use crate::gcode::bead::{Bead, Path};
use crate::gcode::error::{ArcFault, Fault};
use crate::gcode::settings::Filament;
use crate::gcode::words::{Command, REACH, Reading, Words, unknown_motion};

/// Millimeters in an inch.
const INCH: f64 = 25.4;

/// Volumes below this (mm³) are rounding of the register: E is written to 1e-5 mm.
const TRIFLE: f64 = 1e-9;

/// An axis that G92 sets to where it is, up to this (mm), is not reset.
const SAME: f64 = 1e-6;

/// Axes that no weighing knows: rotations, second gantries, other extruders.
const STRANGE_AXES: [u8; 6] = *b"ABCUVW";

/// One extruder.
#[derive(Clone, Copy, Debug)]
struct Tool {
    number: u32,
    /// The filament's cross-section (mm²).
    section: f64,
    /// M221.
    flow: f64,
    /// What has been drawn back and not yet pushed again (mm³).
    drawn: f64,
}

/// The state of a printer between two commands.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    filament: Filament,
    /// The nozzle (mm).
    position: Point3<f64>,
    /// E as the firmware counts it (mm; mm³ where E is volumetric).
    register: f64,
    /// G91.
    relative: bool,
    /// M83.
    relative_e: bool,
    /// Whether M82 or M83 came after the last G91.
    said_e: bool,
    /// Whether G91 leaves E as it is.
    absolute_e: bool,
    /// mm of a number's unit: G20, G21.
    unit: f64,
    /// M200: E counts volumes.
    volumetric: bool,
    /// G90.1: I and J are coordinates, not offsets.
    absolute_centers: bool,
    /// G17.
    plane_xy: bool,
    /// G10 without G11.
    retracted: bool,
    /// M208 S: what G11 pushes beyond what G10 drew back (mm; mm³).
    extra: f64,
    tools: Vec<Tool>,
    /// The place of the present tool in `tools`.
    tool: usize,
    saved: HashMap<String, (Modes, f64)>,
}

/// G91, M83, and whether M82 or M83 came after the last G91.
type Modes = (bool, bool, bool);

/// States kept by name.
const MOST_SAVED: usize = 64;

impl Machine {
    /// At the origin, in absolute millimeters, with tool 0.
    /// `volumetric` and `absolute_e` are what a survey of the file tells.
    pub(crate) fn new(filament: Filament, volumetric: bool, absolute_e: bool) -> Self {
        let mut machine = Self {
            filament,
            position: Point3::origin(),
            register: 0.0,
            relative: false,
            relative_e: false,
            said_e: false,
            absolute_e,
            unit: 1.0,
            volumetric,
            absolute_centers: false,
            plane_xy: true,
            retracted: false,
            extra: 0.0,
            tools: Vec::new(),
            tool: 0,
            saved: HashMap::new(),
        };
        machine.take(0);
        machine
    }

    /// Keeps modes and register under a name (Klipper's `SAVE_GCODE_STATE`).
    pub(crate) fn save(&mut self, name: String) {
        let modes = (self.relative, self.relative_e, self.said_e);
        if self.saved.len() < MOST_SAVED || self.saved.contains_key(&name) {
            self.saved.insert(name, (modes, self.register));
        }
    }

    /// Takes them back (Klipper's `RESTORE_GCODE_STATE`).
    pub(crate) fn restore(&mut self, name: &str) {
        if let Some(&(modes, register)) = self.saved.get(name) {
            (self.relative, self.relative_e, self.said_e) = modes;
            self.register = register;
        }
    }

    /// Whether a state is kept under this name.
    pub(crate) fn has_saved(&self, name: &str) -> bool {
        self.saved.contains_key(name)
    }

    pub(crate) fn filament(&self) -> &Filament {
        &self.filament
    }

    /// Whether E counts volumes.
    pub(crate) fn is_volumetric(&self) -> bool {
        self.volumetric
    }

    /// The present tool's number.
    pub(crate) fn tool(&self) -> u32 {
        self.tools[self.tool].number
    }

    /// The present tool's flow: M221.
    pub(crate) fn flow(&self) -> f64 {
        self.tools[self.tool].flow
    }

    /// How the next motion is read.
    pub(crate) fn reading(&self) -> Reading {
        let tool = &self.tools[self.tool];
        let section = if self.volumetric { 1.0 } else { tool.section };
        Reading {
            from: self.position,
            relative: self.relative,
            relative_e: self.is_relative_e(),
            register: self.register,
            unit: self.unit,
            unit_e: self.unit_e(),
            rate: section * tool.flow,
            drawn: tool.drawn,
            absolute_centers: self.absolute_centers,
        }
    }

    /// Takes tool `number`.
    pub(crate) fn take(&mut self, number: u32) {
        let known = self.tools.iter().position(|tool| tool.number == number);
        self.tool = known.unwrap_or_else(|| {
            self.tools.push(Tool {
                number,
                section: self.filament.section(number),
                flow: 1.0,
                drawn: 0.0,
            });
            self.tools.len() - 1
        });
    }

    /// Obeys a command in the line `text`; `words` is room for its words. Returns what it deposits.
    pub(crate) fn obey(
        &mut self,
        text: &[u8],
        command: &Command,
        words: &mut Words,
    ) -> Result<Option<Bead>, Fault> {
        match (command.letter, command.number) {
            (b'G', 0..=3) if command.fraction == 0 => {
                words.read(text, command)?;
                words.lone().map_or(Ok(()), Err)?;
                self.motion(command.number, words)
            }
            (b'G', 10 | 11 | 28 | 92) | (b'M', 6 | 108 | 135 | 200 | 208 | 221) => {
                words.read(text, command)?;
                self.setting(command, words)
            }
            (b'G', _) => self.mode(command).map(|()| None),
            (b'M', 82 | 83) => {
                self.relative_e = command.number == 83;
                self.said_e = true;
                Ok(None)
            }
            (b'T', number) => {
                self.choose(f64::from(number));
                Ok(None)
            }
            _ => Ok(None),
        }
    }

    /// Modal commands of G, and those whose motion is unknown.
    fn mode(&mut self, command: &Command) -> Result<(), Fault> {
        match (command.number, command.fraction) {
            (17..=19, 0) => self.plane_xy = command.number == 17,
            (20, 0) => self.unit = INCH,
            (21, 0) => self.unit = 1.0,
            (90 | 91, 0) => {
                self.relative = command.number == 91;
                self.said_e = false;
            }
            (90 | 91, 1) => self.absolute_centers = command.number == 90,
            (number, _) => {
                if let Some(why) = unknown_motion(number) {
                    let name = command.title();
                    return Err(Fault::Unknown { name, why });
                }
            }
        }
        Ok(())
    }

    /// Commands with words that are no motion, but for what G11 pushes.
    fn setting(&mut self, command: &Command, words: &Words) -> Result<Option<Bead>, Fault> {
        match (command.letter, command.number) {
            (b'G', 10) => self.retract(words)?,
            (b'G', 11) if self.retracted => {
                self.retracted = false;
                return Ok(self.push(self.extra).map(|volume| self.blob(volume)));
            }
            (b'G', 28) => self.home(words),
            (b'G', 92) if command.fraction == 0 => self.reset(words)?,
            (b'M', 6 | 108 | 135) => {
                if let Some(number) = words.number(b'T')? {
                    self.choose(number);
                }
            }
            (b'M', 200) => self.count_volumes(words)?,
            (b'M', 208) => self.extra = words.number(b'S')?.unwrap_or(0.0) * self.unit_e(),
            (b'M', 221) => self.set_flow(words)?,
            _ => {}
        }
        Ok(None)
    }
}

/// Motions.
impl Machine {
    /// G0 to G3.
    fn motion(&mut self, number: u32, words: &Words) -> Result<Option<Bead>, Fault> {
        if let Some(&axis) = STRANGE_AXES.iter().find(|&&axis| words.has(axis)) {
            return Err(Fault::Unknown {
                name: format!("the axis {} of G{number}", axis as char),
                why: "where it moves the nozzle is unknown",
            });
        }
        let from = self.position;
        let to = self.target(words)?;
        let round = match number {
            0 | 1 => None,
            _ => Some(self.round(&from, words)?),
        };
        self.position = to;
        let Some(volume) = self
            .filament_of(words)?
            .and_then(|length| self.push(length))
        else {
            return Ok(None);
        };
        let path = match round {
            None => Path::Line { from, to },
            Some(round) => {
                let circles = words.number(b'P')?.unwrap_or(0.0).clamp(0.0, 100.0).trunc();
                let arc = Arc::between(&from, &to, round, number == 2, circles);
                Path::Arc(arc.map_err(Fault::Arc)?)
            }
        };
        Ok(Some(Bead { path, volume }))
    }

    /// Where a motion ends.
    fn target(&self, words: &Words) -> Result<Point3<f64>, Fault> {
        let mut to = self.position;
        for (axis, letter) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
            let Some(value) = words.number(letter)? else {
                continue;
            };
            let start = if self.relative { to[axis] } else { 0.0 };
            to[axis] = start + value * self.unit;
            if to[axis].abs() > REACH {
                return Err(Fault::OutOfReach {
                    letter: letter as char,
                    value: to[axis],
                    limit: REACH,
                });
            }
        }
        Ok(to)
    }

    /// The circle of an arc that starts at `from`.
    fn round(&self, from: &Point3<f64>, words: &Words) -> Result<Round, Fault> {
        if !self.plane_xy {
            return Err(Fault::Arc(ArcFault::Plane));
        }
        let radius = words.number(b'R')?.filter(|radius| *radius != 0.0);
        let center = [words.number(b'I')?, words.number(b'J')?];
        match (radius, center) {
            (None, [None, None]) => Err(Fault::Arc(ArcFault::NoCenter)),
            (Some(radius), [None, None]) => Ok(Round::Radius(radius * self.unit)),
            (Some(_), _) => Err(Fault::Arc(ArcFault::Both)),
            (None, center) if self.absolute_centers => {
                let [x, y] = [(center[0], from.x), (center[1], from.y)]
                    .map(|(value, start)| value.map_or(start, |value| value * self.unit));
                Ok(Round::Center(Vector2::new(x, y)))
            }
            (None, center) => {
                let [x, y] = center.map(|value| value.unwrap_or(0.0) * self.unit);
                Ok(Round::Center(from.coords.xy() + Vector2::new(x, y)))
            }
        }
    }

    /// What a motion adds to the register of E.
    fn filament_of(&mut self, words: &Words) -> Result<Option<f64>, Fault> {
        let Some(value) = words.number(b'E')? else {
            return Ok(None);
        };
        let value = value * self.unit_e();
        let length = if self.is_relative_e() {
            value
        } else {
            value - self.register
        };
        self.register += length;
        Ok(Some(length))
    }

    /// Whether E is an offset.
    fn is_relative_e(&self) -> bool {
        self.relative_e || self.relative && !self.said_e && !self.absolute_e
    }

    /// mm, or mm³ of volumetric E, of a unit of E.
    fn unit_e(&self) -> f64 {
        if self.volumetric {
            self.unit.powi(3)
        } else {
            self.unit
        }
    }

    /// Pushes filament, or draws it back below zero; returns the volume that comes out (mm³).
    fn push(&mut self, length: f64) -> Option<f64> {
        let volumetric = self.volumetric;
        let tool = &mut self.tools[self.tool];
        let section = if volumetric { 1.0 } else { tool.section };
        let out = length * section * tool.flow - tool.drawn;
        tool.drawn = (-out).max(0.0);
        (out > TRIFLE).then_some(out)
    }

    /// Plastic where the nozzle stands.
    fn blob(&self, volume: f64) -> Bead {
        let (from, to) = (self.position, self.position);
        Bead {
            path: Path::Line { from, to },
            volume,
        }
    }
}

/// Settings with words.
impl Machine {
    /// G10, unless its words make it another command (offsets and temperatures of tools).
    fn retract(&mut self, words: &Words) -> Result<(), Fault> {
        if words.has(b'L') {
            return Err(Fault::Unknown {
                name: "G10 L".into(),
                why: "it moves the coordinates",
            });
        }
        self.retracted |= !words.has(b'P');
        Ok(())
    }

    /// G28: named axes go home, or all. Home counts as 0.
    fn home(&mut self, words: &Words) {
        let axes = [b'X', b'Y', b'Z'].map(|letter| words.has(letter));
        let all = axes == [false; 3];
        for axis in 0..3 {
            if axes[axis] || all {
                self.position[axis] = 0.0;
            }
        }
    }

    /// G92.
    fn reset(&mut self, words: &Words) -> Result<(), Fault> {
        let is_axis = |axis: &&u8| words.has(**axis);
        if let Some(&axis) = STRANGE_AXES.iter().find(is_axis) {
            return Err(Fault::Unknown {
                name: format!("G92 {}", axis as char),
                why: "where this axis moves the nozzle is unknown",
            });
        }
        let mut known = false;
        for (axis, letter) in [b'X', b'Y', b'Z'].into_iter().enumerate() {
            let Some(value) = words.number(letter)? else {
                continue;
            };
            known = true;
            let (from, to) = (self.position[axis], value * self.unit);
            if (from - to).abs() > SAME {
                let axis = letter as char;
                return Err(Fault::AxisReset { axis, from, to });
            }
        }
        match words.number(b'E')? {
            Some(value) => self.register = value * self.unit_e(),
            None if known => {}
            None => {
                return Err(Fault::Unknown {
                    name: "G92 without an axis".into(),
                    why: "some firmwares reset all axes, others none",
                });
            }
        }
        Ok(())
    }

    /// M200: D is the filament's diameter, 0 for E in lengths; S switches.
    fn count_volumes(&mut self, words: &Words) -> Result<(), Fault> {
        if let Some(diameter) = words.number(b'D')? {
            self.volumetric = diameter != 0.0;
        }
        if let Some(switch) = words.number(b'S')? {
            self.volumetric = switch != 0.0;
        }
        Ok(())
    }

    /// M221: percent of flow, of the present tool or of T.
    fn set_flow(&mut self, words: &Words) -> Result<(), Fault> {
        let Some(percent) = words.number(b'S')? else {
            return Ok(());
        };
        if percent < 0.0 {
            return Err(Fault::NegativeFlow(percent));
        }
        let present = self.tool();
        if let Some(number) = words.number(b'T')? {
            self.choose(number);
        }
        self.tools[self.tool].flow = percent / 100.0;
        self.take(present);
        Ok(())
    }

    /// Takes a tool; numbers no printer has tools for (Bambu Lab's T255, T1000) are commands of their
    /// own and change none.
    fn choose(&mut self, number: f64) {
        if (0.0..254.0).contains(&number) {
            self.take(number as u32);
        }
    }
}
