//! Histograms of a mesh's quality, side by side.

use nalgebra::Point2;

use crate::plot::axis::Axis;
use crate::plot::convergence::COLORS;
use crate::plot::figure::Figure;
use crate::plot::panel::Panel;

/// Numbers to count.
#[derive(Clone, Debug)]
pub(crate) struct Histogram {
    /// What is above the panel.
    pub(crate) title: &'static str,
    /// What is below it.
    pub(crate) name: &'static str,
    /// The numbers.
    pub(crate) values: Vec<f64>,
    /// The ends of the axis; numbers beyond them count for the first or last bar.
    pub(crate) ends: [f64; 2],
    /// How many bars there are.
    pub(crate) bars: usize,
}

/// The first frame, and the steps to those right of it and below.
const FRAME: [Point2<f64>; 2] = [Point2::new(76.0, 34.0), Point2::new(416.0, 224.0)];
const STEPS: [f64; 2] = [430.0, 270.0];

/// Panels in a row.
const COLUMNS: usize = 2;

/// The space that a bar leaves to the next one, as a share of it.
const GAP: f64 = 0.12;

/// All histograms in rows of two.
#[must_use]
pub(crate) fn histograms(all: &[Histogram]) -> Figure {
    let rows = all.len().div_ceil(COLUMNS).max(1);
    let mut figure = Figure::new(
        COLUMNS as f64 * STEPS[0] + 10.0,
        rows as f64 * STEPS[1] + 8.0,
    );
    for (place, histogram) in all.iter().enumerate() {
        let (column, row) = (place % COLUMNS, place / COLUMNS);
        let mut frame = FRAME;
        for corner in &mut frame {
            corner.x += column as f64 * STEPS[0];
            corner.y += row as f64 * STEPS[1];
        }
        draw(&mut figure, histogram, frame);
    }
    figure
}

/// The share (%) of the numbers in each bar.
fn shares(histogram: &Histogram) -> Vec<f64> {
    let [low, high] = histogram.ends;
    let mut counts = vec![0.0; histogram.bars];
    for value in &histogram.values {
        let place = (value - low) / (high - low) * histogram.bars as f64;
        counts[(place.max(0.0) as usize).min(histogram.bars - 1)] += 1.0;
    }
    let all = (histogram.values.len() as f64).max(1.0);
    counts.iter().map(|count| 100.0 * count / all).collect()
}

fn draw(figure: &mut Figure, histogram: &Histogram, frame: [Point2<f64>; 2]) {
    let shares = shares(histogram);
    let [low, high] = histogram.ends;
    let highest = shares.iter().copied().fold(0.0, f64::max);
    // A mesh is as good as its few worst cells: bars of one number are seen on a logarithmic axis only.
    let one = 100.0 / (histogram.values.len() as f64).max(1.0);
    let panel = Panel {
        frame,
        x: Axis::within(low, high),
        y: Axis::logarithmic(0.5 * one, highest.max(one)),
    };
    panel.draw_grid(figure);
    let width = (high - low) / histogram.bars as f64;
    for (bar, share) in shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
        let left = low + width * (bar as f64 + 0.5 * GAP);
        let ends = [
            panel.place(left, *share),
            panel.place(left + width * (1.0 - GAP), panel.y.min),
        ];
        figure.rectangle(ends, Some(COLORS[0]), None);
    }
    let below = format!("{}: {}", histogram.name, range(&histogram.values));
    panel.draw_frame(figure, histogram.title, &below, "%");
}

/// How many numbers there are, the least and the greatest.
fn range(values: &[f64]) -> String {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let is_whole = values.iter().all(|value| value.fract() == 0.0);
    let digits = if is_whole { 0 } else { 3 };
    match values.len() {
        0 => "none".to_owned(),
        count => format!("{count}, {least:.digits$} to {most:.digits$}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_counts_once_also_beyond_the_ends() {
        let histogram = Histogram {
            title: "",
            name: "",
            values: vec![-5.0, 0.0, 0.49, 0.5, 1.0, 7.0, 0.2, 0.7],
            ends: [0.0, 1.0],
            bars: 2,
        };
        assert_eq!(shares(&histogram), [50.0, 50.0]);
        assert_eq!(range(&histogram.values), "8, -5.000 to 7.000");
        assert_eq!(range(&[4.0, 6.0]), "2, 4 to 6");
        assert_eq!(range(&[]), "none");
        let figure = histograms(&[histogram]);
        assert!((figure.height - STEPS[1] - 8.0).abs() < 1e-9);
    }
}
