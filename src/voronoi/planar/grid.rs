//! A uniform grid over sites of the plane, visited in rings of growing distance.

use nalgebra::Point2;

use crate::geometry::bounds::Bounds;

/// Sites per square of the grid, on average: few enough that a ring holds little that is far.
const SITES_PER_SQUARE: f64 = 2.0;

/// The sites, sorted into equal squares.
#[derive(Debug)]
pub(crate) struct PlaneGrid {
    min: Point2<f64>,
    side: f64,
    columns: usize,
    rows: usize,
    /// Where the sites of square k begin in `sites`; one more entry than squares.
    starts: Vec<usize>,
    sites: Vec<usize>,
}

impl PlaneGrid {
    /// Sorts `sites` into squares that cover them.
    pub(crate) fn new(sites: &[Point2<f64>]) -> Self {
        let bounds = Bounds::of(sites);
        let extent = bounds.extent();
        let squares = (sites.len() as f64 / SITES_PER_SQUARE).max(1.0);
        // The second keeps the number of squares linear for sites on a line, the third is for one.
        let side = (extent.x * extent.y / squares)
            .sqrt()
            .max(extent.amax() / squares)
            .max(f64::MIN_POSITIVE);
        let mut grid = Self {
            min: bounds.min,
            side,
            columns: (extent.x / side).ceil().max(1.0) as usize,
            rows: (extent.y / side).ceil().max(1.0) as usize,
            starts: Vec::new(),
            sites: Vec::new(),
        };
        grid.sort(sites);
        grid
    }

    /// The number of rings after which every site has been visited, from any square.
    pub(crate) fn rings(&self) -> usize {
        self.columns.max(self.rows)
    }

    /// A lower bound of the distance from any point of a square to the sites in ring `ring` about
    /// that square and beyond (L).
    pub(crate) fn distance(&self, ring: usize) -> f64 {
        ring.saturating_sub(1) as f64 * self.side
    }

    /// The sites whose square is `ring` squares away, in a fixed order.
    pub(crate) fn ring(&self, from: &Point2<f64>, ring: usize) -> impl Iterator<Item = usize> {
        let (column, row) = self.square_of(from);
        let rows = row.saturating_sub(ring)..(row + ring + 1).min(self.rows);
        rows.flat_map(move |r| {
            let whole = r.abs_diff(row) == ring;
            let columns = column.saturating_sub(ring)..(column + ring + 1).min(self.columns);
            columns
                .filter(move |c| whole || c.abs_diff(column) == ring)
                .flat_map(move |c| self.sites_in(r * self.columns + c))
        })
    }

    fn sites_in(&self, square: usize) -> impl Iterator<Item = usize> + '_ {
        self.sites[self.starts[square]..self.starts[square + 1]]
            .iter()
            .copied()
    }

    fn square_of(&self, point: &Point2<f64>) -> (usize, usize) {
        let steps = (point - self.min) / self.side;
        // The cast sends everything below zero to zero.
        (
            (steps.x as usize).min(self.columns - 1),
            (steps.y as usize).min(self.rows - 1),
        )
    }

    /// A counting sort: sites of one square keep their order.
    fn sort(&mut self, sites: &[Point2<f64>]) {
        let squares: Vec<usize> = sites
            .iter()
            .map(|site| {
                let (column, row) = self.square_of(site);
                row * self.columns + column
            })
            .collect();
        self.starts = vec![0; self.columns * self.rows + 1];
        for &square in &squares {
            self.starts[square + 1] += 1;
        }
        for square in 1..self.starts.len() {
            self.starts[square] += self.starts[square - 1];
        }
        let mut next = self.starts.clone();
        self.sites = vec![0; sites.len()];
        for (site, &square) in squares.iter().enumerate() {
            self.sites[next[square]] = site;
            next[square] += 1;
        }
    }
}
