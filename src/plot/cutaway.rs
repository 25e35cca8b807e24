//! Shaded cells in space with a part taken away, as in \[BL\] Fig. 11.
//!
//! Cells are shown or taken away whole, by their sites, so that the cut is rough and shows the
//! cells' true shapes. They are drawn one at a time and not kept.

use nalgebra::{Point2, Point3};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::plot::camera::TOWARD;
use crate::plot::color::ColorScale;
use crate::plot::figure::{Anchor, Figure};
use crate::plot::panel::{BAR_SPACE, TITLE_SIZE, draw_color_bar};
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

    fn leaves(self, site: &Point3<f64>, middle: &Point3<f64>) -> bool {
        let arm = site - middle;
        let near = |axis: usize| arm[axis] * TOWARD[axis] > 0.0;
        match self {
            Self::Octant => !(near(0) && near(1) && near(2)),
            Self::Half => !near(1),
        }
    }
}

/// Sides of the picture in pixels, and pixels per figure unit.
const WIDTH: usize = 1300;
const HEIGHT: usize = 1300;
const SCALE: f64 = 2.0;

const MARGIN: f64 = 20.0;
const TITLE_SPACE: f64 = 26.0;
const BAR_GAP: f64 = 14.0;
/// The color bar's share of the picture's height.
const BAR_SHARE: f64 = 0.7;

/// A picture under construction.
#[derive(Debug)]
pub(crate) struct CutawayPicture {
    buffer: ZBuffer,
    middle: Point3<f64>,
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
        let corners = (0..8).map(|corner: usize| {
            let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
            Point3::new(pick(0), pick(1), pick(2))
        });
        let mut buffer = ZBuffer::new(WIDTH, HEIGHT)?;
        buffer.aim(corners, 0, WIDTH);
        Ok(Self {
            buffer,
            middle: bounds.center(),
            removed,
            scale,
            title: title.to_owned(),
        })
    }

    /// Whether the cell of `site` is shown; the others need not be pushed.
    #[must_use]
    pub(crate) fn shows(&self, site: &Point3<f64>) -> bool {
        self.removed.leaves(site, &self.middle)
    }

    /// Draws the cell of `site`, colored by `value`, unless it is taken away.
    pub(crate) fn push(&mut self, shell: &Shell, site: &Point3<f64>, value: f64) {
        if self.shows(site) {
            let color = self.scale.color(value);
            self.buffer.draw(shell, |_| color);
        }
    }

    /// The picture with title and color bar as the bytes of a PNG file.
    ///
    /// # Errors
    /// [`PngError::Encode`].
    pub(crate) fn finish(self) -> Result<Vec<u8>, PngError> {
        let size = [WIDTH, HEIGHT].map(|pixels| pixels as f64 / SCALE);
        let mut figure = Figure::new(
            size[0] + 2.0 * MARGIN + BAR_GAP + BAR_SPACE,
            size[1] + 2.0 * MARGIN + TITLE_SPACE,
        );
        let corner = Point2::new(MARGIN, MARGIN + TITLE_SPACE);
        let above = Point2::new(MARGIN + 0.5 * size[0], MARGIN + 0.8 * TITLE_SIZE);
        figure.text(above, &self.title, TITLE_SIZE, Anchor::Middle);
        let bar = Point2::new(
            MARGIN + size[0] + BAR_GAP,
            corner.y + 0.5 * (1.0 - BAR_SHARE) * size[1],
        );
        draw_color_bar(&mut figure, bar, BAR_SHARE * size[1], &self.scale);
        self.buffer.to_png(&figure, corner, SCALE)
    }
}
