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

    /// The color in so much of its light, 0 to 1, as it looks to the eye: hue and saturation stay, since
    /// all three components are scaled alike in linear light.
    #[must_use]
    pub(crate) fn lit(self, factor: f64) -> Self {
        let light = factor.clamp(0.0, 1.0).powf(EYE);
        Self {
            rgb: self.rgb.map(|c| {
                let lit = encoded(linear(f64::from(c) / 255.0) * light);
                (255.0 * lit).round() as u8
            }),
        }
    }
}

/// Lightness is about the cube root of light (CIELAB, OKLab); the sRGB curve is nearly a power of 2.2,
/// and shades that the eye takes for even steps lie between.
const EYE: f64 = 2.2;

/// The light of an sRGB component (IEC 61966-2-1).
fn linear(component: f64) -> f64 {
    if component <= 0.040_45 {
        component / 12.92
    } else {
        ((component + 0.055) / 1.055).powf(2.4)
    }
}

/// The inverse of [`linear`].
fn encoded(light: f64) -> f64 {
    if light <= 0.003_130_8 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
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

    /// Whether some of the values lie below and above the scale.
    #[must_use]
    pub(crate) fn clipped(&self, values: impl IntoIterator<Item = f64>) -> [bool; 2] {
        let slack = 1e-9 * (self.max - self.min);
        values
            .into_iter()
            .fold([false; 2], |[below, above], value| {
                [
                    below || value < self.min - slack,
                    above || value > self.max + slack,
                ]
            })
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

    /// The hue in OKLab (B. Ottosson 2020), in radians.
    fn hue(color: Color) -> f64 {
        let [r, g, b] = color.rgb.map(|c| linear(f64::from(c) / 255.0));
        let l = (0.412_221_47 * r + 0.536_332_54 * g + 0.051_445_99 * b).cbrt();
        let m = (0.211_903_5 * r + 0.680_699_55 * g + 0.107_396_96 * b).cbrt();
        let s = (0.088_302_46 * r + 0.281_718_84 * g + 0.629_978_7 * b).cbrt();
        let a = 1.977_998_5 * l - 2.428_592_2 * m + 0.450_593_7 * s;
        let b = 0.025_904_04 * l + 0.782_771_77 * m - 0.808_675_77 * s;
        b.atan2(a)
    }

    #[test]
    fn shading_keeps_the_hue_and_never_brightens() {
        for step in 0..=20 {
            let color = viridis(f64::from(step) / 20.0);
            for factor in [0.5, 0.7, 0.9, 1.0, 1.3] {
                let lit = color.lit(factor);
                assert!((hue(lit) - hue(color)).abs() < 0.04, "{color:?} {factor}");
                assert!(lit.luma() <= color.luma());
            }
            assert_eq!(color.lit(1.0), color);
        }
    }

    #[test]
    fn values_beyond_a_scale_are_known() {
        let scale = ColorScale {
            label: String::new(),
            min: 1.0,
            max: 2.0,
        };
        assert_eq!(scale.clipped([1.0, 1.5, 2.0]), [false, false]);
        assert_eq!(scale.clipped([0.5, 1.5]), [true, false]);
        assert_eq!(scale.clipped([1.5, 2.1, f64::NAN]), [false, true]);
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
