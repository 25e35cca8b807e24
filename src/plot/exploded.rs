//! Cells taken apart into their six fragments, as in \[BL\] Fig. 12.
//!
//! A fragment has the color of its axis, and its saturation grows with the Chebyshev distance from
//! the center, the quantity that the energy integrates.

use nalgebra::{Point2, Point3, Vector3};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::plot::color::Color;
use crate::plot::figure::{Anchor, Figure};
use crate::plot::panel::{LABEL_SIZE, TITLE_SIZE};
use crate::plot::png::PngError;
use crate::plot::z_buffer::ZBuffer;

/// One fragment of a cell.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Fragment {
    /// The axis along which the distance grows: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Whether it lies on the side of larger coordinates.
    pub positive: bool,
    /// Its surface, where it belongs.
    pub shell: Shell,
}

/// A cell to take apart.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FragmentedCell {
    /// What is written below it.
    pub caption: String,
    /// The point from which distances count.
    pub center: Point3<f64>,
    /// Its fragments.
    pub fragments: Vec<Fragment>,
}

/// How far a fragment moves out of its cell, as a share of the cell's largest extent.
pub(crate) const EXPLOSION: f64 = 0.16;

/// x, y, z (Okabe & Ito's vermilion, green and blue).
pub(crate) const AXES: [Color; 3] = [
    Color::hex(0xd5_5e_00),
    Color::hex(0x00_9e_73),
    Color::hex(0x00_72_b2),
];

/// The color at the center, before the axis' color comes in.
pub(crate) const PALE: Color = Color::hex(0xff_fb_f2);

/// Sides of a cell's part of the picture in pixels, and pixels per figure unit.
const SIDE: usize = 900;
const SCALE: f64 = 2.0;

pub(crate) const MARGIN: f64 = 20.0;
pub(crate) const CAPTION_SPACE: f64 = 30.0;

/// The cells side by side, each as large as its part of the picture allows, as the bytes of a PNG
/// file.
///
/// # Errors
/// [`PngError`] as [`crate::plot::png::png`], also without cells.
pub(crate) fn exploded(cells: &[FragmentedCell]) -> Result<Vec<u8>, PngError> {
    let side = SIDE as f64 / SCALE;
    let width = side * cells.len() as f64;
    let mut figure = Figure::new(width + 2.0 * MARGIN, side + 2.0 * MARGIN + CAPTION_SPACE);
    let mut buffer = ZBuffer::new(SIDE * cells.len(), SIDE)?;
    for (number, cell) in cells.iter().enumerate() {
        draw_cell(&mut buffer, cell, number);
        let below = Point2::new(
            MARGIN + (number as f64 + 0.5) * side,
            MARGIN + side + CAPTION_SPACE,
        );
        figure.text(below, &cell.caption, TITLE_SIZE, Anchor::Middle);
    }
    draw_legend(&mut figure);
    buffer.to_png(&figure, Point2::new(MARGIN, MARGIN), SCALE)
}

/// Draws a cell in part `number` of the buffer.
fn draw_cell(buffer: &mut ZBuffer, cell: &FragmentedCell, number: usize) {
    let corners = || {
        cell.fragments
            .iter()
            .flat_map(|fragment| fragment.shell.vertices())
    };
    let extent = Bounds::of(corners()).extent().max();
    let moved: Vec<(Vector3<f64>, &Fragment)> = cell
        .fragments
        .iter()
        .map(|fragment| (outward(fragment) * EXPLOSION * extent, fragment))
        .collect();
    let places = moved
        .iter()
        .flat_map(|(shift, fragment)| fragment.shell.vertices().iter().map(move |v| v + shift));
    buffer.aim(places, number * SIDE, SIDE);
    let farthest = corners()
        .map(|corner| (corner - cell.center).amax())
        .fold(0.0, f64::max);
    for (shift, fragment) in &moved {
        let axis = fragment.axis.min(2);
        buffer.draw(&fragment.shell.translated(shift), |place| {
            let distance = (place - shift - cell.center)[axis].abs();
            PALE.mix(AXES[axis], distance / farthest)
        });
    }
}

/// The axes' colors, in a row on the line of the caption.
pub(crate) fn draw_legend(figure: &mut Figure) {
    let foot = figure.height - MARGIN;
    for (number, (color, name)) in AXES.into_iter().zip(["x", "y", "z"]).enumerate() {
        let max = Point2::new(MARGIN + 11.0 + 32.0 * number as f64, foot);
        let min = Point2::new(max.x - 11.0, max.y - 11.0);
        figure.rectangle([min, max], Some(color), None);
        let beside = Point2::new(max.x + 5.0, max.y - 1.0);
        figure.text(beside, name, LABEL_SIZE, Anchor::Start);
    }
}

pub(crate) fn outward(fragment: &Fragment) -> Vector3<f64> {
    let mut direction = Vector3::zeros();
    direction[fragment.axis.min(2)] = if fragment.positive { 1.0 } else { -1.0 };
    direction
}
