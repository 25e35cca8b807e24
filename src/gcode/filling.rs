//! The share of space that a layer of infill fills, from its lines alone.
//!
//! The layer's region is drawn on a raster: squares that lines pass through, and those between two of them
//! in a row or a column no farther apart than [`GAP`].

use nalgebra::{Point2, Vector2};

use crate::gcode::bead::Path;

/// Lines of sparse infill lie closer than this (mm): 5 % of lines 0.5 mm wide are 10 mm apart.
const GAP: f64 = 12.0;

/// The side of a square (mm), and the most of them along a side of the raster.
const SQUARE: f64 = 0.2;
const MOST: usize = 1500;

/// The share that so much `volume` (mm³) along `paths` fills of a layer of `height`.
pub(crate) fn local_filling(paths: &[Path], volume: f64, height: f64) -> Option<f64> {
    let raster = Raster::of(paths)?;
    let area = raster.region() as f64 * raster.side * raster.side;
    let share = volume / (area * height);
    (share > 0.0 && share.is_finite()).then_some(share.min(1.0))
}

/// Squares that lines pass through.
struct Raster {
    side: f64,
    columns: usize,
    rows: usize,
    marked: Vec<bool>,
}

impl Raster {
    fn of(paths: &[Path]) -> Option<Self> {
        let ends = || {
            paths
                .iter()
                .flat_map(|path| [0.0, 0.5, 1.0].map(|share| path.at(share).xy()))
        };
        let low = ends().reduce(|low, end| low.inf(&end))?;
        let high = ends().reduce(|high, end| high.sup(&end))?;
        let size: Vector2<f64> = high - low;
        let side = (size.amax() / (MOST as f64 - 2.0)).max(SQUARE);
        let [columns, rows] = [size.x, size.y].map(|length| (length / side) as usize + 1);
        let mut raster = Self {
            side,
            columns,
            rows,
            marked: vec![false; columns * rows],
        };
        for path in paths {
            raster.mark(path, &low);
        }
        Some(raster)
    }

    /// Marks the squares that a path passes through.
    fn mark(&mut self, path: &Path, low: &Point2<f64>) {
        let steps = (2.0 * path.length() / self.side).ceil().clamp(1.0, 1e5) as u32;
        for step in 0..=steps {
            let place = (path.at(f64::from(step) / f64::from(steps)).xy() - low) / self.side;
            let [column, row] = [place.x, place.y].map(|place| place.max(0.0) as usize);
            if column < self.columns && row < self.rows {
                self.marked[row * self.columns + column] = true;
            }
        }
    }

    /// How many squares the region has.
    fn region(&self) -> usize {
        let gap = (GAP / self.side) as usize;
        let mut inside = self.marked.clone();
        for row in 0..self.rows {
            let line = (0..self.columns).map(|column| row * self.columns + column);
            self.bridge(line, gap, &mut inside);
        }
        for column in 0..self.columns {
            let line = (0..self.rows).map(|row| row * self.columns + column);
            self.bridge(line, gap, &mut inside);
        }
        inside.iter().filter(|is_inside| **is_inside).count()
    }

    /// Takes in the squares between two marked ones of a row or column.
    fn bridge(&self, line: impl Iterator<Item = usize>, gap: usize, inside: &mut [bool]) {
        let mut between: Option<Vec<usize>> = None;
        for place in line {
            if self.marked[place] {
                let bridged = between.replace(Vec::new()).unwrap_or_default();
                if bridged.len() <= gap {
                    bridged.into_iter().for_each(|place| inside[place] = true);
                }
            } else if let Some(between) = &mut between {
                between.push(place);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Point3;

    /// Lines 20 mm up over 60 mm, so far apart, leaning by `slope`.
    fn hatch(apart: f64, slope: f64) -> Vec<Path> {
        let spacing = apart * (1.0 + slope * slope).sqrt();
        let count = (60.0 / spacing) as u32;
        let line = |number| {
            let x = f64::from(number) * spacing;
            let (from, to) = (
                Point3::new(x, 0.0, 0.2),
                Point3::new(x + slope * 20.0, 20.0, 0.2),
            );
            Path::Line { from, to }
        };
        (0..count).map(line).collect()
    }

    #[test]
    fn lines_of_known_spacing_fill_what_they_should() {
        for (apart, slope) in [(1.0, 0.0), (2.0, 0.0), (4.5, 0.0), (2.0, 0.5)] {
            let paths = hatch(apart, slope);
            let length: f64 = paths.iter().map(Path::length).sum();
            let share = local_filling(&paths, length * 0.4 * 0.2, 0.2).unwrap();
            let expected = 0.4 / apart;
            assert!((share / expected - 1.0).abs() < 0.12, "{apart}: {share}");
        }
        assert_eq!(local_filling(&[], 1.0, 0.2), None);
    }
}
