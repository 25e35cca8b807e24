//! An axis: its range, its scale and its ticks.

/// A labelled tick.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    /// Its value on the axis.
    pub value: f64,
    /// The text beside it.
    pub label: String,
}

/// A range of values with its ticks.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Axis {
    /// The value at the beginning; positive on a logarithmic axis.
    pub min: f64,
    /// The value at the end, above `min`.
    pub max: f64,
    /// Whether equal ratios instead of equal differences are equally long.
    pub logarithmic: bool,
    /// The labelled ticks inside the range.
    pub ticks: Vec<Tick>,
    /// Unlabelled ticks between them.
    pub minor: Vec<f64>,
    /// The value above which a logarithmic axis counts.
    pub base: f64,
}

/// About as many labelled ticks as fit one of our panels.
const TICKS: f64 = 6.0;

/// The margin beyond the data at either end, as a share of the range.
const MARGIN: f64 = 0.04;

/// The least range of a linear axis relative to its values: a constant still gets an axis whose
/// labels differ within seven digits.
const LEAST_RANGE: f64 = 1e-5;

/// Below this many decades a logarithmic axis also labels 2 and 5.
const FEW_DECADES: f64 = 2.0;

/// The digits that powers of ten are raised by: U+207B and U+2070…
const SUPERSCRIPTS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

impl Axis {
    /// An axis of equal differences around `[low, high]` with ticks on round numbers.
    #[must_use]
    pub(crate) fn linear(low: f64, high: f64) -> Self {
        let middle = 0.5 * (low + high);
        let half = (0.5 * (high - low))
            .max(LEAST_RANGE * middle.abs())
            .max(f64::MIN_POSITIVE.sqrt());
        let reach = half * (1.0 + 2.0 * MARGIN);
        let step = round_step(2.0 * half / TICKS);
        Self::stepped(middle - reach, middle + reach, step)
    }

    /// An axis for counts from `low` to `high`; ticks on whole numbers.
    #[must_use]
    pub(crate) fn counts(low: f64, high: f64) -> Self {
        let high = high.max(low + 1.0);
        let margin = 0.5 * MARGIN * (high - low);
        let step = round_step((high - low) / TICKS).max(1.0);
        Self::stepped(low - margin, high + margin, step)
    }

    /// An axis from exactly `min` to exactly `max` with ticks on round numbers.
    #[must_use]
    pub(crate) fn within(min: f64, max: f64) -> Self {
        Self::stepped(min, max, round_step((max - min) / TICKS))
    }

    /// The same with about so many ticks.
    #[must_use]
    pub(crate) fn within_about(min: f64, max: f64, ticks: f64) -> Self {
        Self::stepped(min, max, round_step((max - min) / ticks.clamp(1.0, TICKS)))
    }

    /// An axis of equal ratios of what lies above `base`, around `[low, high]`, both above it; its ticks
    /// are labelled by the values themselves.
    #[must_use]
    pub(crate) fn logarithmic_above(base: f64, low: f64, high: f64) -> Self {
        let mut axis = Self::logarithmic(low - base, high - base);
        for tick in &mut axis.ticks {
            let decimals = (-tick.value.log10().floor()).max(0.0) as usize;
            tick.label = format!("{:.decimals$}", base + tick.value);
            tick.value += base;
        }
        axis.minor.iter_mut().for_each(|value| *value += base);
        (axis.min, axis.max) = (axis.min + base, axis.max + base);
        axis.base = base;
        axis
    }

    /// An axis of equal ratios around `[low, high]`, both positive, with ticks on decades.
    #[must_use]
    pub(crate) fn logarithmic(low: f64, high: f64) -> Self {
        let decades = (high / low).log10().max(0.1);
        let margin = 10_f64.powf(MARGIN * decades);
        let (min, max) = (low / margin, high.max(low * 10_f64.powf(0.1)) * margin);
        let stride = (decades / TICKS).ceil().max(1.0) as i32;
        let (first, last) = (min.log10().floor() as i32, max.log10().ceil() as i32);
        let labelled: &[f64] = if decades < FEW_DECADES {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        let plain = first >= -4 && last <= 4;
        let inside = |v: &f64| (min..=max).contains(v);
        let decade_starts = (first..=last).filter(|exponent| exponent % stride == 0);
        let ticks = decade_starts
            .flat_map(|exponent| labelled.iter().map(move |digit| (*digit, exponent)))
            .map(|(digit, exponent)| Tick {
                value: digit * 10_f64.powi(exponent),
                label: power_label(digit, exponent, plain),
            })
            .filter(|tick| inside(&tick.value))
            .collect();
        let digits = if stride > 1 { 1..2 } else { 1..10 };
        let minor = (first..=last)
            .flat_map(|exponent| {
                digits
                    .clone()
                    .map(move |d| f64::from(d) * 10_f64.powi(exponent))
            })
            .filter(inside)
            .collect();
        Self {
            min,
            max,
            logarithmic: true,
            ticks,
            minor,
            base: 0.0,
        }
    }

    /// How far along the axis `value` lies: 0 at `min`, 1 at `max`.
    #[must_use]
    pub(crate) fn share(&self, value: f64) -> f64 {
        if self.logarithmic {
            let above = |end: f64| end - self.base;
            (above(value) / above(self.min)).ln() / (above(self.max) / above(self.min)).ln()
        } else {
            (value - self.min) / (self.max - self.min)
        }
    }

    fn stepped(min: f64, max: f64, step: f64) -> Self {
        let decimals = (-step.log10().floor()).clamp(0.0, 15.0) as usize;
        // The slack keeps a tick that rounding puts just beyond an end.
        let (first, last) = ((min / step - 1e-9).ceil(), (max / step + 1e-9).floor());
        let count = (last - first).clamp(-1.0, 100.0) as i64;
        let ticks = (0..=count)
            .map(|k| {
                let value = (first + k as f64) * step;
                let label = format!("{value:.decimals$}").replace('-', "−");
                Tick { value, label }
            })
            .collect();
        Self {
            min,
            max,
            logarithmic: false,
            ticks,
            minor: Vec::new(),
            base: 0.0,
        }
    }
}

/// The least of 1, 2, 5 times a power of ten that is no smaller than `step`.
fn round_step(step: f64) -> f64 {
    let power = 10_f64.powf(step.log10().floor());
    let digit = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|digit| digit * power >= step * (1.0 - 1e-9));
    digit.unwrap_or(10.0) * power
}

/// `digit · 10^exponent`, in plain decimals or as a power of ten.
fn power_label(digit: f64, exponent: i32, plain: bool) -> String {
    if plain {
        let decimals = (-exponent).max(0) as usize;
        return format!("{:.decimals$}", digit * 10_f64.powi(exponent));
    }
    let sign = if exponent < 0 { "⁻" } else { "" };
    let raised = exponent.unsigned_abs().to_string();
    let raised: String = raised
        .bytes()
        .map(|letter| SUPERSCRIPTS[usize::from(letter - b'0')])
        .collect();
    let factor = if digit > 1.0 {
        format!("{digit}·")
    } else {
        String::new()
    };
    format!("{factor}10{sign}{raised}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<&str> {
        axis.ticks.iter().map(|tick| tick.label.as_str()).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(
            labels(&Axis::linear(100.0, 126.4)),
            ["100", "105", "110", "115", "120", "125"]
        );
        assert_eq!(
            labels(&Axis::linear(-0.02, 0.02)),
            ["−0.02", "−0.01", "0.00", "0.01", "0.02"]
        );
        assert_eq!(labels(&Axis::counts(0.0, 3.0)), ["0", "1", "2", "3"]);
    }

    #[test]
    fn logarithmic_ticks_fit_their_range() {
        assert_eq!(
            labels(&Axis::logarithmic(0.003, 12.0)),
            ["0.01", "0.1", "1", "10"]
        );
        assert_eq!(
            labels(&Axis::logarithmic(0.3, 12.0)),
            ["0.5", "1", "2", "5", "10"]
        );
        assert_eq!(
            labels(&Axis::logarithmic(1e-9, 1.0)),
            ["10⁻⁸", "10⁻⁶", "10⁻⁴", "10⁻²", "10⁰"]
        );
    }

    #[test]
    fn every_range_gets_a_few_ticks() {
        for (low, high) in [
            (0.0, 0.0),
            (100.0, 100.0),
            (1e-300, 1e300),
            (99.9999, 100.0),
        ] {
            let axis = Axis::linear(low, high);
            assert!(
                (2..=9).contains(&axis.ticks.len()),
                "{low} {high}: {:?}",
                labels(&axis)
            );
        }
        for ratio in [1.0, 1.5, 10.0, 1e3, 1e12, 1e200] {
            let axis = Axis::logarithmic(1e-12, 1e-12 * ratio);
            assert!(axis.ticks.len() <= 9, "{ratio}: {:?}", labels(&axis));
        }
    }
}
