//! Shaded cells in space with a part taken away, as in \[BL\] Fig. 11.
//!
//! Cells are shown or taken away whole, by their sites, so that the cut is rough and shows the
//! cells' true shapes. They are drawn one at a time and not kept.

use nalgebra::{Point2, Point3};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::plot::camera::{Camera, TOWARD};
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Stroke};
use crate::plot::panel::{
    BAR_SPACE, LABEL_SIZE, LEVEL_BAR_SPACE, TICK_SIZE, TITLE_SIZE, draw_clipped_color_bar,
    draw_level_color_bar,
};
use crate::plot::png::PngError;
use crate::plot::z_buffer::ZBuffer;

/// The part of the domain whose cells are not drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Removed {
    /// The eighth of the domain's box that is nearest to the viewer.
    Octant,
    /// The front half.
    Half,
}

/// The least share of the cells that a cut should take away to show what is inside.
const ENOUGH: f64 = 0.05;

impl Removed {
    /// The octant, or the half where the octant holds less than 5 % of the sites.
    #[must_use]
    pub(crate) fn enough_of(bounds: &Bounds<3>, sites: &[Point3<f64>]) -> Self {
        let middle = bounds.center();
        let gone = |site: &&Point3<f64>| !Self::Octant.leaves(site, &middle);
        let count = sites.iter().filter(gone).count();
        if count as f64 >= ENOUGH * sites.len() as f64 {
            Self::Octant
        } else {
            Self::Half
        }
    }

    /// The words for it in a title.
    #[must_use]
    pub(crate) fn title(self) -> &'static str {
        match self {
            Self::Octant => "Cells, an octant taken away",
            Self::Half => "Cells, the front half taken away",
        }
    }

    /// Whether a cell of this site is shown; `middle` is that of the domain's box.
    #[must_use]
    pub(crate) fn leaves(self, site: &Point3<f64>, middle: &Point3<f64>) -> bool {
        let arm = site - middle;
        let near = |axis: usize| arm[axis] * TOWARD[axis] > 0.0;
        match self {
            Self::Octant => !(near(0) && near(1) && near(2)),
            Self::Half => !near(1),
        }
    }
}

/// The longer side of the picture in pixels, the least of the other, and pixels per figure unit.
const LONGER_SIDE: f64 = 1300.0;
const LEAST_SIDE: f64 = 160.0;
const SCALE: f64 = 2.0;

const MARGIN: f64 = 20.0;
const TITLE_SPACE: f64 = 26.0;
const BAR_GAP: f64 = 14.0;
/// Up to this height in figure units the color bar lies below.
const LOW: f64 = 300.0;
/// The color bar's share of the picture's height, or of its width below.
const BAR_SHARE: f64 = 0.7;
/// The axes' arrows are about this share of the domain's longest extent.
const ARROWS: f64 = 0.12;
/// The space of the axes' arrows below the picture.
const AXES_SPACE: f64 = 64.0;

/// A picture under construction.
#[derive(Debug)]
pub(crate) struct CutawayPicture {
    buffer: ZBuffer,
    bounds: Bounds<3>,
    size: [usize; 2],
    clipped: [bool; 2],
    removed: Removed,
    scale: ColorScale,
    title: String,
}

impl CutawayPicture {
    /// An empty picture of a domain with these bounds.
    ///
    /// # Errors
    /// [`PngError`] as [`crate::plot::png::png`].
    pub(crate) fn new(
        bounds: &Bounds<3>,
        removed: Removed,
        scale: ColorScale,
        title: &str,
    ) -> Result<Self, PngError> {
        let corners = || {
            (0..8).map(|corner: usize| {
                let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
                Point3::new(pick(0), pick(1), pick(2))
            })
        };
        let extent = Camera::extent(corners());
        let sides = extent * (LONGER_SIDE / extent.max().max(f64::MIN_POSITIVE));
        let size = [sides.x, sides.y].map(|side| side.max(LEAST_SIDE).ceil() as usize);
        let mut buffer = ZBuffer::new(size[0], size[1])?;
        buffer.aim(corners(), 0, size[0]);
        Ok(Self {
            buffer,
            bounds: *bounds,
            size,
            clipped: [false; 2],
            removed,
            scale,
            title: title.to_owned(),
        })
    }

    /// Whether the cell of `site` is shown; the others need not be pushed.
    #[must_use]
    pub(crate) fn shows(&self, site: &Point3<f64>) -> bool {
        self.removed.leaves(site, &self.bounds.center())
    }

    /// Draws the cell of `site`, colored by `value`, unless it is taken away.
    pub(crate) fn push(&mut self, shell: &Shell, site: &Point3<f64>, value: f64) {
        if self.shows(site) {
            let color = self.scale.color(value);
            let [below, above] = self.scale.clipped([value]);
            self.clipped = [self.clipped[0] || below, self.clipped[1] || above];
            self.buffer.draw(shell, |_| color);
        }
    }

    /// The picture with title and color bar as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PngError::Encode`].
    pub(crate) fn finish(self) -> Result<Vec<u8>, PngError> {
        let size = self.size.map(|pixels| pixels as f64 / SCALE);
        let is_low = size[1] < LOW;
        let (right, below) = if is_low {
            (0.0, LEVEL_BAR_SPACE)
        } else {
            (BAR_GAP + BAR_SPACE, 0.0)
        };
        let corner = Point2::new(MARGIN, MARGIN + TITLE_SPACE);
        let mut figure = Figure::new(
            size[0] + 2.0 * MARGIN + right,
            corner.y + size[1] + MARGIN + AXES_SPACE.max(below),
        );
        let above = Point2::new(MARGIN + 0.5 * size[0], MARGIN + 0.8 * TITLE_SIZE);
        figure.text(above, &self.title, TITLE_SIZE, Anchor::Middle);
        self.draw_bar(&mut figure, corner, size, is_low);
        let foot = Point2::new(MARGIN + AXES_FOOT, corner.y + size[1] + AXES_SPACE - 22.0);
        self.draw_axes(&mut figure, foot);
        self.buffer.to_png(&figure, corner, SCALE)
    }

    /// The color bar, beside the picture of this size or below it.
    fn draw_bar(&self, figure: &mut Figure, corner: Point2<f64>, size: [f64; 2], is_low: bool) {
        let scale = (&self.scale, self.clipped);
        if is_low {
            let length = BAR_SHARE * size[0];
            let start = Point2::new(MARGIN + size[0] - length, corner.y + size[1] + MARGIN);
            draw_level_color_bar(figure, start, length, scale);
        } else {
            let length = BAR_SHARE * size[1];
            let top = corner.y + 0.5 * (size[1] - length);
            let start = Point2::new(MARGIN + size[0] + BAR_GAP, top);
            draw_clipped_color_bar(figure, start, length, scale);
        }
    }

    /// The axes' directions, each as long as the same length in the domain, which is named.
    fn draw_axes(&self, figure: &mut Figure, foot: Point2<f64>) {
        let length = round_length(ARROWS * self.bounds.extent().max());
        let origin = self.buffer.image(&Point3::origin());
        for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
            let mut end = Point3::origin();
            end[axis] = length;
            let arm = (self.buffer.image(&end) - origin) / SCALE;
            figure.line(foot, foot + arm, Stroke::solid(Color::INK, 1.4));
            let beyond = foot + arm + arm.normalize() * 9.0;
            let beside = Point2::new(beyond.x, beyond.y + 0.36 * LABEL_SIZE);
            figure.text(beside, name, LABEL_SIZE, Anchor::Middle);
        }
        let beside = Point2::new(foot.x + AXES_FOOT + 12.0, foot.y);
        let name = format!("each {length} long");
        figure.text(beside, &name, TICK_SIZE, Anchor::Start);
    }
}

/// Where the axes' arrows meet, from the left.
const AXES_FOOT: f64 = 56.0;

/// The greatest of 1, 2, 5 times a power of ten that is no longer.
fn round_length(length: f64) -> f64 {
    let exponent = length.log10().floor();
    // As text, so that the number has no digits of rounding.
    let times = |digit: u32| format!("{digit}e{exponent}").parse().unwrap_or(length);
    let round = [5, 2, 1].map(times);
    let fits = round.into_iter().find(|round: &f64| *round <= length);
    fits.unwrap_or(length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_of_arrows_are_round() {
        for (length, round) in [
            (0.12, 0.1),
            (0.3, 0.2),
            (7.0, 5.0),
            (1e-7, 1e-7),
            (999.0, 500.0),
        ] {
            assert!(
                (round_length(length) / round - 1.0_f64).abs() < 1e-12,
                "{length}"
            );
        }
    }
}
