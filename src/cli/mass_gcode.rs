//! `chebloyd mass PART.gcode`: mass, center of mass and inertia of what a printer deposits.

use std::fs::File;
use std::path::Path;

use clap::Args;
use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};

use crate::cli::failure::{Failure, print};
use crate::cli::mass_report::{AxisMoment, MassProperties, figure, positive};
use crate::gcode::labels::is_part;
use crate::gcode::settings::{Filament, PerTool};
use crate::gcode::weigh::{Deposit, Weighed, weigh};
use crate::geometry::moments::Moments;
use crate::mass::body::Body;

/// The endings of names of G-code files; the last two are refused with the mend.
const ENDINGS: [&str; 6] = [".gcode", ".gco", ".gc", ".g", ".bgcode", ".gcode.3mf"];

/// Cubic millimeters in a cubic centimeter.
const PER_CM3: f64 = 1000.0;

/// Options for G-code.
#[derive(Debug, Args)]
#[command(next_help_heading = "G-code")]
pub(crate) struct GcodeOptions {
    /// Weigh these feature types only, named as in the file; several: repeat, or separate by commas
    #[arg(
        long,
        value_name = "TYPE",
        value_delimiter = ',',
        conflicts_with = "without"
    )]
    only: Vec<String>,
    /// Leave out these feature types, besides skirt, brim, raft, support, tower, purge and start code
    #[arg(long, value_name = "TYPE", value_delimiter = ',')]
    without: Vec<String>,
    /// Mass of a mm³ of plastic, one for all tools or one for each [default: 1]
    #[arg(long, value_name = "D,…", value_delimiter = ',', value_parser = not_negative)]
    material_density: Vec<f64>,
    /// Filament's density in g/cm³ for `grams`, one for all tools or one for each [default: the file's]
    #[arg(long, value_name = "D,…", value_delimiter = ',', value_parser = not_negative)]
    filament_density: Vec<f64>,
    /// Filament's diameter in mm, one for all tools or one for each [default: the file's, else 1.75]
    #[arg(
        long,
        visible_alias = "filament-diameter",
        value_name = "MM,…",
        value_delimiter = ',',
        value_parser = positive
    )]
    filament: Vec<f64>,
}

impl GcodeOptions {
    /// The first of these options that is given.
    pub(crate) fn first_given(&self) -> Option<&'static str> {
        let given = [
            (self.only.is_empty(), "--only"),
            (self.without.is_empty(), "--without"),
            (self.material_density.is_empty(), "--material-density"),
            (self.filament_density.is_empty(), "--filament-density"),
            (self.filament.is_empty(), "--filament"),
        ];
        given
            .into_iter()
            .find(|(is_empty, _)| !is_empty)
            .map(|(_, name)| name)
    }
}

/// What is asked of every kind of file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked<'a> {
    pub(crate) mass: Option<f64>,
    pub(crate) axis: Option<AxisMoment>,
    pub(crate) units: Option<&'a str>,
    pub(crate) json: bool,
}

/// What is printed, in this order.
#[derive(Debug, Serialize)]
struct PrintReport<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    units: Option<&'a str>,
    #[serde(flatten)]
    part: Weight,
    deposited: Weight,
    types: Listed<Share>,
    tools: Listed<Shares>,
    objects: Listed<Shares>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    notes: Vec<String>,
}

/// The part, or everything.
#[derive(Debug, Serialize)]
struct Weight {
    #[serde(flatten)]
    properties: MassProperties,
    #[serde(skip_serializing_if = "Option::is_none")]
    grams: Option<f64>,
}

/// A share of the plastic.
#[derive(Debug, Serialize)]
struct Share {
    volume: f64,
    /// `null` without plastic.
    center_of_mass: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    grams: Option<f64>,
}

/// A share of the part, and of everything.
#[derive(Debug, Serialize)]
struct Shares {
    #[serde(flatten)]
    part: Share,
    deposited: Share,
}

/// Names with their values, in the order of their appearance.
#[derive(Debug)]
struct Listed<T>(Vec<(String, T)>);

impl<T: Serialize> Serialize for Listed<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, value) in &self.0 {
            map.serialize_entry(name, value)?;
        }
        map.end()
    }
}

/// Whether the file's name is that of G-code.
pub(crate) fn is_gcode(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default();
    let name = name.to_string_lossy().to_ascii_lowercase();
    ENDINGS.iter().any(|ending| name.ends_with(ending))
}

/// Weighs a print and prints its report.
pub(crate) fn run(path: &Path, options: &GcodeOptions, asked: Asked<'_>) -> Result<(), Failure> {
    let refuse =
        |error: &dyn std::fmt::Display| Failure::input(format!("{}: {error}", path.display()));
    let mut file = File::open(path).map_err(|error| refuse(&error))?;
    let given = Filament {
        diameters: PerTool::new(options.filament.iter().copied()),
        densities: PerTool::new(options.filament_density.iter().copied()),
    };
    let weighed = weigh(&mut file, given).map_err(|error| refuse(&error))?;
    let scale = Scale::new(&weighed, options).map_err(|error| refuse(&error))?;
    let report = scale.report(asked).map_err(|error| refuse(&error))?;
    if asked.json {
        let text = serde_json::to_string_pretty(&report).map_err(Failure::run)?;
        return print(text + "\n");
    }
    print(report.table())
}

/// What was weighed, seen by the options.
#[derive(Debug)]
struct Scale<'a> {
    weighed: &'a Weighed,
    /// Whether each type belongs to the part.
    chosen: Vec<bool>,
    /// The densities of plastic by tool.
    material: Vec<f64>,
}

impl<'a> Scale<'a> {
    fn new(weighed: &'a Weighed, options: &GcodeOptions) -> Result<Self, String> {
        let types = weighed.types.list();
        let named = |names: &[String]| -> Result<Vec<bool>, String> {
            let places = names.iter().map(|name| find(types, name));
            let places = places.collect::<Result<Vec<_>, _>>()?;
            Ok((0..types.len())
                .map(|place| places.contains(&place))
                .collect())
        };
        let chosen = if options.only.is_empty() {
            let without = named(&options.without)?;
            let kept = types.iter().zip(without);
            kept.map(|(name, left)| is_part(name) && !left).collect()
        } else {
            named(&options.only)?
        };
        let scale = Self {
            weighed,
            chosen,
            material: options.material_density.clone(),
        };
        scale.check_tools()?;
        Ok(scale)
    }

    /// Densities are given for all tools or for each.
    fn check_tools(&self) -> Result<(), String> {
        let count = self.material.len();
        let beyond = |deposit: &&Deposit| count > 1 && deposit.tool as usize >= count;
        match self.weighed.deposits.iter().find(beyond) {
            Some(deposit) => Err(format!(
                "--material-density gives {count} values, from tool 0 on; tool {} prints too",
                deposit.tool
            )),
            None => Ok(()),
        }
    }

    fn density(&self, tool: u32) -> f64 {
        match &self.material[..] {
            [] => 1.0,
            [all] => *all,
            each => each[tool as usize],
        }
    }

    fn in_part(&self, deposit: &Deposit) -> bool {
        self.chosen[deposit.kind]
    }

    /// The plastic of some deposits as one body; `None` without mass.
    fn body(&self, which: impl Fn(&Deposit) -> bool) -> Option<Body> {
        let (mut volume, mut moments) = (0.0, Moments::default());
        for deposit in self
            .weighed
            .deposits
            .iter()
            .filter(|deposit| which(deposit))
        {
            volume += deposit.moments.mass;
            moments += deposit.moments * self.density(deposit.tool);
        }
        (moments.mass > 0.0).then(|| Body::from_moments(volume, 0.0, &moments, &self.weighed.near))
    }

    /// What some deposits weigh; `None` where a tool's filament has no density.
    fn grams(&self, which: impl Fn(&Deposit) -> bool) -> Option<f64> {
        let chosen = self
            .weighed
            .deposits
            .iter()
            .filter(|deposit| which(deposit));
        chosen
            .map(|deposit| {
                let density = self.weighed.filament.densities.get(deposit.tool)?;
                Some(deposit.moments.mass * density / PER_CM3)
            })
            .sum()
    }

    fn share(&self, which: impl Fn(&Deposit) -> bool + Copy) -> Share {
        let body = self.body(which);
        let chosen = self
            .weighed
            .deposits
            .iter()
            .filter(|deposit| which(deposit));
        Share {
            volume: chosen.map(|deposit| deposit.moments.mass).sum(),
            center_of_mass: body.map(|body| body.center_of_mass().into()),
            grams: self.grams(which),
        }
    }

    fn shares(&self, which: impl Fn(&Deposit) -> bool + Copy) -> Shares {
        Shares {
            part: self.share(|deposit| which(deposit) && self.in_part(deposit)),
            deposited: self.share(which),
        }
    }

    fn report(&self, asked: Asked<'a>) -> Result<PrintReport<'a>, String> {
        let part = self.body(|deposit| self.in_part(deposit));
        let part = part.ok_or_else(|| self.nothing())?;
        let all = self.body(|_| true).ok_or_else(|| self.nothing())?;
        let factor = asked.mass.map_or(1.0, |mass| mass / part.mass);
        let weight = |body: &Body, grams| {
            let body = body.weighing(body.mass * factor);
            let mut properties = MassProperties::of(&body, asked.axis);
            properties.totals.surface_area = None;
            Weight { properties, grams }
        };
        let names = |list: &[String]| list.iter().cloned().enumerate().collect::<Vec<_>>();
        let types = names(self.weighed.types.list()).into_iter();
        let objects = names(self.weighed.objects.list()).into_iter();
        let types = types.map(|(kind, name)| (name, self.share(|one| one.kind == kind)));
        let objects = objects.map(|(place, name)| {
            let shares = self.shares(|one| one.object == Some(place));
            (name, shares)
        });
        Ok(PrintReport {
            units: asked.units,
            part: weight(&part, self.grams(|deposit| self.in_part(deposit))),
            deposited: weight(&all, self.grams(|_| true)),
            types: Listed(types.collect()),
            tools: self.tools(),
            objects: Listed(objects.collect()),
            notes: self.notes(),
        })
    }

    fn tools(&self) -> Listed<Shares> {
        let mut tools: Vec<_> = self.weighed.deposits.iter().map(|one| one.tool).collect();
        tools.sort_unstable();
        tools.dedup();
        let shares = |tool: u32| (tool.to_string(), self.shares(|one| one.tool == tool));
        Listed(tools.into_iter().map(shares).collect())
    }

    fn nothing(&self) -> String {
        format!(
            "nothing of the part has mass; the file has the feature types {}; choose with --only",
            quoted(self.weighed.types.list())
        )
    }

    /// The file's notes, what is left out, and whether grams mislead.
    fn notes(&self) -> Vec<String> {
        let mut notes = self.weighed.notes.clone();
        let types = self.weighed.types.list().iter().enumerate();
        let left: Vec<_> = types
            .filter(|(kind, _)| !self.chosen[*kind])
            .map(|(kind, name)| {
                let volume = self.share(|one| one.kind == kind).volume;
                format!("{name} ({volume:.3} mm³)")
            })
            .collect();
        if !left.is_empty() {
            notes.push(format!("not in the part: {}", left.join(", ")));
        }
        let densities = &self.weighed.filament.densities;
        let mut used: Vec<_> = self
            .weighed
            .deposits
            .iter()
            .map(|one| densities.get(one.tool))
            .collect();
        used.dedup();
        if self.material.len() < 2 && used.len() > 1 {
            notes.push(
                "tools print filaments of different densities, which center and inertia do not know: \
                 give --material-density one value for each"
                    .into(),
            );
        }
        notes
    }
}

/// The place of the type `name`, whatever its case.
fn find(types: &[String], name: &str) -> Result<usize, String> {
    let is = |known: &String| known.eq_ignore_ascii_case(name.trim());
    types.iter().position(is).ok_or_else(|| {
        let there = quoted(types);
        format!(
            "no feature type '{}' prints anything here; there are {there}",
            name.trim()
        )
    })
}

fn quoted(names: &[String]) -> String {
    let names: Vec<_> = names.iter().map(|name| format!("'{name}'")).collect();
    names.join(", ")
}

impl PrintReport<'_> {
    fn table(&self) -> String {
        let mut text = self.part.properties.table();
        let mut line = |name: &str, value: f64| text += &format!("{name:<24}{}\n", figure(value));
        if let Some(grams) = self.part.grams {
            line("grams", grams);
        }
        line("deposited volume", self.deposited.properties.totals.volume);
        if let Some(grams) = self.deposited.grams {
            line("deposited grams", grams);
        }
        if let Some(units) = &self.units {
            text += &format!("{:<24}  {units}\n", "units");
        }
        text += &format!("{:<24}{:>20}{:>20}\n", "", "volume", "center of mass");
        for (name, share) in &self.types.0 {
            text += &share.line(&format!("type {name}"));
        }
        let several = |list: &Listed<Shares>| list.0.len() > 1;
        for (title, list) in [("tool", &self.tools), ("object", &self.objects)] {
            for (name, shares) in list.0.iter().filter(|_| title == "object" || several(list)) {
                text += &shares.part.line(&format!("{title} {name}"));
            }
        }
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }
}

impl Share {
    /// Volume, then the center of mass.
    fn line(&self, title: &str) -> String {
        let center = self.center_of_mass.unwrap_or_default().map(figure);
        let center = self
            .center_of_mass
            .map_or(String::new(), |_| center.concat());
        format!("{title:<24}{}{center}\n", figure(self.volume))
    }
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number >= 0.0 && number.is_finite() => Ok(number),
        _ => Err("a number of zero or more is needed".into()),
    }
}
