//! The solid within a closed surface of triangles, as a domain.

use nalgebra::{Point3, Vector3};

use crate::domain::error::{DomainError, check_digits};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::domain::tri_surface::clip_cell::ClipStatus;
use crate::domain::tri_surface::convex_parts::convex_parts;
use crate::domain::tri_surface::indexed::IndexedSurface;
use crate::domain::tri_surface::outline::outline;
use crate::domain::tri_surface::signed_prisms::signed_prisms;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::{ValidSurface, validate_surface};

/// The margin between the solid's bounds and the box from which cells are cut, as a share of the longest
/// extent, so that no side of the box lies on a wall.
const MARGIN: f64 = 1.0 / 16.0;

/// The solid within a closed surface: of any shape and genus, of one or more parts, with or without
/// cavities.
#[derive(Clone, Debug)]
pub struct SurfaceSolid {
    surface: IndexedSurface,
    start: Bounds<3>,
    volume: f64,
}

impl SurfaceSolid {
    /// The solid within `surface`. A wall's number is that of its first triangle; triangles in one
    /// plane that are connected are one wall.
    ///
    /// # Errors
    /// When the volume is not a positive number.
    pub fn new(surface: &ValidSurface) -> Result<Self, DomainError> {
        let mesh = surface.mesh().clone();
        let volume = mesh.volume();
        if !volume.is_normal() || volume < 0.0 {
            return Err(DomainError::NoVolume { volume });
        }
        check_digits(&mesh.bounds())?;
        let surface = IndexedSurface::new(mesh);
        let margin = Vector3::repeat(MARGIN * surface.bounds.extent().max());
        Ok(Self {
            start: surface.bounds.grown(&margin),
            surface,
            volume,
        })
    }

    /// The same solid with walls that end where the `groups` of its triangles do.
    #[must_use]
    pub(crate) fn parted_by(mut self, groups: &[u32]) -> Self {
        self.surface = IndexedSurface::with_groups(self.surface.mesh, groups);
        self
    }

    /// The solid within a closed surface of triangles, counter-clockwise from outside. What needs no
    /// guess (winding, duplicates) is repaired.
    ///
    /// # Errors
    /// [`DomainError::Mesh`] when the triangles bound no solid, [`DomainError::Overlap`] when they
    /// enclose a part of it more than once.
    ///
    /// # Examples
    /// ```
    /// use chebloyd::{Domain, SurfaceSolid};
    ///
    /// let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let triangles = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
    /// let solid = SurfaceSolid::from_arrays(&corners, &triangles)?;
    /// assert!((solid.shape().volume() - 1.0 / 6.0).abs() < 1e-15);
    /// # Ok::<(), chebloyd::DomainError>(())
    /// ```
    pub fn from_arrays<P: Copy + Into<Point3<f64>>>(
        vertices: &[P],
        triangles: &[[u32; 3]],
    ) -> Result<Self, DomainError> {
        let mesh = SurfaceMesh {
            vertices: vertices.iter().map(|&vertex| vertex.into()).collect(),
            triangles: triangles.to_vec(),
        };
        let (surface, report) = validate_surface(&mesh)?;
        match report.no_domain() {
            Some(reason) => Err(DomainError::Overlap { reason }),
            None => Self::new(&surface),
        }
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &SurfaceMesh {
        &self.surface.mesh
    }

    /// The surface with its search structures.
    #[must_use]
    pub fn indexed(&self) -> &IndexedSurface {
        &self.surface
    }

    /// Whether a convex part of space that no triangle touches lies in the solid.
    fn contains_part(&self, site: &Point3<f64>, part: &Polyhedron) -> bool {
        let sum: Vector3<f64> = part.vertices().map(|vertex| vertex.coords).sum();
        !part.is_empty() && self.contains(&(site + sum / part.vertex_count() as f64))
    }
}

impl DomainShape for SurfaceSolid {
    fn bounds(&self) -> Bounds<3> {
        self.surface.bounds
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.surface.contains(point)
    }

    fn boundary(&self) -> Vec<[Point3<f64>; 3]> {
        self.surface.mesh.all_corners().collect()
    }

    fn start(&self, site: &Point3<f64>, _index: u32, cell: &mut Polyhedron) {
        let around = self.start.translated(&-site.coords);
        cell.assign_cuboid(&around, [FacetKind::Inner.label(); 6]);
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn signed_pieces(
        &self,
        site: &Point3<f64>,
        part: &Polyhedron,
        holds_site: bool,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        match scratch.clipped.clip(&self.surface, site, part) {
            ClipStatus::Disjoint if holds_site || self.contains_part(site, part) => {
                visit(1.0, Piece::Convex(part));
            }
            ClipStatus::Disjoint => {}
            ClipStatus::Clipped => visit(1.0, Piece::Brep(&scratch.clipped.part)),
            ClipStatus::Inconsistent => signed_prisms(&self.surface, site, part, scratch, visit),
        }
    }

    fn outline(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(Piece<'_>),
    ) {
        outline(&self.surface, site, cell, scratch, visit);
    }

    fn convex_parts(
        &self,
        site: &Point3<f64>,
        part: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(&Polyhedron),
    ) {
        convex_parts(&self.surface, site, part, &mut scratch.clip, visit);
    }

    fn surface_mesh(&self) -> Option<&SurfaceMesh> {
        Some(&self.surface.mesh)
    }

    fn first_exit(&self, site: &Point3<f64>, step: &Vector3<f64>) -> f64 {
        let exit = self.surface.ray_exit(site, step);
        exit.map_or(f64::INFINITY, |(share, _)| share)
    }

    fn wall_ahead(&self, site: &Point3<f64>, step: &Vector3<f64>) -> Option<(f64, Vector3<f64>)> {
        let (share, triangle) = self.surface.ray_exit(site, step)?;
        let [a, b, c] = self.surface.mesh.corners(triangle as usize);
        Some((share, (b - a).cross(&(c - a)).normalize()))
    }
}
