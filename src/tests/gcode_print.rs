//! Prints with modulated infill: what is written weighs what was wanted, and nothing else changes.

use std::collections::HashSet;
use std::io::Cursor;

use nalgebra::{Point3, Vector3};

use crate::gcode::bead::Path;
use crate::gcode::error::GcodeError;
use crate::gcode::flow::{FieldFlow, Flow, PieceFlow};
use crate::gcode::infill::InfillTypes;
use crate::gcode::lines::Lines;
use crate::gcode::modulate::{ModulateError, Modulated, Modulation, modulate};
use crate::gcode::pace::Pace;
use crate::gcode::part::part;
use crate::gcode::reader::{Printed, Reader, examine};
use crate::gcode::settings::Filament;
use crate::gcode::stale::Change;
use crate::gcode::weigh::weigh;
use crate::gcode::words::Words;
use crate::geometry::moments::Moments;
use crate::tests::gcode::{Dice, MIXED, mutants, mutated};
use crate::tests::gcode_rewrite::{SAMPLES, Style, rewritten};

const CURA: usize = 0;
const GYROID: usize = 1;
const PRUSA: usize = 2;

/// mm² of filament.
const SECTION: f64 = std::f64::consts::PI * 1.75 * 1.75 / 4.0;

/// The middle of the bed.
const NEAR: Point3<f64> = Point3::new(100.0, 100.0, 5.0);

type Field<'a> = &'a dyn Fn(&Point3<f64>) -> f64;

/// How a test modulates.
struct Way<'a> {
    field: Field<'a>,
    pieces: Option<PieceFlow>,
    step: f64,
    limits: [f64; 2],
    pace: Pace,
    change: Option<&'a Change>,
}

impl<'a> Way<'a> {
    fn new(field: Field<'a>) -> Self {
        Self {
            field,
            pieces: None,
            step: 2.0,
            limits: [0.0, f64::INFINITY],
            pace: Pace::default(),
            change: None,
        }
    }

    fn try_print(&self, text: &[u8]) -> Result<(Vec<u8>, Modulated), ModulateError> {
        let field = FieldFlow {
            field: self.field,
            unit: 1.0,
        };
        let flow: &dyn Flow = match &self.pieces {
            Some(pieces) => pieces,
            None => &field,
        };
        let modulation = Modulation {
            infill: &InfillTypes::new([]),
            step: self.step,
            flow,
            limits: self.limits,
            pace: self.pace,
            nozzle: Some(0.4),
            change: self.change,
            near: NEAR,
        };
        let mut source = Cursor::new(text);
        let survey = examine(&mut source)?;
        let mut out = Vec::new();
        let done = modulate(
            &mut source,
            survey,
            Filament::default(),
            &modulation,
            &mut out,
        )?;
        Ok((out, done))
    }

    fn print(&self, text: &str) -> (String, Modulated) {
        let (bytes, done) = self
            .try_print(text.as_bytes())
            .unwrap_or_else(|error| panic!("{error}"));
        (String::from_utf8(bytes).unwrap(), done)
    }
}

fn print(text: &str, field: Field<'_>) -> (String, Modulated) {
    Way::new(field).print(text)
}

/// The beads of a file with their types.
fn beads(text: &[u8]) -> Result<Vec<(String, Printed)>, GcodeError> {
    let mut source = Cursor::new(text);
    let survey = examine(&mut source)?;
    let mut lines = Lines::new(source);
    let (mut reader, mut words) = (Reader::new(survey, Filament::default()), Words::new());
    let mut beads = Vec::new();
    while let Some(line) = lines.next()? {
        if let Some(printed) = reader.line(&line, &mut words)? {
            let name = &reader.types.list()[reader.kinds[printed.kind].feature];
            beads.push((name.clone(), printed));
        }
    }
    Ok(beads)
}

fn is_infill(name: &str) -> bool {
    InfillTypes::new([]).has(name)
}

/// The moments of infill, and of all else, from [`NEAR`].
fn weighed(text: &str) -> [Moments; 2] {
    let mut sums = [Moments::default(); 2];
    for (name, printed) in beads(text.as_bytes()).unwrap() {
        let place = usize::from(!is_infill(&name));
        sums[place] += printed.bead.moments(printed.height, &NEAR);
    }
    sums
}

fn assert_near(got: f64, expected: f64, tolerance: f64, what: &str) {
    let is_near = (got - expected).abs() <= tolerance;
    assert!(is_near, "{what}: {got}, not {expected}");
}

fn assert_same(got: &Moments, expected: &Moments, tolerance: f64) {
    let scale = [
        1.0, 50.0, 50.0, 50.0, 2500.0, 2500.0, 2500.0, 2500.0, 2500.0, 2500.0,
    ];
    for (place, scale) in scale.into_iter().enumerate() {
        let (got, wanted) = (got.ten()[place], expected.ten()[place]);
        let tolerance = tolerance * scale * expected.mass;
        assert_near(got, wanted, tolerance, &format!("moment {place}"));
    }
}

#[test]
fn a_field_of_one_returns_the_same_bytes() {
    for sample in SAMPLES {
        let (text, done) = print(sample, &|_| 1.0);
        assert!(text == sample);
        assert!(done.moves > 100 && done.changed == 0);
        let wanted = weighed(sample);
        assert_same(&done.written, &wanted[0], 1e-11);
        assert_same(&done.sliced, &wanted[0], 1e-11);
        assert_same(&done.wanted, &wanted[0], 1e-11);
    }
    let marked = format!("\u{feff}{}", SAMPLES[PRUSA].replace('\n', "\r\n"));
    assert!(print(&marked, &|_| 1.0).0 == marked);
}

/// density.md 5.3: the bar of 0.5 → 1.5 along its 100 mm at 2 mm.
#[test]
fn the_bar_of_rising_density_weighs_what_was_measured() {
    let (text, done) = print(SAMPLES[PRUSA], &|point| 0.5 + (point.x - 50.0) / 100.0);
    let [infill, rest] = weighed(&text);
    assert_near(infill.mass, 3777.400, 1e-3, "volume");
    assert_near(NEAR.x + infill.center().x, 108.0901, 3e-3, "center");
    assert_near(NEAR.x + done.wanted.center().x, 108.0901, 5e-5, "wanted");
    assert_same(&rest, &weighed(SAMPLES[PRUSA])[1], 1e-11);
    assert_same(&infill, &done.written, 2e-6);
    let finer = Way {
        step: 0.5,
        ..Way::new(&|point| 0.5 + (point.x - 50.0) / 100.0)
    };
    let center = weighed(&finer.print(SAMPLES[PRUSA]).0)[0].center().x;
    assert_near(center, done.wanted.center().x, 1.5e-4, "finer steps");
    assert!(
        text.len() > 700_000 && text.len() < 900_000,
        "{}",
        text.len()
    );
}

#[test]
fn absolute_filament_is_right_to_a_hundred_thousandth_of_a_mm() {
    for sample in [CURA, GYROID].map(|place| SAMPLES[place]) {
        let (text, done) = print(sample, &|point| 1.0 + 0.008 * (point.x - 105.0));
        let [infill, _] = weighed(&text);
        assert_same(&infill, &done.written, 1e-5);
        let rest = |text: &str| -> Vec<Printed> {
            let beads = beads(text.as_bytes()).unwrap();
            let others = beads.into_iter().filter(|(name, _)| !is_infill(name));
            others.map(|(_, printed)| printed).collect()
        };
        let (before, after) = (rest(sample), rest(&text));
        assert_eq!(before.len(), after.len());
        for (one, other) in before.iter().zip(&after) {
            assert_eq!(one.bead.path, other.bead.path);
            let error = (one.bead.volume - other.bead.volume).abs() / SECTION;
            assert!(error <= 1.001e-5, "{error}");
        }
        let volume = |all: &[Printed]| all.iter().map(|one| one.bead.volume).sum::<f64>();
        assert_near(volume(&after), volume(&before), 1e-4, "all walls");
    }
}

/// Words of a line without E.
fn without_e(line: &str) -> Vec<&str> {
    let words = line.split_whitespace();
    words.filter(|word| !word.starts_with('E')).collect()
}

#[test]
fn a_constant_rescales_lines_and_splits_none() {
    for (place, sample) in SAMPLES.into_iter().enumerate() {
        let (text, done) = print(sample, &|_| 0.75);
        assert_eq!(text.lines().count(), sample.lines().count());
        assert_eq!(done.changed, done.moves);
        let mut changed = 0;
        for (one, other) in sample.lines().zip(text.lines()) {
            assert_eq!(without_e(one), without_e(other));
            changed += usize::from(one != other);
        }
        if place == PRUSA {
            assert_eq!(changed, done.moves);
        }
        let (before, after) = (weighed(sample)[0], weighed(&text)[0]);
        assert_near(after.mass, before.mass * 0.75, 1e-3, "mass");
        assert_near(
            (after.center() - before.center()).norm(),
            0.0,
            1e-4,
            "center",
        );
    }
}

/// The box of the next test and whether a path touches it or its surroundings.
const BOX: [[f64; 3]; 2] = [[70.0, 96.0, 3.0], [74.0, 99.0, 5.0]];

/// By how far Cura's bar lies off.
const CURA_OFF: Vector3<f64> = Vector3::new(10.0, 10.0, 0.0);

fn in_box(point: &Point3<f64>, margin: f64) -> bool {
    (0..3).all(|axis| {
        let [low, high] = [BOX[0][axis] - margin, BOX[1][axis] + margin];
        low < point[axis] && point[axis] < high
    })
}

/// The moments of all beads far from the box.
fn outside_box(text: &str, off: &Vector3<f64>) -> Moments {
    let mut sum = Moments::default();
    for (_, printed) in &beads(text.as_bytes()).unwrap() {
        let path = &printed.bead.path;
        let near = [0.0, 0.25, 0.5, 0.75, 1.0].iter().any(|&share| {
            let mut place = path.at(share);
            place.z -= printed.height / 2.0;
            in_box(&(place - off), 20.0)
        });
        if !near {
            sum += printed.bead.moments(printed.height, &NEAR);
        }
    }
    sum
}

#[test]
fn a_field_that_is_one_outside_a_box_changes_nothing_outside() {
    for (place, sample) in SAMPLES.into_iter().enumerate() {
        let off = if place == CURA {
            CURA_OFF
        } else {
            Vector3::zeros()
        };
        let field = |point: &Point3<f64>| {
            if in_box(&(point - off), 0.0) {
                1.5
            } else {
                1.0
            }
        };
        let (text, done) = print(sample, &field);
        assert!(
            done.changed > 10 && done.changed < done.moves / 5,
            "{done:?}"
        );
        let is_relative = sample.contains("M83");
        let known: HashSet<_> = sample.lines().collect();
        let (mut new, mut reader_x) = (0, 0.0);
        for line in text.lines() {
            let number = |letter| {
                let word = line
                    .split_whitespace()
                    .find_map(|word| word.strip_prefix(letter));
                word.and_then(|word| word.parse::<f64>().ok())
            };
            let is_move = line.starts_with("G1") || line.starts_with("G0");
            reader_x = number('X').filter(|_| is_move).unwrap_or(reader_x);
            if is_relative && !known.contains(line) {
                new += 1;
                assert!((55.0..90.0).contains(&reader_x), "{line}");
            }
        }
        assert_eq!(new > 10, is_relative);
        let outside = |text: &str| outside_box(text, &off);
        assert_same(&outside(&text), &outside(sample), 1e-7);
        let (before, after) = (weighed(sample), weighed(&text));
        assert_same(&after[1], &before[1], 1e-7);
        let gained = after[0].mass - before[0].mass;
        assert!(gained > 0.5 && gained < 12.0, "{gained}");
        let center = (after[0].first - before[0].first) / gained + NEAR.coords - off;
        let middle = (Vector3::from(BOX[0]) + Vector3::from(BOX[1])) / 2.0;
        assert!((center - middle).amax() < 0.5, "{center}");
    }
}

/// A sample up to some lines of its first infill, a mark of the end behind it.
fn short(sample: &str) -> String {
    let lines: Vec<_> = sample.lines().collect();
    let begins = |line: &&str| line.starts_with(";TYPE:") && is_infill(&line[6..]);
    let first = lines.iter().position(begins).unwrap();
    let from = first.saturating_sub(200);
    let head = lines.iter().take(40.min(from)).copied();
    let body = lines[from..first + 150].iter().copied();
    head.chain(body)
        .chain(["M84", ""])
        .collect::<Vec<_>>()
        .join("\n")
}

/// What a sample weighs after it is written in a style and then modulated.
fn assert_modulates_alike(style: Style, tolerance: f64) {
    let field: Field<'_> = &|point| 1.0 + 0.006 * (point.x - 105.0) + 0.02 * (point.z - 5.0);
    for sample in SAMPLES.map(short) {
        let plain = rewritten(&sample, Style::default());
        let expected = weighed(&print(&plain, field).0);
        let text = rewritten(&sample, style);
        let (written, done) = print(&text, field);
        let got = weighed(&written);
        assert_same(&got[0], &expected[0], tolerance);
        assert_same(&got[1], &weighed(&text)[1], tolerance);
        assert_same(&got[0], &done.written, tolerance);
        let (back, again) = print(&text, &|_| 1.0);
        assert!(back == text && again.changed == 0);
    }
}

#[test]
fn prints_written_otherwise_are_modulated_alike() {
    let plain = Style::default();
    let absolute_e = true;
    assert_modulates_alike(
        Style {
            absolute_e,
            ..plain
        },
        1e-5,
    );
    let resets = Some(7);
    assert_modulates_alike(
        Style {
            absolute_e,
            resets,
            ..plain
        },
        1e-5,
    );
    let relative = true;
    assert_modulates_alike(Style { relative, ..plain }, 1e-5);
    let inches = true;
    assert_modulates_alike(Style { inches, ..plain }, 1e-5);
    assert_modulates_alike(
        Style {
            inches,
            relative,
            absolute_e,
            ..plain
        },
        1e-5,
    );
}

#[test]
fn volumes_flow_tools_and_numbers_are_modulated_alike() {
    let plain = Style::default();
    let volumetric = true;
    assert_modulates_alike(
        Style {
            volumetric,
            ..plain
        },
        1e-5,
    );
    let flow = Some(40.0);
    assert_modulates_alike(Style { flow, ..plain }, 1e-5);
    let firmware = true;
    assert_modulates_alike(Style { firmware, ..plain }, 1e-5);
    let tools = true;
    assert_modulates_alike(Style { tools, ..plain }, 1e-5);
    let numbered = true;
    let absolute_e = true;
    let end = Some("\r\n");
    assert_modulates_alike(
        Style {
            numbered,
            absolute_e,
            end,
            ..plain
        },
        1e-5,
    );
}

#[test]
fn flat_arcs_are_modulated_like_lines() {
    let plain = Style::default();
    let arcs = Some(1e5);
    assert_modulates_alike(Style { arcs, ..plain }, 1e-5);
    let (inches, relative) = (true, true);
    assert_modulates_alike(
        Style {
            arcs,
            inches,
            relative,
            ..plain
        },
        1e-5,
    );
}

#[test]
fn pieces_of_arcs_keep_the_center() {
    let head = "M83\n;LAYER:0\n;HEIGHT:.4\n;TYPE:FILL\nG0 X30 Y10 Z.4 F3000\n";
    for arc in [
        "G2 X10 Y30 I-20 J0 E2 F1200 ; round\n",
        "G3 X10 Y30 R-20 Z.9 E2\n",
        "G3 X30 Y10 I-20 P2 E9\n",
        "G3 X30 I-20 E9\n",
        "G90.1\nG2 Y10 I10 J10 E9\n",
        "G91\nG3 X-20 Y20 R20 E2\n",
    ] {
        let text = format!("{head}{arc}G90\nM84\n");
        let (written, done) = print(&text, &|point| 1.0 + 0.02 * (point.x - 10.0));
        let before = beads(text.as_bytes()).unwrap();
        let Path::Arc(whole) = before[0].1.bead.path else {
            panic!("{arc} is no arc");
        };
        let after = beads(written.as_bytes()).unwrap();
        assert!(after.len() > 10, "{written}");
        let mut sweep = 0.0;
        for (_, printed) in &after {
            let Path::Arc(part) = printed.bead.path else {
                panic!("{written}");
            };
            assert!((part.center - whole.center).norm() < 2e-3, "{written}");
            assert_near(part.radius, whole.radius, 2e-3, arc);
            sweep += part.sweep;
        }
        assert_near(sweep, whole.sweep, 1e-3, arc);
        assert_same(&weighed(&written)[0], &done.written, 1e-5);
        assert_same(&weighed(&written)[0], &done.wanted, 1e-3);
        assert!(written.contains("M84"), "{written}");
    }
}

#[test]
fn speeds_change_for_pieces_only() {
    let text = "M83\n;TYPE:FILL\nG0 Z.2 F6000\nG1 F1200\nG1 X8 E.4\nG0 X0 Y1\nG1 X8 E.4 F1200\nM106\nG1 X0 F600 E-.1\nM84\n";
    let pieces = || Some(PieceFlow([0.5, 0.5, 2.0, 2.0].repeat(2)));
    let way = |pace| Way {
        pieces: pieces(),
        pace,
        ..Way::new(&|_| 1.0)
    };
    let keep_flow = Pace {
        keep_flow: true,
        ..Pace::default()
    };
    let (written, done) = way(keep_flow).print(text);
    assert_eq!(
        written,
        "M83\n;TYPE:FILL\nG0 Z.2 F6000\nG1 F1200\nG1 X4 E0.1 F2400\nG1 X8 E0.4 F600\nG1 F1200\nG0 X0 Y1\n\
         G1 X4 E0.1 F2400\nG1 X8 E0.4 F600\nG1 F1200\nM106\nG1 X0 F600 E-.1\nM84\n"
    );
    // 8 mm at 20 mm/s, then half at 40 and half at 10, twice.
    assert_near(
        done.change.seconds,
        2.0 * (0.1 + 0.4 - 0.4),
        1e-12,
        "seconds",
    );
    assert_eq!(done.speeds, Some([10.0, 40.0]));
    // As sliced 0.05 × 2.405 mm² × 20 mm/s = 2.405 mm³/s; twice as much is too much.
    let slow = Pace {
        max_flow: Some(3.0),
        ..Pace::default()
    };
    let (written, _) = way(slow).print(text);
    let lines: Vec<_> = written.lines().collect();
    assert_eq!(lines[4], "G1 X4 E0.1");
    assert!(lines[5].starts_with("G1 X8 E0.4 F748.35"), "{written}");
    assert_eq!(lines[6], "G1 F1200");
    let capped = Pace {
        keep_flow: true,
        max_speed: Some(30.0),
        ..Pace::default()
    };
    let (written, _) = way(capped).print(text);
    assert!(written.contains("G1 X4 E0.1 F1800\n"), "{written}");
}

#[test]
fn registers_and_states_are_honored() {
    // Half of 2 mm of filament is left out; all that follows moves by it, until G92.
    let text = "M82\n;TYPE:FILL\nG1 X1 E2\n;TYPE:SKIN\nG1 X2 E3.5\nG1 E1.5\nG1 E3.5\nG92 E3.5\nG1 X3 E4\nM84\n";
    let (written, _) = print(text, &|_| 0.5);
    assert_eq!(
        written,
        "M82\n;TYPE:FILL\nG1 X1 E1\n;TYPE:SKIN\nG1 X2 E2.5\nG1 E0.5\nG1 E2.5\nG92 E3.5\nG1 X3 E4\nM84\n"
    );
    let text = "M82\nG1 E1\nSAVE_GCODE_STATE NAME=a\n;TYPE:FILL\nG1 X1 E2\n;TYPE:SKIN\nG1 X2 E3\nRESTORE_GCODE_STATE NAME=a\nG1 X3 E2\nM84\n";
    let (written, _) = print(text, &|_| 0.5);
    assert_eq!(
        written,
        "M82\nG1 E1\nSAVE_GCODE_STATE NAME=a\n;TYPE:FILL\nG1 X1 E1.5\n;TYPE:SKIN\nG1 X2 E2.5\nRESTORE_GCODE_STATE NAME=a\nG1 X3 E2\nM84\n"
    );
    // Pushed again after a retraction: the retraction stays whole.
    let text = "M83\n;TYPE:FILL\nG1 X1 E1\nG1 E-2\nG1 X3 E3\nM84\n";
    let (written, done) = print(text, &|_| 0.5);
    assert_eq!(
        written,
        "M83\n;TYPE:FILL\nG1 X1 E0.5\nG1 E-2\nG1 X3 E2.5\nM84\n"
    );
    assert_near(done.written.mass, SECTION, 1e-12, "half of it");
    // Modes change in between.
    let text = "M83\n;TYPE:FILL\nG1 X1 E1\nM82\nG1 X2 E2\n;TYPE:SKIN\nG1 X3 E3\nM84\n";
    let (written, _) = print(text, &|_| 0.5);
    assert_eq!(
        written,
        "M83\n;TYPE:FILL\nG1 X1 E0.5\nM82\nG1 X2 E1\n;TYPE:SKIN\nG1 X3 E2\nM84\n"
    );
}

#[test]
fn rounding_is_carried_on() {
    let lines: String = (1..=3000).map(|x| format!("G1 X{x} E.00001\n")).collect();
    let text = format!("M83\n;TYPE:FILL\n{lines}M84\n");
    let (written, _) = print(&text, &|_| 0.35);
    assert_near(
        weighed(&written)[0].mass / SECTION,
        0.0105,
        6e-6,
        "filament",
    );
}

#[test]
fn limits_clip_and_are_counted() {
    let way = Way {
        limits: [0.8, 1.2],
        ..Way::new(&|point: &Point3<f64>| 0.5 + (point.x - 50.0) / 100.0)
    };
    let (written, done) = way.print(SAMPLES[PRUSA]);
    let [below, above] = done.clipped;
    assert!(below > 1000 && above > 1000 && below + above < done.pieces);
    let [low, high] = done.extremes.unwrap();
    assert!(low < 0.53 && high > 1.47, "{low} {high}");
    let lost = done.clipped_volume[1] - done.clipped_volume[0];
    let infill = weighed(&written)[0].mass;
    assert_near(infill, done.wanted.mass - lost, 1e-3, "volume");
    let spoiled = Way {
        limits: [0.0, 2.0],
        ..Way::new(&|_| f64::NAN)
    };
    let (written, done) = spoiled.print(SAMPLES[PRUSA]);
    assert!(written == SAMPLES[PRUSA] && done.clipped[0] == done.pieces);
}

#[test]
fn totals_in_comments_follow() {
    let field: Field<'_> = &|_| 0.5;
    let change = print(SAMPLES[PRUSA], field).1.change;
    let way = Way {
        change: Some(&change),
        ..Way::new(field)
    };
    let (written, _) = way.print(SAMPLES[PRUSA]);
    let used = 2645.53 - 3777.400 / 2.0 / SECTION;
    let line = format!("; filament used [mm] = {used:.2}\n");
    assert!(written.contains(&line), "{line}");
    assert!(written.contains("= 30m 2s\n"), "no speed has changed");
}

#[test]
fn the_part_is_found_on_the_bed() {
    for (place, low, high, filling) in [
        (CURA, [60.0, 105.0, 0.0], [160.0, 115.0, 10.0], 0.2),
        // The pattern follows the walls: more than the slicer's 25 %.
        (GYROID, [50.0, 95.0, 0.0], [150.0, 105.0, 10.0], 0.36),
        (PRUSA, [50.0, 95.0, 0.0], [150.0, 105.0, 10.0], 0.5),
    ] {
        let mut source = Cursor::new(SAMPLES[place]);
        let survey = examine(&mut source).unwrap();
        let said = survey.settings.filling;
        assert_eq!(said, [None, Some(0.25), Some(0.5)][place]);
        let infill = InfillTypes::new([]);
        let found = part(&mut source, survey, Filament::default(), &infill).unwrap();
        assert!(
            (found.bounds.min - Point3::from(low)).amax() < 0.05,
            "{:?}",
            found.bounds
        );
        assert!(
            (found.bounds.max - Point3::from(high)).amax() < 0.05,
            "{:?}",
            found.bounds
        );
        let measured = found.filling.unwrap();
        assert!(
            (measured / filling - 1.0).abs() < 0.15,
            "{measured} {filling}"
        );
        assert_near(found.ground, 0.0, 1e-9, "ground");
        assert!(found.footprint.len() > 100);
    }
}

/// What can be weighed can be modulated, and what is written weighs what was planned.
#[test]
fn mutated_files_are_written_right_or_refused() {
    let infill = MIXED.replace(";TYPE:Perimeter", ";TYPE:FILL");
    let field: Field<'_> = &|point| 1.0 + 0.03 * point.x.sin();
    let mut dice = Dice(0x2545_F491_4F6C_DD1D);
    let (mut written, mut refused) = (0, 0);
    for _ in 0..mutants() {
        let text = mutated(infill.as_bytes(), &mut dice);
        let shown = || String::from_utf8_lossy(&text).into_owned();
        let is_sound = weigh(&mut Cursor::new(&text), Filament::default()).is_ok();
        match Way::new(field).try_print(&text) {
            Ok((bytes, done)) => {
                written += 1;
                assert!(is_sound, "{}", shown());
                let planned = done.fixed.mass + done.written.mass;
                assert!(planned.is_finite(), "{}", shown());
                let back = Way::new(&|_| 1.0).try_print(&bytes);
                let (_, back) = back.unwrap_or_else(|error| {
                    panic!(
                        "{error}\n{}\n->\n{}",
                        shown(),
                        String::from_utf8_lossy(&bytes)
                    )
                });
                let got = back.fixed.mass + back.sliced.mass;
                let slack = 0.01 * planned + 0.1;
                let text = String::from_utf8_lossy(&bytes);
                assert!(
                    (got - planned).abs() <= slack,
                    "{got} {planned}\n{}\n->\n{text}",
                    shown()
                );
            }
            Err(_) => {
                refused += 1;
                let is_strange = shown().contains("G93") || shown().contains("G95");
                assert!(!is_sound || is_strange, "{}", shown());
            }
        }
    }
    println!("{written} written, {refused} refused");
    assert!(written > mutants() / 10 && refused > mutants() / 10);
}
