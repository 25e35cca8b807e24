//! Polynomials in x, y and z: arithmetic, evaluation and change of coordinates.
//!
//! A polynomial that was read from text keeps it as a `Formula`, so that far from the origin, where its
//! terms cancel each other, it is expanded and evaluated by the operations that the text names.

use crate::arrays::MapEach;
use crate::integrals::formula::{Formula, Step};
use crate::integrals::series::{Exponents, Monomials, degree};
use nalgebra::{Point3, Rotation3, Vector3};
use std::collections::BTreeMap;
use std::ops::{Add, Mul, Neg};

/// Σ a_{αβγ} x^α y^β z^γ, kept sorted by powers so that sums over its terms have one order.
///
/// Reads from text such as `1 + 2*x - 0.5*y*z` or `(x - 1e6)^8*(1 - z)` by [`str::parse`]. Then
/// [`Polynomial::at`] and [`Polynomial::relative_to`] keep the digits that the terms about the origin
/// would cancel; of the terms alone, fifteen digits may cancel before twelve are lost.
#[derive(Clone, Debug, Default)]
pub struct Polynomial {
    terms: BTreeMap<Exponents, f64>,
    /// The operations by which it was given.
    formula: Option<Formula>,
}

impl PartialEq for Polynomial {
    /// Whether all terms about the origin are the same; a term of zero is none.
    fn eq(&self, other: &Self) -> bool {
        let is_there = |(_, value): &(Exponents, f64)| value.abs() > 0.0;
        self.terms()
            .filter(is_there)
            .eq(other.terms().filter(is_there))
    }
}

impl Polynomial {
    /// The polynomial with one term.
    #[must_use]
    pub fn monomial(coefficient: f64, exponents: Exponents) -> Self {
        Self::of_terms(BTreeMap::from([(exponents, coefficient)]))
    }

    /// The sum of terms, each its exponents of x, y, z and its coefficient.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::Polynomial;
    ///
    /// let density = Polynomial::from_terms([([0, 0, 0], 1.0), ([4, 0, 0], 80.0)]);
    /// assert_eq!(Ok(density), "1 + 80*x^4".parse());
    /// ```
    pub fn from_terms(terms: impl IntoIterator<Item = (Exponents, f64)>) -> Self {
        let monomials = terms.into_iter();
        monomials.fold(Self::default(), |sum, (exponents, coefficient)| {
            sum + Self::monomial(coefficient, exponents)
        })
    }

    /// Of coefficients alone.
    fn of_terms(terms: BTreeMap<Exponents, f64>) -> Self {
        let formula = None;
        Self { terms, formula }
    }

    /// Of operations.
    pub(crate) fn of_formula(formula: Formula) -> Self {
        Self {
            terms: formula.about(&Point3::origin()),
            formula: Some(formula),
        }
    }

    /// The operations by which it was given, or the sum of its terms.
    fn into_formula(self) -> Formula {
        let Self { terms, formula } = self;
        formula.unwrap_or_else(|| Formula::of_terms(terms.into_iter()))
    }

    /// A constant.
    #[must_use]
    pub fn constant(value: f64) -> Self {
        Self::monomial(value, [0; 3])
    }

    /// The linear function with this value at the origin and this gradient.
    #[must_use]
    pub fn linear(value: f64, gradient: &Vector3<f64>) -> Self {
        Self::constant(value)
            + Self::monomial(gradient.x, [1, 0, 0])
            + Self::monomial(gradient.y, [0, 1, 0])
            + Self::monomial(gradient.z, [0, 0, 1])
    }

    /// The powers and coefficients, in ascending order of the powers.
    pub fn terms(&self) -> impl Iterator<Item = (Exponents, f64)> + '_ {
        self.terms
            .iter()
            .map(|(&exponents, &value)| (exponents, value))
    }

    /// The highest total degree of a term; 0 of none.
    #[must_use]
    pub fn degree(&self) -> u32 {
        self.terms
            .keys()
            .map(|&powers| degree(powers))
            .max()
            .unwrap_or(0)
    }

    /// The value at a point.
    #[must_use]
    pub fn at(&self, point: &Point3<f64>) -> f64 {
        if let Some(formula) = &self.formula {
            let constant = formula.about(point).get(&[0; 3]).copied();
            return constant.unwrap_or(0.0);
        }
        self.terms()
            .map(|([a, b, c], value)| {
                value * power(point.x, a) * power(point.y, b) * power(point.z, c)
            })
            .sum()
    }

    /// The same function of y − `origin`: q with q(y − origin) = p(y).
    ///
    /// Every coefficient is right to an ulp and 2⁻¹⁰⁰ times the largest number that occurs in p's
    /// operations at `origin`: products of differences of a coordinate and a number keep all digits,
    /// far from the origin too.
    #[must_use]
    pub fn relative_to(&self, origin: &Point3<f64>) -> Self {
        if let Some(formula) = &self.formula {
            return Self::of_terms(formula.about(origin));
        }
        let mut table = DenseTerms::of(&self.terms);
        for axis in 0..3 {
            table.shift(axis, origin[axis]);
        }
        Self::of_terms(table.terms())
    }

    /// The same function of y with x = `rotation` y.
    #[must_use]
    pub fn rotated(&self, rotation: &Rotation3<f64>) -> Self {
        let rows: [Self; 3] =
            [0, 1, 2].map_each(|axis| Self::linear(0.0, &rotation.matrix().row(axis).transpose()));
        self.substituted(&rows)
    }

    /// The coefficients in the order of a table; terms that are not in it are left out.
    #[must_use]
    pub fn coefficients(&self, monomials: &Monomials) -> Vec<f64> {
        let value = |exponents| self.terms.get(exponents).copied().unwrap_or(0.0);
        monomials.exponents().iter().map(value).collect()
    }

    /// The polynomial of these three in place of x, y and z.
    fn substituted(&self, coordinates: &[Self; 3]) -> Self {
        self.terms()
            .map(|(exponents, value)| {
                (0..3).fold(Self::constant(value), |product, axis| {
                    product * coordinates[axis].power(exponents[axis])
                })
            })
            .fold(Self::default(), |sum, term| sum + term)
    }

    /// The polynomial multiplied by itself `exponent` times.
    #[must_use]
    pub fn power(&self, exponent: u32) -> Self {
        (0..exponent).fold(Self::constant(1.0), |product, _| product * self.clone())
    }
}

/// The coefficients of all powers up to the highest of each axis, z's next to each other.
struct DenseTerms {
    lengths: [usize; 3],
    coefficients: Vec<f64>,
}

impl DenseTerms {
    fn of(terms: &BTreeMap<Exponents, f64>) -> Self {
        let mut lengths = [1; 3];
        for powers in terms.keys() {
            for axis in 0..3 {
                lengths[axis] = lengths[axis].max(powers[axis] as usize + 1);
            }
        }
        let [_, y, z] = lengths;
        let mut coefficients = vec![0.0; lengths.iter().product()];
        for (&[a, b, c], value) in terms {
            coefficients[(a as usize * y + b as usize) * z + c as usize] = *value;
        }
        Self {
            lengths,
            coefficients,
        }
    }

    /// Puts `by` + x in place of a coordinate x: Horner's scheme, once for every power.
    fn shift(&mut self, axis: usize, by: f64) {
        let length = self.lengths[axis];
        let stride: usize = self.lengths[axis + 1..].iter().product();
        for block in self.coefficients.chunks_exact_mut(stride * length) {
            for lowest in 0..length {
                for at in (lowest * stride..(length - 1) * stride).rev() {
                    block[at] += by * block[at + stride];
                }
            }
        }
    }

    fn terms(&self) -> BTreeMap<Exponents, f64> {
        let [_, y, z] = self.lengths;
        let numbered = self.coefficients.iter().enumerate();
        let terms = numbered.filter(|(_, value)| **value != 0.0);
        let powers = |at: usize| [at / (y * z), at / z % y, at % z].map_each(|power| power as u32);
        terms.map(|(at, value)| (powers(at), *value)).collect()
    }
}

/// x^n by repeated multiplication; x^0 = 1 also at 0.
fn power(x: f64, n: u32) -> f64 {
    (0..n).fold(1.0, |product, _| product * x)
}

impl Add for Polynomial {
    type Output = Self;

    fn add(mut self, other: Self) -> Self {
        if self.formula.is_some() || other.formula.is_some() {
            let formula = self.into_formula().with(other.into_formula(), Step::Add);
            return Self::of_formula(formula);
        }
        for (exponents, value) in other.terms() {
            *self.terms.entry(exponents).or_default() += value;
        }
        self
    }
}

impl Neg for Polynomial {
    type Output = Self;

    fn neg(mut self) -> Self {
        for value in self.terms.values_mut() {
            *value = -*value;
        }
        let formula = self.formula.take();
        self.formula = formula.map(|formula| formula.followed_by(Step::Negate));
        self
    }
}

impl Mul for Polynomial {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        if self.formula.is_some() || other.formula.is_some() {
            let formula = self
                .into_formula()
                .with(other.into_formula(), Step::Multiply);
            return Self::of_formula(formula);
        }
        let mut product = Self::default();
        for (a, left) in self.terms() {
            for (b, right) in other.terms() {
                let exponents = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
                *product.terms.entry(exponents).or_default() += left * right;
            }
        }
        product
    }
}
