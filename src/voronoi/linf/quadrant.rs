//! Quadrants of neighbors and walls, which cut a cone.

use crate::voronoi::linf::block::{CONE_SIDE, Line};

/// Where a neighbor is nearer than the site, in one cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quadrant {
    /// The height from which on it is in the section (L).
    pub(crate) start: f64,
    /// The neighbor's distances along u and v (L).
    pub(crate) across: [f64; 2],
    /// Whether it lies towards negative u and v.
    pub(crate) is_low: [bool; 2],
    /// Whether it starts at once on all of its extent: half-way to the neighbor.
    pub(crate) is_ahead: bool,
    pub(crate) source: u32,
}

impl Quadrant {
    pub(crate) fn contains(&self, other: &Self) -> bool {
        self.is_low == other.is_low
            && self.across[0] <= other.across[0]
            && self.across[1] <= other.across[1]
            && self.start <= other.start
    }

    /// The height at which the direction (1, u, v) comes into it (L).
    pub(crate) fn entry(&self, direction: [f64; 2]) -> f64 {
        let along = |along: usize| {
            let sign = if self.is_low[along] { -1.0 } else { 1.0 };
            let (distance, rate) = (self.across[along], 1.0 + sign * direction[along]);
            if distance > 0.0 { distance / rate } else { 0.0 }
        };
        self.start.max(along(0)).max(along(1))
    }

    /// The coordinate of its side along an axis across.
    pub(crate) fn side(&self, along: usize) -> Line {
        front_line(self.across[along], self.is_low[along], self.source)
    }
}

/// Walls along the axes: the distance (L) and who is beyond, along u and v, low and high, and ahead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConeWalls {
    pub(crate) across: [[(f64, u32); 2]; 2],
    pub(crate) ahead: (f64, u32),
}

impl Default for ConeWalls {
    fn default() -> Self {
        let none = (f64::INFINITY, CONE_SIDE);
        Self {
            across: [[none; 2]; 2],
            ahead: none,
        }
    }
}

impl ConeWalls {
    /// The section's own end along an axis: the wall once it is reached, else the cone's side.
    #[inline]
    pub(crate) fn end(&self, along: usize, is_high: bool, height: f64) -> Line {
        let (distance, source) = self.across[along][usize::from(is_high)];
        let sign = if is_high { 1.0 } else { -1.0 };
        if distance <= height {
            return Line {
                offset: sign * distance,
                slope: 0.0,
                source,
            };
        }
        Line {
            offset: 0.0,
            slope: sign,
            source: CONE_SIDE,
        }
    }

    /// The first wall beyond a height (L).
    pub(crate) fn next(&self, height: f64) -> f64 {
        let walls = self.across.iter().flatten().map(|wall| wall.0);
        let beyond = walls.filter(|&distance| distance > height);
        beyond.fold(self.ahead.0, f64::min)
    }
}

/// The line of a quadrant's side, offset from the site by `at`, that comes from below or above.
#[inline]
pub(crate) fn front_line(at: f64, is_low: bool, source: u32) -> Line {
    let sign = if is_low { -1.0 } else { 1.0 };
    Line {
        offset: sign * at,
        slope: -sign,
        source,
    }
}
