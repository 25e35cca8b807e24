//! Checks of cells wherever their energies are computed: volumes, a floor of the energies, finite figures.
//!
//! - Their volumes sum to the domain's.
//! - Their mean energy is no less than that of n bodies of the least energy: a body of mass m in a density of
//!   at most ρ has ∫ ρ d^p ≥ that of the ball of its distance, of volume m/ρ, in the density ρ. For the Chebyshev
//!   distance the ball is a cube and the energy ρ D/(D+p) 2^−p (m/ρ)^((D+p)/D), for p = 1 in space
//!   (3/8) m^(4/3) ρ^(−1/3); it is convex in m, so that n masses have the least sum where all are equal. For
//!   the squared Euclidean distance it is D/(D+2) m r², r the radius of the ball.
//! - Every energy is a number that 64 bits hold.

use thiserror::Error;

use crate::parallel::map_runs;
use crate::relax::optimum::optimal_energy;

/// The relative rounding that sums of volumes and energies may have.
const ROUNDING: f64 = 1e-9;

/// Cells whose figures one task adds.
const RUN: usize = 4096;

/// Why cells are not those of a tessellation, or what of them is no number. Sites count from zero.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CellsError {
    /// The cells do not fill the domain once.
    #[error(
        "the volumes of the {count} cells sum to {sum}, the domain's is {domain} (relative difference {:e}): \
         {cause}; does the domain overlap or cross itself?",
        sum / domain - 1.0
    )]
    Volumes {
        /// How many cells there are.
        count: usize,
        /// The sum of their volumes (L^D).
        sum: f64,
        /// The domain's volume (L^D).
        domain: f64,
        /// Which cell is at fault, as far as it can be told.
        cause: String,
    },
    /// The mean energy lies below what any cells could have.
    #[error(
        "the mean energy of the {count} cells is {mean:e}, below {floor:e}, the least of that many bodies \
         that share the domain's mass {mass}: {cause}"
    )]
    BelowFloor {
        /// How many cells there are.
        count: usize,
        /// Their mean energy (L^(D+p)).
        mean: f64,
        /// The least possible one.
        floor: f64,
        /// The domain's mass.
        mass: f64,
        /// Which cell is at fault, as far as it can be told.
        cause: String,
    },
    /// An energy beyond what a 64-bit float holds.
    #[error(
        "the cell of site {site} has the volume {volume:e} and the energy {energy:e} of order {order}, beyond \
         what a 64-bit float holds; scale the coordinates so that cells have a size near 1"
    )]
    Range {
        /// The cell's site.
        site: usize,
        /// Its volume (L^D).
        volume: f64,
        /// Its energy as computed.
        energy: f64,
        /// The order p.
        order: u32,
    },
    /// The energies of any cells would be beyond what a 64-bit float holds.
    #[error(
        "a cell of the mean volume {volume:e} has an energy near 1e{exponent:.0} at order {order}, beyond what a \
         64-bit float holds; scale the coordinates so that cells have a size near 1"
    )]
    Scale {
        /// The mean volume (L^D).
        volume: f64,
        /// The decimal logarithm of the energy.
        exponent: f64,
        /// The order p.
        order: u32,
    },
    /// A figure of a cell that is no number.
    #[error("the {figure} of the cell of site {site} is {value}")]
    Figure {
        /// The figure's name.
        figure: &'static str,
        /// The cell's site.
        site: usize,
        /// Its value.
        value: f64,
    },
    /// A figure of all cells that is no number.
    #[error(
        "`{figure}` is {value} after {iteration} iterations; no figure is written that is no number"
    )]
    Total {
        /// The figure's name.
        figure: &'static str,
        /// The moves made so far.
        iteration: u64,
        /// Its value.
        value: f64,
    },
}

/// What bounds the energies of any cells of a domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DomainTotals {
    /// The volume (L^D).
    pub(crate) volume: f64,
    /// The integral of the density: the volume without one.
    pub(crate) mass: f64,
    /// No less than the density anywhere.
    pub(crate) density: f64,
}

/// The energy of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum EnergyKind {
    /// ∫ d∞^p of this order p.
    Chebyshev(u32),
    /// ∫ |y − x|².
    Euclidean,
}

impl EnergyKind {
    /// The power of the distance.
    fn order(self) -> u32 {
        match self {
            Self::Chebyshev(order) => order,
            Self::Euclidean => 2,
        }
    }
}

/// Volume and energy of a cell.
pub(crate) type CellFigures = (f64, f64);

/// Cells together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct CellSums {
    /// How many there are.
    pub(crate) count: usize,
    /// The sum of their volumes (L^D).
    pub(crate) volume: f64,
    /// The sum of their energies (L^(D+p)).
    pub(crate) energy: f64,
}

impl DomainTotals {
    /// The least mean energy that `count` cells can have.
    pub(crate) fn floor<const D: usize>(&self, count: usize, kind: EnergyKind) -> f64 {
        let volume = self.mass / self.density / count as f64;
        self.density
            * match kind {
                EnergyKind::Chebyshev(order) => optimal_energy::<D>(volume, 1, order),
                EnergyKind::Euclidean => ball_moment::<D>(volume),
            }
    }

    /// Refuses orders and sizes whose energies a 64-bit float does not hold, before any cell is built.
    ///
    /// # Errors
    /// [`CellsError::Scale`].
    pub(crate) fn check_scale<const D: usize>(
        &self,
        count: usize,
        kind: EnergyKind,
    ) -> Result<(), CellsError> {
        let volume = self.volume / count.max(1) as f64;
        let of_order = |order: u32| {
            let power = f64::from(order);
            let density = self.mass / self.volume;
            let energy = volume.log10() * (1.0 + power / D as f64) + density.log10();
            let half = 0.5_f64.log10() * power;
            (energy + half, order)
        };
        // With room for the sum and for cells that are larger or smaller than the mean.
        let is_held = |(exponent, _): &(f64, u32)| (-290.0..=290.0).contains(exponent);
        match [of_order(kind.order()), of_order(1)]
            .iter()
            .find(|it| !is_held(it))
        {
            Some(&(exponent, order)) => Err(CellsError::Scale {
                volume,
                exponent,
                order,
            }),
            None => Ok(()),
        }
    }

    /// Checks the cells of a tessellation, given by a number that counts them from zero; `cause` is asked
    /// only where they are none.
    ///
    /// # Errors
    /// As [`CellsError`] says.
    pub(crate) fn check<const D: usize>(
        &self,
        count: usize,
        cells: &(dyn Fn(usize) -> CellFigures + Sync),
        kind: EnergyKind,
        cause: impl FnOnce() -> Option<String>,
    ) -> Result<(), CellsError> {
        // Whoever adds a run, its sum is the same.
        let runs = map_runs(count, RUN, |run| {
            let (mut sums, mut impossible, mut refused) = ((0.0, 0.0), None, None);
            for site in run {
                let cell = cells(site);
                sums = (sums.0 + cell.0, sums.1 + cell.1);
                if impossible.is_none() && !self.is_possible(cell.0) {
                    impossible = Some((site, cell.0));
                }
                refused = refused.or_else(|| Self::out_of_range(site, cell, kind));
            }
            (sums, impossible, refused)
        });
        let add = |sums: CellFigures, run: &CellFigures| (sums.0 + run.0, sums.1 + run.1);
        let (volume, energy) = runs.iter().map(|run| &run.0).fold((0.0, 0.0), add);
        let impossible = runs.iter().find_map(|run| run.1);
        if impossible.is_none() && self.is_filled(volume) {
            let refused = runs.into_iter().find_map(|run| run.2);
            refused.map_or(Ok(()), Err)?;
        }
        let sums = CellSums {
            count,
            volume,
            energy,
        };
        self.check_sums::<D>(&sums, impossible.is_none(), kind, || match impossible {
            Some((site, volume)) => format!("the cell of site {site} has the volume {volume}"),
            None => cause().unwrap_or_else(|| "no single cell is at fault".to_owned()),
        })
    }

    /// Checks what cells are together, each of which has a possible volume or not.
    ///
    /// # Errors
    /// [`CellsError::Volumes`] and [`CellsError::BelowFloor`].
    pub(crate) fn check_sums<const D: usize>(
        &self,
        &CellSums {
            count,
            volume,
            energy,
        }: &CellSums,
        are_possible: bool,
        kind: EnergyKind,
        cause: impl FnOnce() -> String,
    ) -> Result<(), CellsError> {
        if !(are_possible && self.is_filled(volume)) {
            return Err(CellsError::Volumes {
                count,
                sum: volume,
                domain: self.volume,
                cause: cause(),
            });
        }
        let (mean, floor) = (energy / count as f64, self.floor::<D>(count, kind));
        if mean.is_nan() || mean < floor * (1.0 - ROUNDING) {
            return Err(CellsError::BelowFloor {
                count,
                mean,
                floor,
                mass: self.mass,
                cause: cause(),
            });
        }
        Ok(())
    }

    /// The refusal of a cell whose energy 64 bits do not hold.
    pub(crate) fn out_of_range(
        site: usize,
        (volume, energy): CellFigures,
        kind: EnergyKind,
    ) -> Option<CellsError> {
        let order = kind.order();
        let is_lost = volume > 0.0 && !(energy.is_normal() && energy > 0.0);
        is_lost.then_some(CellsError::Range {
            site,
            volume,
            energy,
            order,
        })
    }

    /// Whether volumes that sum to this fill the domain.
    pub(crate) fn is_filled(&self, volume: f64) -> bool {
        (volume - self.volume).abs() <= ROUNDING * self.volume
    }

    /// Whether a cell can have this volume.
    pub(crate) fn is_possible(&self, volume: f64) -> bool {
        (-ROUNDING * self.volume..=(1.0 + ROUNDING) * self.volume).contains(&volume)
    }
}

/// ∫ |y|² over the ball (the disc, for D = 2) of this volume about the origin.
fn ball_moment<const D: usize>(volume: f64) -> f64 {
    let unit = if D == 2 {
        std::f64::consts::PI
    } else {
        4.0 / 3.0 * std::f64::consts::PI
    };
    let d = D as f64;
    d / (d + 2.0) * volume * (volume / unit).powf(2.0 / d)
}

#[cfg(test)]
mod tests {
    use super::*;
    const CUBE: DomainTotals = DomainTotals {
        volume: 1.0,
        mass: 1.0,
        density: 1.0,
    };

    #[test]
    fn floors_are_the_energies_of_cubes_and_balls() {
        // (3/8) s⁴, 3/5 s⁵/4 of a cube, (2/3) s³/2 of a square, ∫ r² over ball and disc.
        let dense = DomainTotals {
            mass: 0.5,
            density: 4.0,
            ..CUBE
        };
        let cases = [
            (
                CUBE.floor::<3>(8, EnergyKind::Chebyshev(1)),
                3.0 / 8.0 / 16.0,
            ),
            (CUBE.floor::<3>(1, EnergyKind::Chebyshev(2)), 3.0 / 20.0),
            (CUBE.floor::<2>(4, EnergyKind::Chebyshev(1)), 1.0 / 24.0),
            (
                dense.floor::<3>(1, EnergyKind::Chebyshev(1)),
                4.0 * 3.0 / 8.0 / 16.0,
            ),
            (
                CUBE.floor::<2>(1, EnergyKind::Euclidean),
                0.5 / std::f64::consts::PI,
            ),
            (
                CUBE.floor::<3>(1, EnergyKind::Euclidean),
                0.6 * (0.75 / std::f64::consts::PI).powf(2.0 / 3.0),
            ),
        ];
        for (floor, exact) in cases {
            assert!((floor / exact - 1.0).abs() < 1e-14, "{floor} {exact}");
        }
    }

    #[test]
    fn faults_are_told_with_the_first_cell() {
        let check = |cells: &[CellFigures]| {
            CUBE.check::<3>(
                cells.len(),
                &|site| cells[site],
                EnergyKind::Chebyshev(1),
                || None,
            )
        };
        let half = 0.2;
        assert_eq!(check(&[(0.5, half), (0.5, half)]), Ok(()));
        let short = check(&[(0.5, half), (0.4, half)]).expect_err("a tenth is missing");
        assert!(short.to_string().contains("sum to 0.9"), "{short}");
        let negative = check(&[(1.5, half), (-0.5, half)]).expect_err("a negative volume");
        assert!(negative.to_string().contains("site 0"), "{negative}");
        let low = check(&[(0.5, 0.01), (0.5, 0.01)]).expect_err("below two cubes");
        assert!(matches!(low, CellsError::BelowFloor { .. }));
        let nothing = check(&[(0.5, half), (0.5, 0.0)]).expect_err("underflow");
        assert!(matches!(nothing, CellsError::Range { site: 1, .. }));
        let lost = check(&[(f64::NAN, half)]).expect_err("no number");
        assert!(matches!(lost, CellsError::Volumes { .. }));
    }
}
