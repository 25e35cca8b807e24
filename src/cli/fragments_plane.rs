//! `chebloyd fragments` in the plane: one cell beside its four fragments as triangles.

use std::io::Write;
use std::path::Path;

use nalgebra::Point2;

use crate::cli::cell_files::PNG_SCALE;
use crate::cli::failure::{Failure, write_file};
use crate::energy::planar::visit;
use crate::plot::planar_fragments::{FlatCell, FlatTriangle, fragments_figure};
use crate::plot::png::png;
use crate::plot::svg::svg;
use crate::relax::planar::Plane;
use crate::relax::planar_cell::CellInPlane;
use crate::relax::relaxation_space::RelaxationSpace;
use crate::scene::description::Scene;
use crate::scene::run::{RunSpace, plane};
use crate::voronoi::planar::diagram::{PlaneCell, PlaneDiagram};

/// Draws the cell of `site`, by default that nearest the middle of the domain, as `format`.
pub(crate) fn draw_fragments(
    scene: &Scene,
    site: Option<usize>,
    (path, format): (&Path, &str),
) -> Result<(), Failure> {
    let plane = plane(scene).map_err(Failure::input)?;
    let sites = plane.place(scene).map_err(Failure::input)?;
    let number = site.unwrap_or_else(|| middle(&plane, &sites));
    if number >= sites.len() {
        let count = sites.len();
        let message = format!("there is no site {number} among {count}; the first is 0");
        return Err(Failure::input(message));
    }
    let diagram = PlaneDiagram::new(&plane.domain, &sites).map_err(Failure::input)?;
    let figure = fragments_figure(&flat_cell(&plane, &diagram.cells[number], number));
    let bytes = match format {
        "svg" => svg(&figure).into_bytes(),
        _ => png(&figure, PNG_SCALE).map_err(Failure::run)?,
    };
    write_file(path, |file| file.write_all(&bytes)).map_err(Failure::input)
}

/// The site nearest the middle of the domain's box.
fn middle(plane: &Plane, sites: &[Point2<f64>]) -> usize {
    let center = plane.bounds().center();
    let distance = |site: usize| (sites[site] - center).norm_squared();
    let nearest = (0..sites.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    nearest.unwrap_or_default()
}

fn flat_cell(plane: &Plane, cell: &PlaneCell, number: usize) -> FlatCell {
    let domain = &plane.domain;
    let energy = CellInPlane { domain, cell }.energy(1).at_site();
    let mut triangles = Vec::new();
    for piece in cell.pieces() {
        visit(piece, &Point2::origin(), |triangle| {
            // Pieces beside the site count the triangles before them as negative.
            if triangle.signed_area() > 0.0 {
                triangles.push(FlatTriangle {
                    axis: triangle.axis,
                    sign: triangle.sign,
                    ends: [triangle.start, triangle.end],
                });
            }
        });
    }
    FlatCell {
        caption: format!("site {number}: energy {energy:.6e}"),
        sum: format!("the sum over {} triangles", triangles.len()),
        pieces: cell.pieces().to_vec(),
        area: cell.area(),
        triangles,
    }
}
