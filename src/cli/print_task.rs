//! A print that is modulated: its file, what a first reading says, and trials of flows.

use std::fs::File;
use std::io::{self, Seek};

use nalgebra::Point3;

use crate::cli::failure::Failure;
use crate::cli::print_options::PrintOptions;
use crate::cli::print_weights::{Filling, Weights};
use crate::export::atomic_write;
use crate::gcode::error::GcodeError;
use crate::gcode::flow::Flow;
use crate::gcode::infill::InfillTypes;
use crate::gcode::modulate::{ModulateError, Modulated, Modulation, modulate};
use crate::gcode::part::{Part, part};
use crate::gcode::reader::examine;
use crate::gcode::settings::{Filament, PerTool};
use crate::gcode::stale::Change;
use crate::gcode::survey::Survey;
use crate::gcode::weigh::weigh;

/// One call of the command: the file, and what a first reading says.
pub(crate) struct Task<'a> {
    pub(crate) options: &'a PrintOptions,
    file: File,
    survey: Survey,
    given: Filament,
    pub(crate) infill: InfillTypes,
    pub(crate) part: Part,
    pub(crate) filling: Filling,
}

/// How the pieces of a run are multiplied.
#[derive(Clone, Copy)]
pub(crate) struct Run<'a> {
    pub(crate) flow: &'a dyn Flow,
    pub(crate) limits: [f64; 2],
    pub(crate) change: Option<&'a Change>,
}

impl<'a> Task<'a> {
    pub(crate) fn open(options: &'a PrintOptions) -> Result<Self, Failure> {
        let path = options.file.display();
        let refuse = |error: GcodeError| Failure::input(format!("{path}: {error}"));
        let mut file = File::open(&options.file)
            .map_err(|error| Failure::input(format!("{path}: cannot be read: {error}")))?;
        let survey = examine(&mut file).map_err(refuse)?;
        let given = Filament {
            diameters: PerTool::new(options.filament.iter().copied()),
            densities: PerTool::default(),
        };
        let infill = InfillTypes::new(options.infill.iter().cloned());
        let part = part(&mut file, survey.clone(), given.clone(), &infill).map_err(refuse)?;
        if part.infill <= 0.0 {
            return Err(Failure::input(format!(
                "{path}: {}",
                no_infill(&part, &infill)
            )));
        }
        let filling = Filling::of(options.filling, survey.settings.filling, part.filling);
        Ok(Self {
            options,
            file,
            survey,
            given,
            infill,
            part,
            filling,
        })
    }

    /// The range that is asked for, within full filling.
    pub(crate) fn limits(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        let most = high.min(self.filling.limit());
        [low.min(most), most]
    }

    fn modulate(&mut self, run: Run<'_>, out: impl io::Write) -> Result<Modulated, ModulateError> {
        let modulation = Modulation {
            infill: &self.infill,
            step: self.options.step,
            flow: run.flow,
            limits: run.limits,
            pace: self.options.pace(),
            nozzle: self.survey.settings.nozzles.get(0),
            change: run.change,
            near: self.near(),
        };
        let (survey, given) = (self.survey.clone(), self.given.clone());
        modulate(&mut self.file, survey, given, &modulation, out)
    }

    /// Where moments are measured from.
    pub(crate) fn near(&self) -> Point3<f64> {
        self.part.bounds.center()
    }

    /// What a flow would bring about, without writing it.
    pub(crate) fn tried(
        &mut self,
        flow: &dyn Flow,
        limits: [f64; 2],
    ) -> Result<Modulated, Failure> {
        let run = Run {
            flow,
            limits,
            change: None,
        };
        let path = self.options.file.display().to_string();
        self.modulate(run, io::sink())
            .map_err(|error| Failure::input(format!("{path}: {error}")))
    }

    /// Writes the output as a whole or not at all.
    pub(crate) fn write(&mut self, run: Run<'_>) -> Result<(), Failure> {
        let output = self.options.output.clone();
        let mut fault = None;
        let written = atomic_write::write(&output, |out| {
            self.modulate(run, out)
                .map(drop)
                .map_err(|error| match error {
                    ModulateError::Write(error) => error,
                    ModulateError::Gcode(error) => {
                        let text = error.to_string();
                        fault = Some(error);
                        io::Error::other(text)
                    }
                })
        });
        match (written, fault) {
            (Ok(()), _) => Ok(()),
            (Err(_), Some(fault)) => Err(Failure::input(format!(
                "{}: changed while it was read: {fault}",
                self.options.file.display()
            ))),
            (Err(error), None) => Err(Failure::run(format!(
                "cannot write {}: {error}",
                output.display()
            ))),
        }
    }

    /// Weighs the written file; with its notes.
    pub(crate) fn weighed_again(&self) -> Result<(Weights, Vec<String>), Failure> {
        let path = self.options.output.display();
        let again =
            |error: &dyn std::fmt::Display| Failure::run(format!("{path}, read again: {error}"));
        let mut file = File::open(&self.options.output).map_err(|error| again(&error))?;
        let weighed = weigh(&mut file, self.given.clone()).map_err(|error| again(&error))?;
        let weights = Weights::read_back(&weighed, &self.infill, &self.near());
        Ok((weights, weighed.notes))
    }

    /// The file from its beginning, and what a first reading says.
    pub(crate) fn source(&mut self) -> Result<(&mut File, Survey, Filament), Failure> {
        self.file.rewind().map_err(Failure::run)?;
        Ok((&mut self.file, self.survey.clone(), self.given.clone()))
    }
}

fn no_infill(part: &Part, infill: &InfillTypes) -> String {
    let types: Vec<_> = part.types.iter().map(|name| format!("'{name}'")).collect();
    format!(
        "no infill to modulate: {} prints nothing; the file has the feature types {}; choose by --infill",
        infill.names().join(", "),
        types.join(", ")
    )
}
