//! Runs as curves over their iterations; several runs of one kind as their mean and their extremes.
//!
//! Beyond its last iteration a run keeps its last energy, so that a run that ended early still counts; it moves
//! no more, so that the mean movement is that of the runs that go on.

use crate::relax::optimum::EnergyReference;
use crate::relax::record::Record;

/// `(iteration, value)` in order.
pub(crate) type CurvePoints = Vec<(f64, f64)>;

/// Movements below this (%) are rounding noise.
const LEAST_MOVEMENT: f64 = 1e-12;

/// Runs that are drawn as one curve.
#[derive(Clone, Debug)]
pub(crate) struct RunGroup<'a> {
    /// The name in the legend; shortened where it is too long.
    pub name: String,
    /// Their logs; more than one make a band.
    pub logs: Vec<&'a [Record]>,
}

/// Points from elsewhere that are drawn upon the curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Overlay {
    /// The name in the legend.
    pub name: String,
    /// Movements in percent.
    pub movement: CurvePoints,
    /// Energies in percent.
    pub energy: CurvePoints,
}

/// A curve with the least and the greatest values around it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Band {
    /// The mean over the runs.
    pub mean: CurvePoints,
    /// The least and the greatest values, where there are several runs.
    pub extremes: Option<[CurvePoints; 2]>,
}

impl Overlay {
    /// Without the points after an iteration, for which there are no runs.
    pub(crate) fn up_to(&self, last: f64) -> Self {
        let kept = |points: &CurvePoints| {
            let kept = points.iter().filter(|(iteration, _)| *iteration <= last);
            kept.copied().collect()
        };
        Self {
            name: self.name.clone(),
            movement: kept(&self.movement),
            energy: kept(&self.energy),
        }
    }
}

impl RunGroup<'_> {
    /// Movements in percent, those that are not zero.
    pub(crate) fn movement(&self) -> Band {
        self.band(|log, k| {
            let value = log.get(k)?.movement_percent;
            (value.is_finite() && value >= LEAST_MOVEMENT).then_some(value)
        })
    }

    /// Energies in percent.
    pub(crate) fn energy(&self) -> Band {
        self.band(|log, k| {
            let value = log.get(k).or(log.last())?.energy_percent;
            value.is_finite().then_some(value)
        })
    }

    /// What the energies are relative to.
    pub(crate) fn reference(&self) -> EnergyReference {
        let first = self.logs.iter().find_map(|log| log.first());
        first
            .and_then(|record| record.energy_reference)
            .unwrap_or_default()
    }

    /// The last iteration of all runs.
    pub(crate) fn last_iteration(&self) -> f64 {
        let last = self.logs.iter().flat_map(|log| log.iter());
        last.map(|record| record.iteration as f64)
            .fold(0.0, f64::max)
    }

    /// Mean and extremes of the values by line of the logs.
    fn band(&self, read: impl Fn(&[Record], usize) -> Option<f64>) -> Band {
        let longest = self.logs.iter().max_by_key(|log| log.len());
        let lines = longest.copied().unwrap_or_default();
        let mut band = Band::default();
        let [mut low, mut high] = [Vec::new(), Vec::new()];
        for (k, line) in lines.iter().enumerate() {
            let values: Vec<f64> = self.logs.iter().filter_map(|log| read(log, k)).collect();
            if values.is_empty() {
                continue;
            }
            let iteration = line.iteration as f64;
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            band.mean.push((iteration, mean));
            low.push((iteration, values.iter().copied().fold(mean, f64::min)));
            high.push((iteration, values.iter().copied().fold(mean, f64::max)));
        }
        if self.logs.len() > 1 {
            band.extremes = Some([low, high]);
        }
        band
    }
}

impl Band {
    /// All curves.
    pub(crate) fn curves(&self) -> impl Iterator<Item = &CurvePoints> {
        std::iter::once(&self.mean).chain(self.extremes.iter().flatten())
    }
}
