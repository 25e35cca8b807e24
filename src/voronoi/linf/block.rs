//! Blocks of a cone: at all heights between two, its section has one rectangle whose sides move evenly.

use crate::arrays::MapEach;

/// The source of the sides of a cone itself.
pub(crate) const CONE_SIDE: u32 = u32::MAX;

/// A coordinate across a cone that is offset + slope · h at the height h (L); the slope is −1, 0 or 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Line {
    pub(crate) offset: f64,
    pub(crate) slope: f64,
    /// Who or what is beyond.
    pub(crate) source: u32,
}

impl Line {
    /// The coordinate at a height (L).
    #[inline]
    pub(crate) fn at(&self, height: f64) -> f64 {
        self.offset + self.slope * height
    }
}

/// A rectangle of a section, from a low to a high line along u and along v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Column {
    pub(crate) u: [Line; 2],
    pub(crate) v: [Line; 2],
}

impl Column {
    /// The height from which on there is nothing between the lines along v; infinite if they never meet.
    ///
    /// Half the sum of two coordinates is rounded once, and always in the same way.
    #[inline]
    pub(crate) fn closing(&self) -> f64 {
        let [low, high] = self.v;
        let (gap, rate) = (high.offset - low.offset, high.slope - low.slope);
        if rate < -1.5 {
            0.5 * gap
        } else if rate < -0.5 {
            gap
        } else if rate > 0.5 || gap > 0.0 {
            f64::INFINITY
        } else {
            0.0
        }
    }

    /// Its extents along u and v at a height (L).
    #[inline]
    fn extents(&self, height: f64) -> [f64; 2] {
        [self.u, self.v].map_each(|[low, high]| {
            let extent = high.at(height) - low.at(height);
            if extent > 0.0 { extent } else { 0.0 }
        })
    }
}

/// A column between two heights: a convex part of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    pub(crate) column: Column,
    /// From and to (L).
    pub(crate) heights: [f64; 2],
}

impl Block {
    /// ∫ h^p over the block (L^(3+p)).
    ///
    /// With the share t of the way from h0 to h1, h = h0 (1−t) + h1 t and the extents likewise: products of
    /// (1−t)^i t^j, whose integrals are i! j! / (i + j + 1)!. No term is negative.
    #[inline]
    pub(crate) fn integral(&self, order: u32) -> f64 {
        let [low, high] = self.heights;
        let [[u0, v0], [u1, v1]] = self.heights.map_each(|height| self.column.extents(height));
        let areas = [u0 * v0, u0 * v1 + u1 * v0, u1 * v1];
        let p = f64::from(order);
        let mut sum = 0.0;
        for term in 0..=order {
            let (m, rest) = (f64::from(term), f64::from(order - term));
            let weights = [
                (rest + 2.0) * (rest + 1.0),
                (rest + 1.0) * (m + 1.0),
                (m + 2.0) * (m + 1.0),
            ];
            let power = low.powi((order - term) as i32) * high.powi(term as i32);
            sum += power * (weights[0] * areas[0] + weights[1] * areas[1] + weights[2] * areas[2]);
        }
        (high - low) * sum / ((p + 1.0) * (p + 2.0) * (p + 3.0))
    }

    /// Its corners (h, u, v), where two may be one.
    pub(crate) fn corners(&self) -> [[f64; 3]; 8] {
        std::array::from_fn(|corner| {
            let height = self.heights[corner & 1];
            let [u, v] = [
                self.column.u[corner >> 1 & 1],
                self.column.v[corner >> 2 & 1],
            ];
            [height, u.at(height), v.at(height)]
        })
    }

    /// The part up to a height; `None` if there is none.
    pub(crate) fn up_to(&self, height: f64) -> Option<Self> {
        let [from, to] = self.heights;
        (from < height).then_some(Self {
            heights: [from, to.min(height)],
            ..*self
        })
    }
}

/// Things that stay the same over several intervals of height are one, from the first to the last.
#[derive(Clone, Debug)]
pub(crate) struct Lasting<T> {
    open: Vec<(T, f64)>,
    spare: Vec<(T, f64)>,
}

impl<T> Default for Lasting<T> {
    fn default() -> Self {
        Self {
            open: Vec::new(),
            spare: Vec::new(),
        }
    }
}

impl<T: Copy + PartialEq> Lasting<T> {
    /// Forgets what there is.
    pub(crate) fn clear(&mut self) {
        self.open.clear();
    }

    /// What there is from `height` on; passes what there was until then, and is no more, to `ended`.
    pub(crate) fn turn(
        &mut self,
        now: impl Iterator<Item = T>,
        height: f64,
        mut ended: impl FnMut(T, [f64; 2]),
    ) {
        self.spare.clear();
        // Most follow each other as they did before.
        let mut next = 0;
        for thing in now {
            let (earlier, later) = self.open.split_at(next);
            let is_same = |(other, _): &(T, f64)| *other == thing;
            let before = match later.iter().position(is_same) {
                Some(place) => Some(next + place),
                None => earlier.iter().position(is_same),
            };
            let mut since = height;
            if let Some(place) = before {
                // What has been carried over must not end.
                since = std::mem::replace(&mut self.open[place].1, f64::NAN);
                next = place + 1;
            }
            self.spare.push((thing, since));
        }
        for &(thing, since) in &self.open {
            if since < height {
                ended(thing, [since, height]);
            }
        }
        std::mem::swap(&mut self.open, &mut self.spare);
    }
}
