//! The interface between the driver and a space: cells, their energies, and how sites may move.

use nalgebra::{Point, SVector};
use thiserror::Error;

/// Part of an [`EnergySpec`]; re-exported for the floors above.
pub(crate) use crate::energy::center::Minimizer;
use crate::geometry::bounds::Bounds;
use crate::minimize::lbfgsb_state::LbfgsbError;
use crate::relax::cell_check::{CellsError, EnergyKind};
use crate::relax::optimum::EnergyOptimum;

/// A displacement that leaves the domain is halved at most so often, then given up.
const HALVINGS: u32 = 8;

/// No step brings a site nearer to a wall than this share of the domain's extent, which is far more than
/// rounding and far less than a cell.
const WALL_MARGIN: f64 = 1e-9;

/// The share of the room before a wall that a step into it uses: twenty steps bring a site whose best
/// place is on the wall as near as is of any use, and one step too long pins no site there.
const WALL_SHARE: f64 = 0.5;

/// How many walls a step is bent along: three hold a site in a corner.
const MOST_WALLS: usize = 4;

/// The distance whose energy a site minimizes over its cell.
///
/// # Examples
/// ```
/// use chebloyd::{Method, Norm};
///
/// let control = Method::lloyd(50).norm(Norm::L2);
/// assert_ne!(control, Method::lloyd(50));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "scene",
    derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema)
)]
#[cfg_attr(feature = "scene", serde(rename_all = "snake_case"))]
pub enum Norm {
    #[default]
    /// The Chebyshev distance: a site moves to its cell's center.
    Linf,
    /// The Euclidean distance: a site moves to its cell's centroid (the classical control).
    L2,
}

/// The energy of a cell, and how its minimizer is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EnergySpec {
    /// The distance to integrate and minimize.
    pub norm: Norm,
    /// The order p ≥ 1 of the Chebyshev energy ∫ d∞^p.
    pub order: u32,
    /// How the center is found.
    pub minimizer: Minimizer,
}

impl EnergySpec {
    /// The energy by which cells are checked.
    pub(crate) fn kind(&self) -> EnergyKind {
        match self.norm {
            Norm::Linf => EnergyKind::Chebyshev(self.order),
            Norm::L2 => EnergyKind::Euclidean,
        }
    }
}

/// The energy of one cell and its minimizer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellResult<const D: usize> {
    /// Its volume (L^D).
    pub volume: f64,
    /// Energy at the site in the given norm and order: ∫ d∞^p (L^(D+p)), or ∫ |y−x|₂² (L^(D+2)).
    pub energy: f64,
    /// The p = 1 Chebyshev energy at the site, per unit of the domain's mean density (L^(D+1)).
    pub chebyshev: f64,
    /// Where the site should move: the center, or the centroid.
    pub target: Point<f64, D>,
    /// How many energy evaluations the result took.
    pub evaluations: u32,
}

/// The energy of all cells as a function of all sites, at some sites.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectiveValue<const D: usize> {
    /// F: the sum of the cells' Chebyshev energies of the given order (L^(D+p)).
    pub energy: f64,
    /// The sum of the cells' p = 1 Chebyshev energies, per unit of the domain's mean density
    /// (L^(D+1)).
    pub chebyshev: f64,
    /// The largest energy of a cell (L^(D+p)).
    pub energy_max: f64,
    /// ∂F/∂x_i for every site (L^(D+p−1)).
    pub gradient: Vec<SVector<f64, D>>,
    /// Every cell's energy (L^(D+p)).
    pub energies: Vec<f64>,
}

/// How crowded a cell is, and how much room it has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellCrowding<const D: usize> {
    /// Its energy of order 1 (L^(D+1)).
    pub energy: f64,
    /// Its vertex farthest from the site in the Chebyshev norm.
    pub vertex: Point<f64, D>,
    /// How far that is (L).
    pub distance: f64,
}

/// Why a relaxation failed in a space with errors of type `E`.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum RelaxationError<E: std::error::Error + 'static> {
    /// The sites have no diagram.
    #[error(transparent)]
    Space(E),
    /// A figure of the run is no number.
    #[error(transparent)]
    Cells(#[from] CellsError),
    /// The options or the state of the descent are impossible.
    #[error(transparent)]
    Descent(#[from] LbfgsbError),
    /// A level's sites cannot be split.
    #[error(
        "only {placed} of {wanted} sites of a finer level found a place of their own in the domain; \
         run without levels (--coarse-to-fine 0)"
    )]
    NoRoom {
        /// How many sites found one.
        placed: usize,
        /// How many there should be.
        wanted: usize,
    },
}

/// How many steps a descent's model of the curvature remembers.
pub(crate) const REMEMBERED_STEPS: usize = 10;

/// A domain in which sites have cells with energies.
pub trait RelaxationSpace<const D: usize>: Sync {
    /// Why sites have no diagram here.
    type Error: std::error::Error + Send + Sync + 'static;

    /// The domain's volume (L^D).
    fn volume(&self) -> f64;

    /// The box in which sites stay.
    fn bounds(&self) -> Bounds<D>;

    /// Whether a point lies in the domain.
    fn contains(&self, point: &Point<f64, D>) -> bool;

    /// The length of the period along each axis that has one.
    fn periods(&self) -> [Option<f64>; D] {
        [None; D]
    }

    /// The point of the domain that is `point` but for whole periods.
    fn wrap(&self, point: &Point<f64, D>) -> Point<f64, D> {
        *point
    }

    /// The mean density; `None` where it is 1 everywhere.
    fn varying_density(&self) -> Option<f64> {
        None
    }

    /// What `energy_percent` is relative to.
    fn optimum(&self) -> EnergyOptimum {
        EnergyOptimum::of_equal_cubes(self.volume())
    }

    /// How many steps a descent's model of the curvature remembers where it is not told.
    fn remembered_steps(&self) -> usize {
        REMEMBERED_STEPS
    }

    /// Refuses sites so many, or an order so high, that a 64-bit float holds no energy.
    ///
    /// # Errors
    /// [`CellsError::Scale`].
    fn check_scale(&self, count: usize, spec: EnergySpec) -> Result<(), CellsError>;

    /// The displacement from `from` to `to`, the shortest one where the space is periodic.
    fn displacement(&self, from: &Point<f64, D>, to: &Point<f64, D>) -> SVector<f64, D> {
        to - from
    }

    /// `site` moved by `step`, or by as much of it as keeps it in the domain and off its box's faces,
    /// where sites of other rows might meet it.
    fn displaced(&self, site: &Point<f64, D>, mut step: SVector<f64, D>) -> Point<f64, D> {
        let (bounds, periods) = (self.bounds(), self.periods());
        for _ in 0..HALVINGS {
            let moved = site + step;
            let is_off_walls = (0..D).all(|axis| {
                periods[axis].is_some()
                    || (bounds.min[axis] < moved[axis] && moved[axis] < bounds.max[axis])
            });
            let wrapped = self.wrap(&moved);
            if is_off_walls && self.contains(&wrapped) {
                return wrapped;
            }
            step *= 0.5;
        }
        *site
    }

    /// The place `factor` times as far from `site` as `target`, or as much of that way as keeps the
    /// site in the domain.
    fn beyond(&self, site: &Point<f64, D>, target: &Point<f64, D>, factor: f64) -> Point<f64, D> {
        let moved = self.displaced(site, self.displacement(site, target) * factor);
        if moved == *site { *target } else { moved }
    }

    /// Whether the walls are those of the domain's box.
    fn is_box(&self) -> bool {
        true
    }

    /// The first wall, of those that are not the box's, that the straight way from `site` along `step`
    /// meets: the share of the step before it, and the wall's outward unit normal.
    fn wall_ahead(
        &self,
        site: &Point<f64, D>,
        step: &SVector<f64, D>,
    ) -> Option<(f64, SVector<f64, D>)> {
        let _ = (site, step);
        None
    }

    /// `step`, or what is left of it where walls that are not those of the box stand in its way: it goes
    /// half of the way to such a wall and on along it. The straight way from `site` along what is left
    /// stays in the domain, and forms no obtuse angle with `step`.
    fn along_walls(&self, site: &Point<f64, D>, step: SVector<f64, D>) -> SVector<f64, D> {
        let stays = |step: &SVector<f64, D>| self.contains(&self.wrap(&(site + step)));
        let margin = WALL_MARGIN * self.bounds().extent().max();
        let mut bent = step;
        for _ in 0..MOST_WALLS {
            let Some((share, normal)) = self.wall_ahead(site, &bent) else {
                if stays(&bent) && bent.dot(&step) >= 0.0 {
                    return bent;
                }
                break;
            };
            let climb = normal.dot(&bent);
            let room = share * climb;
            let kept = if room > margin {
                WALL_SHARE * room
            } else {
                (room - WALL_SHARE * margin).min(0.0)
            };
            bent -= normal * (climb - kept);
        }
        // Between walls that lead into each other: straight on, half of the way.
        let share = self.wall_ahead(site, &step).map_or(1.0, |ahead| ahead.0);
        let mut straight = step * (WALL_SHARE * share);
        for _ in 0..HALVINGS {
            if stays(&straight) {
                return straight;
            }
            straight *= 0.5;
        }
        SVector::zeros()
    }

    /// The total energy of the cells of `sites`.
    ///
    /// # Errors
    /// When the sites have no diagram.
    fn energy(&self, sites: &[Point<f64, D>], spec: EnergySpec) -> Result<f64, Self::Error>;

    /// The energies and minimizers of the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram: duplicates, points outside the domain or not finite.
    fn assess(
        &self,
        sites: &[Point<f64, D>],
        spec: EnergySpec,
    ) -> Result<Vec<CellResult<D>>, Self::Error>;

    /// The energy of order `order` ≥ 1 of all cells with its exact gradient by all sites.
    ///
    /// # Errors
    /// When the sites have no diagram.
    fn objective(
        &self,
        sites: &[Point<f64, D>],
        order: u32,
    ) -> Result<ObjectiveValue<D>, RelaxationError<Self::Error>>;

    /// How crowded the cells of all `sites` are.
    ///
    /// # Errors
    /// As [`objective`](Self::objective).
    fn crowding(
        &self,
        sites: &[Point<f64, D>],
    ) -> Result<Vec<CellCrowding<D>>, RelaxationError<Self::Error>>;
}
