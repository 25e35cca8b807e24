//! The least energy that cells may have: that of equal cubes, or with a density the asymptotic optimum.

#[cfg(feature = "scene")]
use serde::{Deserialize, Serialize};

/// What `energy_percent` is relative to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize))]
#[cfg_attr(feature = "scene", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum EnergyReference {
    /// Equal cubes (squares in the plane): no tessellation lies below.
    #[default]
    EqualCubes,
    /// With a density: the least energy as the number of sites grows; few sites may lie below.
    AsymptoticOptimum,
}

/// The least energy of order 1 that cells may have, as that of equal cubes of density 1.
///
/// In a density ρ the asymptotic optimum of n sites is n times the energy (3/8) n^(−4/3) (∫ ρ^¾)^(4/3) (in D
/// dimensions D/(D+1)/2 n^(−1−1/D) (∫ ρ^(D/(D+1)))^((D+1)/D)): cubes of volume ∝ ρ^−¾, each in a constant density
/// (Gersho, *Asymptotically optimal block quantization*, 1979).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyOptimum {
    /// What it is.
    pub kind: EnergyReference,
    /// The volume of all cubes (L^D): ∫ (ρ/mean)^(D/(D+1)), the domain's without a density.
    pub(crate) volume: f64,
    /// An estimate of the error of that integral (L^D), 0 where there is a closed form.
    pub(crate) volume_error: f64,
    /// The mean density.
    pub(crate) density: f64,
}

impl EnergyOptimum {
    /// Equal cubes of total volume `volume`.
    #[must_use]
    pub fn of_equal_cubes(volume: f64) -> Self {
        Self {
            kind: EnergyReference::EqualCubes,
            volume,
            volume_error: 0.0,
            density: 1.0,
        }
    }

    /// The mean energy of `count` cells (L^(D+1)).
    #[must_use]
    pub fn energy<const D: usize>(&self, count: usize) -> f64 {
        self.density * optimal_energy::<D>(self.volume, count, 1)
    }

    /// An estimate of that energy's error (L^(D+1)).
    #[must_use]
    pub fn energy_error<const D: usize>(&self, count: usize) -> f64 {
        let power = 1.0 + 1.0 / D as f64;
        self.energy::<D>(count) * power * self.volume_error / self.volume
    }

    /// `energy` of order 1 per mean density in percent of a cell's optimum.
    #[must_use]
    pub(crate) fn percent<const D: usize>(&self, energy: f64, count: usize) -> f64 {
        100.0 * energy / optimal_energy::<D>(self.volume, count, 1)
    }

    /// What a record names.
    pub(crate) fn named(&self) -> Option<EnergyReference> {
        (self.kind != EnergyReference::EqualCubes).then_some(self.kind)
    }
}

/// The side of a cube (a square, for D = 2) of the mean cell's volume (L).
#[must_use]
pub(crate) fn optimal_side<const D: usize>(volume: f64, count: usize) -> f64 {
    (volume / count as f64).powf(1.0 / D as f64)
}

/// The order-p Chebyshev energy of that cube about its center, the least that a mean cell can
/// have (L^(D+p)): D/(D+p) · s^(D+p)/2^p, for p = 1 and D = 3 the (3/8) s⁴ of section 3.5.
#[must_use]
pub(crate) fn optimal_energy<const D: usize>(volume: f64, count: usize, order: u32) -> f64 {
    let (d, p) = (D as f64, f64::from(order));
    let side = optimal_side::<D>(volume, count);
    d / (d + p) * side.powf(d + p) / 2.0_f64.powf(p)
}
