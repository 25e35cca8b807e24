//! The moments of everything a file deposits, by feature type, tool and object.

use std::io::{Read, Seek};

use nalgebra::Point3;

use crate::gcode::error::GcodeError;
use crate::gcode::labels::Names;
use crate::gcode::lines::Lines;
use crate::gcode::reader::{Kind, Printed, Reader, examine};
use crate::gcode::settings::Filament;
use crate::gcode::words::Words;
use crate::geometry::moments::Moments;

/// Beads added one after the other before their sum is: a million beads then round as two thousand.
const BLOCK: u32 = 512;

/// What is deposited of one type, by one tool, for one object.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deposit {
    /// Its place among the types.
    pub(crate) kind: usize,
    pub(crate) tool: u32,
    /// Its place among the objects.
    pub(crate) object: Option<usize>,
    /// Of density 1, in mm, measured from [`Weighed::near`].
    pub(crate) moments: Moments,
    /// Beads not yet in `moments`.
    block: Moments,
    count: u32,
}

/// All that a file deposits.
#[derive(Clone, Debug)]
pub(crate) struct Weighed {
    pub(crate) deposits: Vec<Deposit>,
    pub(crate) types: Names,
    pub(crate) objects: Names,
    /// A point of the first bead (mm).
    pub(crate) near: Point3<f64>,
    pub(crate) filament: Filament,
    /// What the reader should know.
    pub(crate) notes: Vec<String>,
}

/// Weighs the file `source`, read twice; what is `given` about the filament stands above what the
/// file says.
pub(crate) fn weigh<R: Read + Seek>(
    source: &mut R,
    given: Filament,
) -> Result<Weighed, GcodeError> {
    let survey = examine(source)?;
    let mut lines = Lines::new(source);
    let mut reader = Reader::new(survey, given);
    let mut words = Words::new();
    let mut sums = Sums::default();
    while let Some(line) = lines.next()? {
        if let Some(printed) = reader.line(&line, &mut words)? {
            sums.add(&printed, &reader.kinds);
        }
    }
    let lines = lines.count();
    let (deposits, near) = sums.finish().ok_or(GcodeError::Nothing { lines })?;
    Ok(Weighed {
        deposits,
        notes: reader.notes(),
        filament: reader.machine().filament().clone(),
        types: reader.types,
        objects: reader.objects,
        near,
    })
}

/// Moments by kinds of deposit.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sums {
    deposits: Vec<Deposit>,
    near: Option<Point3<f64>>,
}

impl Sums {
    /// Adds a bead, whose kind is one of `kinds`.
    pub(crate) fn add(&mut self, printed: &Printed, kinds: &[Kind]) {
        let bead = &printed.bead;
        let near = *self.near.get_or_insert_with(|| bead.path.middle());
        if self.deposits.len() < kinds.len() {
            let new = kinds[self.deposits.len()..].iter();
            self.deposits.extend(new.map(Deposit::new));
        }
        self.deposits[printed.kind].add(&bead.moments(printed.height, &near));
    }

    /// The sums, and the point that they are measured from; `None` without a bead.
    pub(crate) fn finish(mut self) -> Option<(Vec<Deposit>, Point3<f64>)> {
        for deposit in &mut self.deposits {
            deposit.settle();
        }
        Some((self.deposits, self.near?))
    }
}

impl Deposit {
    fn new(kind: &Kind) -> Self {
        Self {
            kind: kind.feature,
            tool: kind.tool,
            object: kind.object,
            moments: Moments::default(),
            block: Moments::default(),
            count: 0,
        }
    }

    fn add(&mut self, moments: &Moments) {
        self.block += *moments;
        self.count += 1;
        if self.count == BLOCK {
            self.settle();
        }
    }

    fn settle(&mut self) {
        self.moments += self.block;
        self.block = Moments::default();
        self.count = 0;
    }
}
