//! Colors and the scale from values to colors.

/// An opaque sRGB color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Color {
    /// Red, green, blue.
    pub rgb: [u8; 3],
}

impl Color {
    /// The background.
    pub(crate) const WHITE: Self = Self::hex(0xff_ff_ff);
    /// Text and frames.
    pub(crate) const INK: Self = Self::hex(0x22_22_22);
    /// Grid lines.
    pub(crate) const GRID: Self = Self::hex(0xe3_e3_e3);
    /// Reference lines.
    pub(crate) const GRAY: Self = Self::hex(0x88_88_88);

    /// The color written as `0xrrggbb`.
    #[must_use]
    pub(crate) const fn hex(code: u32) -> Self {
        Self {
            rgb: [(code >> 16) as u8, (code >> 8) as u8, code as u8],
        }
    }

    /// The color a share `t` in 0…1 of the way to `other`, mixed in sRGB.
    #[must_use]
    pub(crate) fn mix(self, other: Self, t: f64) -> Self {
        let blend = |k: usize| {
            let (a, b) = (f64::from(self.rgb[k]), f64::from(other.rgb[k]));
            (a + t.clamp(0.0, 1.0) * (b - a)).round() as u8
        };
        Self {
            rgb: [blend(0), blend(1), blend(2)],
        }
    }

    /// The perceived brightness, 0 to 255 (ITU-R BT.601).
    #[must_use]
    pub(crate) fn luma(self) -> f64 {
        let [r, g, b] = self.rgb.map(f64::from);
        0.299 * r + 0.587 * g + 0.114 * b
    }

    /// The color with its brightness multiplied by `factor ≥ 0`.
    #[must_use]
    pub(crate) fn lit(self, factor: f64) -> Self {
        Self {
            rgb: self
                .rgb
                .map(|c| (f64::from(c) * factor).round().clamp(0.0, 255.0) as u8),
        }
    }
}

/// Seventeen equidistant stops of viridis (S. van der Walt & N. Smith, matplotlib, CC0): even
/// steps in the table are even steps to the eye, also in gray and to the color-blind.
const VIRIDIS: [u32; 17] = [
    0x44_01_54, 0x48_18_6a, 0x47_2d_7b, 0x42_40_86, 0x3b_52_8b, 0x33_63_8d, 0x2c_72_8e, 0x26_82_8e,
    0x21_91_8c, 0x1f_a0_88, 0x28_ae_80, 0x3f_bc_73, 0x5e_c9_62, 0x84_d4_4b, 0xad_dc_30, 0xd8_e2_19,
    0xfd_e7_25,
];

/// The viridis color at a share `t` of the way from its dark to its bright end; `t` is clamped to
/// 0…1, and what is not a number is gray.
#[must_use]
pub(crate) fn viridis(t: f64) -> Color {
    if t.is_nan() {
        return Color::GRAY;
    }
    let place = t.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let stop = (place as usize).min(VIRIDIS.len() - 2);
    Color::hex(VIRIDIS[stop]).mix(Color::hex(VIRIDIS[stop + 1]), place - stop as f64)
}

/// Values of one quantity, the lower the better, and the range over which colors spread. Low values are
/// bright: most cells of a relaxed tessellation are near the best value, and only bright colors show
/// outlines and shading.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ColorScale {
    /// The quantity's name and unit, for the color bar.
    pub label: String,
    /// The value of one end; lower ones share its color.
    pub min: f64,
    /// The value of the other end; higher ones share its color.
    pub max: f64,
}

/// The share of viridis at its dark end that no value gets, so that outlines stay visible.
pub(crate) const TOO_DARK: f64 = 0.12;

/// The share of the values at either end that may leave the scale, so that one odd cell does not
/// wash out all others.
const OUTLIERS: f64 = 0.02;

/// The least range of a fitted scale relative to its values: rounding noise stays one color.
const LEAST_RANGE: f64 = 1e-3;

impl ColorScale {
    /// The scale that spreads its colors over `values` but for the outermost 2 % at either end.
    /// Values that are not finite do not count.
    #[must_use]
    pub(crate) fn fitting(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let mut sorted: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().saturating_sub(1);
        let cut = (last as f64 * OUTLIERS).floor() as usize;
        let min = sorted.get(cut).copied().unwrap_or(0.0);
        let max = sorted.get(last - cut).copied().unwrap_or(0.0);
        let least = LEAST_RANGE * min.abs().max(max.abs()).max(f64::MIN_POSITIVE);
        Self {
            label: label.to_owned(),
            min,
            max: max.max(min + least),
        }
    }

    /// The color of `value`.
    #[must_use]
    pub(crate) fn color(&self, value: f64) -> Color {
        let share = ((value - self.min) / (self.max - self.min)).clamp(0.0, 1.0);
        viridis(TOO_DARK + (1.0 - TOO_DARK) * (1.0 - share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn viridis_ends_where_matplotlib_does() {
        assert_eq!(viridis(-1.0), Color::hex(0x44_01_54));
        assert_eq!(viridis(2.0), Color::hex(0xfd_e7_25));
        assert_eq!(viridis(f64::NAN), Color::GRAY);
    }

    #[test]
    fn a_scale_ignores_outliers_and_survives_constants() {
        let scale = ColorScale::fitting("", (0..1000).map(f64::from).chain([1e9, f64::NAN]));
        assert!((scale.min - 20.0).abs() < 1e-12 && (scale.max - 980.0).abs() < 1e-12);
        let constant = ColorScale::fitting("", [100.0; 5]);
        assert!(constant.max > constant.min);
        let empty = ColorScale::fitting("", []);
        assert_eq!(empty.color(empty.min), viridis(1.0));
    }
}
