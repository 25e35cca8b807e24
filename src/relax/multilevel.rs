//! Coarse-to-fine relaxation: the numbers of sites of its levels, and the choice of few sites for many.
//!
//! What is hard to find, the arrangement of rows, is found where it is cheap; `split` makes a finer
//! level of a coarse one.

use nalgebra::{Point, SVector};

/// How many sites a level works on: `count` / 2^(D·level), rounded, at least one.
#[must_use]
pub(crate) fn sites_of_level<const D: usize>(count: usize, level: u32) -> usize {
    let coarse = count as f64 / 2.0_f64.powi((D as u32 * level) as i32);
    (coarse.round() as usize).max(1)
}

/// The fewest sites of a coarse level along every axis: a cube of three by three by three has a cell without
/// walls.
const FEWEST: usize = 3;

/// Counts that eight (in the plane four) does not divide are split anyway while there are more than this: they cannot
/// become a grid of cubes, and searching among so many sites takes long.
const MANY: usize = 4000;

/// How many levels lie below `count` sites that are to become cubes: as long as eight (in the plane four)
/// divides them, and a grid that fits stays one when it is split.
#[must_use]
pub(crate) fn levels_for_cubes<const D: usize>(count: usize) -> u32 {
    let mut level = 0;
    while sites_of_level::<D>(count, level + 1) >= FEWEST.pow(D as u32)
        && (count.is_multiple_of((1_usize << D).pow(level + 1))
            || sites_of_level::<D>(count, level) > MANY)
    {
        level += 1;
    }
    level
}

/// `count` of the sites, spread as they are: the sites are cut in halves across their longest
/// extent until as many groups are left, and each is represented by the member nearest its mean.
#[must_use]
pub(crate) fn coarsened<const D: usize>(
    sites: &[Point<f64, D>],
    count: usize,
) -> Vec<Point<f64, D>> {
    let mut members = sites.to_vec();
    let mut chosen = Vec::with_capacity(count);
    divide(&mut members, count.min(sites.len()), &mut chosen);
    chosen
}

fn divide<const D: usize>(
    members: &mut [Point<f64, D>],
    count: usize,
    chosen: &mut Vec<Point<f64, D>>,
) {
    if count <= 1 || members.len() <= 1 {
        chosen.extend(representative(members));
        return;
    }
    let extent = |axis: usize| {
        let ends = members
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), site| {
                (low.min(site[axis]), high.max(site[axis]))
            });
        ends.1 - ends.0
    };
    let extents: [f64; D] = std::array::from_fn(extent);
    let axis = (1..D).fold(0, |longest, axis| {
        if extents[axis] > extents[longest] {
            axis
        } else {
            longest
        }
    });
    members.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    let lower_count = count / 2;
    let middle = (members.len() * lower_count).div_ceil(count);
    let (lower, upper) = members.split_at_mut(middle);
    divide(lower, lower_count, chosen);
    divide(upper, count - lower_count, chosen);
}

fn representative<const D: usize>(members: &[Point<f64, D>]) -> Option<Point<f64, D>> {
    let sum: SVector<f64, D> = members.iter().map(|site| site.coords).sum();
    let mean = Point::from(sum / members.len() as f64);
    let distance = |site: &Point<f64, D>| (site - mean).norm_squared();
    members
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .copied()
}
