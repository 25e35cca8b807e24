//! The options of `chebloyd print`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use nalgebra::Vector3;

use crate::cli::mass_report::{AxisMoment, axis, positive};
use crate::cli::options::finite;
use crate::gcode::pace::Pace;

/// What --stable exceeds the other moments by if nothing is said.
const STABLE_SHARE: &str = "0.01";

/// Vary the flow of a print's infill, so that it weighs, stands or spins as wanted
///
/// Every infill move is split into pieces whose filament follows a field: 1 prints as sliced. Walls, skins
/// and supports stay as they are. --stand and --spin find the multipliers of the pieces themselves, walls
/// and skins included: the print, not the solid, balances. The file is weighed again after it is written,
/// and wanted and obtained mass, center and inertia are told. Nothing is written, and the exit code is 1,
/// where --range or full filling (100 % of space at a place) would change the multipliers, unless --clip
/// is given.
#[derive(Debug, Args)]
pub(crate) struct PrintOptions {
    /// The sliced print, plain G-code
    #[arg(value_name = "IN.gcode")]
    pub(crate) file: PathBuf,
    /// The file to write
    #[arg(long, short, value_name = "OUT.gcode")]
    pub(crate) output: PathBuf,
    /// What multiplies the flow, as in `mass`: a formula in bed coordinates such as '0.5 + 0.01*x',
    /// 'linear:axis=x,from=0.5,to=1.5' over the part's box, 'profile:axis=x,0=0.5,100=1.5' with mm
    /// from where that box begins, or a field file '@field.json' of stand or spin
    #[arg(long, value_name = "FIELD", allow_hyphen_values = true,
          required_unless_present_any = ["stand", "spin"], conflicts_with_all = ["stand", "spin"])]
    pub(crate) density: Option<String>,
    /// The field's value that prints as sliced, or `mean`: infill as much as sliced in all [default: 1]
    #[arg(long, value_name = "V|mean", value_parser = relative_to)]
    pub(crate) relative_to: Option<Relative>,
    /// Where the field's origin lies on the bed [default: field files by the boxes' middles, else 0,0,0]
    #[arg(long, value_name = "DX,DY,DZ", value_parser = three, allow_hyphen_values = true)]
    pub(crate) place: Option<[f64; 3]>,
    /// The least and the greatest multiplier; HI may be inf [default: 0,inf; with --stand and --spin
    /// the least range about 1 that suffices, times 1.5]. Full filling always bounds it
    #[arg(long, value_name = "LO,HI", value_parser = multiplier_range)]
    pub(crate) range: Option<[f64; 2]>,
    /// Write the file even where multipliers are clipped
    #[arg(long)]
    pub(crate) clip: bool,
    /// How long the pieces are (mm)
    #[arg(long, value_name = "MM", default_value = "2", value_parser = step)]
    pub(crate) step: f64,
    /// What stays: the speed, or the flow in mm³/s (the speed then changes, F ∝ 1/multiplier: for
    /// Bowden extruders)
    #[arg(long, value_name = "WHAT", value_enum, default_value_t = Keep::Speed)]
    pub(crate) keep: Keep,
    /// mm³/s that the hotend melts: changed pieces above it are slowed down
    #[arg(long, value_name = "Q", value_parser = positive)]
    pub(crate) max_flow: Option<f64>,
    /// mm/s that pieces made faster by --keep flow do not exceed
    #[arg(long, value_name = "V", value_parser = positive)]
    pub(crate) max_speed: Option<f64>,
    /// The feature types to modulate, named as in the file [default: Internal infill, Sparse infill, FILL]
    #[arg(long, value_name = "TYPE", value_delimiter = ',')]
    pub(crate) infill: Vec<String>,
    /// The share of space that infill fills as sliced, in percent [default: the file's, else measured]
    #[arg(long, value_name = "PERCENT", value_parser = percent)]
    pub(crate) filling: Option<f64>,
    /// Filament's diameter in mm, one for all tools or one for each [default: the file's, else 1.75]
    #[arg(long, value_name = "MM,…", value_delimiter = ',', value_parser = positive)]
    pub(crate) filament: Vec<f64>,
    /// Write pictures and tables there: a layer's deposit, and the profile along an axis
    #[arg(long, value_name = "DIR")]
    pub(crate) report: Option<PathBuf>,
    /// The axis of the report's profile [default: the part's longest side]
    #[arg(long, value_name = "AXIS", value_parser = ["x", "y", "z"], requires = "report")]
    pub(crate) report_axis: Option<String>,
    /// The height of the report's layer in mm [default: the middle of the part]
    #[arg(long, value_name = "Z", requires = "report")]
    pub(crate) report_layer: Option<f64>,
    /// Replace files that are there, never the input
    #[arg(long)]
    pub(crate) force: bool,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) balance: BalanceOptions,
}

/// What stays as it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Keep {
    /// The speed
    Speed,
    /// The flow in mm³/s
    Flow,
}

/// The field's value that counts as 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Relative {
    Value(f64),
    Mean,
}

/// What the print is to do, in bed coordinates.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Balance, in bed coordinates")]
pub(crate) struct BalanceOptions {
    /// Find the multipliers with which the print stands: its center over what it stands on
    #[arg(long, conflicts_with = "spin")]
    pub(crate) stand: bool,
    /// Find the multipliers with which the print spins about --axis: its center on it, it principal
    #[arg(long, requires = "axis")]
    pub(crate) spin: bool,
    /// stand: the direction up when it stands: x, -z, … or a vector [default: z]
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    pub(crate) up: Option<Vector3<f64>>,
    /// stand: what lies within this share of the height above the lowest place touches the ground
    /// [default: the beads of the part's first layer]
    #[arg(long, value_name = "SHARE", value_parser = share)]
    pub(crate) contact: Option<f64>,
    /// stand: corners of what it stands on, `x,y` lines, instead of the contact's hull
    #[arg(long, value_name = "FILE", conflicts_with_all = ["contact", "point", "target"])]
    pub(crate) polygon: Option<PathBuf>,
    /// stand: on a point, or hung from it: the center over (X, Y)
    #[arg(long, value_name = "X,Y", value_parser = two, allow_hyphen_values = true,
          conflicts_with_all = ["contact", "target"])]
    pub(crate) point: Option<[f64; 2]>,
    /// stand: the center itself; `_` leaves a coordinate free, as in 97,_,_
    #[arg(long, value_name = "X,Y,Z", value_parser = target, allow_hyphen_values = true,
          conflicts_with = "contact")]
    pub(crate) target: Option<[Option<f64>; 3]>,
    /// stand: how far within the contact's hull the center must lie (mm) [default: 0]
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    pub(crate) margin: Option<f64>,
    /// stand: by how many degrees the ground may tilt to any side [default: 0]
    #[arg(long, value_name = "DEGREES", value_parser = tilt)]
    pub(crate) tilt: Option<f64>,
    /// stand: the multipliers nearest to --prefer within --range, those of the least range that suffices,
    /// or those for the greatest tilt that --range allows [default: least-variance]
    #[arg(long, value_name = "GOAL", value_enum)]
    pub(crate) goal: Option<Goal>,
    /// spin: a point and a direction
    #[arg(long, value_name = "PX,PY,PZ,DX,DY,DZ", value_parser = axis,
          allow_hyphen_values = true)]
    pub(crate) axis: Option<AxisMoment>,
    /// spin: also the place of the center along the axis: its distance from the axis's point
    #[arg(long, value_name = "Z", value_parser = finite, allow_hyphen_values = true)]
    pub(crate) center_at: Option<f64>,
    /// spin: also the axis's moment the largest, by this share of the others (without a number 0.01)
    #[arg(long, value_name = "SHARE", num_args = 0..=1, require_equals = true,
          default_missing_value = STABLE_SHARE, value_parser = share)]
    pub(crate) stable: Option<f64>,
    /// stand, spin: the multiplier that pieces stay near to [default: 1, as sliced]
    #[arg(long, value_name = "D0", value_parser = positive)]
    pub(crate) prefer: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Goal {
    /// Nearest to --prefer
    LeastVariance,
    /// The least range about 1
    LeastContrast,
    /// The greatest tilt
    MostStable,
}

impl BalanceOptions {
    /// An option that is given where it has no meaning, and what it is for.
    fn misplaced(&self) -> Option<(&'static str, &'static str)> {
        let of_stand = [
            (self.up.is_some(), "--up"),
            (self.contact.is_some(), "--contact"),
            (self.polygon.is_some(), "--polygon"),
            (self.point.is_some(), "--point"),
            (self.target.is_some(), "--target"),
            (self.margin.is_some(), "--margin"),
            (self.tilt.is_some(), "--tilt"),
            (self.goal.is_some(), "--goal"),
        ];
        let of_spin = [
            (self.axis.is_some(), "--axis"),
            (self.center_at.is_some(), "--center-at"),
            (self.stable.is_some(), "--stable"),
        ];
        let of_both = [(self.prefer.is_some(), "--prefer")];
        let first = |options: &[(bool, &'static str)], is_asked: bool, owner| {
            let given = options.iter().find(|(is_given, _)| *is_given && !is_asked);
            given.map(|(_, name)| (*name, owner))
        };
        first(&of_stand, self.stand, "--stand")
            .or(first(&of_spin, self.spin, "--spin"))
            .or(first(
                &of_both,
                self.stand || self.spin,
                "--stand and --spin",
            ))
    }
}

impl PrintOptions {
    /// An option that is given where it has no meaning, and what it is for.
    pub(crate) fn misplaced(&self) -> Option<(&'static str, &'static str)> {
        let of_field = [
            (self.relative_to.is_some(), "--relative-to"),
            (self.place.is_some(), "--place"),
            (self.clip, "--clip"),
        ];
        let is_given = |(is_given, _): &&(bool, &str)| *is_given && self.density.is_none();
        let of_field = of_field
            .iter()
            .find(is_given)
            .map(|(_, name)| (*name, "--density"));
        self.balance.misplaced().or(of_field)
    }

    pub(crate) fn pace(&self) -> Pace {
        Pace {
            keep_flow: self.keep == Keep::Flow,
            max_flow: self.max_flow,
            max_speed: self.max_speed,
        }
    }
}

fn relative_to(text: &str) -> Result<Relative, String> {
    if text.trim().eq_ignore_ascii_case("mean") {
        return Ok(Relative::Mean);
    }
    let value = positive(text).map_err(|_| "a positive number or `mean` is needed")?;
    Ok(Relative::Value(value))
}

fn three(text: &str) -> Result<[f64; 3], String> {
    let numbers: Vec<f64> = numbers(text)?;
    numbers
        .try_into()
        .map_err(|numbers: Vec<f64>| format!("three numbers are needed, not {}", numbers.len()))
}

/// Finite numbers separated by commas.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        word.trim()
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
    };
    let numbers: Option<_> = text.split(',').map(number).collect();
    numbers.ok_or_else(|| format!("numbers separated by commas are needed, not `{text}`"))
}

/// LO,HI with 0 ≤ LO ≤ HI.
fn multiplier_range(text: &str) -> Result<[f64; 2], String> {
    let words: Vec<_> = text
        .split(',')
        .map(|word| word.trim().parse::<f64>())
        .collect();
    match words[..] {
        [Ok(low), Ok(high)] if low >= 0.0 && low.is_finite() && high >= low && high > 0.0 => {
            Ok([low, high])
        }
        [Ok(low), Ok(high)] if high < low => Err(format!("LO {low} is above HI {high}")),
        [Ok(_), Ok(_)] => Err("a multiplier is not negative, and HI above zero".to_owned()),
        _ => Err("two numbers LO,HI are needed; HI may be inf".to_owned()),
    }
}

/// Pieces are no shorter than printers follow.
fn step(text: &str) -> Result<f64, String> {
    let step = positive(text)?;
    if step < 0.05 {
        return Err("pieces shorter than 0.05 mm make more moves than printers follow".to_owned());
    }
    Ok(step)
}

fn percent(text: &str) -> Result<f64, String> {
    let share = positive(text.trim().trim_end_matches('%'))? / 100.0;
    if share > 1.0 {
        return Err("more than 100 % cannot be filled".to_owned());
    }
    Ok(share)
}

fn direction(text: &str) -> Result<Vector3<f64>, String> {
    let (sign, name) = match text.trim().strip_prefix('-') {
        Some(name) => (-1.0, name),
        None => (1.0, text.trim()),
    };
    let place = ["x", "y", "z"]
        .iter()
        .position(|axis| name.eq_ignore_ascii_case(axis));
    if let Some(place) = place {
        return Ok(Vector3::ith(place, sign));
    }
    let numbers = numbers(text)?;
    match numbers[..] {
        [x, y, z] if Vector3::new(x, y, z).norm() > 0.0 => Ok(Vector3::new(x, y, z)),
        _ => Err("x, y, z with a sign, or three numbers not all zero are needed".to_owned()),
    }
}

fn two(text: &str) -> Result<[f64; 2], String> {
    let numbers = numbers(text)?;
    numbers
        .try_into()
        .map_err(|numbers: Vec<f64>| format!("two numbers are needed, not {}", numbers.len()))
}

/// Three coordinates, `_` for a free one.
fn target(text: &str) -> Result<[Option<f64>; 3], String> {
    let mut target = Vec::new();
    for word in text.split(',') {
        target.push(match word.trim() {
            "_" => None,
            word => Some(finite(word)?),
        });
    }
    let count = target.len();
    let target: [Option<f64>; 3] = target
        .try_into()
        .map_err(|_| format!("three coordinates are needed, not {count}; `_` frees one"))?;
    if target == [None; 3] {
        return Err("one coordinate at least must not be `_`".to_owned());
    }
    Ok(target)
}

fn share(text: &str) -> Result<f64, String> {
    match finite(text)? {
        share if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("a share lies between 0 and 1".to_owned()),
    }
}

fn tilt(text: &str) -> Result<f64, String> {
    match finite(text)? {
        degrees if (0.0..90.0).contains(&degrees) => Ok(degrees),
        _ => Err("degrees from 0 to below 90 are needed".to_owned()),
    }
}
