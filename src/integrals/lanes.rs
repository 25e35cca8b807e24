//! Eight simplices at a time.
//!
//! The ten moments of a simplex are some hundred multiplications without a branch, so they run as
//! wide as the machine if the data lie by component: [`Lanes`] holds one number of eight
//! simplices. Every lane adds up its own sum, and the eight are added at the end in one order;
//! how many lanes an instruction really takes changes no bit, because nothing is contracted or
//! reordered across lanes. Lanes without a simplex hold zeros, which add nothing.

use crate::integrals::moments::Moments;

/// Simplices handled together.
pub const WIDTH: usize = 8;

/// One number of [`WIDTH`] simplices.
pub type Lanes = [f64; WIDTH];

/// The running sums of `∫ρ·{1, x, y, z, x², y², z², xy, yz, zx}`, before the simplex's constant
/// factors.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    ten: [Lanes; 10],
}

impl Sums {
    /// Adds 6·volume · Σ_i … of the simplices spanned by an origin of density `apex_density`
    /// and `K` corners: the integrals over a simplex of (linear density) × {1, y, y yᵀ}.
    ///
    /// With S = Σ v_i, σ = Σ ρ_i, D = Σ ρ_i v_i over all corners (the apex at 0 adds to σ alone),
    /// the Dirichlet weights 1/24, 1/120, 1/720 of a tetrahedron leave
    /// σ, σ S + D and Σ (σ + 2ρ_i) v_i v_iᵀ + U Sᵀ + S Uᵀ with U = σ S / 2 + D.
    #[inline(always)]
    pub fn add_linear<const K: usize>(
        &mut self,
        six_volumes: &Lanes,
        corners: &[[Lanes; 3]; K],
        densities: &[Lanes; K],
        apex_density: f64,
    ) {
        for lane in 0..WIDTH {
            let volume = six_volumes[lane];
            let mut sigma = apex_density;
            let (mut s, mut d, mut second) = ([0.0; 3], [0.0; 3], [0.0; 6]);
            for density in densities {
                sigma += density[lane];
            }
            for (corner, density) in corners.iter().zip(densities) {
                let v = [corner[0][lane], corner[1][lane], corner[2][lane]];
                let weight = sigma + 2.0 * density[lane];
                let w = [weight * v[0], weight * v[1], weight * v[2]];
                for axis in 0..3 {
                    s[axis] += v[axis];
                    d[axis] += density[lane] * v[axis];
                    second[axis] += w[axis] * v[axis];
                    second[3 + axis] += w[axis] * v[(axis + 1) % 3];
                }
            }
            self.ten[0][lane] += volume * sigma;
            for axis in 0..3 {
                let next = (axis + 1) % 3;
                let u = 0.5 * sigma * s[axis] + d[axis];
                let u_next = 0.5 * sigma * s[next] + d[next];
                self.ten[1 + axis][lane] += volume * (sigma * s[axis] + d[axis]);
                self.ten[4 + axis][lane] += volume * (second[axis] + 2.0 * u * s[axis]);
                self.ten[7 + axis][lane] +=
                    volume * (second[3 + axis] + u * s[next] + u_next * s[axis]);
            }
        }
    }

    /// The same for density 1, where the weights 1/6, 1/24, 1/120 leave 1, S and Σ v vᵀ + S Sᵀ.
    #[inline(always)]
    pub fn add_constant<const K: usize>(&mut self, six_volumes: &Lanes, corners: &[[Lanes; 3]; K]) {
        for lane in 0..WIDTH {
            let volume = six_volumes[lane];
            let (mut s, mut second) = ([0.0; 3], [0.0; 6]);
            for corner in corners {
                let v = [corner[0][lane], corner[1][lane], corner[2][lane]];
                for axis in 0..3 {
                    s[axis] += v[axis];
                    second[axis] += v[axis] * v[axis];
                    second[3 + axis] += v[axis] * v[(axis + 1) % 3];
                }
            }
            self.ten[0][lane] += volume;
            for axis in 0..3 {
                let next = (axis + 1) % 3;
                self.ten[1 + axis][lane] += volume * s[axis];
                self.ten[4 + axis][lane] += volume * (second[axis] + s[axis] * s[axis]);
                self.ten[7 + axis][lane] += volume * (second[3 + axis] + s[axis] * s[next]);
            }
        }
    }

    /// The moments, given the factors of mass, first and second moments.
    pub fn moments(&self, [mass, first, second]: [f64; 3]) -> Moments {
        let mut ten = self.ten.map(|lanes| lanes.iter().sum::<f64>());
        ten[0] *= mass;
        for sum in &mut ten[1..4] {
            *sum *= first;
        }
        for sum in &mut ten[4..] {
            *sum *= second;
        }
        Moments::from_ten(ten)
    }
}

/// Six times the signed volumes of tetrahedra with one corner at 0: a · (b × c).
#[inline(always)]
pub fn six_volumes([a, b, c]: &[[Lanes; 3]; 3]) -> Lanes {
    let mut volumes = [0.0; WIDTH];
    for (lane, volume) in volumes.iter_mut().enumerate() {
        let x = b[1][lane] * c[2][lane] - b[2][lane] * c[1][lane];
        let y = b[2][lane] * c[0][lane] - b[0][lane] * c[2][lane];
        let z = b[0][lane] * c[1][lane] - b[1][lane] * c[0][lane];
        *volume = a[0][lane] * x + a[1][lane] * y + a[2][lane] * z;
    }
    volumes
}
