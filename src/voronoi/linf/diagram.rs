//! The L∞ Voronoi diagram of all sites: cells visited in parallel, results in site order.

use nalgebra::Point3;

use crate::voronoi::diagram::{Diagram, DiagramError};
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::linf::cell::{LinfCell, LinfCellBuilder, Ties};
use crate::voronoi::linf::search::nearest;
use crate::voronoi::search::Duplicate;

impl Diagram<'_> {
    /// As [`Diagram::map`], for the L∞ cells.
    ///
    /// # Errors
    /// [`DiagramError::Duplicate`] for the first pair of sites in one place.
    pub(crate) fn map_linf<Scratch: Default + Send, T: Send>(
        &self,
        ties: Ties,
        of_cell: impl Fn(&mut Scratch, LinfCell<'_>) -> T + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        self.map_places(self.built_linf(self.tree()?, ties, of_cell))
    }

    /// As [`Diagram::map_copied`], for the L∞ cells.
    ///
    /// # Errors
    /// As [`Diagram::map_linf`].
    pub(crate) fn map_linf_copied<Scratch: Default + Send, T: Copy + Send + Sync + 'static>(
        &self,
        ties: Ties,
        of_cell: impl Fn(&mut Scratch, LinfCell<'_>) -> T + Sync,
    ) -> Result<Vec<T>, DiagramError> {
        self.copy_places(self.built_linf(self.tree()?, ties, of_cell))
    }

    /// What `of_cell` says of the L∞ cell in a place.
    fn built_linf<Scratch, T>(
        &self,
        tree: &KdTree,
        ties: Ties,
        of_cell: impl Fn(&mut Scratch, LinfCell<'_>) -> T + Sync,
    ) -> impl Fn(&mut (LinfCellBuilder, Scratch), usize) -> Result<T, Duplicate> + Sync {
        let domain = self.domain();
        move |(builder, scratch), place| {
            let cell = builder.build(domain, tree, place, ties)?;
            Ok(of_cell(scratch, cell))
        }
    }

    /// As [`Diagram::stream`], for the L∞ cells.
    ///
    /// # Errors
    /// As [`Diagram::stream`].
    pub(crate) fn stream_linf<T: Send, Failure: From<DiagramError>>(
        &self,
        of_cell: impl Fn(LinfCell<'_>) -> T + Sync,
        take: impl FnMut(usize, T) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let of_cell = |(): &mut (), cell: LinfCell<'_>| of_cell(cell);
        let one = self.built_linf(self.tree()?, Ties::ToSmallerIndex, of_cell);
        self.stream_places(one, take)
    }

    /// The site nearest to a point in the Chebyshev distance, which is that whose L∞ cell holds it; of
    /// several the one with the least index. `None` outside the domain, and of a diagram that was stopped.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Diagram};
    ///
    /// let cube = Cuboid::unit();
    /// let diagram = Diagram::new(&cube, &[[0.1, 0.1, 0.5], [0.9, 0.5, 0.5]])?;
    /// // Equally far in the Euclidean distance, but not in the Chebyshev distance.
    /// assert_eq!(diagram.locate_linf([0.48, 0.1, 0.5]), Some(0));
    /// # Ok::<(), chebloyd::DiagramError>(())
    /// ```
    #[must_use]
    pub fn locate_linf(&self, point: impl Into<Point3<f64>>) -> Option<usize> {
        let point = self.domain().wrap(&point.into());
        let tree = self.tree().ok();
        let tree = tree.filter(|_| self.domain().contains(&point))?;
        Some(nearest(tree, &point) as usize)
    }
}
