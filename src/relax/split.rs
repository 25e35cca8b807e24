//! The split of a coarse level's sites into those of finer levels, each at a place of its own.
//!
//! A perfect tessellation of n/2^D cubes becomes a perfect one of n when every site is split into 2^D
//! at ± a quarter of its cell's side. Where a place that this gives is taken, or lies outside the domain
//! however near to the site, another one is drawn near the site: so every level has as many distinct
//! sites in the domain as it should, in domains of any shape. Draws are seeded by the site's number.

use std::collections::HashSet;

use nalgebra::{Point, SVector};

use crate::geometry::random::Random;
use crate::relax::multilevel::sites_of_level;
use crate::relax::optimum::optimal_side;
use crate::relax::relaxation_space::{RelaxationError, RelaxationSpace};

/// Sites nearer than this share of a quarter of the side are at one place. It is far above the rounding
/// of positions and far below the distances that a descent resolves.
const SAME_PLACE: f64 = 1e-6;

/// Draws within each box about a site, and how often that box is halved. In a box as small as the last
/// one a domain is a wedge; one in a thousand draws hits the sharpest that meshers make.
const DRAWS: u32 = 200;
const HALVINGS: u32 = 16;

/// Draws in the domain's whole box after that, where a site stands on the edge of a blade.
const LAST_DRAWS: u32 = 1_000_000;

/// The seed of all draws: they are part of the method, like the corners of a cube.
const SEED: u64 = 0;

/// The sites of the finest level, `count` of them: levels still to come are split one after another,
/// without moves. As they are where nothing has been coarsened.
///
/// # Errors
/// [`RelaxationError::NoRoom`].
pub(crate) fn split_to_finest<const D: usize, S: RelaxationSpace<D>>(
    space: &S,
    sites: &[Point<f64, D>],
    count: usize,
    level: u32,
) -> Result<Vec<Point<f64, D>>, RelaxationError<S::Error>> {
    let mut sites = sites.to_vec();
    if sites.len() == count {
        return Ok(sites);
    }
    for finer in (0..level).rev() {
        sites = refined(space, &sites, sites_of_level::<D>(count, finer))?;
    }
    Ok(sites)
}

/// `count` sites in place of the coarse ones: 2^D for each, at ± a quarter of the mean cell's side.
/// Where these are too many, some are left out, evenly; where they are too few, some of the coarse
/// sites stay among theirs.
///
/// # Errors
/// [`RelaxationError::NoRoom`].
pub(crate) fn refined<const D: usize, S: RelaxationSpace<D>>(
    space: &S,
    coarse: &[Point<f64, D>],
    count: usize,
) -> Result<Vec<Point<f64, D>>, RelaxationError<S::Error>> {
    if count <= coarse.len() {
        return Ok(coarse.to_vec());
    }
    let quarter = 0.25 * optimal_side::<D>(space.volume(), coarse.len());
    let mut split = Split {
        space,
        quarter,
        places: Places::new(space, SAME_PLACE * quarter),
    };
    let corners = coarse.len() << D;
    let surplus = corners.saturating_sub(count);
    let is_left_out =
        |number: usize| number * surplus / corners != (number + 1) * surplus / corners;
    let mut fine = Vec::with_capacity(count);
    for number in 0..corners.max(count) {
        if surplus > 0 && is_left_out(number) {
            continue;
        }
        let is_corner = number < corners;
        let near = &coarse[if is_corner {
            number >> D
        } else {
            (number - corners) % coarse.len()
        }];
        let wanted = if is_corner {
            split.corner(near, number & ((1 << D) - 1))
        } else {
            *near
        };
        let site = split.place(wanted, near, number as u64);
        fine.push(site.ok_or(RelaxationError::NoRoom {
            placed: fine.len(),
            wanted: count,
        })?);
    }
    Ok(fine)
}

/// A level's split under way.
struct Split<'a, const D: usize, S> {
    space: &'a S,
    /// A quarter of the mean cell's side (L).
    quarter: f64,
    places: Places<D>,
}

impl<const D: usize, S: RelaxationSpace<D>> Split<'_, D, S> {
    /// The site moved toward a corner of its cell; as it is where all of that way is outside.
    fn corner(&self, site: &Point<f64, D>, corner: usize) -> Point<f64, D> {
        let side = |axis, _| match corner >> axis & 1 {
            1 => self.quarter,
            _ => -self.quarter,
        };
        self.space.displaced(site, SVector::from_fn(side))
    }

    /// Takes the place `wanted`, or a free one near a coarse site; none where none was found.
    fn place(
        &mut self,
        wanted: Point<f64, D>,
        near: &Point<f64, D>,
        number: u64,
    ) -> Option<Point<f64, D>> {
        let wanted = self.space.wrap(&wanted);
        if self.places.take(&wanted) {
            return Some(wanted);
        }
        let mut random = Random::stream(SEED, number);
        for halving in 0..HALVINGS {
            let reach = self.quarter * 0.5_f64.powi(halving as i32);
            for _ in 0..DRAWS {
                let step = SVector::from_fn(|_, _| reach * (2.0 * random.uniform() - 1.0));
                let drawn = self.space.wrap(&(near + step));
                if self.space.contains(&drawn) && self.places.take(&drawn) {
                    return Some(drawn);
                }
            }
        }
        let bounds = self.space.bounds();
        let mut draws = (0..LAST_DRAWS).map(|_| random.point(&bounds));
        draws.find(|drawn| self.space.contains(drawn) && self.places.take(drawn))
    }
}

/// The places that sites have taken, in cubes of the side below which two places are one.
struct Places<const D: usize> {
    taken: HashSet<[i64; D]>,
    min: Point<f64, D>,
    periods: [Option<f64>; D],
    side: f64,
}

impl<const D: usize> Places<D> {
    fn new(space: &impl RelaxationSpace<D>, side: f64) -> Self {
        Self {
            taken: HashSet::new(),
            min: space.bounds().min,
            periods: space.periods(),
            side,
        }
    }

    /// Takes a place; false where it is taken. Of two places less than half a side apart along every
    /// axis, the second is refused.
    fn take(&mut self, point: &Point<f64, D>) -> bool {
        let at: [f64; D] = std::array::from_fn(|axis| (point[axis] - self.min[axis]) / self.side);
        let is_taken = (0..1 << D).any(|corner: usize| {
            let key = std::array::from_fn(|axis| {
                let key = match corner >> axis & 1 {
                    1 => at[axis].ceil(),
                    _ => at[axis].floor(),
                };
                self.key(key, axis)
            });
            self.taken.contains(&key)
        });
        if !is_taken {
            let key = std::array::from_fn(|axis| self.key(at[axis].round(), axis));
            self.taken.insert(key);
        }
        !is_taken
    }

    /// The number of a cube along an axis, the same for all its periodic images.
    fn key(&self, cube: f64, axis: usize) -> i64 {
        let cubes = self.periods[axis].map(|period| (period / self.side).round());
        cubes.map_or(cube, |cubes| cube.rem_euclid(cubes)) as i64
    }
}
