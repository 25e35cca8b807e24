//! What a loop asks of a space: the cells of sites and what they are worth.

use nalgebra::Point;

/// Part of a [`Question`]; the floors above may not look further down for it.
pub use crate::energy::center::Minimizer;
use crate::geometry::bounds::Bounds;

/// Which distance a site minimizes over its cell.
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

/// What a loop wants to know of every cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Question {
    /// The distance to integrate and minimize.
    pub norm: Norm,
    /// The order p ≥ 1 of the Chebyshev energy ∫ d∞^p.
    pub order: u32,
    /// How the center is found.
    pub minimizer: Minimizer,
}

/// The answer for one cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Assessment<const D: usize> {
    /// Energy at the site in the asked norm and order: ∫ d∞^p (L^(D+p)), or ∫ |y−x|₂² (L^(D+2)).
    pub energy: f64,
    /// The p = 1 Chebyshev energy at the site, per unit of the domain's mean density (L^(D+1)).
    pub chebyshev: f64,
    /// Where the site should move: the center, or the centroid.
    pub target: Point<f64, D>,
    /// How many energy evaluations the answer took.
    pub evaluations: u32,
}

/// A space in which sites have cells: a domain and the diagrams in it.
pub trait Tessellation<const D: usize>: Sync {
    /// Why sites have no diagram here.
    type Error: std::error::Error + Send + Sync + 'static;

    /// The domain's volume (L^D).
    fn volume(&self) -> f64;

    /// The box in which sites stay.
    fn bounds(&self) -> Bounds<D>;

    /// The displacement from `from` to `to`, the shortest one where the space is periodic.
    fn displacement(&self, from: &Point<f64, D>, to: &Point<f64, D>) -> nalgebra::SVector<f64, D> {
        to - from
    }

    /// The place `factor` times as far from `site` as `target`, or as much of that way as keeps the
    /// site in the domain.
    fn beyond(&self, site: &Point<f64, D>, target: &Point<f64, D>, factor: f64) -> Point<f64, D>;

    /// The total energy of the cells of `sites`, in the asked norm and order.
    ///
    /// # Errors
    /// When the sites have no diagram.
    fn energy(&self, sites: &[Point<f64, D>], question: Question) -> Result<f64, Self::Error>;

    /// Assesses the cells of all `sites`, in site order.
    ///
    /// # Errors
    /// When the sites have no diagram: duplicates, points outside the domain or not finite.
    fn assess(
        &self,
        sites: &[Point<f64, D>],
        question: Question,
    ) -> Result<Vec<Assessment<D>>, Self::Error>;
}
