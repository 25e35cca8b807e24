//! The figures of cells and of the whole tessellation, as `measure` prints them.
//!
//! Shape figures are those of section 3.5 of \[BL\] read together with how near a cell is to an
//! axis-aligned cube: a tessellation of cubes has cubeness, six-facet fraction and axis-aligned
//! area 1 and volume deviation 0. In the plane, read square for cube and edge for facet: "six"
//! is then four, and `four_sided_fraction` says it so.

use std::collections::BTreeMap;

use nalgebra::{Point, Rotation3, SVector, Vector3};
#[cfg(feature = "scene")]
use serde::{Deserialize, Serialize, Serializer};

use crate::domain::facet_kind::FacetKind;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::exact_sum::{ExactSum, exact_sums};
use crate::relax::cell_check::CellsError;
use crate::relax::optimum::EnergyOptimum;

/// Facets larger than this share of V^{(D−1)/D} count.
pub(crate) const FACET_SHARE: f64 = 0.05;

/// A facet is axis-aligned if a component of its unit normal is at least this: within ten degrees.
pub(crate) const ALIGNED: f64 = 0.985;

/// The figures of one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize))]
pub struct CellMetrics<const D: usize> {
    /// The volume (L^D).
    pub volume: f64,
    /// The mass center.
    #[cfg_attr(feature = "scene", serde(serialize_with = "point_as_array"))]
    pub centroid: Point<f64, D>,
    /// The energy at the site in the given norm and order.
    pub energy: f64,
    /// Its gradient at the site.
    #[cfg_attr(feature = "scene", serde(serialize_with = "vector_as_array"))]
    pub gradient: SVector<f64, D>,
    /// The minimizer of the energy in the cell's bounds.
    #[cfg_attr(feature = "scene", serde(serialize_with = "point_as_array"))]
    pub center: Point<f64, D>,
    /// The energy there.
    pub center_energy: f64,
    /// How many facets are larger than [`FACET_SHARE`] of V^{(D−1)/D}.
    pub facets: u32,
    /// The p = 1 Chebyshev energy at the site (L^(D+1)).
    #[cfg_attr(feature = "scene", serde(skip))]
    pub chebyshev: f64,
    /// The mean density in the cell, relative to the domain's; 1 without a density.
    #[cfg_attr(feature = "scene", serde(skip))]
    pub relative_density: f64,
    /// |C ∩ Q| / |C ∪ Q|, Q the axis-aligned cube of the cell's volume about its site.
    #[cfg_attr(feature = "scene", serde(skip))]
    pub cubeness: f64,
    /// The share of the facet area that is axis-aligned.
    #[cfg_attr(feature = "scene", serde(skip))]
    pub axis_aligned: f64,
}

/// The figures of a tessellation.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Relaxation};
///
/// let metrics = Relaxation::new(Cuboid::unit()).measure(&[[0.5; 3]])?;
/// assert!((metrics.cubeness - 1.0).abs() < 1e-12 && (metrics.energy_percent - 100.0).abs() < 1e-9);
/// # Ok::<(), chebloyd::RelaxError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize))]
#[non_exhaustive]
pub struct Metrics {
    /// How many sites there are.
    pub sites: usize,
    /// The domain's volume (L^D).
    pub domain_volume: f64,
    /// The sum of the cells' volumes (L^D).
    pub volume_sum: f64,
    /// Mean energy at the sites, in the given norm and order.
    pub energy_mean: f64,
    /// Largest energy of a cell.
    pub energy_max: f64,
    /// 100 · mean p = 1 Chebyshev energy / that of a cube of the mean volume; with a density / that of
    /// the asymptotic optimum, which few sites may pass below.
    pub energy_percent: f64,
    /// Mean of the cells' cubeness.
    pub cubeness: f64,
    /// Share of the cells with exactly 2·D counted facets.
    pub six_facet_fraction: f64,
    /// In the plane the same share, of cells with four counted edges.
    #[cfg_attr(
        feature = "scene",
        serde(default, skip_serializing_if = "Option::is_none")
    )]
    pub(crate) four_sided_fraction: Option<f64>,
    /// Mean share of axis-aligned facet area.
    pub axis_aligned_area: f64,
    /// Relative standard deviation of the cells' volumes.
    pub volume_sd: f64,
    /// Counted facets → cells.
    pub facet_histogram: BTreeMap<u32, usize>,
    /// Where the cells are L∞ cells: the same sites in either tessellation.
    #[cfg_attr(
        feature = "scene",
        serde(flatten, skip_serializing_if = "Option::is_none")
    )]
    pub(crate) both: Option<BothTessellations>,
}

/// The same sites with L2 and with L∞ cells.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "scene", derive(Serialize, Deserialize))]
pub(crate) struct BothTessellations {
    /// `energy_percent` with L2 cells.
    pub(crate) energy_percent_l2: f64,
    /// `energy_percent` with L∞ cells, never above that with L2 cells.
    pub(crate) energy_percent_linf: f64,
    /// The share of the volume that is equidistant, equal in `f64`, to several sites in the Chebyshev
    /// distance.
    pub(crate) tied_volume: f64,
}

/// How many cells have so many counted facets.
pub(crate) type FacetHistogram = BTreeMap<u32, usize>;

/// How the figures of some cells become those of all.
pub(crate) trait Reduction {
    /// How many cells there are in all, where these are so many.
    fn count(&self, own: usize) -> usize;

    /// The sum over all cells.
    fn total(&self, own: &ExactSum) -> f64;

    /// The largest of all cells.
    fn largest(&self, own: f64) -> f64;

    /// The histogram of all cells.
    fn histogram(&self, own: FacetHistogram) -> FacetHistogram;
}

/// These are all cells.
struct AllCells;

impl Reduction for AllCells {
    fn count(&self, own: usize) -> usize {
        own
    }

    fn total(&self, own: &ExactSum) -> f64 {
        own.value()
    }

    fn largest(&self, own: f64) -> f64 {
        own
    }

    fn histogram(&self, own: FacetHistogram) -> FacetHistogram {
        own
    }
}

impl Metrics {
    /// Sums up the figures of all cells of a domain of volume `domain_volume`.
    #[must_use]
    pub fn of<const D: usize>(
        domain_volume: f64,
        optimum: &EnergyOptimum,
        cells: &[CellMetrics<D>],
    ) -> Self {
        Self::reduced(domain_volume, optimum, cells, &AllCells)
    }

    /// Sums up the figures of cells that may be some of all.
    pub(crate) fn reduced<const D: usize>(
        domain_volume: f64,
        optimum: &EnergyOptimum,
        cells: &[CellMetrics<D>],
        reduction: &dyn Reduction,
    ) -> Self {
        let sites = reduction.count(cells.len());
        let count = sites as f64;
        let mean = |figure: &(dyn Fn(&CellMetrics<D>) -> f64 + Sync)| {
            let [sum] = exact_sums(cells, |cell| [figure(cell)]);
            reduction.total(&sum) / count
        };
        let volume_mean = mean(&|cell| cell.volume);
        let variance = mean(&|cell| (cell.volume - volume_mean).powi(2));
        let mut facet_histogram = BTreeMap::new();
        for cell in cells {
            *facet_histogram.entry(cell.facets).or_insert(0) += 1;
        }
        let facet_histogram = reduction.histogram(facet_histogram);
        let cubic = facet_histogram.get(&(2 * D as u32)).copied().unwrap_or(0);
        let largest = cells.iter().map(|cell| cell.energy).fold(0.0, f64::max);
        Self {
            sites,
            domain_volume,
            volume_sum: volume_mean * count,
            energy_mean: mean(&|cell| cell.energy),
            energy_max: reduction.largest(largest),
            energy_percent: optimum.percent::<D>(mean(&|cell| cell.chebyshev), sites),
            cubeness: mean(&|cell| cell.cubeness),
            six_facet_fraction: cubic as f64 / count,
            four_sided_fraction: (D == 2).then_some(cubic as f64 / count),
            axis_aligned_area: mean(&|cell| cell.axis_aligned),
            volume_sd: variance.sqrt() / volume_mean,
            facet_histogram,
            both: None,
        }
    }

    /// The same figures beside those of both tessellations, if there are such.
    #[must_use]
    pub(crate) fn beside(self, both: Option<BothTessellations>) -> Self {
        Self { both, ..self }
    }

    /// The same figures if all are numbers; `iteration` is told where one is not.
    ///
    /// # Errors
    /// [`CellsError::Total`].
    pub(crate) fn checked(self, iteration: u64) -> Result<Self, CellsError> {
        let figures = [
            ("domain_volume", self.domain_volume),
            ("volume_sum", self.volume_sum),
            ("energy_mean", self.energy_mean),
            ("energy_max", self.energy_max),
            ("energy_percent", self.energy_percent),
            ("cubeness", self.cubeness),
            ("axis_aligned_area", self.axis_aligned_area),
            ("volume_sd", self.volume_sd),
        ];
        match figures.into_iter().find(|(_, value)| !value.is_finite()) {
            Some((figure, value)) => Err(CellsError::Total {
                figure,
                iteration,
                value,
            }),
            None => Ok(self),
        }
    }
}

impl<const D: usize> CellMetrics<D> {
    /// The first figure that is no number, for the cell of `site`.
    ///
    /// # Errors
    /// [`CellsError::Figure`].
    pub(crate) fn check(&self, site: usize) -> Result<(), CellsError> {
        let figures: [(&str, &[f64]); 8] = [
            ("volume", &[self.volume]),
            ("centroid", self.centroid.coords.as_slice()),
            ("energy", &[self.energy]),
            ("gradient", self.gradient.as_slice()),
            ("center", self.center.coords.as_slice()),
            ("center_energy", &[self.center_energy]),
            ("chebyshev energy", &[self.chebyshev]),
            ("cubeness", &[self.cubeness]),
        ];
        for (figure, values) in figures {
            if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
                return Err(CellsError::Figure {
                    figure,
                    site,
                    value,
                });
            }
        }
        Ok(())
    }
}

#[cfg(feature = "scene")]
fn point_as_array<S: Serializer, const D: usize>(
    point: &Point<f64, D>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(point.iter())
}

#[cfg(feature = "scene")]
fn vector_as_array<S: Serializer, const D: usize>(
    vector: &SVector<f64, D>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(vector.iter())
}

/// Sums over the signed pieces of a cell whose site is the origin.
#[derive(Debug, Default)]
pub(crate) struct ShapeSums {
    /// Per facet label, the area vector over all pieces. A wall is what the domain says it is: for a
    /// surface, the triangles in one plane that hang together.
    areas: BTreeMap<Label, Vector3<f64>>,
    overlap: f64,
}

impl ShapeSums {
    /// Adds the facets of `sign` times the piece.
    pub(crate) fn add(&mut self, sign: f64, piece: Piece<'_>) {
        piece.visit_facets(|label, _, area| {
            if FacetKind::of(label) != FacetKind::Inner {
                *self.areas.entry(label).or_default() += area * sign;
            }
        });
    }

    /// Adds `volume` to what the cell and its cube have in common.
    pub(crate) fn add_overlap(&mut self, volume: f64) {
        self.overlap += volume;
    }

    /// How many facets are larger than [`FACET_SHARE`] of V^{2/3}.
    pub(crate) fn facets(&self, volume: f64) -> u32 {
        let least = FACET_SHARE * volume.cbrt().powi(2);
        self.areas
            .values()
            .filter(|area| area.norm() > least)
            .count() as u32
    }

    /// The share of the facet area whose unit normal has a component of at least [`ALIGNED`] in the
    /// cell's frame.
    pub(crate) fn axis_aligned(&self, frame: Option<&Rotation3<f64>>) -> f64 {
        let (mut aligned, mut all) = (0.0, 0.0);
        for vector in self.areas.values() {
            let area = vector.norm();
            all += area;
            let turned = frame.map_or(*vector, |frame| frame.inverse() * vector);
            if turned.amax() >= ALIGNED * area {
                aligned += area;
            }
        }
        if all > 0.0 { aligned / all } else { 0.0 }
    }

    /// |C ∩ Q| / |C ∪ Q| for the cube Q of the cell's volume about its site.
    pub(crate) fn cubeness(&self, volume: f64) -> f64 {
        let union = 2.0 * volume - self.overlap;
        if union > 0.0 {
            self.overlap / union
        } else {
            0.0
        }
    }
}

/// The common part of a cell with the cube of volume `volume` about the origin, in the cell's frame.
pub(crate) fn within_cube(
    cell: &Polyhedron,
    volume: f64,
    frame: Option<&Rotation3<f64>>,
    scratch: &mut ClipScratch,
) -> Polyhedron {
    let mut common = cell.clone();
    let offset = 0.5 * volume.max(0.0).cbrt();
    for axis in 0..3 {
        for sign in [1.0, -1.0] {
            let mut normal = Vector3::zeros();
            normal[axis] = sign;
            let normal = frame.map_or(normal, |frame| frame * normal);
            let side = HalfSpace { normal, offset };
            if clip(&mut common, &side, FacetKind::Inner.label(), scratch) == Clip::Emptied {
                return common;
            }
        }
    }
    common
}
