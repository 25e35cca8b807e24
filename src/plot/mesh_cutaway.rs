//! A mesh in space with a part taken away, its cells colored by kind.

use nalgebra::{Point2, Point3};

use crate::geometry::bounds::Bounds;
use crate::geometry::shell::Shell;
use crate::mesh::poly_mesh::{CellFaces, PolyMesh};
use crate::plot::camera::Camera;
use crate::plot::color::Color;
use crate::plot::cutaway::Removed;
use crate::plot::figure::{Anchor, Figure, Stroke};
use crate::plot::panel::{LABEL_SIZE, TITLE_SIZE};
use crate::plot::png::PngError;
use crate::plot::z_buffer::ZBuffer;

/// The longer side of the picture in pixels, the least of the other, and pixels per figure unit.
const LONGER_SIDE: f64 = 1300.0;
const LEAST_SIDE: f64 = 200.0;
const SCALE: f64 = 2.0;

const MARGIN: f64 = 20.0;
const TITLE_SPACE: f64 = 26.0;
/// A row of the legend, which is below.
const ROW: f64 = 20.0;
/// The side of a square of the legend.
const SQUARE: f64 = 11.0;

/// The picture as the bytes of a PNG file. `kinds` gives every cell a place in `legend`, whose entries without
/// text are not shown.
///
/// # Errors
/// [`PngError`] as [`crate::plot::png::png`].
pub(crate) fn mesh_picture(
    mesh: &PolyMesh,
    kinds: &[usize],
    legend: &[(String, Color)],
) -> Result<Vec<u8>, PngError> {
    let bounds = Bounds::of(&mesh.points);
    let corners: Vec<Point3<f64>> = (0..8)
        .map(|corner: usize| {
            let pick = |axis: usize| [bounds.min, bounds.max][corner >> axis & 1][axis];
            Point3::new(pick(0), pick(1), pick(2))
        })
        .collect();
    let extent = Camera::extent(corners.iter().copied());
    let sides = extent * (LONGER_SIDE / extent.max().max(f64::MIN_POSITIVE));
    let size = [sides.x, sides.y].map(|side| side.max(LEAST_SIDE).ceil() as usize);
    let mut buffer = ZBuffer::new(size[0], size[1])?;
    buffer.aim(corners, 0, size[0]);
    let cells = mesh.cell_faces();
    let centers: Vec<Point3<f64>> = (0..mesh.cell_count)
        .map(|cell| center(mesh, &cells, cell))
        .collect();
    let removed = Removed::enough_of(&bounds, &centers);
    for cell in 0..mesh.cell_count {
        if removed.leaves(&centers[cell], &bounds.center()) {
            let color = legend[kinds[cell]].1;
            buffer.draw(&shell(mesh, &cells, cell), |_| color);
        }
    }
    let size = size.map(|pixels| pixels as f64 / SCALE);
    let corner = Point2::new(MARGIN, MARGIN + TITLE_SPACE);
    let shown = || legend.iter().filter(|(name, _)| !name.is_empty());
    let rows = shown().count() as f64 * ROW;
    let mut figure = Figure::new(size[0] + 2.0 * MARGIN, corner.y + size[1] + MARGIN + rows);
    let above = Point2::new(MARGIN + 0.5 * size[0], MARGIN + 0.8 * TITLE_SIZE);
    let title = removed.title().replace("Cells", "Mesh");
    figure.text(above, &title, TITLE_SIZE, Anchor::Middle);
    draw_legend(&mut figure, corner.y + size[1], shown());
    buffer.to_png(&figure, corner, SCALE)
}

/// Squares of the colors with their names, in rows below `top`.
fn draw_legend<'a>(
    figure: &mut Figure,
    top: f64,
    shown: impl Iterator<Item = &'a (String, Color)>,
) {
    for (row, (name, color)) in shown.enumerate() {
        let foot = top + ROW * (row as f64 + 0.6);
        let square = [
            Point2::new(MARGIN, foot - SQUARE),
            Point2::new(MARGIN + SQUARE, foot),
        ];
        figure.rectangle(square, Some(*color), Some(Stroke::solid(Color::INK, 0.8)));
        let beside = Point2::new(MARGIN + 1.8 * SQUARE, foot - 1.0);
        figure.text(beside, name, LABEL_SIZE, Anchor::Start);
    }
}

/// The mean of the corners of a cell's faces.
fn center(mesh: &PolyMesh, cells: &CellFaces, cell: usize) -> Point3<f64> {
    let (mut sum, mut count) = (Point3::origin(), 0.0);
    for place in cells.of(cell).flat_map(|(face, _)| mesh.face_places(face)) {
        sum += place.coords;
        count += 1.0;
    }
    sum / f64::max(count, 1.0)
}

/// A cell's faces as seen from outside.
fn shell(mesh: &PolyMesh, cells: &CellFaces, cell: usize) -> Shell {
    let (mut places, mut facets) = (Vec::new(), Vec::new());
    for (face, is_owner) in cells.of(cell) {
        let start = places.len() as u32;
        places.extend(mesh.face_places(face));
        let mut facet: Vec<u32> = (start..places.len() as u32).collect();
        if !is_owner {
            facet.reverse();
        }
        facets.push(facet);
    }
    // All numbers are there.
    Shell::new(&places, facets).unwrap_or_default()
}
