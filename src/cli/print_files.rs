//! The files of `chebloyd print --report`: a layer's deposit, and the infill's profile along an axis.

use std::cell::RefCell;
use std::fs::{self, File};
use std::io::Write;
use std::path::Path;

use nalgebra::{Point2, Point3};
use serde::Serialize;

use crate::cli::cell_files::PNG_SCALE;
use crate::cli::failure::{Failure, write_file};
use crate::cli::print_options::PrintOptions;
use crate::cli::print_task::Task;
use crate::gcode::bead;
use crate::gcode::flow::{Flow, Piece};
use crate::gcode::part::each_bead;
use crate::gcode::reader::{Printed, examine};
use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::plot::figure::Figure;
use crate::plot::print_layer::{Bin, Strip, layer, profile};
use crate::plot::{png, svg};

/// The files' names.
pub(crate) const FILES: [&str; 6] = [
    "layer.svg",
    "layer.png",
    "profile.csv",
    "profile.json",
    "profile.svg",
    "profile.png",
];

/// mm of a bin.
const BIN: f64 = 5.0;

/// Beads are shared out to bins by parts no longer than this (mm).
const PART: f64 = 0.25;

/// Bins at most: those of a part five meters long.
const MOST_BINS: f64 = 1000.0;

/// Nozzle heights closer than this (mm) are one layer.
const SAME: f64 = 1e-3;

/// Arcs are drawn as so many lines.
const ARC_LINES: usize = 32;

/// Volumes along an axis.
#[derive(Clone, Debug)]
pub(crate) struct Bins {
    axis: usize,
    from: f64,
    volumes: Vec<f64>,
}

impl Bins {
    /// Over the box of a part.
    pub(crate) fn over(bounds: &Bounds<3>, axis: usize) -> Self {
        let count = (bounds.extent()[axis] / BIN - 1e-6)
            .ceil()
            .clamp(1.0, MOST_BINS);
        Self {
            axis,
            from: (bounds.min[axis] * 1e3).round() / 1e3,
            volumes: vec![0.0; count as usize],
        }
    }

    /// The same bins without volume.
    fn emptied(&self) -> Self {
        Self {
            volumes: vec![0.0; self.volumes.len()],
            ..*self
        }
    }

    fn add(&mut self, place: &Point3<f64>, volume: f64) {
        let bin = ((place[self.axis] - self.from) / BIN).max(0.0) as usize;
        let last = self.volumes.len() - 1;
        self.volumes[bin.min(last)] += volume;
    }

    /// Adds a bead of infill.
    fn add_bead(&mut self, printed: &Printed) {
        let bead = &printed.bead;
        let count = (bead.path.length() / PART).ceil().clamp(1.0, 10_000.0);
        for part in 0..count as usize {
            let place = bead.path.at((part as f64 + 0.5) / count);
            self.add(&place, bead.volume / count);
        }
    }
}

/// A flow, what it wants added to bins.
pub(crate) struct BinnedFlow<'a> {
    flow: &'a dyn Flow,
    bins: RefCell<Bins>,
}

impl<'a> BinnedFlow<'a> {
    pub(crate) fn new(flow: &'a dyn Flow, bins: Bins) -> Self {
        let bins = RefCell::new(bins);
        Self { flow, bins }
    }

    pub(crate) fn into_bins(self) -> Bins {
        self.bins.into_inner()
    }
}

impl Flow for BinnedFlow<'_> {
    fn multiplier(&self, piece: &Piece) -> f64 {
        self.flow.multiplier(piece)
    }

    fn wanted(&self, piece: &Piece, near: &Point3<f64>) -> Moments {
        let count = (piece.bead.path.length() / PART)
            .ceil()
            .clamp(1.0, 10_000.0);
        for part in 0..count as usize {
            let [from, to] = [part, part + 1].map(|end| end as f64 / count);
            let small = Piece {
                bead: piece.bead.part(from, to),
                ..*piece
            };
            let volume = small.bead.volume * self.flow.multiplier(&small);
            self.bins
                .borrow_mut()
                .add(&small.bead.path.middle(), volume);
        }
        self.flow.wanted(piece, near)
    }
}

/// The beads of one layer.
struct LayerStrips {
    z: f64,
    strips: Vec<Strip>,
}

impl LayerStrips {
    fn add(&mut self, printed: &Printed, is_infill: bool) {
        if (printed.bead.path.last_z() - self.z).abs() > SAME {
            return;
        }
        let path = &printed.bead.path;
        let count = match path {
            bead::Path::Line { .. } => 1,
            bead::Path::Arc(_) => ARC_LINES,
        };
        let end = |number: usize| -> Point2<f64> { path.at(number as f64 / count as f64).xy() };
        let width = printed.bead.width(printed.height);
        self.strips.extend((0..count).map(|number| Strip {
            from: end(number),
            to: end(number + 1),
            width,
            is_infill,
        }));
    }
}

/// What `profile.json` holds.
#[derive(Debug, Serialize)]
struct ProfileJson {
    axis: &'static str,
    bin: f64,
    bins: Vec<BinJson>,
    /// Obtained less wanted in percent of the mean wanted.
    rms_percent: f64,
    max_percent: f64,
}

#[derive(Debug, Serialize)]
struct BinJson {
    from: f64,
    to: f64,
    as_sliced: f64,
    wanted: f64,
    obtained: f64,
}

/// The axis of the profile: 0, 1 or 2.
pub(crate) fn profile_axis(options: &PrintOptions, bounds: &Bounds<3>) -> usize {
    let named = options.report_axis.as_deref();
    let place = named.and_then(|name| ["x", "y", "z"].iter().position(|axis| *axis == name));
    place.unwrap_or_else(|| bounds.extent().imax())
}

/// Writes the report of the file that was written; `wanted` are the flow's volumes.
pub(crate) fn write(directory: &Path, task: &mut Task<'_>, wanted: &Bins) -> Result<(), Failure> {
    let (sliced, z) = sliced(task, wanted.emptied())?;
    let (obtained, strips) = obtained(task, wanted.emptied(), z)?;
    let bins = joined(wanted, &sliced, &obtained);
    fs::create_dir_all(directory)
        .map_err(|error| Failure::run(format!("cannot make {}: {error}", directory.display())))?;
    let axis = ["x", "y", "z"][wanted.axis];
    let title = format!("the layer at z = {z:.3} mm");
    write_picture(directory, "layer", &layer(&strips, &title))?;
    write_picture(directory, "profile", &profile(&bins, axis))?;
    write_tables(directory, axis, &bins)
}

/// The infill as sliced, and the nozzle's height in the layer to show.
fn sliced(task: &mut Task<'_>, mut bins: Bins) -> Result<(Bins, f64), Failure> {
    let middle = task.part.bounds.center().z;
    let z = task.options.report_layer.unwrap_or(middle);
    let infill = task.infill.clone();
    let (source, survey, given) = task.source()?;
    let mut nearest = f64::INFINITY;
    each_bead(source, survey, given, &mut |name, printed| {
        if infill.has(name) {
            bins.add_bead(printed);
            let height = printed.bead.path.last_z();
            if (height - z).abs() < (nearest - z).abs() {
                nearest = height;
            }
        }
    })
    .map_err(Failure::run)?;
    Ok((bins, nearest))
}

/// The infill of the written file, and the beads of its layer at `z`.
fn obtained(task: &mut Task<'_>, mut bins: Bins, z: f64) -> Result<(Bins, Vec<Strip>), Failure> {
    let infill = task.infill.clone();
    let (_, _, given) = task.source()?;
    let strips = Vec::new();
    let mut layer = LayerStrips { z, strips };
    let mut file = File::open(&task.options.output).map_err(Failure::run)?;
    let survey = examine(&mut file).map_err(Failure::run)?;
    each_bead(&mut file, survey, given, &mut |name, printed| {
        let is_infill = infill.has(name);
        if is_infill {
            bins.add_bead(printed);
        }
        layer.add(printed, is_infill);
    })
    .map_err(Failure::run)?;
    Ok((bins, layer.strips))
}

fn joined(wanted: &Bins, sliced: &Bins, obtained: &Bins) -> Vec<Bin> {
    let bin = |place: usize| Bin {
        from: wanted.from + place as f64 * BIN,
        to: wanted.from + (place + 1) as f64 * BIN,
        as_sliced: sliced.volumes[place],
        wanted: wanted.volumes[place],
        obtained: obtained.volumes[place],
    };
    (0..wanted.volumes.len()).map(bin).collect()
}

fn write_picture(directory: &Path, name: &str, figure: &Figure) -> Result<(), Failure> {
    let put = |ending: &str, bytes: &[u8]| {
        let path = directory.join(format!("{name}.{ending}"));
        write_file(&path, |file| file.write_all(bytes)).map_err(Failure::run)
    };
    put("svg", svg::svg(figure).as_bytes())?;
    put("png", &png::png(figure, PNG_SCALE).map_err(Failure::run)?)
}

fn write_tables(directory: &Path, axis: &'static str, bins: &[Bin]) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(&ProfileJson::of(axis, bins)).map_err(Failure::run)?;
    for (name, text) in [("profile.csv", csv(bins)), ("profile.json", json + "\n")] {
        let path = directory.join(name);
        write_file(&path, |file| file.write_all(text.as_bytes())).map_err(Failure::run)?;
    }
    Ok(())
}

fn csv(bins: &[Bin]) -> String {
    let mut csv = "from,to,as_sliced,wanted,obtained\n".to_owned();
    for bin in bins {
        let (sliced, wanted, obtained) = (bin.as_sliced, bin.wanted, bin.obtained);
        csv += &format!("{},{},{sliced},{wanted},{obtained}\n", bin.from, bin.to);
    }
    csv
}

impl ProfileJson {
    fn of(axis: &'static str, bins: &[Bin]) -> Self {
        let mean = bins.iter().map(|bin| bin.wanted).sum::<f64>() / bins.len() as f64;
        let errors = || {
            let off = |bin: &Bin| 100.0 * (bin.obtained - bin.wanted) / mean;
            bins.iter().map(off)
        };
        let squares: f64 = errors().map(|error| error * error).sum();
        Self {
            axis,
            bin: BIN,
            bins: bins.iter().map(BinJson::of).collect(),
            rms_percent: (squares / bins.len() as f64).sqrt(),
            max_percent: errors().map(f64::abs).fold(0.0, f64::max),
        }
    }
}

impl BinJson {
    fn of(bin: &Bin) -> Self {
        Self {
            from: bin.from,
            to: bin.to,
            as_sliced: bin.as_sliced,
            wanted: bin.wanted,
            obtained: bin.obtained,
        }
    }
}
