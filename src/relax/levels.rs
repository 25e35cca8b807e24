//! Coarse to fine: few sites that stand for many, and many that follow from few.
//!
//! A perfect tessellation of n/8 cubes becomes a perfect one of n by splitting every site into
//! eight at ± a quarter of its cell's side: what is hard to find, the arrangement of rows, is found
//! where it is cheap.

use nalgebra::{Point3, Vector3};

use crate::relax::noise::displaced;
use crate::relax::record::optimal_side;
use crate::relax::space::Space;
use crate::relax::tessellation::Tessellation;

/// How many sites a level works on: `count` / 8^level, rounded, at least one.
#[must_use]
pub fn sites_of_level(count: usize, level: u32) -> usize {
    let coarse = count as f64 / 8.0_f64.powi(level as i32);
    (coarse.round() as usize).max(1)
}

/// The fewest sites of a coarse level: a cube of three by three by three has a cell without walls.
const FEWEST: usize = 27;

/// Counts that eight does not divide are split anyway while there are more than this: they cannot
/// become a grid of cubes, and searching among so many sites takes long.
const MANY: usize = 4000;

/// How many levels lie below `count` sites that are to become cubes: as long as eight divides
/// them, and a grid that fits stays one when it is split.
#[must_use]
pub fn levels_for_cubes(count: usize) -> u32 {
    let mut level = 0;
    while sites_of_level(count, level + 1) >= FEWEST
        && (count.is_multiple_of(8_usize.pow(level + 1)) || sites_of_level(count, level) > MANY)
    {
        level += 1;
    }
    level
}

/// `count` of the sites, spread as they are: the sites are cut in halves across their longest
/// extent until as many groups are left, and each is represented by the member nearest its mean.
#[must_use]
pub fn coarsened(sites: &[Point3<f64>], count: usize) -> Vec<Point3<f64>> {
    let mut members = sites.to_vec();
    let mut chosen = Vec::with_capacity(count);
    divide(&mut members, count.min(sites.len()), &mut chosen);
    chosen
}

fn divide(members: &mut [Point3<f64>], count: usize, chosen: &mut Vec<Point3<f64>>) {
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
    let extents = [extent(0), extent(1), extent(2)];
    let axis = (1..3).fold(0, |longest, axis| {
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

fn representative(members: &[Point3<f64>]) -> Option<Point3<f64>> {
    let sum: Vector3<f64> = members.iter().map(|site| site.coords).sum();
    let mean = Point3::from(sum / members.len() as f64);
    let distance = |site: &Point3<f64>| (site - mean).norm_squared();
    members
        .iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .copied()
}

/// `count` sites in place of the coarse ones: eight for each, at ± a quarter of the mean cell's
/// side. Where eight of each are too many, some are left out, evenly; where they are too few, some
/// of the coarse sites stay among their eight.
#[must_use]
pub fn refined(space: &Space, coarse: &[Point3<f64>], count: usize) -> Vec<Point3<f64>> {
    let quarter = 0.25 * optimal_side::<3>(space.volume(), coarse.len());
    let mut fine = Vec::with_capacity(8 * coarse.len());
    for site in coarse {
        for corner in 0..8 {
            let side = |axis: usize| {
                if corner >> axis & 1 == 1 {
                    quarter
                } else {
                    -quarter
                }
            };
            let way = Vector3::new(side(0), side(1), side(2));
            fine.push(displaced(space, site, way));
        }
    }
    let missing = count.saturating_sub(fine.len());
    fine.extend(coarse.iter().take(missing));
    let surplus = fine.len() - count.min(fine.len());
    if surplus > 0 {
        let all = fine.len();
        let is_left_out = |number: usize| number * surplus / all != (number + 1) * surplus / all;
        let mut number = 0;
        fine.retain(|_| {
            number += 1;
            !is_left_out(number - 1)
        });
    }
    fine
}
