//! The solid within a closed surface, as a domain.

use nalgebra::{Point3, Vector3};

use crate::domain::beyond::Beyond;
use crate::domain::error::DomainError;
use crate::domain::near::visit_near;
use crate::domain::space::{Domain, PieceScratch};
use crate::domain::surface::clearance::Clearance;
use crate::domain::surface::clipped::Meeting;
use crate::domain::surface::outline::outline;
use crate::domain::surface::shadow::shadows;
use crate::domain::surface::triangle::{Border, Corner, Origin};
use crate::domain::surface::walls::walls;
use crate::domain::surface::way::first_exit;
use crate::domain::surface::winding::winding;
use crate::geometry::bounds::Bounds;
use crate::geometry::box_tree::BoxTree;
use crate::geometry::faceted::Piece;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::edges::EdgeTable;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::ValidSurface;

/// By which share of its longest extent the box from which cells are cut stands off the solid, so
/// that no side of it lies on a wall.
const MARGIN: f64 = 1.0 / 16.0;

/// The solid within a closed surface: of any shape and genus, of one or more parts, with or without
/// cavities.
#[derive(Clone, Debug)]
pub struct SurfaceSolid {
    surface: SurfaceMesh,
    /// Per triangle the edges from its corners 0, 1, 2.
    edges: Vec<[u32; 3]>,
    walls: Vec<u32>,
    tree: BoxTree,
    clearance: Clearance,
    bounds: Bounds<3>,
    start: Bounds<3>,
    volume: f64,
}

impl SurfaceSolid {
    /// The solid within `surface`. A wall's number is that of its first triangle; triangles in one
    /// plane that hang together are one wall.
    ///
    /// # Errors
    /// When the volume is not a positive number.
    pub fn new(surface: &ValidSurface) -> Result<Self, DomainError> {
        let surface = surface.mesh().clone();
        let volume = surface.volume();
        if !volume.is_normal() || volume < 0.0 {
            return Err(DomainError::NoVolume { volume });
        }
        let table = EdgeTable::of(&surface.triangles, surface.vertices.len());
        let mut edges = vec![[0; 3]; surface.triangles.len()];
        for (edge, number) in table.iter().zip(0..) {
            for &side in edge.sides {
                edges[side as usize / 3][side as usize % 3] = number;
            }
        }
        let bounds = surface.bounds();
        let margin = Vector3::repeat(MARGIN * bounds.extent().max());
        Ok(Self {
            edges,
            walls: walls(&surface, &table),
            clearance: Clearance::new(&surface),
            tree: BoxTree::new(surface.all_corners().map(|corners| Bounds::of(&corners))),
            start: Bounds {
                min: bounds.min - margin,
                max: bounds.max + margin,
            },
            bounds,
            volume,
            surface,
        })
    }

    /// The surface.
    #[must_use]
    pub fn surface(&self) -> &SurfaceMesh {
        &self.surface
    }

    /// The triangles' bounds.
    #[must_use]
    pub fn tree(&self) -> &BoxTree {
        &self.tree
    }

    /// The label of the wall on which a triangle lies.
    pub(crate) fn label(&self, triangle: u32) -> Label {
        Beyond::Wall(self.walls[triangle as usize]).label()
    }

    /// How often the surface winds about the point, `None` for a point on it.
    pub(crate) fn winding(&self, point: &Point3<f64>) -> Option<i32> {
        winding(&self.surface, &self.tree, point)
    }

    /// Whether the triangle runs along its edge from the lower vertex to the higher.
    pub(crate) fn runs_forward(&self, triangle: u32, edge: u32) -> bool {
        let from = self.edges[triangle as usize]
            .iter()
            .position(|&e| e == edge);
        let vertices = self.surface.triangles[triangle as usize];
        from.is_some_and(|from| vertices[from] < vertices[(from + 1) % 3])
    }

    /// A triangle's corners, relative to `site`.
    pub(crate) fn triangle(&self, triangle: u32, site: &Point3<f64>) -> [Corner; 3] {
        let vertices = self.surface.triangles[triangle as usize];
        [0, 1, 2].map(|k| Corner {
            position: self.surface.vertices[vertices[k] as usize] - site,
            origin: Origin::Vertex(vertices[k]),
            border: Border::Side(self.edges[triangle as usize][k]),
        })
    }

    /// Whether it is plain at first sight that no triangle touches `cell`, in coordinates relative
    /// to `site`.
    pub(crate) fn is_clear(&self, site: &Point3<f64>, cell: &Polyhedron) -> bool {
        let clearance = self.clearance.at(site);
        let reaches_less = |vertex: Point3<f64>| vertex.coords.amax() < clearance;
        clearance > 0.0 && self.bounds.contains(site) && cell.vertices().all(reaches_less)
    }

    /// Appends the triangles that `cell`, in coordinates relative to `site`, may touch.
    pub(crate) fn near(&self, site: &Point3<f64>, cell: &Polyhedron, near: &mut Vec<u32>) {
        visit_near(&self.tree, site, cell, |triangle| near.push(triangle));
    }
}

impl SurfaceSolid {
    /// Whether a convex part of space that no triangle touches lies in the solid.
    pub(crate) fn holds(&self, site: &Point3<f64>, part: &Polyhedron) -> bool {
        let sum: Vector3<f64> = part.vertices().map(|vertex| vertex.coords).sum();
        !part.is_empty() && self.contains(&(site + sum / part.vertex_count() as f64))
    }

    /// Visits the pieces of the cell, which has just been met.
    fn visit_met(
        &self,
        meeting: Meeting,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        match meeting {
            Meeting::Apart => visit(1.0, Piece::Convex(cell)),
            Meeting::Clipped => visit(1.0, Piece::Faceted(&scratch.clipped.part)),
            Meeting::Tangled => {
                let memory = (&mut scratch.piece, &mut scratch.clip);
                let label = |triangle| self.label(triangle);
                shadows(
                    &self.surface,
                    &self.tree,
                    label,
                    site,
                    cell,
                    memory,
                    |sign, part| {
                        visit(sign, Piece::Convex(part));
                    },
                );
            }
        }
    }
}

impl Domain for SurfaceSolid {
    fn bounds(&self) -> Bounds<3> {
        self.bounds
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn contains(&self, point: &Point3<f64>) -> bool {
        self.bounds.contains(point) && self.winding(point).is_none_or(|winding| winding > 0)
    }

    fn start(&self, site: &Point3<f64>, _index: u32, cell: &mut Polyhedron) {
        let around = Bounds {
            min: self.start.min - site.coords,
            max: self.start.max - site.coords,
        };
        cell.assign_cuboid(&around, [Beyond::Inner.label(); 6]);
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn pieces(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        let meeting = scratch.clipped.meet(self, site, cell);
        self.visit_met(meeting, site, cell, scratch, visit);
    }

    fn pieces_within(
        &self,
        site: &Point3<f64>,
        part: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>),
    ) {
        let meeting = scratch.clipped.meet(self, site, part);
        if meeting != Meeting::Apart || self.holds(site, part) {
            self.visit_met(meeting, site, part, scratch, visit);
        }
    }

    fn shape(
        &self,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(Piece<'_>),
    ) {
        outline(self, site, cell, scratch, visit);
    }

    fn first_exit(&self, site: &Point3<f64>, step: &Vector3<f64>) -> f64 {
        first_exit(&self.surface, &self.tree, site, step)
    }
}
