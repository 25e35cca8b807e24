//! Powers of a linear function over a simplex.
//!
//! On a d-simplex the barycentric monomials integrate to ∫ Π λ_i^{k_i} = vol d! Π k_i! / (d + Σk)!
//! (Dirichlet), so for a function that is linear on the simplex, with the values u_0 … u_d at its
//! corners,
//!
//! ∫ u^p = vol · d! p! / (d + p)! · h_p(u_0, …, u_d),
//!
//! where h_p is the complete homogeneous symmetric polynomial: the sum of all monomials of degree
//! p, each once. For p = 1 on a tetrahedron this is \[BL\] eq. 1.

/// Orders up to this one are evaluated without touching the heap; the Chebyshev energy uses
/// p ≤ 8 and mass properties p ≤ 3.
const ORDERS_ON_STACK: usize = 16;

/// h_p of `values`: the sum of all monomials of degree `p` in them, each once.
///
/// h_0 = 1, also of no values; h_p of no values is 0 for p > 0. Costs p multiplications a value
/// and loses no digits while the values share a sign.
#[must_use]
pub fn complete_homogeneous(p: u32, values: &[f64]) -> f64 {
    let p = p as usize;
    if p == 1 {
        values.iter().sum()
    } else if p <= ORDERS_ON_STACK {
        let mut row = [0.0; ORDERS_ON_STACK + 1];
        last_of_row(&mut row[..=p], values)
    } else {
        last_of_row(&mut vec![0.0; p + 1], values)
    }
}

/// The integral over a d-simplex of the p-th power of a linear function: d + 1 corner `values`,
/// `volume` the simplex's d-dimensional volume (signed if the caller's is).
///
/// The unit is that of `volume` times that of the values to the power `p`.
#[must_use]
pub fn linear_power(volume: f64, values: &[f64], p: u32) -> f64 {
    let dimension = values.len().saturating_sub(1);
    volume * complete_homogeneous(p, values) / binomial_in_floats(dimension, p)
}

/// Fills `row[k]` with h_k for k = 0, 1, … by h_k(u_0…u_m) = h_k(u_0…u_{m−1}) + u_m h_{k−1}(u_0…u_m)
/// and returns the last.
fn last_of_row(row: &mut [f64], values: &[f64]) -> f64 {
    row[0] = 1.0;
    for value in values {
        for k in 1..row.len() {
            row[k] += value * row[k - 1];
        }
    }
    row[row.len() - 1]
}

/// (d + p)! / (d! p!), exact while it is below 2^53.
fn binomial_in_floats(dimension: usize, p: u32) -> f64 {
    (1..=dimension).fold(1.0, |product, k| {
        product * (f64::from(p) + k as f64) / k as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_orders_are_the_sums_of_all_monomials() {
        let [a, b, c] = [2.0_f64, 3.0, -5.0];
        let two = a * a + b * b + c * c + a * b + b * c + c * a;
        assert!((complete_homogeneous(0, &[a, b, c]) - 1.0).abs() < 1e-15);
        assert!((complete_homogeneous(1, &[a, b, c])).abs() < 1e-15);
        assert!((complete_homogeneous(2, &[a, b, c]) - two).abs() < 1e-13);
        assert!((complete_homogeneous(40, &[1.0, 1.0]) - 41.0).abs() < 1e-12);
        assert!(complete_homogeneous(3, &[]).abs() < 1e-15);
    }

    #[test]
    fn one_dimension_is_the_power_rule() {
        // ∫ x^p over [1, 3] = (3^{p+1} − 1)/(p + 1)
        for p in 0..30 {
            let expected = (3.0_f64.powi(p + 1) - 1.0) / f64::from(p + 1);
            let got = linear_power(2.0, &[1.0, 3.0], p.unsigned_abs());
            assert!((got / expected - 1.0).abs() < 1e-14, "p = {p}");
        }
    }

    #[test]
    fn a_tetrahedron_of_linear_density_weighs_its_mean_density() {
        let mass = linear_power(6.0, &[1.0, 2.0, 3.0, 4.0], 1);
        assert!((mass - 15.0).abs() < 1e-14);
    }
}
