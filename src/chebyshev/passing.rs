//! Where the energy of order 1 passes from one polynomial to the next.
//!
//! The energy bends by the areas of the interfaces, which are polynomials in the center as long as
//! no vertex passes through an interface and no diagonal over an edge of the piece. Where one does, it
//! is the polynomial continued plus κ τ⁴/24, with τ linear in the center and zero at the passage: only
//! so does the energy stay three times differentiable. For a convex piece with the center inside
//! - a vertex of the facets 1, 2, 3 that passes through the interface with w = left − right, the
//!   difference of the gradients of its sectors' distances, has τ = w·v, v its displacement, and
//!   κ = ∓ D |D| / Π w·(n_j × n_k) with D = n_1·(n_2 × n_3), the product over the three pairs in turn
//!   and the sign − for a passage from left to right: the area that a plane cuts out of a simple cone
//!   (Lawrence, *Polytope volume computation*, Math. Comp. 57, 1991);
//! - a diagonal along ρ that passes from facet f to g has τ = (n_f·ρ) h_g − (n_g·ρ) h_f, h the
//!   center's heights below them, and, where ρ is (1, 1, 1),
//!   κ = −1 / ((n_f·ρ) (n_g·ρ) Π w·(n_f × n_g)), the product over the three interfaces that meet at ρ.
//!
//! What passes adds up: each is told by what is nearby.

use nalgebra::{Matrix3, Vector3};

use crate::chebyshev::endpoint::Endpoint;
use crate::chebyshev::interface::diagonal_ray;
use crate::chebyshev::pierced::Pierced;
use crate::minimize::problem::Evaluation;

/// The largest κ τ³ of a passage, by the volume and by the smallest factor under the fraction in κ,
/// whose rounding is then below 1e-13 of the volume in the gradient.
const LARGEST: f64 = 100.0;

/// What a passage adds to the energy.
#[derive(Clone, Debug)]
pub(crate) struct Passing {
    /// κ.
    bend: f64,
    /// τ at the origin of the piece's coordinates.
    offset: f64,
    /// How τ changes with the center.
    along: Vector3<f64>,
    /// The smallest factor under the fraction in κ.
    slant: f64,
}

impl Passing {
    /// The passage of a vertex at `point`.
    pub(crate) fn of_vertex(
        endpoint: Endpoint,
        point: &Vector3<f64>,
        normals: [&Vector3<f64>; 3],
    ) -> Self {
        let (left, right) = endpoint.interface().sectors();
        let across = |vector: &Vector3<f64>| left.distance(vector) - right.distance(vector);
        let [a, b, c] = normals;
        let edges = [b.cross(c), c.cross(a), a.cross(b)];
        let determinant = a.dot(&edges[0]);
        let slants = edges.each_ref().map(across);
        let [one, two, three] = slants;
        let bend = -endpoint.signed(determinant * determinant.abs()) / (one * two * three);
        let mut along = Vector3::zeros();
        along[left.axis()] = -left.sign();
        along[right.axis()] = right.sign();
        Self {
            bend,
            offset: across(point),
            along,
            slant: least(&slants),
        }
    }

    /// The passage of a diagonal from one facet to another.
    pub(crate) fn of_diagonal(diagonal: usize, from: &Pierced, to: &Pierced) -> Self {
        let ray = diagonal_ray(diagonal as u8);
        let [one, other] = [from, to].map(|facet| facet.plane.normal.component_mul(ray));
        let [x, y, z] = one.cross(&other).into();
        let factors = [from.along, to.along, x - y, x - z, y - z];
        Self {
            bend: -1.0 / factors.iter().product::<f64>(),
            offset: from.along * to.plane.offset - to.along * from.plane.offset,
            along: from.plane.normal * to.along - to.plane.normal * from.along,
            slant: least(&factors),
        }
    }
}

/// The sum of what passages add: value, gradient, the Hessian's diagonal and what is beside it.
#[derive(Default)]
pub(crate) struct Sum {
    value: f64,
    gradient: Vector3<f64>,
    squares: Vector3<f64>,
    products: Vector3<f64>,
    is_precise: bool,
}

impl Sum {
    /// What all passages add at a center to the energy of a piece of some volume.
    pub(crate) fn of(all: &[Passing], center: &Vector3<f64>, volume: f64) -> Self {
        let mut sum = Self {
            is_precise: true,
            ..Self::default()
        };
        for passing in all {
            sum.add(passing, center, volume);
        }
        sum
    }

    #[inline]
    fn add(&mut self, passing: &Passing, center: &Vector3<f64>, volume: f64) {
        let Passing {
            bend,
            offset,
            along,
            slant,
        } = passing;
        let beyond = offset + along.dot(center);
        let second = bend * beyond * beyond / 2.0;
        let third = second * beyond / 3.0;
        let bent = along * second;
        self.value += third * beyond / 4.0;
        self.gradient += along * third;
        self.squares += bent.component_mul(along);
        self.products += bent.yzx().component_mul(&along.zxy());
        self.is_precise &= third.abs() <= LARGEST * volume * slant;
    }

    /// The sum, unless rounding would be felt.
    pub(crate) fn evaluation(&self) -> Option<Evaluation<3>> {
        let (diagonal, [yz, zx, xy]) = (&self.squares, self.products.into());
        self.is_precise.then(|| Evaluation {
            value: self.value,
            gradient: self.gradient,
            hessian: Matrix3::new(
                diagonal.x, xy, zx, //
                xy, diagonal.y, yz, //
                zx, yz, diagonal.z,
            ),
        })
    }
}

/// The smallest number but for signs.
fn least(factors: &[f64]) -> f64 {
    let sizes = factors.iter().map(|factor| factor.abs());
    sizes.fold(f64::INFINITY, f64::min)
}
