//! Least-variance densities and least contrasts of small sums of elements, against what brute force,
//! bisection and hand calculation find.

use nalgebra::{DMatrix, DVector};

use crate::balance::contrast::{RangeGrowth, least_contrast, least_growth, refute};
use crate::balance::dual::{Balance, DensityRange, DualPoint, Relation};
use crate::balance::quadratic::minimize_quadratic;
use crate::balance::solve::{SolveEnd, least_variance};
use crate::geometry::random::Random;

/// Grains of one density each: their volumes, and what each adds to the conditions at density 1.
#[derive(Debug)]
struct Grains {
    volumes: Vec<f64>,
    rows: Vec<DVector<f64>>,
    constants: DVector<f64>,
    relations: Vec<Relation>,
}

impl Grains {
    fn density(
        range: &DensityRange,
        multipliers: &DVector<f64>,
        row: &DVector<f64>,
        volume: f64,
    ) -> f64 {
        (range.prefer + multipliers.dot(row) / volume).clamp(range.low, range.high)
    }
}

impl Balance for Grains {
    fn relations(&self) -> &[Relation] {
        &self.relations
    }

    fn constants(&self) -> DVector<f64> {
        self.constants.clone()
    }

    fn dual(&self, range: &DensityRange, multipliers: &DVector<f64>, whole: bool) -> DualPoint {
        let count = self.relations.len();
        let mut residual = self.constants.clone();
        let mut curvature = DMatrix::zeros(count, count);
        let mut distance = 0.0;
        for (volume, row) in self.volumes.iter().zip(&self.rows) {
            let density = Self::density(range, multipliers, row, *volume);
            residual += row * density;
            distance += 0.5 * volume * (density - range.prefer).powi(2);
            if whole || (range.low < density && density < range.high) {
                curvature += row * row.transpose() / *volume;
            }
        }
        DualPoint {
            value: distance - multipliers.dot(&residual),
            residual,
            curvature,
        }
    }

    fn totals(&self) -> DVector<f64> {
        let count = self.relations.len();
        self.rows
            .iter()
            .fold(DVector::zeros(count), |sum, row| sum + row)
    }

    fn positive_part(&self, multipliers: &DVector<f64>) -> (f64, DVector<f64>) {
        let zero = (0.0, DVector::zeros(self.relations.len()));
        self.rows.iter().fold(zero, |(value, gradient), row| {
            let product = multipliers.dot(row);
            if product > 0.0 {
                (value + product, gradient + row)
            } else {
                (value, gradient)
            }
        })
    }
}

/// Slices of the unit interval whose center is to be at `target`.
fn slices(count: usize, target: f64) -> Grains {
    let size = 1.0 / count as f64;
    Grains {
        volumes: vec![size; count],
        rows: (0..count)
            .map(|k| DVector::from_element(1, size * (target - (k as f64 + 0.5) * size)))
            .collect(),
        constants: DVector::zeros(1),
        relations: vec![Relation::Equal],
    }
}

/// Grains at random points of a box, whose center is to be at `target`.
fn cloud(count: usize, target: [f64; 3], seed: u64) -> Grains {
    let mut random = Random::new(seed);
    let volumes: Vec<f64> = (0..count).map(|_| 0.5 + random.uniform()).collect();
    let row =
        |volume: &f64| DVector::from_fn(3, |axis, _| volume * (target[axis] - random.uniform()));
    Grains {
        rows: volumes.iter().map(row).collect(),
        volumes,
        constants: DVector::zeros(3),
        relations: vec![Relation::Equal; 3],
    }
}

fn range(low: f64, high: f64, prefer: f64) -> DensityRange {
    DensityRange { low, high, prefer }
}

#[test]
fn quadratic_programs_are_minimized_over_all_active_sets() {
    let mut random = Random::new(5);
    for case in 0..200 {
        let root = DMatrix::from_fn(4, 4, |_, _| random.gaussian());
        let matrix = &root * root.transpose();
        let linear = DVector::from_fn(4, |_, _| random.gaussian());
        let relations: Vec<_> = (0..4)
            .map(|k| {
                if k < case % 5 {
                    Relation::AtLeast
                } else {
                    Relation::Equal
                }
            })
            .collect();
        let value = |y: &DVector<f64>| 0.5 * (&matrix * y).dot(y) + linear.dot(y);
        let found = minimize_quadratic(&matrix, &linear, &relations);
        let best = (0..16_u32)
            .filter_map(|held| face_minimizer(&matrix, &linear, held))
            .filter(|y| (0..4).all(|k| relations[k] == Relation::Equal || y[k] >= 0.0))
            .map(|point| value(&point))
            .fold(f64::INFINITY, f64::min);
        assert!((0..4).all(|k| relations[k] == Relation::Equal || found[k] >= 0.0));
        assert!(
            value(&found) <= best + 1e-9 * (1.0 + best.abs()),
            "case {case}"
        );
    }
}

/// The minimizer with the variables of the bits of `held` at zero.
fn face_minimizer(matrix: &DMatrix<f64>, linear: &DVector<f64>, held: u32) -> Option<DVector<f64>> {
    let is_held = |k: usize| held & (1 << k) != 0;
    let entry = |i: usize, j: usize| match (is_held(i) || is_held(j), i == j) {
        (false, _) => matrix[(i, j)],
        (true, on_diagonal) => f64::from(u8::from(on_diagonal)),
    };
    let left = DMatrix::from_fn(4, 4, entry);
    let right = DVector::from_fn(4, |k, _| if is_held(k) { 0.0 } else { -linear[k] });
    left.lu().solve(&right)
}

#[test]
fn the_center_of_a_line_needs_the_contrast_of_hand_calculation() {
    for (target, contrast) in [(1.0 / 3.0, 4.0), (0.25, 9.0), (0.5, 1.0)] {
        let least = least_contrast(&slices(1200, target));
        assert!(
            (1.0 + least.growth - contrast).abs() < 1e-11,
            "{target}: {least:?}"
        );
    }
    assert!(least_contrast(&slices(12, -0.1)).growth.is_infinite());
}

#[test]
fn least_variance_meets_conditions_and_is_least() {
    let grains = cloud(300, [0.42, 0.5, 0.6], 3);
    let range = range(1.0, 5.0, 1.2);
    let found = least_variance(&grains, &range);
    assert_eq!(found.end, SolveEnd::Met, "{found:?}");
    assert!(found.residual.amax() < 1e-12 * 300.0 && found.iterations() <= 10);
    // At the optimum the dual's value is the primal's, and no other point of the dual lies higher.
    let value = |multipliers: &DVector<f64>| grains.dual(&range, multipliers, false).value;
    let mut random = Random::new(1);
    for _ in 0..100 {
        let other = &found.multipliers + DVector::from_fn(3, |_, _| 0.1 * random.gaussian());
        assert!(value(&other) <= value(&found.multipliers));
    }
}

#[test]
fn the_least_contrast_parts_what_is_solved_from_what_is_refuted() {
    for seed in 0..4 {
        let grains = cloud(200, [0.35, 0.45, 0.6], seed);
        let contrast = 1.0 + least_contrast(&grains).growth;
        let above = least_variance(&grains, &range(1.0, contrast * (1.0 + 1e-3), 1.0));
        let below = least_variance(&grains, &range(1.0, contrast * (1.0 - 1e-3), 1.0));
        assert_eq!(
            (above.end, below.end),
            (SolveEnd::Met, SolveEnd::Refuted),
            "seed {seed}"
        );
        assert!(refute(&grains, &range(1.0, contrast * (1.0 + 1e-9), 1.0), 0.0).is_none());
        assert!(refute(&grains, &range(1.0, contrast * (1.0 - 1e-6), 1.0), 0.0).is_some());
    }
}

#[test]
fn inequalities_need_less_than_equalities_and_have_multipliers_of_one_sign() {
    let mut grains = cloud(400, [0.3, 0.4, 0.5], 7);
    let equal = least_contrast(&grains).growth;
    for row in &mut grains.rows {
        *row = DVector::from_fn(5, |k, _| if k < 3 { row[k] } else { row[0] + row[k - 2] });
    }
    grains.constants = DVector::zeros(5);
    grains.relations = vec![Relation::AtLeast; 5];
    let least = least_contrast(&grains);
    assert!(
        least.growth < equal && least.multipliers.min() >= 0.0,
        "{least:?}"
    );
    let found = least_variance(&grains, &range(2.0, 2.001 * (1.0 + least.growth), 2.0));
    assert_eq!(found.end, SolveEnd::Met, "{found:?}");
    assert!(found.multipliers.min() >= 0.0 && found.residual.min() > -1e-10);
    let below = least_variance(&grains, &range(2.0, 1.99 * (1.0 + least.growth), 2.0));
    assert_eq!(below.end, SolveEnd::Refuted);
}

#[test]
fn a_wanted_mass_is_a_condition_like_others() {
    let mut grains = slices(900, 1.0 / 3.0);
    for (row, volume) in grains.rows.iter_mut().zip(&grains.volumes) {
        *row = DVector::from_column_slice(&[row[0], *volume]);
    }
    grains.relations = vec![Relation::Equal; 2];
    // The least high end above low = 1 that holds this mass.
    grains.constants = DVector::from_column_slice(&[0.0, -1.9]);
    let growth = RangeGrowth {
        middle: 1.0,
        down: 0.0,
        up: 1.0,
    };
    let high = 1.0 + least_growth(&grains, &growth).growth;
    let above = least_variance(&grains, &range(1.0, high * 1.001, 1.0));
    let below = least_variance(&grains, &range(1.0, high * 0.999, 1.0));
    assert_eq!(
        (above.end, below.end),
        (SolveEnd::Met, SolveEnd::Refuted),
        "{high}"
    );
    assert!(above.residual.amax() < 1e-12);
    // Around the mean density the least symmetric range holds the same mass.
    let around = RangeGrowth {
        middle: 1.9,
        down: 1.0,
        up: 1.0,
    };
    let growth = least_growth(&grains, &around).growth;
    for (factor, end) in [(1.001, SolveEnd::Met), (0.999, SolveEnd::Refuted)] {
        let half = growth * factor;
        let found = least_variance(&grains, &range(1.9 - half, 1.9 + half, 1.9));
        assert_eq!(found.end, end, "{half}");
    }
}
