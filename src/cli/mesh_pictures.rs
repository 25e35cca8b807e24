//! Histograms of quality and cells by kind, for the pictures of `chebloyd mesh`.

use crate::cli::mesh_report::MeshReport;
use crate::complex::element::{CellElement, KINDS};
use crate::complex::quality::MeasuredMesh;
use crate::plot::color::Color;
use crate::plot::histograms::Histogram;

/// The colors of [`KINDS`] (Okabe & Ito 2008).
const COLORS: [Color; 5] = [
    Color::hex(0x56_b4_e9),
    Color::hex(0x00_9e_73),
    Color::hex(0xe6_9f_00),
    Color::hex(0xcc_79_a7),
    Color::hex(0xe0_dc_d0),
];

/// The axis of angles ends at a multiple of this (degrees).
const ANGLES: f64 = 10.0;

/// The kind of every cell, and what the legend says of the kinds that are there.
pub(crate) fn kinds_and_legend(
    measured: &MeasuredMesh<'_>,
    report: &MeshReport,
) -> (Vec<usize>, Vec<(String, Color)>) {
    let kinds = measured.elements.iter().map(CellElement::kind);
    let legend = KINDS.into_iter().zip(COLORS).map(|(name, color)| {
        let (count, percent) = report.share(name);
        let text = match count {
            0 => String::new(),
            _ => format!("{name}: {count}, {percent:.1} % of the volume"),
        };
        (text, color)
    });
    (kinds.collect(), legend.collect())
}

/// Non-orthogonality, skewness, faces of cells, and scaled Jacobians.
pub(crate) fn quality_histograms(measured: &MeasuredMesh<'_>) -> Vec<Histogram> {
    let (angles, skewness) = (measured.non_orthogonality(), measured.skewness());
    let sizes: Vec<f64> = (0..measured.mesh.cell_count)
        .map(|cell| measured.cells.of(cell).len() as f64)
        .collect();
    let jacobians = measured.scaled_jacobians();
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let steepest = (most(&angles) / ANGLES).ceil().max(1.0) * ANGLES;
    let skewest = most(&skewness).ceil().max(1.0);
    let widest = most(&sizes).clamp(8.0, 40.0);
    let histogram = |title, name, values, ends, bars| Histogram {
        title,
        name,
        values,
        ends,
        bars,
    };
    vec![
        histogram(
            "Non-orthogonality",
            "degrees; faces between cells",
            angles,
            [0.0, steepest],
            40,
        ),
        histogram("Skewness", "all faces", skewness, [0.0, skewest], 40),
        histogram(
            "Faces of a cell",
            "cells",
            sizes,
            [3.5, widest + 0.5],
            widest as usize - 3,
        ),
        histogram("Scaled Jacobian", "hexahedra", jacobians, [0.0, 1.0], 40),
    ]
}
