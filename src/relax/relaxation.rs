//! A relaxation in one call: a domain, a method, sites, and perhaps an observer.
//!
//! [`Relaxation`] is what most callers need. Sites are `[f64; 3]` or nalgebra's points; parallel work
//! runs in the rayon pool that the caller has installed, or in the global one. A [`Checkpoint`] holds
//! all that a run needs to go on, to the bit as if it had not stopped.

use std::ops::ControlFlow;

use nalgebra::{Point, Point3};
use thiserror::Error;

use crate::domain::domain::Domain;
use crate::domain::random_points::random_points;
use crate::relax::cell_check::CellsError;
use crate::relax::driver::{Observer, RunEnd, drive};
use crate::relax::frames::Frames;
use crate::relax::method::Method;
use crate::relax::metrics::Metrics;
use crate::relax::plan::Plan;
use crate::relax::record::Record;
use crate::relax::relaxation_space::{Norm, RelaxationError, RelaxationSpace};
use crate::relax::space::{Space, SpaceError};
use crate::relax::split::split_to_finest;
use crate::relax::state::RunState;

/// Why a relaxation failed.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, RelaxError, Relaxation};
///
/// let twice = Relaxation::new(Cuboid::unit()).run(&mut vec![[0.5; 3]; 2]);
/// assert!(matches!(twice, Err(RelaxError::Space(_))));
/// ```
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum RelaxError {
    /// The sites have no cells, or the descent was given impossible numbers.
    #[error(transparent)]
    Space(#[from] RelaxationError<SpaceError>),
    /// The domain is too thin to draw random points in it.
    #[error("no random point fell into the domain in {draws} draws; give sites of your own")]
    Thin {
        /// How many points were drawn in a row.
        draws: u64,
    },
    /// More sites than can be numbered.
    #[error("{count} sites are more than the {} that can be numbered", u32::MAX - 1)]
    TooManySites {
        /// How many.
        count: usize,
    },
    /// L∞ cells do not go with something else.
    #[error("L∞ cells do not go with {what}; choose L2 cells")]
    Cells {
        /// With what.
        what: &'static str,
    },
    /// The numbers of a checkpoint are of no run.
    #[error("the checkpoint's {numbers} numbers are of no run of {sites} sites")]
    Checkpoint {
        /// How many numbers there are.
        numbers: usize,
        /// How many sites there are.
        sites: usize,
    },
}

/// All that a run needs to go on, to the bit as if it had not stopped.
///
/// # Examples
/// ```
/// use chebloyd::Checkpoint;
///
/// let checkpoint: Checkpoint = Checkpoint::at_start(vec![[0.5; 3].into()]);
/// assert!(checkpoint.record.is_none() && checkpoint.state_numbers().is_empty());
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint<const D: usize = 3> {
    /// The sites.
    pub sites: Vec<Point<f64, D>>,
    /// The record that describes them; none before the first.
    pub record: Option<Record>,
    /// The method's own state after that record; none before the first.
    pub(crate) state: Option<RunState<D>>,
}

impl<const D: usize> Checkpoint<D> {
    /// A run before its first record.
    #[must_use]
    pub fn at_start(sites: Vec<Point<f64, D>>) -> Self {
        Self {
            sites,
            record: None,
            state: None,
        }
    }

    /// The checkpoint of these parts, the state as [`Checkpoint::state_numbers`] gave it; that of plain
    /// Lloyd may be empty, since the record tells all of it.
    ///
    /// # Errors
    /// [`RelaxError::Checkpoint`] when the numbers are of no state of so many sites.
    pub fn from_parts(
        sites: Vec<Point<f64, D>>,
        record: Record,
        state_numbers: &[f64],
    ) -> Result<Self, RelaxError> {
        let state = if state_numbers.is_empty() {
            RunState::of_lloyd(sites.len(), &record)
        } else {
            let state = RunState::from_numbers(state_numbers);
            let state = state.filter(|state| state.is_of(sites.len()));
            state.ok_or(RelaxError::Checkpoint {
                numbers: state_numbers.len(),
                sites: sites.len(),
            })?
        };
        Ok(Self {
            sites,
            record: Some(record),
            state: Some(state),
        })
    }

    /// How many sites the run's finest level has.
    #[cfg(feature = "scene")]
    pub(crate) fn count(&self) -> usize {
        let state = self.state.as_ref();
        state.map_or(self.sites.len(), |state| state.count)
    }

    /// All sites of the run: its own, those of a coarse level split without moves.
    pub(crate) fn finest_sites<S: RelaxationSpace<D>>(
        &self,
        space: &S,
    ) -> Result<Vec<Point<f64, D>>, RelaxationError<S::Error>> {
        match &self.state {
            Some(state) => split_to_finest(space, &self.sites, state.count, state.level),
            None => Ok(self.sites.clone()),
        }
    }

    /// The method's state as plain numbers, to be kept in any form; empty before the first record.
    #[must_use]
    pub fn state_numbers(&self) -> Vec<f64> {
        self.numbers().collect()
    }

    /// As [`Checkpoint::state_numbers`], one by one: those of a descent are many times the sites.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + Clone + '_ {
        self.state.iter().flat_map(RunState::numbers)
    }
}

/// How a relaxation ended.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Method, Relaxation};
///
/// let lloyd = Relaxation::new(Cuboid::unit()).method(Method::lloyd(5));
/// let outcome = lloyd.run(&mut vec![[0.3; 3], [0.6; 3]])?;
/// assert_eq!(outcome.records.len(), 6);
/// # Ok::<(), chebloyd::RelaxError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outcome {
    /// Every record, the first of the sites before any move.
    pub records: Vec<Record>,
    /// Why it ended.
    pub ended: RunEnd,
}

/// A domain, a method, and axes of distance: all of a relaxation but the sites.
///
/// # Examples
/// ```
/// use std::ops::ControlFlow;
/// use chebloyd::{Cuboid, Method, Relaxation};
///
/// let mut sites = vec![[0.2, 0.3, 0.4], [0.7, 0.6, 0.5], [0.4, 0.8, 0.1]];
/// let relaxation = Relaxation::new(Cuboid::unit()).method(Method::lloyd(20));
/// let outcome = relaxation.run_with(&mut sites, |record, _| {
///     println!("{} {:.3} %", record.iteration, record.energy_percent);
///     ControlFlow::Continue(())
/// })?;
/// assert_eq!(outcome.records.len(), 21);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Relaxation {
    space: Space,
    plan: Plan,
}

impl Relaxation {
    /// Fifty moves of Lloyd's iteration in `domain`.
    #[must_use]
    pub fn new(domain: impl Domain + 'static) -> Self {
        Self::boxed(Box::new(domain))
    }

    /// The same for a domain whose type is known only when the program runs.
    #[must_use]
    pub fn boxed(domain: Box<dyn Domain>) -> Self {
        Self {
            space: Space::new(domain),
            plan: Method::default().0,
        }
    }

    /// With this method.
    #[must_use]
    pub fn method(self, method: Method) -> Self {
        Self {
            plan: method.0,
            ..self
        }
    }

    /// With distances measured along these axes instead of those of space.
    #[must_use]
    pub fn frames(self, frames: Frames) -> Self {
        Self {
            space: self.space.framed(frames),
            ..self
        }
    }

    /// With cells of the points nearest to their site in this distance: [`Norm::L2`] unless told
    /// otherwise. L∞ cells are fastest in boxes, periodic or not; they are made without frames and for
    /// the Chebyshev norm only, otherwise runs end in [`RelaxError::Cells`].
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Method, Norm, Relaxation, random_sites};
    ///
    /// let mut sites = random_sites(&Cuboid::unit(), 20, 1)?;
    /// let own = Relaxation::new(Cuboid::unit()).cells(Norm::Linf);
    /// let borrowed = Relaxation::new(Cuboid::unit()).measure(&sites)?.energy_percent;
    /// assert!(own.measure(&sites)?.energy_percent < borrowed);
    /// own.method(Method::quasi_newton(5)).run(&mut sites)?;
    /// # Ok::<(), chebloyd::RelaxError>(())
    /// ```
    #[must_use]
    pub fn cells(self, distance: Norm) -> Self {
        let space = self.space.with_cells(distance);
        Self { space, ..self }
    }

    /// Refuses what L∞ cells do not go with.
    fn check_cells(&self) -> Result<(), RelaxError> {
        let refused = self.space.refused_cells(self.plan.spec.norm);
        refused.map_or(Ok(()), |what| Err(RelaxError::Cells { what }))
    }

    /// Relaxes `sites` in place.
    ///
    /// # Errors
    /// When a site is not finite or outside the domain, or two coincide; `sites` are then unchanged.
    pub fn run<P>(&self, sites: &mut Vec<P>) -> Result<Outcome, RelaxError>
    where
        P: Copy + Into<Point3<f64>> + From<Point3<f64>>,
    {
        self.run_with(sites, |_, _| ControlFlow::Continue(()))
    }

    /// As [`Relaxation::run`]; the observer is shown every record with the sites it describes, and may
    /// stop the run. A run that ends on a coarse level leaves all sites, those split without moves.
    ///
    /// # Errors
    /// As [`Relaxation::run`].
    pub fn run_with<P>(
        &self,
        sites: &mut Vec<P>,
        mut observer: impl FnMut(&Record, &[Point3<f64>]) -> ControlFlow<()>,
    ) -> Result<Outcome, RelaxError>
    where
        P: Copy + Into<Point3<f64>> + From<Point3<f64>>,
    {
        let points = sites.iter().map(|&site| site.into()).collect();
        let mut checkpoint = Checkpoint::at_start(points);
        let mut records = Vec::new();
        let ended = self.resume(&mut checkpoint, |record, sites| {
            records.push(record.clone());
            observer(record, sites)
        })?;
        *sites = self
            .sites_of(&checkpoint)?
            .into_iter()
            .map(P::from)
            .collect();
        Ok(Outcome { records, ended })
    }

    /// Goes on from a checkpoint, which is then where the run stopped: at its end, or where the
    /// observer stopped it. On a coarse level it holds that level's sites ([`Relaxation::sites_of`]).
    ///
    /// # Errors
    /// As [`Relaxation::run`]; the checkpoint is then of no further use.
    ///
    /// # Examples
    /// ```
    /// use std::ops::ControlFlow;
    /// use chebloyd::{Checkpoint, Cuboid, Relaxation};
    ///
    /// let sites = [[0.2, 0.3, 0.4], [0.7, 0.6, 0.5]].map(Into::into).to_vec();
    /// let relaxation = Relaxation::new(Cuboid::unit());
    /// let mut stopped = Checkpoint::at_start(sites.clone());
    /// relaxation.resume(&mut stopped, |record, _| match record.iteration {
    ///     3 => ControlFlow::Break(()),
    ///     _ => ControlFlow::Continue(()),
    /// })?;
    /// relaxation.resume(&mut stopped, |_, _| ControlFlow::Continue(()))?;
    /// let mut straight = Checkpoint::at_start(sites);
    /// relaxation.resume(&mut straight, |_, _| ControlFlow::Continue(()))?;
    /// assert_eq!(stopped.sites, straight.sites);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn resume(
        &self,
        checkpoint: &mut Checkpoint,
        mut observer: impl FnMut(&Record, &[Point3<f64>]) -> ControlFlow<()>,
    ) -> Result<RunEnd, RelaxError> {
        self.check_cells()?;
        let observer = &mut |record: &Record, sites: &[Point3<f64>], _: &_| observer(record, sites);
        Ok(continue_run(&self.space, &self.plan, checkpoint, observer)?)
    }

    /// All sites of a run that has stopped: the checkpoint's, those of a coarse level split without
    /// moves. Plain methods have no coarse levels.
    ///
    /// # Errors
    /// When the domain has no room for so many distinct sites.
    pub fn sites_of(&self, checkpoint: &Checkpoint) -> Result<Vec<Point3<f64>>, RelaxError> {
        Ok(checkpoint.finest_sites(&self.space)?)
    }

    /// Volume, energy and shape of the cells of `sites`, without any move.
    ///
    /// # Errors
    /// As [`Relaxation::run`].
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Relaxation};
    ///
    /// let metrics = Relaxation::new(Cuboid::unit()).measure(&[[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]])?;
    /// assert!((metrics.volume_sum - 1.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn measure<P: Copy + Into<Point3<f64>>>(&self, sites: &[P]) -> Result<Metrics, RelaxError> {
        self.check_cells()?;
        let points: Vec<_> = sites.iter().map(|&site| site.into()).collect();
        let cells = self.space.metrics(&points, self.plan.spec);
        let cells = cells.map_err(RelaxationError::Space)?;
        let figures = Metrics::of(self.space.volume(), &self.space.optimum(), &cells);
        Ok(figures.checked(0).map_err(RelaxationError::Cells)?)
    }
}

/// Drives a run on from a checkpoint and keeps that up to date.
pub(crate) fn continue_run<const D: usize, S: RelaxationSpace<D>>(
    space: &S,
    plan: &Plan,
    checkpoint: &mut Checkpoint<D>,
    observer: &mut Observer<'_, D>,
) -> Result<RunEnd, RelaxationError<S::Error>> {
    let Checkpoint {
        sites,
        record,
        state,
    } = checkpoint;
    let count = sites.len();
    let state = state.get_or_insert_with(|| RunState::new(count, plan.levels));
    let resumed = record.clone();
    let mut refused = None;
    let ended = drive(
        space,
        plan,
        sites,
        state,
        resumed.as_ref(),
        &mut |now, sites, state| {
            if let Some((figure, value)) = now.not_finite() {
                let iteration = now.iteration;
                refused = Some(CellsError::Total {
                    figure,
                    iteration,
                    value,
                });
                return ControlFlow::Break(());
            }
            *record = Some(now.clone());
            observer(now, sites, state)
        },
    );
    match refused {
        Some(error) => Err(error.into()),
        None => ended,
    }
}

/// Uniform random sites in a domain: those that a scene's `"random"` names with this seed.
///
/// # Errors
/// [`RelaxError::Thin`] when the domain fills next to nothing of its bounding box,
/// [`RelaxError::TooManySites`].
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, random_sites};
///
/// let cube = Cuboid::unit();
/// assert_eq!(random_sites(&cube, 10, 1)?, random_sites(&cube, 10, 1)?);
/// # Ok::<(), chebloyd::RelaxError>(())
/// ```
pub fn random_sites(
    domain: &dyn Domain,
    count: usize,
    seed: u64,
) -> Result<Vec<Point3<f64>>, RelaxError> {
    if count >= u32::MAX as usize {
        return Err(RelaxError::TooManySites { count });
    }
    random_points(domain.shape(), count, seed).map_err(|draws| RelaxError::Thin { draws })
}
