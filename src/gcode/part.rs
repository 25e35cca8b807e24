//! The part on the bed by a first reading: its box, its first layer, its infill.

use std::io::{Read, Seek};

use nalgebra::{Point2, Point3, Vector2, Vector3};

use crate::gcode::bead::{Bead, Path};
use crate::gcode::error::GcodeError;
use crate::gcode::filling::local_filling;
use crate::gcode::infill::InfillTypes;
use crate::gcode::labels::is_part;
use crate::gcode::lines::Lines;
use crate::gcode::reader::{Printed, Reader};
use crate::gcode::settings::Filament;
use crate::gcode::survey::Survey;
use crate::gcode::words::Words;
use crate::geometry::bounds::Bounds;

/// Heights closer than this (mm) are one layer.
const SAME: f64 = 1e-3;

/// Corners of a bead along an arc, one for each so many radians.
const ARC_STEP: f64 = 0.1;

/// The part and its infill, as sliced.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    /// The box of the part's beads; those with round sides, as slicers count their width.
    pub(crate) bounds: Bounds<3>,
    /// Feature types in the order of their appearance.
    pub(crate) types: Vec<String>,
    /// mm³ of infill.
    pub(crate) infill: f64,
    /// The share of space that infill fills, measured where it fills most of a layer.
    pub(crate) filling: Option<f64>,
    /// Corners of the beads of the part's lowest layer (mm).
    pub(crate) footprint: Vec<Point2<f64>>,
    /// Where that layer lies on the bed (mm).
    pub(crate) ground: f64,
}

/// Visits all beads of `source`, which `survey` has been through, with their feature types; returns the
/// types.
pub(crate) fn each_bead<R: Read + Seek>(
    source: &mut R,
    survey: Survey,
    given: Filament,
    visit: &mut dyn FnMut(&str, &Printed),
) -> Result<Vec<String>, GcodeError> {
    source.rewind()?;
    let mut lines = Lines::new(source);
    let (mut reader, mut words) = (Reader::new(survey, given), Words::new());
    while let Some(line) = lines.next()? {
        if let Some(printed) = reader.line(&line, &mut words)? {
            let name = &reader.types.list()[reader.kinds[printed.kind].feature];
            visit(name, &printed);
        }
    }
    let lines = lines.count();
    let types = reader.types.list();
    if types.is_empty() {
        return Err(GcodeError::Nothing { lines });
    }
    Ok(types.to_vec())
}

/// Reads all of `source`, which `survey` has been through.
pub(crate) fn part<R: Read + Seek>(
    source: &mut R,
    survey: Survey,
    given: Filament,
    infill: &InfillTypes,
) -> Result<Part, GcodeError> {
    let mut scan = Scan::new();
    let types = each_bead(source, survey, given, &mut |name, printed| {
        let is_infill = infill.has(name);
        if is_part(name) || is_infill {
            scan.add(printed, is_infill);
        }
    })?;
    Ok(scan.finish(types))
}

/// Where the part's beads are lowest along `up`, and their corners within a `share` of its height above.
pub(crate) fn contacts<R: Read + Seek>(
    source: &mut R,
    survey: Survey,
    given: Filament,
    infill: &InfillTypes,
    up: &Vector3<f64>,
    share: f64,
) -> Result<(f64, Vec<Point3<f64>>), GcodeError> {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut points = Vec::new();
    each_bead(
        source,
        survey.clone(),
        given.clone(),
        &mut |name, printed| {
            for point in ends(name, printed, infill) {
                let height = up.dot(&point.coords);
                low = low.min(height);
                high = high.max(height);
            }
        },
    )?;
    let most = low + share * (high - low) + SAME;
    each_bead(source, survey, given, &mut |name, printed| {
        let near = |point: &Point3<f64>| up.dot(&point.coords) <= most;
        points.extend(ends(name, printed, infill).into_iter().filter(near));
    })?;
    Ok((low, points))
}

/// The corners of a bead of the part, above and below.
fn ends(name: &str, printed: &Printed, infill: &InfillTypes) -> Vec<Point3<f64>> {
    if !(is_part(name) || infill.has(name)) {
        return Vec::new();
    }
    let top = printed.bead.path.last_z();
    let half = printed.bead.width(printed.height) / 2.0;
    let corners = corners(&printed.bead, half).into_iter();
    let heights = [top, top - printed.height];
    let both = |corner: Point2<f64>| heights.map(|z| Point3::new(corner.x, corner.y, z));
    corners.flat_map(both).collect()
}

/// The sums of a reading.
struct Scan {
    bounds: Bounds<3>,
    footprint: Vec<Point2<f64>>,
    ground: f64,
    infill: f64,
    layer: InfillLayer,
    fullest: InfillLayer,
}

/// The infill of one layer.
#[derive(Clone, Debug, Default)]
struct InfillLayer {
    z: f64,
    volume: f64,
    height: f64,
    paths: Vec<Path>,
}

impl Scan {
    fn new() -> Self {
        Self {
            bounds: Bounds::empty(),
            footprint: Vec::new(),
            ground: f64::INFINITY,
            infill: 0.0,
            layer: InfillLayer::default(),
            fullest: InfillLayer::default(),
        }
    }

    fn add(&mut self, printed: &Printed, is_infill: bool) {
        let (bead, height) = (&printed.bead, printed.height);
        let width = bead.width(height);
        let round = (1.0 - std::f64::consts::FRAC_PI_4) * height;
        let top = bead.path.last_z();
        let corners = corners(bead, (width + round) / 2.0);
        for corner in &corners {
            for z in [top - height, top] {
                self.bounds.include(&Point3::new(corner.x, corner.y, z));
            }
        }
        self.stand(bead, width, top - height);
        if is_infill {
            self.fill(printed);
        }
    }

    /// The first layer is the lowest.
    fn stand(&mut self, bead: &Bead, width: f64, bottom: f64) {
        if bottom < self.ground - SAME {
            self.ground = bottom;
            self.footprint.clear();
        }
        if bottom <= self.ground + SAME {
            self.footprint.extend(corners(bead, width / 2.0));
        }
    }

    fn fill(&mut self, printed: &Printed) {
        self.infill += printed.bead.volume;
        let z = printed.bead.path.last_z();
        if (z - self.layer.z).abs() > SAME {
            self.close_layer();
            self.layer.z = z;
        }
        self.layer.volume += printed.bead.volume;
        self.layer.height = printed.height;
        self.layer.paths.push(printed.bead.path);
    }

    fn close_layer(&mut self) {
        let layer = std::mem::take(&mut self.layer);
        if layer.volume > self.fullest.volume {
            self.fullest = layer;
        }
    }

    fn finish(mut self, types: Vec<String>) -> Part {
        self.close_layer();
        let fullest = &self.fullest;
        Part {
            bounds: self.bounds,
            types,
            infill: self.infill,
            filling: local_filling(&fullest.paths, fullest.volume, fullest.height),
            footprint: self.footprint,
            ground: self.ground,
        }
    }
}

/// The corners of a bead seen from above, half its width beside its path.
fn corners(bead: &Bead, half: f64) -> Vec<Point2<f64>> {
    let beside = |point: Point3<f64>, across: Vector2<f64>| {
        [1.0, -1.0].map(|side| point.xy() + across * (side * half))
    };
    match &bead.path {
        Path::Line { from, to } => {
            let along = (to - from).xy();
            let across = Vector2::new(-along.y, along.x).try_normalize(0.0);
            let across = across.unwrap_or_default();
            [beside(*from, across), beside(*to, across)].concat()
        }
        Path::Arc(arc) => {
            let count = (arc.sweep.abs() / ARC_STEP).ceil().clamp(1.0, 1000.0) as u32;
            let points = (0..=count).map(|k| bead.path.at(f64::from(k) / f64::from(count)));
            let corners = points.flat_map(|point| {
                let out = (point.xy().coords - arc.center).try_normalize(0.0);
                beside(point, out.unwrap_or_default())
            });
            corners.collect()
        }
    }
}
