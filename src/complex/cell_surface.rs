//! A cell's boundary as loops of vertices that name the planes that meet in them.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::complex::vertex_key::{Shift, VertexKey};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::PieceScratch;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::{Brep, Piece};
use crate::geometry::facet_polygons::polygons;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::cell::Cell;

/// A vertex of a cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceVertex {
    /// Its position in the domain's coordinates.
    pub(crate) position: Point3<f64>,
    /// The labels of three facets that meet in it.
    pub(crate) facets: [Label; 3],
}

/// The boundary of a cell within the domain.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellSurface {
    /// The cell's site.
    pub(crate) site: u32,
    /// All vertices.
    pub(crate) vertices: Vec<SurfaceVertex>,
    /// The label and the end in `corners` of every facet.
    facets: Vec<(Label, u32)>,
    /// The facets' corners, one facet after the other, counter-clockwise from outside.
    corners: Vec<u32>,
}

impl CellSurface {
    /// The boundary of `cell`; without facets where none was found.
    #[must_use]
    pub(crate) fn of(cell: &Cell<'_>, scratch: &mut PieceScratch) -> Self {
        let mut surface = Self {
            site: cell.site,
            ..Self::default()
        };
        let (domain, here) = (cell.domain, cell.position);
        let mut take = |piece: Piece<'_>| match piece {
            Piece::Convex(polyhedron) => surface.assign_convex(polyhedron, &here.coords),
            Piece::Brep(brep) => surface.assign_brep(brep, &here.coords),
        };
        domain.outline(&here, cell.polyhedron(), scratch, &mut take);
        surface
    }

    /// The facets: labels and loops of places in `vertices`.
    pub(crate) fn facets(&self) -> impl Iterator<Item = (Label, &[u32])> {
        let mut start = 0;
        self.facets.iter().map(move |&(label, end)| {
            let corners = &self.corners[start as usize..end as usize];
            start = end;
            (label, corners)
        })
    }

    /// The side of a cube as large as the box around the cell (L).
    #[must_use]
    pub(crate) fn size(&self) -> f64 {
        let places = self.vertices.iter().map(|vertex| &vertex.position);
        Bounds::of(places).volume().cbrt()
    }

    /// How many facets there are, and how many corners these have together.
    #[must_use]
    pub(crate) fn counts(&self) -> (usize, usize) {
        (self.facets.len(), self.corners.len())
    }

    /// The least of the sites that a vertex's key names.
    #[must_use]
    pub(crate) fn first_site(&self, vertex: &SurfaceVertex) -> usize {
        let sites = vertex
            .facets
            .iter()
            .filter_map(|&label| match FacetKind::of(label) {
                FacetKind::Neighbor { site, .. } => Some(site),
                _ => None,
            });
        sites.fold(self.site, u32::min) as usize
    }

    /// The identity of a vertex, and the shift at which this cell sees it.
    #[must_use]
    pub(crate) fn key(&self, vertex: &SurfaceVertex) -> (VertexKey, Shift) {
        VertexKey::new(self.site, vertex.facets)
    }

    fn push_facet(&mut self, label: Label, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.facets.push((label, self.corners.len() as u32));
    }

    fn assign_convex(&mut self, polyhedron: &Polyhedron, here: &Vector3<f64>) {
        let labels = |planes: [u32; 3]| planes.map(|plane| polyhedron.labels[plane as usize]);
        // Three facets meet in every vertex: 3 V corners, and V / 2 + 2 facets by Euler.
        let count = polyhedron.vertex_count();
        self.vertices.reserve_exact(count);
        self.corners.reserve_exact(3 * count);
        self.facets.reserve_exact(count / 2 + 2);
        let vertices = polyhedron.vertices().zip(&polyhedron.facets);
        self.vertices
            .extend(vertices.map(|(position, &planes)| SurfaceVertex {
                position: position + here,
                facets: labels(planes),
            }));
        for facet in polyhedron.facets() {
            let corners = facet.vertex_numbers().map(|vertex| vertex as u32);
            self.push_facet(facet.label(), corners);
        }
    }

    /// Triangles of one wall become one facet: edges between them vanish, and so do vertices in which
    /// fewer than three facets are left.
    fn assign_brep(&mut self, brep: &Brep, here: &Vector3<f64>) {
        let label = |facet: u32| brep.facets[facet as usize].1;
        let mut around = vec![Vec::new(); brep.vertices.len()];
        // Per label: a normal, and the directed edges.
        let mut groups: BTreeMap<Label, (Vector3<f64>, Vec<[u32; 2]>)> = BTreeMap::new();
        for edge in &brep.edges {
            let sides = [label(edge.left), label(edge.right)];
            if sides[0] == sides[1] {
                continue;
            }
            let ends = [edge.from, edge.to];
            for vertex in ends {
                around[vertex as usize].extend(sides);
            }
            for (facet, ends) in [(edge.left, ends), (edge.right, [edge.to, edge.from])] {
                let normal = brep.facets[facet as usize].0.normal;
                let group = groups.entry(label(facet));
                group.or_insert((normal, Vec::new())).1.push(ends);
            }
        }
        self.push_groups(brep, here, around, groups);
    }

    fn push_groups(
        &mut self,
        brep: &Brep,
        here: &Vector3<f64>,
        mut around: Vec<Vec<Label>>,
        groups: BTreeMap<Label, (Vector3<f64>, Vec<[u32; 2]>)>,
    ) {
        const UNUSED: u32 = u32::MAX;
        let mut numbers = vec![UNUSED; around.len()];
        for (vertex, labels) in around.iter_mut().enumerate() {
            labels.sort_unstable();
            labels.dedup();
            if labels.len() < 3 {
                continue;
            }
            numbers[vertex] = self.vertices.len() as u32;
            self.vertices.push(SurfaceVertex {
                position: Point3::from(brep.vertices[vertex] + here),
                facets: [labels[0], labels[1], labels[2]],
            });
        }
        for (label, (normal, edges)) in groups {
            for corners in polygons(&edges, &brep.vertices, &normal) {
                let corners = corners.iter().map(|&corner| numbers[corner as usize]);
                let corners: Vec<u32> = corners.filter(|&number| number != UNUSED).collect();
                if corners.len() >= 3 {
                    self.push_facet(label, corners);
                }
            }
        }
    }

    /// Whether a side of the box from which cells are cut is left: then the cell is not bounded by
    /// the domain.
    #[must_use]
    pub(crate) fn is_open(&self) -> bool {
        let inner = FacetKind::Inner.label();
        self.facets.is_empty() || self.facets.iter().any(|&(label, _)| label == inner)
    }
}
