//! Densities read from the text of `--density`.

use std::str::FromStr;

use nalgebra::{Point3, Vector3};

use crate::integrals::polynomial::Polynomial;
use crate::mass::density::{DensityError, Ramp, SolidDensity, VertexRamp};
use crate::mass::profile::Profile;

const LINEAR: &str = "linear:axis=z,from=0,to=1";
const PROFILE: &str = "profile:axis=z,0.2=1,0.8=5";
const RAMP: &str = "ramp:direction=0,0,1,from=0.2,to=0.8,low=1,high=5";

impl FromStr for SolidDensity {
    type Err = DensityError;

    fn from_str(text: &str) -> Result<Self, DensityError> {
        let text = text.trim();
        if let Some(inside) = text.strip_prefix("clamp(") {
            return clamp_text(text, inside);
        }
        match text.split_once(':') {
            Some(("linear", settings)) => ramp(settings).map(Self::Ramp),
            Some(("profile", settings)) => profile(settings).map(Self::Profile),
            Some(("ramp", settings)) => directed_ramp(settings),
            Some(("vertex", name)) => Ok(Self::Vertex(Some(name.trim().into()))),
            Some((kind, _)) => Err(DensityError::Kind { kind: kind.into() }),
            None if text == "vertex" => Ok(Self::Vertex(None)),
            None => number_or_polynomial(text),
        }
    }
}

fn number_or_polynomial(text: &str) -> Result<SolidDensity, DensityError> {
    let polynomial: Polynomial = text.parse().map_err(|error| DensityError::Polynomial {
        text: text.into(),
        error,
    })?;
    if polynomial.degree() == 0 {
        return Ok(SolidDensity::Constant(polynomial.at(&Point3::origin())));
    }
    Ok(SolidDensity::Polynomial(polynomial))
}

fn ramp(settings: &str) -> Result<Ramp, DensityError> {
    let (mut axis, mut from, mut to) = (None, None, None);
    for setting in settings.split(',') {
        match key_and_value(setting) {
            Some(("axis", value)) => axis = Some(axis_named(value)?),
            Some(("from", value)) => from = Some(number(setting, value)?),
            Some(("to", value)) => to = Some(number(setting, value)?),
            _ => return Err(unknown("linear", setting, "`axis`, `from` and `to`")),
        }
    }
    let missing = |key| DensityError::Missing {
        kind: "linear",
        key,
        example: LINEAR,
    };
    Ok(Ramp {
        axis: axis.ok_or(missing("axis"))?,
        from: from.ok_or(missing("from"))?,
        to: to.ok_or(missing("to"))?,
    })
}

fn profile(settings: &str) -> Result<Profile, DensityError> {
    let mut axis = None;
    let mut breaks = Vec::new();
    for setting in settings.split(',') {
        match key_and_value(setting) {
            Some(("axis", value)) => axis = Some(axis_named(value)?),
            Some((position, density)) => {
                breaks.push([number(setting, position)?, number(setting, density)?]);
            }
            None => return Err(unknown("profile", setting, "`axis` and `position=density`")),
        }
    }
    let axis = axis.ok_or(DensityError::Missing {
        kind: "profile",
        key: "axis",
        example: PROFILE,
    })?;
    let direction = Vector3::from_fn(|row, _| if row == axis { 1.0 } else { 0.0 });
    Ok(Profile::new(&direction, breaks)?)
}

fn key_and_value(setting: &str) -> Option<(&str, &str)> {
    let (key, value) = setting.split_once('=')?;
    Some((key.trim(), value.trim()))
}

/// `clamp(LOW, HIGH, …)`, of which `inside` follows the bracket.
fn clamp_text(text: &str, inside: &str) -> Result<SolidDensity, DensityError> {
    let broken = || DensityError::Clamp { text: text.into() };
    let inside = inside.strip_suffix(')').ok_or_else(broken)?;
    let mut parts = inside.splitn(3, ',').map(str::trim);
    let (Some(low), Some(high), Some(of)) = (parts.next(), parts.next(), parts.next()) else {
        return Err(broken());
    };
    let end = |end: &str| end.parse::<f64>().map_err(|_| broken());
    let (low, high) = (end(low)?, end(high)?);
    if !(low.is_finite() && low < high) {
        return Err(DensityError::ClampRange { low, high });
    }
    if let Some(name) = of.strip_prefix("vertex") {
        let name = match name.strip_prefix(':') {
            Some(name) => Some(name.trim().into()),
            None if name.is_empty() => None,
            None => return Err(broken()),
        };
        let (from, width) = (low, high - low);
        let slope = 1.0;
        return Ok(SolidDensity::VertexRamp(VertexRamp {
            name,
            from,
            width,
            low,
            slope,
        }));
    }
    let formula = || of.into();
    let of: Polynomial = of.parse().map_err(|error| DensityError::Polynomial {
        text: formula(),
        error,
    })?;
    let degree = of.degree();
    if degree > 1 {
        let text = formula();
        return Err(DensityError::ClampDegree { text, degree });
    }
    let value = of.at(&Point3::origin());
    let mut gradient = Vector3::zeros();
    for (exponents, coefficient) in of.terms() {
        if let Some(axis) = exponents.iter().position(|&power| power == 1) {
            gradient[axis] += coefficient;
        }
    }
    SolidDensity::clamp(low, high, value, &gradient)
}

fn directed_ramp(settings: &str) -> Result<SolidDensity, DensityError> {
    // The direction's own commas do not part settings.
    let mut parts: Vec<String> = Vec::new();
    for part in settings.split(',') {
        match parts.last_mut() {
            Some(last) if !part.contains('=') => *last += &format!(",{part}"),
            _ => parts.push(part.into()),
        }
    }
    let (mut along, mut name) = (None, None);
    let mut numbers = [None; 4];
    for setting in &parts {
        match key_and_value(setting) {
            Some(("direction", value)) => along = Some(direction_of(value)?),
            Some(("vertex", value)) => name = Some((!value.is_empty()).then(|| value.into())),
            Some((key, value)) => {
                let place = RAMP_NUMBERS.iter().position(|known| *known == key);
                let place = place.ok_or_else(|| unknown("ramp", setting, RAMP_KEYS))?;
                numbers[place] = Some(number(setting, value)?);
            }
            None => return Err(unknown("ramp", setting, RAMP_KEYS)),
        }
    }
    let missing = |key| DensityError::Missing {
        kind: "ramp",
        key,
        example: RAMP,
    };
    let value = |place: usize| numbers[place].ok_or(missing(RAMP_NUMBERS[place]));
    let ends = [[value(0)?, value(2)?], [value(1)?, value(3)?]];
    ramp_between(ends, along, name)?.ok_or(missing("direction"))
}

/// The numbers of a ramp: two places, then the densities there.
const RAMP_NUMBERS: [&str; 4] = ["from", "to", "low", "high"];

/// The ramp from a place with its density to another, along a direction or by vertex data; none of neither.
fn ramp_between(
    ends: [[f64; 2]; 2],
    along: Option<Vector3<f64>>,
    name: Option<Option<String>>,
) -> Result<Option<SolidDensity>, DensityError> {
    let [[from, low], [to, high]] = ends;
    let slope = (high - low) / (to - from);
    if !slope.is_finite() {
        return Err(DensityError::Level { from, to });
    }
    let [first, last] = if from < to { ends } else { [ends[1], ends[0]] };
    match (along, name) {
        (Some(direction), None) => {
            let profile = Profile::new(&direction, vec![first, last])?;
            Ok(Some(SolidDensity::Profile(profile)))
        }
        (None, Some(name)) => Ok(Some(SolidDensity::VertexRamp(VertexRamp {
            name,
            from: first[0],
            width: last[0] - first[0],
            low: first[1],
            slope,
        }))),
        (Some(_), Some(_)) => Err(unknown(
            "ramp",
            "vertex",
            "`direction` or `vertex`, not both",
        )),
        (None, None) => Ok(None),
    }
}

const RAMP_KEYS: &str = "`direction` (or `vertex`), `from`, `to`, `low` and `high`";

/// Three numbers between commas.
fn direction_of(text: &str) -> Result<Vector3<f64>, DensityError> {
    let numbers: Option<Vec<f64>> = text
        .split(',')
        .map(|part| part.trim().parse().ok())
        .collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Vector3::new(x, y, z)),
        _ => Err(DensityError::Direction { text: text.into() }),
    }
}

fn unknown(kind: &'static str, setting: &str, known: &'static str) -> DensityError {
    DensityError::Setting {
        kind,
        setting: setting.trim().into(),
        known,
    }
}

fn axis_named(name: &str) -> Result<usize, DensityError> {
    let axis = ["x", "y", "z"]
        .iter()
        .position(|axis| axis.eq_ignore_ascii_case(name));
    axis.ok_or(DensityError::Axis { axis: name.into() })
}

fn number(setting: &str, value: &str) -> Result<f64, DensityError> {
    match value.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(DensityError::Number {
            setting: setting.trim().into(),
            value: value.into(),
        }),
    }
}
