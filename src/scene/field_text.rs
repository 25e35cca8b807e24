//! Densities read from text: those that have closed integrals, radial ones and formulas.

use std::str::FromStr;

use nalgebra::Point3;

use crate::integrals::expression::Expression;
use crate::integrals::expression_text::ExpressionError;
use crate::integrals::polynomial_text::PolynomialError;
use crate::integrals::radial::{Radial, RadialKind};
use crate::mass::density::{DensityError, SolidDensity};

/// A density as its text gives it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum FieldText {
    /// With a closed integral over solids.
    Solid(SolidDensity),
    /// A function of the distance from a point.
    Radial(Radial),
    /// A formula.
    Formula(Expression),
    /// A formula sampled at the vertices of tetrahedra.
    Sampled(Expression),
}

/// Why a text is no density.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum FieldTextError {
    /// Of a kind with a closed integral.
    #[error(transparent)]
    Density(#[from] DensityError),
    /// Neither a kind nor a formula.
    #[error(
        "`{text}` is not a density: {error} (a density is a number, a polynomial or another formula \
         in x, y, z, r and distance, `vertex[:NAME]`, `vertex:=FORMULA`, a field file `@field.json`, \
         or one of the kinds linear:, profile:, ramp:, clamp(…), sine:, radial:; see --help)"
    )]
    Formula {
        /// The text.
        text: String,
        /// Why it is no formula.
        error: ExpressionError,
    },
    /// Settings of a radial density.
    #[error("`{text}` is not a `{kind}` density: {reason}, as in `{example}`")]
    Radial {
        /// The text.
        text: String,
        /// The kind.
        kind: &'static str,
        /// What is wrong.
        reason: String,
        /// A complete one.
        example: &'static str,
    },
}

const SINE: &str = "sine:point=0,0,0.5,k=20";
const RADIAL: &str = "radial:point=0,0,0.5,0.2=1,0.8=5";

impl FromStr for FieldText {
    type Err = FieldTextError;

    fn from_str(text: &str) -> Result<Self, FieldTextError> {
        let text = text.trim();
        if let Some(formula) = text.strip_prefix("vertex:=") {
            return expression(text, formula).map(Self::Sampled);
        }
        for kind in ["sine", "radial"] {
            if let Some((_, settings)) = text.split_once(':').filter(|(name, _)| *name == kind) {
                return radial(text, settings, kind).map(Self::Radial);
            }
        }
        match text.parse() {
            Ok(density) => Ok(Self::Solid(density)),
            Err(DensityError::Polynomial { error, text: of }) if may_be_formula(&error) => {
                match expression(text, text) {
                    Ok(formula) => Ok(Self::Formula(formula)),
                    Err(refused) if of == text => Err(refused),
                    Err(_) => Err(DensityError::Polynomial { error, text: of }.into()),
                }
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// Whether what is no polynomial may be another formula: not where a polynomial is refused for its size.
fn may_be_formula(error: &PolynomialError) -> bool {
    match error {
        PolynomialError::Unexpected { .. } | PolynomialError::Number { .. } => true,
        PolynomialError::DivisionByZero { .. }
        | PolynomialError::Degree { .. }
        | PolynomialError::Overflow
        | PolynomialError::Depth { .. } => false,
    }
}

fn expression(text: &str, formula: &str) -> Result<Expression, FieldTextError> {
    let skipped = text.len() - formula.len();
    let parsed = formula.parse();
    parsed.map_err(|error: ExpressionError| FieldTextError::Formula {
        text: text.into(),
        error: error.shifted(text[..skipped].chars().count()),
    })
}

/// `point=X,Y,Z` and `k=K` or breaks `ρ=density`.
fn radial(text: &str, settings: &str, kind: &'static str) -> Result<Radial, FieldTextError> {
    let example = if kind == "sine" { SINE } else { RADIAL };
    let refused = |reason: String| FieldTextError::Radial {
        text: text.into(),
        kind,
        reason,
        example,
    };
    let number = |value: &str| {
        let number = value.trim().parse::<f64>().ok();
        let number = number.filter(|number| number.is_finite());
        number.ok_or_else(|| refused(format!("`{}` is not a finite number", value.trim())))
    };
    let mut parts = settings.split(',');
    let first = parts.next().unwrap_or_default();
    let Some(("point", x)) = key_and_value(first) else {
        return Err(refused("it begins with the point".into()));
    };
    let mut rest = || {
        parts
            .next()
            .ok_or_else(|| refused("a point has three coordinates".into()))
    };
    let point = Point3::new(number(x)?, number(rest()?)?, number(rest()?)?);
    let mut pairs = Vec::new();
    for part in parts {
        let pair = key_and_value(part);
        pairs.push(pair.ok_or_else(|| refused(format!("`{part}` is no setting `key=value`")))?);
    }
    if kind == "sine" {
        let [("k", k)] = pairs[..] else {
            return Err(refused("after the point it takes k alone".into()));
        };
        let kind = RadialKind::Sine { k: number(k)? };
        return Ok(Radial { point, kind });
    }
    let mut breaks = Vec::new();
    for (radius, value) in pairs {
        breaks.push([number(radius)?, number(value)?]);
    }
    check_breaks(&breaks).map_err(refused)?;
    let kind = RadialKind::Linear { breaks };
    Ok(Radial { point, kind })
}

fn check_breaks(breaks: &[[f64; 2]]) -> Result<(), String> {
    if breaks.is_empty() {
        return Err("it needs at least one `radius=density`".into());
    }
    if let Some([radius, _]) = breaks.iter().find(|pair| pair[0] < 0.0) {
        return Err(format!("the radius {radius} is negative"));
    }
    match breaks.windows(2).find(|pair| pair[1][0] <= pair[0][0]) {
        Some([_, [radius, _]]) => Err(format!(
            "the radius {radius} is not beyond the one before it"
        )),
        _ => Ok(()),
    }
}

fn key_and_value(setting: &str) -> Option<(&str, &str)> {
    let (key, value) = setting.split_once('=')?;
    Some((key.trim(), value.trim()))
}
