//! Bodies as sums of elements, each of one density: cells, vertices of a mesh, points, pieces of a print.
//!
//! Element i has the weight w_i = ∫ B_i (its volume) and the rows W_ki = ∫ φ_k B_i, B_i being 1 in it (or the
//! hat function of a vertex). The density nearest to d₀ in Σ w_i (d_i − d₀)² that meets the conditions is
//! d_i = clamp(d₀ + Σ λ_k W_ki / w_i, lo, hi). What does not vary adds a constant to every ∫ d φ_k.
//! Sums run by halves: their bits do not depend on the number of threads.

use std::ops::{Add, Range};

use nalgebra::{DMatrix, DVector, Point3};

use crate::balance::conditions::Condition;
use crate::balance::dual::{Balance, DensityRange, DualPoint, Relation};
use crate::geometry::moments::Moments;
use crate::integrals::pairwise::sum_by_halves;
use crate::parallel::map;

/// A body of elements under conditions.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Elements {
    relations: Vec<Relation>,
    /// w_i.
    weights: Vec<f64>,
    /// W_ki, the rows of one element after those of another.
    rows: Vec<f64>,
    /// What does not vary, less what is wanted.
    fixed: DVector<f64>,
}

impl Elements {
    /// Elements whose `moments` at density 1 are measured from `origin`, beside a body that does not vary.
    pub(crate) fn of_moments(
        conditions: &[Condition],
        moments: &[Moments],
        fixed: &Moments,
        origin: &Point3<f64>,
    ) -> Self {
        let weights = moments.iter().map(|element| element.mass).collect();
        let row = |element: usize| {
            let row = conditions.iter();
            row.map(|c| c.of(&moments[element], origin)).collect()
        };
        let rows: Vec<Vec<f64>> = map(moments.len(), &row);
        let fixed = conditions.iter().map(|c| c.of(fixed, origin));
        Self::new(conditions, weights, rows.concat(), fixed)
    }

    fn new(
        conditions: &[Condition],
        weights: Vec<f64>,
        rows: Vec<f64>,
        fixed: impl Iterator<Item = f64>,
    ) -> Self {
        let wanted = conditions.iter().map(|condition| condition.wanted);
        let fixed: Vec<_> = fixed.zip(wanted).map(|(fixed, w)| fixed - w).collect();
        Self {
            relations: conditions.iter().map(|c| c.relation).collect(),
            weights,
            rows,
            fixed: fixed.into(),
        }
    }

    /// The densities d_i at multipliers.
    pub(crate) fn densities(&self, range: &DensityRange, multipliers: &DVector<f64>) -> Vec<f64> {
        let density = |element| self.density(element, range, multipliers).0;
        map(self.weights.len(), &density)
    }

    /// The rows of an element.
    fn rows(&self, element: usize) -> &[f64] {
        let count = self.relations.len();
        &self.rows[element * count..(element + 1) * count]
    }

    /// Σ λ_k W_ki.
    fn tilt(&self, element: usize, multipliers: &DVector<f64>) -> f64 {
        let rows = self.rows(element).iter();
        rows.zip(multipliers)
            .map(|(row, factor)| row * factor)
            .sum()
    }

    /// d_i, and whether it lies between the bounds.
    fn density(
        &self,
        element: usize,
        range: &DensityRange,
        multipliers: &DVector<f64>,
    ) -> (f64, bool) {
        let weight = self.weights[element];
        let tilt = self.tilt(element, multipliers);
        let free = if weight > 0.0 { tilt / weight } else { 0.0 } + range.prefer;
        (range.clamp(free), range.low < free && free < range.high)
    }

    /// The sums over some elements.
    fn leaf(
        &self,
        elements: Range<usize>,
        range: &DensityRange,
        multipliers: &DVector<f64>,
        whole: bool,
    ) -> Sums {
        let mut sums = Sums::zero(self.relations.len());
        for element in elements {
            let weight = self.weights[element];
            let (density, is_free) = self.density(element, range, multipliers);
            sums.value += 0.5 * weight * (density - range.prefer).powi(2);
            let rows = self.rows(element);
            for (sum, row) in sums.first.iter_mut().zip(rows) {
                *sum += density * row;
            }
            if (whole || is_free) && weight > 0.0 {
                sums.add_products(rows, 1.0 / weight);
            }
        }
        sums
    }

    /// The sums over all elements of what `leaf` adds up.
    fn sum(&self, leaf: &(impl Fn(Range<usize>) -> Sums + Sync)) -> Sums {
        sum_by_halves(self.weights.len(), leaf)
    }
}

impl Balance for Elements {
    fn relations(&self) -> &[Relation] {
        &self.relations
    }

    fn dual(&self, range: &DensityRange, multipliers: &DVector<f64>, whole: bool) -> DualPoint {
        let sums = self.sum(&|elements| self.leaf(elements, range, multipliers, whole));
        let residual = sums.first + &self.fixed;
        let mut curvature = sums.products;
        curvature.fill_upper_triangle_with_lower_triangle();
        DualPoint {
            value: sums.value - multipliers.dot(&residual),
            residual,
            curvature,
        }
    }

    fn totals(&self) -> DVector<f64> {
        let sums = self.sum(&|elements| {
            let mut sums = Sums::zero(self.relations.len());
            for element in elements {
                sums.add_rows(self.rows(element));
            }
            sums
        });
        sums.first
    }

    fn constants(&self) -> DVector<f64> {
        self.fixed.clone()
    }

    fn positive_part(&self, multipliers: &DVector<f64>) -> (f64, DVector<f64>) {
        let sums = self.sum(&|elements| {
            let mut sums = Sums::zero(self.relations.len());
            for element in elements {
                let tilt = self.tilt(element, multipliers);
                if tilt > 0.0 {
                    sums.value += tilt;
                    sums.add_rows(self.rows(element));
                }
            }
            sums
        });
        (sums.value, sums.first)
    }
}

/// A number, one for each condition, and one for each pair of them.
struct Sums {
    value: f64,
    first: DVector<f64>,
    /// The lower triangle.
    products: DMatrix<f64>,
}

impl Sums {
    fn zero(conditions: usize) -> Self {
        Self {
            value: 0.0,
            first: DVector::zeros(conditions),
            products: DMatrix::zeros(conditions, conditions),
        }
    }

    fn add_rows(&mut self, rows: &[f64]) {
        for (sum, row) in self.first.iter_mut().zip(rows) {
            *sum += row;
        }
    }

    fn add_products(&mut self, rows: &[f64], factor: f64) {
        for column in 0..rows.len() {
            for row in column..rows.len() {
                self.products[(row, column)] += rows[row] * rows[column] * factor;
            }
        }
    }
}

impl Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            value: self.value + other.value,
            first: self.first + other.first,
            products: self.products + other.products,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::conditions::SpinAxis;
    use nalgebra::Vector3;

    /// A 6 × 5 × 4 grid of boxes over [0, 1]³, moments from its corner.
    fn boxes() -> Vec<Moments> {
        let counts = [6, 5, 4];
        let size = Vector3::from(counts.map(|count| 1.0 / f64::from(count)));
        let mut boxes = Vec::new();
        for x in 0..counts[0] {
            for y in 0..counts[1] {
                for z in 0..counts[2] {
                    let corner = Vector3::new(f64::from(x), f64::from(y), f64::from(z));
                    let at_zero = Moments {
                        mass: size.product(),
                        first: Vector3::zeros(),
                        second: nalgebra::Matrix3::from_diagonal(
                            &(size.component_mul(&size) / 12.0 * size.product()),
                        ),
                    };
                    let middle = (corner + Vector3::repeat(0.5)).component_mul(&size);
                    boxes.push(at_zero.translated(&middle));
                }
            }
        }
        boxes
    }

    fn conditions() -> Vec<Condition> {
        let axis = SpinAxis::new(&Point3::new(0.4, 0.45, 0.5), &Vector3::new(0.1, 0.2, 1.0));
        let axis = axis.expect("it has a direction");
        let mut all = [axis.center_on(), axis.principal()].concat();
        all.push(axis.stable_against(0.3, 0.1));
        all.push(Condition::mass(1.7));
        all
    }

    const RANGE: DensityRange = DensityRange {
        low: 0.5,
        high: 1.5,
        prefer: 0.9,
    };

    #[test]
    fn residuals_and_curvatures_are_derivatives_of_the_value() {
        let fixed = Moments {
            mass: 0.2,
            first: Vector3::new(0.1, 0.02, 0.03),
            second: nalgebra::Matrix3::identity() * 0.1,
        };
        let body = Elements::of_moments(&conditions(), &boxes(), &fixed, &Point3::origin());
        let at = DVector::from_vec(vec![0.5, -1.0, 0.7, 1.2, 0.6, 0.3]);
        let here = body.dual(&RANGE, &at, false);
        let step = 1e-5;
        for k in 0..at.len() {
            let moved = |sign: f64| {
                let mut moved = at.clone();
                moved[k] += sign * step;
                body.dual(&RANGE, &moved, false)
            };
            let (plus, minus) = (moved(1.0), moved(-1.0));
            let slope = (plus.value - minus.value) / (2.0 * step);
            assert!((slope + here.residual[k]).abs() < 1e-9, "{k}: {slope}");
            let change = (plus.residual - minus.residual) / (2.0 * step);
            let error = (change - here.curvature.column(k)).amax();
            assert!(error < 1e-8, "{k}: {error:e}");
        }
    }

    #[test]
    fn totals_are_what_the_density_one_gives() {
        let body = Elements::of_moments(
            &conditions(),
            &boxes(),
            &Moments::default(),
            &Point3::origin(),
        );
        let one = DensityRange {
            low: 1.0,
            high: 1.0,
            prefer: 1.0,
        };
        let zero = DVector::zeros(6);
        let residual = body.dual(&one, &zero, true).residual;
        assert!((residual - body.totals() - body.constants()).amax() < 1e-15);
        let at = DVector::from_vec(vec![0.5, -1.0, 0.7, 1.2, 0.6, 0.3]);
        let (plus, minus) = (body.positive_part(&at), body.positive_part(&-&at));
        let all = at.dot(&body.totals());
        assert!((plus.0 - minus.0 - all).abs() < 1e-15);
        assert!((plus.1 + minus.1 - body.totals()).amax() < 1e-14);
        assert!((body.constants()[5] + 1.7).abs() < 1e-15);
    }

    #[test]
    fn the_bits_do_not_depend_on_the_threads() {
        let boxes: Vec<_> = std::iter::repeat_n(boxes(), 200).flatten().collect();
        let body = Elements::of_moments(
            &conditions(),
            &boxes,
            &Moments::default(),
            &Point3::origin(),
        );
        let at = DVector::from_vec(vec![0.5, -1.0, 0.7, 1.2, 0.6, 0.3]);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let dual = || body.dual(&RANGE, &at, false);
            pool.expect("threads").install(dual)
        };
        assert_eq!(with(1), with(3));
    }
}
