//! One Voronoi cell, cut by bisectors up to its security radius, with its facets and moments.
//!
//! Cells are cut in fixed slots. One that does not fit there is cut again as a polyhedron of any
//! size: two in 10⁵ among random sites, and wherever many sites lie on one sphere.

use std::cell::{OnceCell, RefCell};

use nalgebra::{Point, Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::ClipScratch;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::moments::Moments;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::small_polyhedron::SmallPolyhedron;
use crate::geometry::small_polyhedron_clip::SmallClipScratch;
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::search::{BisectorSearch, BuildError, Duplicate};

/// Facets below this share of the squared diagonal of the cell's box count as having no area.
const NO_AREA: f64 = 1e-14;

/// A cell while it is visited: its body, cut from the domain's convex start, in coordinates
/// relative to its site.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Diagram};
///
/// let cube = Cuboid::unit();
/// let diagram = Diagram::new(&cube, &[[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]])?;
/// let extents = diagram.map_cells(|cell| cell.bounds().extent().x)?;
/// assert_eq!(extents, [0.5, 0.5]);
/// # Ok::<(), chebloyd::DiagramError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// The site's index.
    pub site: u32,
    /// The site's position.
    pub position: Point3<f64>,
    pub(crate) domain: &'a dyn Domain,
    pub(crate) body: &'a CellStorage,
}

/// A facet of a cell, in the domain's coordinates.
///
/// # Examples
/// ```
/// use chebloyd::{Cuboid, Diagram};
///
/// let cube = Cuboid::unit();
/// let facets = Diagram::new(&cube, &[[0.5; 3]])?.map_cells(|cell| cell.facets())?;
/// assert_eq!(facets[0].len(), 6);
/// assert!(facets[0].iter().all(|facet| facet.area == 1.0 && facet.vertices.len() == 4));
/// # Ok::<(), chebloyd::DiagramError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct CellFacet {
    /// The neighbor or the wall behind it.
    pub kind: FacetKind,
    /// Its area (L²).
    pub area: f64,
    /// Its outward unit normal.
    pub normal: Vector3<f64>,
    /// Its corners, counter-clockwise from outside.
    pub vertices: Vec<Point3<f64>>,
}

impl CellFacet {
    fn new(label: Label, normal: &Vector3<f64>, vertices: Vec<Point3<f64>>) -> Self {
        let arm = |corner: usize| vertices[corner] - vertices[0];
        let fan = (2..vertices.len()).map(|corner| arm(corner - 1).cross(&arm(corner)) * 0.5);
        Self {
            kind: FacetKind::of(label),
            area: fan.sum::<Vector3<f64>>().norm(),
            normal: normal.normalize(),
            vertices,
        }
    }
}

impl<'a> Cell<'a> {
    /// Volume, first and second moments within the domain, about the site.
    #[must_use]
    pub fn moments(&self) -> Moments {
        let mut moments = Moments::default();
        let mut add = |sign: f64, piece: Piece<'_>| moments += piece.moments() * sign;
        let scratch = &mut PieceScratch::default();
        self.domain
            .pieces(&self.position, self.polyhedron(), scratch, &mut add);
        moments
    }

    /// The volume within the domain (L³).
    #[must_use]
    pub fn volume(&self) -> f64 {
        self.moments().mass
    }

    /// The facets within the domain. Those without area, which touch along an edge or in a vertex only,
    /// are left out; a facet in several parts is listed once for each.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Cuboid, Diagram, FacetKind};
    ///
    /// let cube = Cuboid::unit();
    /// let diagram = Diagram::new(&cube, &[[0.25, 0.5, 0.5], [0.75, 0.5, 0.5]])?;
    /// let neighbors = diagram.map_cells(|cell| {
    ///     let facets = cell.facets().into_iter();
    ///     facets.filter(|facet| matches!(facet.kind, FacetKind::Neighbor { .. })).count()
    /// })?;
    /// assert_eq!(neighbors, [1, 1]);
    /// # Ok::<(), chebloyd::DiagramError>(())
    /// ```
    #[must_use]
    pub fn facets(&self) -> Vec<CellFacet> {
        let mut facets = Vec::new();
        let least = NO_AREA * self.bounds().extent().norm_squared();
        let mut list = |piece: Piece<'_>| {
            let places = piece.vertices();
            piece.visit_polygons(|label, normal, corners| {
                let corners = corners.iter().map(|&corner| places[corner as usize]);
                let vertices = corners.map(|corner| corner + self.position.coords);
                let facet = CellFacet::new(label, normal, vertices.collect());
                if facet.area > least {
                    facets.push(facet);
                }
            });
        };
        let scratch = &mut PieceScratch::default();
        self.domain
            .outline(&self.position, self.polyhedron(), scratch, &mut list);
        facets
    }

    /// The body as a polyhedron; the site is its origin.
    #[must_use]
    pub fn polyhedron(&self) -> &'a Polyhedron {
        self.body.polyhedron()
    }

    /// The least axis-aligned box around the body, relative to the site.
    #[must_use]
    pub fn bounds(&self) -> Bounds<3> {
        self.body.bounds()
    }

    /// How far the cell asks for neighbors: sites farther than this from its own cannot change it (L). It is
    /// twice the distance of its farthest vertex, the security radius of \[RSL\].
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Bounds, Cuboid, Diagram};
    ///
    /// // Of a row of sites only those below x = 4.5 are known: the first cell needs no others.
    /// let row = Cuboid::new(Bounds::from_corners([0.0; 3], [9.0, 0.1, 0.1]), [false; 3])?;
    /// let sites = [0.5, 1.5, 2.5, 3.5].map(|x| [x, 0.05, 0.05]);
    /// let known = Bounds::from_corners([0.0; 3], [4.5, 0.1, 0.1]);
    /// let diagram = Diagram::new(&row, &sites)?;
    /// let cells = diagram.map_cells_of(&[3, 0], |cell| (cell.reach(), cell.is_certified(&known)))?;
    /// assert!(cells[0].0 > 11.0 && !cells[0].1);
    /// assert!(cells[1].0 < 1.1 && cells[1].1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn reach(&self) -> f64 {
        2.0 * self.body.radius_squared().sqrt()
    }

    /// Whether the cell is right if all sites in the box `known` are given, and perhaps none of the others:
    /// whether all of the domain within [`reach`](Self::reach) of the site lies in the box. Along periodic
    /// axes any image of the box may hold it.
    #[must_use]
    pub fn is_certified(&self, known: &Bounds<3>) -> bool {
        let known = [known.min, known.max].map_each(|corner| corner.coords.into());
        let (bounds, periods) = (self.domain.bounds(), self.domain.periods());
        holds_ball(&bounds, &periods, &self.position, self.reach(), &known)
    }

    /// The half-spaces that meet in the body, and maybe some that hold all of it.
    #[must_use]
    pub fn half_spaces(&self) -> &'a [HalfSpace] {
        self.body.half_spaces()
    }

    /// The body in fixed slots, if it fits there.
    #[must_use]
    pub fn compact(&self) -> Option<&'a SmallPolyhedron> {
        self.body.compact()
    }
}

/// Whether `known` (least and greatest corner) holds the ball about a site, as far as it lies in the
/// domain; along periodic axes in any of its images.
pub(crate) fn holds_ball<const D: usize>(
    bounds: &Bounds<D>,
    periods: &[Option<f64>; D],
    site: &Point<f64, D>,
    radius: f64,
    known: &[[f64; D]; 2],
) -> bool {
    (0..D).all(|axis| {
        let ([low, high], center) = (known.map_each(|corner| corner[axis]), site[axis]);
        match periods[axis] {
            Some(period) => {
                high - low >= period
                    || [-1.0, 0.0, 1.0].iter().any(|copies| {
                        let center = center + copies * period;
                        low <= center - radius && center + radius <= high
                    })
            }
            None => {
                low <= (center - radius).max(bounds.min[axis])
                    && high >= (center + radius).min(bounds.max[axis])
            }
        }
    })
}

/// The memory in which cells are built, one after the other.
#[derive(Debug, Default)]
pub(crate) struct CellBuilder {
    start: Polyhedron,
    clip: ClipScratch,
    body: CellStorage,
    compact_scratch: Box<SmallClipScratch>,
    search: BisectorSearch,
}

impl CellBuilder {
    /// Builds the cell of the site in `place` of the tree. All cells of a builder are of one tree.
    ///
    /// # Errors
    /// When another site, or an image of one, lies in the same place.
    pub(crate) fn build<'a>(
        &'a mut self,
        domain: &'a dyn Domain,
        tree: &KdTree,
        place: usize,
    ) -> Result<Cell<'a>, Duplicate> {
        let (site, position) = (tree.site(place), tree.position(place));
        domain.start(&position, site, &mut self.start);
        match self.cut_in_slots(tree, place) {
            Ok(()) => {}
            Err(BuildError::Duplicate(duplicate)) => return Err(duplicate),
            Err(BuildError::Full) => self.cut_in_any_size(tree, place)?,
        }
        Ok(Cell {
            site,
            position,
            domain,
            body: &self.body,
        })
    }

    #[inline]
    fn cut_in_slots(&mut self, tree: &KdTree, place: usize) -> Result<(), BuildError> {
        let compact = self.body.slots();
        if !compact.assign(&self.start) {
            return Err(BuildError::Full);
        }
        let target = &mut (compact, &mut *self.compact_scratch);
        self.search.cut_all(tree, place, target)
    }

    fn cut_in_any_size(&mut self, tree: &KdTree, place: usize) -> Result<(), Duplicate> {
        let (start, search, clip) = (&self.start, &mut self.search, &mut self.clip);
        self.body.assign(|polyhedron| {
            polyhedron.clone_from(start);
            match search.cut_all(tree, place, &mut (&mut *polyhedron, clip)) {
                Err(BuildError::Duplicate(duplicate)) => Err(duplicate),
                // Any size fits.
                Ok(()) | Err(BuildError::Full) => Ok(()),
            }
        })
    }
}

/// A cell's body, in memory that serves one cell after another.
///
/// Integrals are taken straight from fixed slots; everything else reads a polyhedron, which is made
/// on the first request.
#[derive(Debug, Default)]
pub(crate) struct CellStorage {
    compact: SmallPolyhedron,
    /// Whether the body is in the fixed slots.
    is_compact: bool,
    polyhedron: OnceCell<Polyhedron>,
    /// The memory of an earlier polyhedron.
    spare: RefCell<Polyhedron>,
}

impl CellStorage {
    /// The body in fixed slots, if it fits.
    #[inline]
    pub(crate) fn compact(&self) -> Option<&SmallPolyhedron> {
        self.is_compact.then_some(&self.compact)
    }

    /// The body as a polyhedron.
    pub(crate) fn polyhedron(&self) -> &Polyhedron {
        self.polyhedron.get_or_init(|| {
            let mut polyhedron = self.spare.take();
            self.compact.write(&mut polyhedron);
            polyhedron
        })
    }

    /// The slots, for a new body to be written there.
    #[inline]
    pub(crate) fn slots(&mut self) -> &mut SmallPolyhedron {
        self.clear();
        self.is_compact = true;
        &mut self.compact
    }

    /// Stores what `make` writes into a polyhedron, in slots if it fits there.
    pub(crate) fn assign<E>(
        &mut self,
        make: impl FnOnce(&mut Polyhedron) -> Result<(), E>,
    ) -> Result<(), E> {
        self.clear();
        let mut polyhedron = self.spare.take();
        make(&mut polyhedron)?;
        self.is_compact = self.compact.assign(&polyhedron);
        self.polyhedron = OnceCell::from(polyhedron);
        Ok(())
    }

    /// The least axis-aligned box around the body, which holds the origin.
    pub(crate) fn bounds(&self) -> Bounds<3> {
        match self.compact() {
            Some(compact) => compact.bounds_about_origin(),
            None => self.polyhedron().bounds(),
        }
    }

    /// The greatest squared distance of a vertex from the origin (L²).
    fn radius_squared(&self) -> f64 {
        match self.compact() {
            Some(compact) => compact.radius_squared(),
            None => self.polyhedron().radius_squared(),
        }
    }

    /// The half-spaces that meet in the body, and maybe some that hold all of it.
    pub(crate) fn half_spaces(&self) -> &[HalfSpace] {
        match self.compact() {
            Some(compact) => &compact.planes,
            None => &self.polyhedron().planes,
        }
    }

    fn clear(&mut self) {
        if let Some(polyhedron) = self.polyhedron.take() {
            *self.spare.get_mut() = polyhedron;
        }
    }
}
