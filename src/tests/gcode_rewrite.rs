//! The same print written in other ways weighs the same.

use std::fmt::Write;
use std::io::Cursor;

use nalgebra::Point3;

use crate::gcode::labels::is_part;
use crate::gcode::settings::Filament;
use crate::gcode::weigh::{Weighed, weigh};
use crate::geometry::moments::Moments;

pub(super) const SAMPLES: [&str; 3] = [
    include_str!("../../tests/cases/gcode/bar-cura.gcode"),
    include_str!("../../tests/cases/gcode/bar-gyroid-absolute.gcode"),
    include_str!("../../tests/cases/gcode/bar-prusaslicer.gcode"),
];

/// mm² of filament.
const SECTION: f64 = std::f64::consts::PI * 1.75 * 1.75 / 4.0;

/// A line of a sample, understood.
enum Step<'a> {
    Text(&'a str),
    /// Targets (mm), filament (mm), speed.
    Move([Option<f64>; 3], Option<f64>, Option<&'a str>),
}

/// How a print is written.
#[derive(Clone, Copy, Default)]
pub(super) struct Style {
    pub(super) absolute_e: bool,
    /// G92 E after every so many moves.
    pub(super) resets: Option<usize>,
    pub(super) inches: bool,
    pub(super) relative: bool,
    /// G91 after M82, not before.
    pub(super) late: bool,
    pub(super) volumetric: bool,
    /// Percent.
    pub(super) flow: Option<f64>,
    /// Radius of the arcs that replace lines (mm).
    pub(super) arcs: Option<f64>,
    pub(super) tools: bool,
    pub(super) firmware: bool,
    pub(super) numbered: bool,
    pub(super) end: Option<&'static str>,
}

/// Reads a sample by the few commands that it has.
fn steps(text: &str) -> Vec<Step<'_>> {
    let (mut register, mut is_relative) = (0.0, false);
    let mut steps = Vec::new();
    for line in text.lines() {
        let code = line.split(';').next().unwrap_or_default();
        let mut words = code.split_whitespace();
        let name = words.next().unwrap_or_default();
        let words: Vec<_> = words.collect();
        let word = |letter: char| words.iter().find_map(|word| word.strip_prefix(letter));
        let number = |letter| word(letter).map(|word| word.parse::<f64>().unwrap());
        match name {
            "M82" | "M83" => is_relative = name == "M83",
            "G92" => register = number('E').unwrap(),
            "G0" | "G1" => {
                let pushed = number('E').map(|e| if is_relative { e } else { e - register });
                register += pushed.unwrap_or(0.0);
                let to = ['X', 'Y', 'Z'].map(number);
                steps.push(Step::Move(to, pushed, word('F')));
            }
            _ => steps.push(Step::Text(line)),
        }
    }
    steps
}

struct Writer {
    style: Style,
    text: String,
    lines: usize,
    moves: usize,
    layers: usize,
    position: Point3<f64>,
    register: f64,
}

impl Writer {
    fn line(&mut self, line: &str) {
        self.lines += 1;
        let end = self.style.end.unwrap_or("\n");
        if self.style.numbered && !line.starts_with(';') && !line.is_empty() {
            let code = line.split(';').next().unwrap_or_default();
            let line = format!("N{} {code}", self.lines);
            let sum = line.bytes().fold(0, |sum, byte| sum ^ byte);
            write!(self.text, "{line}*{sum} ; with * in a comment{end}").unwrap();
        } else {
            write!(self.text, "{line}{end}").unwrap();
        }
    }

    fn begin(&mut self) {
        let style = self.style;
        let lines = [
            (style.inches, "G20".to_owned()),
            (style.relative && !style.late, "G91".to_owned()),
            (style.absolute_e, "M82".to_owned()),
            (!style.absolute_e, "M83".to_owned()),
            (style.late, "G91".to_owned()),
            (style.volumetric, format!("M200 D{}", self.unit(1.75))),
            (
                style.flow.is_some(),
                format!("M221 S{}", style.flow.unwrap_or(100.0)),
            ),
        ];
        for (_, line) in lines.iter().filter(|(is_said, _)| *is_said) {
            self.line(line);
        }
    }

    fn unit(&self, length: f64) -> f64 {
        if self.style.inches {
            length / 25.4
        } else {
            length
        }
    }

    fn text_line(&mut self, line: &str) {
        let overruled = ["G20", "G21", "G90", "G91"];
        if overruled.iter().any(|name| line.starts_with(name)) {
            return;
        }
        self.line(line);
        if self.style.tools && line.starts_with(";LAYER") && !line.starts_with(";LAYER_COUNT") {
            self.layers += 1;
            self.line(if self.layers.is_multiple_of(2) {
                "T1"
            } else {
                "T0"
            });
        }
    }

    /// The E word's number.
    fn extrusion(&mut self, pushed: f64) -> f64 {
        let mut e = pushed * 100.0 / self.style.flow.unwrap_or(100.0);
        if self.style.volumetric {
            e *= SECTION;
        }
        let unit = if self.style.volumetric { 3 } else { 1 };
        e /= if self.style.inches {
            25.4_f64.powi(unit)
        } else {
            1.0
        };
        self.register += e;
        if self.style.absolute_e {
            self.register
        } else {
            e
        }
    }

    fn motion(&mut self, to: [Option<f64>; 3], pushed: Option<f64>, speed: Option<&str>) {
        self.moves += 1;
        if self.style.firmware
            && to == [None; 3]
            && pushed.is_some_and(|e| (e.abs() - 2.0).abs() < 1e-9)
        {
            let is_back = pushed.is_some_and(|e| e > 0.0);
            return self.line(if is_back { "G11" } else { "G10" });
        }
        let from = self.position;
        let mut words = String::new();
        for axis in 0..3 {
            let Some(target) = to[axis] else { continue };
            let start = if self.style.relative { from[axis] } else { 0.0 };
            let letter = ['X', 'Y', 'Z'][axis];
            write!(words, " {letter}{}", self.unit(target - start)).unwrap();
            self.position[axis] = target;
        }
        let arc = self.style.arcs.filter(|_| pushed.is_some_and(|e| e > 0.0));
        let code = match arc.and_then(|radius| self.arc(&from, radius)) {
            Some((code, round)) => {
                words += &round;
                code
            }
            None => "G1",
        };
        if let Some(pushed) = pushed {
            write!(words, " E{}", self.extrusion(pushed)).unwrap();
        }
        if let Some(speed) = speed {
            write!(words, " F{speed}").unwrap();
        }
        self.line(&format!("{code}{words}"));
        if self
            .style
            .resets
            .is_some_and(|every| self.moves.is_multiple_of(every))
        {
            self.register = self.moves as f64 / 7.0;
            self.line(&format!("G92 E{}", self.register));
        }
    }

    /// An arc from `from` to the present position, by center and by radius in turn.
    fn arc(&self, from: &Point3<f64>, radius: f64) -> Option<(&'static str, String)> {
        let chord = (self.position - from).xy();
        if chord.norm() < 1e-9 {
            return None;
        }
        let code = ["G2", "G3"][self.moves / 2 % 2];
        if self.moves.is_multiple_of(2) {
            return Some((code, format!(" R{}", self.unit(radius))));
        }
        let side = if code == "G2" { -1.0 } else { 1.0 };
        let left = nalgebra::Vector2::new(-chord.y, chord.x).normalize();
        let height = (radius * radius - chord.norm_squared() / 4.0).sqrt();
        let center = chord / 2.0 + left * (side * height);
        let [i, j] = [center.x, center.y].map(|x| self.unit(x));
        Some((code, format!(" I{i} J{j}")))
    }
}

pub(super) fn rewritten(text: &str, style: Style) -> String {
    let mut writer = Writer {
        style,
        text: String::new(),
        lines: 0,
        moves: 0,
        layers: 0,
        position: Point3::origin(),
        register: 0.0,
    };
    writer.begin();
    for step in steps(text) {
        match step {
            Step::Text(line) => writer.text_line(line),
            Step::Move(to, pushed, speed) => writer.motion(to, pushed, speed),
        }
    }
    writer.text
}

fn weighed(text: &str) -> Weighed {
    weigh(&mut Cursor::new(text), Filament::default()).unwrap()
}

/// The part's moments from the middle of the bed.
fn part(weighed: &Weighed) -> Moments {
    let mut sum = Moments::default();
    for deposit in &weighed.deposits {
        if is_part(&weighed.types.list()[deposit.kind]) {
            sum += deposit.moments;
        }
    }
    sum.translated(&(weighed.near - Point3::new(100.0, 100.0, 0.0)))
}

fn assert_same(text: &str, other: &str, tolerance: f64) {
    let (one, other) = (part(&weighed(text)).ten(), part(&weighed(other)).ten());
    let scale = [
        1.0, 50.0, 50.0, 50.0, 2500.0, 2500.0, 2500.0, 2500.0, 2500.0, 2500.0,
    ];
    for place in 0..10 {
        let error = (one[place] - other[place]).abs() / (one[0] * scale[place]);
        assert!(
            error < tolerance,
            "moment {place}: {} and {}",
            one[place],
            other[place]
        );
    }
}

fn assert_written_otherwise(style: Style, tolerance: f64) {
    for sample in SAMPLES {
        assert_same(sample, &rewritten(sample, style), tolerance);
    }
}

#[test]
fn absolute_or_relative_filament() {
    assert_written_otherwise(Style::default(), 1e-12);
    let absolute_e = true;
    assert_written_otherwise(
        Style {
            absolute_e,
            ..Style::default()
        },
        1e-9,
    );
    let resets = Some(7);
    assert_written_otherwise(
        Style {
            absolute_e,
            resets,
            ..Style::default()
        },
        1e-10,
    );
}

#[test]
fn relative_moves_and_inches() {
    let relative = true;
    assert_written_otherwise(
        Style {
            relative,
            ..Style::default()
        },
        1e-10,
    );
    let inches = true;
    assert_written_otherwise(
        Style {
            inches,
            ..Style::default()
        },
        1e-12,
    );
    let absolute_e = true;
    assert_written_otherwise(
        Style {
            inches,
            relative,
            absolute_e,
            ..Style::default()
        },
        1e-9,
    );
}

#[test]
fn absolute_filament_under_relative_moves_is_told_by_its_numbers() {
    let style = Style {
        relative: true,
        late: true,
        absolute_e: true,
        ..Style::default()
    };
    assert_written_otherwise(style, 1e-9);
    let numbered = true;
    let resets = Some(300);
    assert_written_otherwise(
        Style {
            numbered,
            resets,
            ..style
        },
        1e-9,
    );
    // Relative numbers rise about every other time.
    let style = Style {
        absolute_e: false,
        ..style
    };
    for sample in SAMPLES {
        let text = rewritten(sample, style).replacen("M83\n", "", 1);
        assert_same(sample, &text, 1e-10);
    }
}

#[test]
fn lines_as_flat_arcs() {
    let arcs = Some(1e8);
    assert_written_otherwise(
        Style {
            arcs,
            ..Style::default()
        },
        1e-7,
    );
    let inches = true;
    let relative = true;
    assert_written_otherwise(
        Style {
            arcs,
            inches,
            relative,
            ..Style::default()
        },
        1e-7,
    );
}

#[test]
fn volumes_flow_and_firmware_retraction() {
    let volumetric = true;
    assert_written_otherwise(
        Style {
            volumetric,
            ..Style::default()
        },
        1e-12,
    );
    let inches = true;
    assert_written_otherwise(
        Style {
            volumetric,
            inches,
            ..Style::default()
        },
        1e-12,
    );
    let flow = Some(40.0);
    assert_written_otherwise(
        Style {
            flow,
            ..Style::default()
        },
        1e-12,
    );
    let firmware = true;
    assert_written_otherwise(
        Style {
            firmware,
            ..Style::default()
        },
        1e-12,
    );
}

#[test]
fn two_tools_take_turns() {
    let style = Style {
        tools: true,
        ..Style::default()
    };
    assert_written_otherwise(style, 1e-12);
    for sample in SAMPLES {
        let weighed = weighed(&rewritten(sample, style));
        let of = |tool| weighed.deposits.iter().filter(move |one| one.tool == tool);
        let volume = |tool| of(tool).map(|one| one.moments.mass).sum::<f64>();
        assert!(volume(0) > 1000.0 && volume(1) > 1000.0);
    }
}

#[test]
fn numbers_with_checksums_and_any_line_ends() {
    let numbered = true;
    assert_written_otherwise(
        Style {
            numbered,
            ..Style::default()
        },
        1e-12,
    );
    for end in ["\r\n", "\r", "\n\r\n"] {
        let end = Some(end);
        assert_written_otherwise(
            Style {
                numbered,
                end,
                ..Style::default()
            },
            1e-12,
        );
    }
}
