//! Pictures of prints: the beads of a layer in their widths, and plastic along an axis.

use nalgebra::{Point2, Vector2};

use crate::plot::axis::Axis;
use crate::plot::color::{Color, ColorScale};
use crate::plot::figure::{Anchor, Figure, Shape, Stroke};
use crate::plot::panel::{BAR_SPACE, LABEL_SIZE, Panel, TITLE_SIZE, draw_color_bar};

/// A straight bead seen from above (mm).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Strip {
    pub(crate) from: Point2<f64>,
    pub(crate) to: Point2<f64>,
    pub(crate) width: f64,
    /// Whether it is infill, which is colored by its width.
    pub(crate) is_infill: bool,
}

/// The sheet's width, and the margin around the layer.
const WIDTH: f64 = 960.0;
const MARGIN: f64 = 24.0;
const TITLE_SPACE: f64 = 44.0;

/// The layer's height on the sheet, so that the color bar has its ticks.
const HEIGHTS: [f64; 2] = [180.0, 760.0];

/// Walls, skins and all that does not vary.
const FIXED: Color = Color::hex(0xc4_c8_cc);

/// The colors of what was wanted and of what was obtained (Okabe & Ito 2008).
const WANTED: Color = Color::hex(0x00_72_b2);
const OBTAINED: Color = Color::hex(0xd5_5e_00);

/// Where a layer lies on the sheet.
#[derive(Clone, Copy, Debug)]
struct LayerFrame {
    low: Point2<f64>,
    high: Point2<f64>,
    /// Figure units in a mm.
    scale: f64,
    /// The layer's upper left corner, and the height of its space.
    corner: Point2<f64>,
    height: f64,
}

/// The space for the layer between the margins and the color bar.
const ROOM: f64 = WIDTH - 2.0 * MARGIN - BAR_SPACE - 16.0;

impl LayerFrame {
    fn around(strips: &[Strip]) -> Self {
        let corners = || strips.iter().flat_map(corners_of).flatten();
        let low = corners().reduce(|low, corner| low.inf(&corner));
        let high = corners().reduce(|high, corner| high.sup(&corner));
        let (low, high) = (low.unwrap_or_default(), high.unwrap_or_default());
        let size: Vector2<f64> = (high - low).map(|side: f64| side.max(1e-6));
        let scale = (ROOM / size.x).min(HEIGHTS[1] / size.y);
        let height = (size.y * scale).max(HEIGHTS[0]);
        let left = MARGIN + (ROOM - size.x * scale) / 2.0;
        let top = TITLE_SPACE + (height - size.y * scale) / 2.0;
        Self {
            low,
            high,
            scale,
            corner: Point2::new(left, top),
            height,
        }
    }

    fn place(&self, point: Point2<f64>) -> Point2<f64> {
        let offset = Vector2::new(point.x - self.low.x, self.high.y - point.y);
        self.corner + offset * self.scale
    }

    fn draw(&self, figure: &mut Figure, strip: &Strip, fill: Color) {
        let Some(corners) = corners_of(strip) else {
            return;
        };
        figure.shapes.push(Shape::Path {
            contours: vec![corners.map(|corner| self.place(corner)).to_vec()],
            closed: true,
            fill: Some(fill),
            stroke: None,
        });
    }
}

/// The beads of a layer; infill colored by width.
pub(crate) fn layer(strips: &[Strip], title: &str) -> Figure {
    let frame = LayerFrame::around(strips);
    let mut figure = Figure::new(WIDTH, frame.height + TITLE_SPACE + MARGIN);
    let middle = Point2::new(MARGIN + ROOM / 2.0, 28.0);
    figure.text(middle, title, TITLE_SIZE, Anchor::Middle);
    let of = |is_infill| {
        strips
            .iter()
            .filter(move |strip| strip.is_infill == is_infill)
    };
    let widths = of(true).map(|strip| strip.width);
    let colors = ColorScale::fitting("width of infill (mm)", widths);
    for strip in of(true) {
        frame.draw(&mut figure, strip, colors.color(strip.width));
    }
    for strip in of(false) {
        frame.draw(&mut figure, strip, FIXED);
    }
    let bar = Point2::new(WIDTH - MARGIN - BAR_SPACE, TITLE_SPACE);
    draw_color_bar(&mut figure, bar, frame.height, &colors);
    figure
}

/// The corners of a strip that has a length.
fn corners_of(strip: &Strip) -> Option<[Point2<f64>; 4]> {
    let along = (strip.to - strip.from).try_normalize(0.0)?;
    let across = Vector2::new(-along.y, along.x) * (strip.width / 2.0);
    Some([
        strip.from + across,
        strip.to + across,
        strip.to - across,
        strip.from - across,
    ])
}

/// Plastic between two places along an axis (mm³).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bin {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) as_sliced: f64,
    pub(crate) wanted: f64,
    pub(crate) obtained: f64,
}

/// What was sliced, dashed.
const SLICED: Stroke = Stroke {
    color: Color::GRAY,
    width: 1.2,
    dash: Some([4.0, 3.0]),
};

/// The infill along an axis: as sliced, wanted and obtained.
pub(crate) fn profile(bins: &[Bin], axis: &str) -> Figure {
    let mut figure = Figure::new(WIDTH, 420.0);
    let panel = profile_panel(bins);
    panel.draw_grid(&mut figure);
    let steps = |value: fn(&Bin) -> f64| -> Vec<Point2<f64>> {
        let step = |bin: &Bin| [bin.from, bin.to].map(|x| panel.place(x, value(bin)));
        bins.iter().flat_map(step).collect()
    };
    figure.polyline(steps(|bin| bin.as_sliced), SLICED);
    figure.polyline(steps(|bin| bin.wanted), Stroke::solid(WANTED, 1.8));
    for bin in bins {
        let center = panel.place((bin.from + bin.to) / 2.0, bin.obtained);
        figure.shapes.push(disc(center));
    }
    let (title, axis) = ("Infill, wanted and obtained", format!("{axis} (mm)"));
    panel.draw_frame(&mut figure, title, &axis, "volume in a bin (mm³)");
    legend(&mut figure);
    figure
}

fn profile_panel(bins: &[Bin]) -> Panel {
    let ends = || bins.iter().flat_map(|bin| [bin.from, bin.to]);
    let volumes = bins
        .iter()
        .flat_map(|bin| [bin.as_sliced, bin.wanted, bin.obtained]);
    let low = ends().fold(f64::INFINITY, f64::min);
    let high = ends().fold(f64::NEG_INFINITY, f64::max);
    Panel {
        frame: [Point2::new(90.0, 36.0), Point2::new(WIDTH - 30.0, 330.0)],
        x: Axis::linear(low, high),
        y: Axis::linear(0.0, volumes.fold(0.0, f64::max)),
    }
}

/// The mark of what was obtained.
fn disc(center: Point2<f64>) -> Shape {
    Shape::Disc {
        center,
        radius: 4.0,
        fill: OBTAINED,
    }
}

fn legend(figure: &mut Figure) {
    let y = 396.0;
    let rows = [
        (300.0, "as sliced"),
        (460.0, "wanted"),
        (620.0, "obtained, read back"),
    ];
    for (x, name) in rows {
        figure.text(
            Point2::new(x + 34.0, y + 4.0),
            name,
            LABEL_SIZE,
            Anchor::Start,
        );
    }
    let ends = |x: f64| [Point2::new(x, y), Point2::new(x + 26.0, y)];
    for (x, stroke) in [(rows[0].0, SLICED), (rows[1].0, Stroke::solid(WANTED, 1.8))] {
        let [from, to] = ends(x);
        figure.line(from, to, stroke);
    }
    figure.shapes.push(disc(Point2::new(rows[2].0 + 14.0, y)));
}
