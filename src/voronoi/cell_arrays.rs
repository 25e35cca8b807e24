//! Cells as flat arrays: corners, facets with their neighbors, areas and normals, volumes, centroids, reach.
//!
//! Cells are built in the order of the index, in blocks, and gathered into the order in which they were
//! chosen, one array at a time, each thread filling its own part of it.

use nalgebra::{Point2, Point3, Vector3};
use rayon::prelude::*;

use crate::arrays::MapEach;
use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::domain::shape::PieceScratch;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::{weld, welded_ring};
use crate::voronoi::cell::{Cell, holds_ball};
use crate::voronoi::diagram::{Diagram, DiagramError};
use crate::voronoi::planar::diagram::{
    PlaneCell, PlaneDiagram, PlaneDiagramError, security_radius,
};

/// How many cells a block holds: enough for a thread to be worth waking, few enough to share work evenly.
const CELLS_PER_BLOCK: usize = 512;

/// Vertices nearer than this share of the cell's extent are one, as in shells.
const WELD: f64 = 1e-10;

/// Some sites' cells, in the order in which these were chosen. Points have `dimension` coordinates each.
/// Facets are polygons in space and edges in the plane; those that shrink to an edge or a vertex when corners
/// nearer than 1e-10 of the cell are one are left out, so that every cell stays closed.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct CellArrays {
    /// 3 in space, 2 in the plane.
    pub dimension: usize,
    /// The corners of every cell, one cell after the other (L); none where shapes were not asked for.
    pub vertices: Vec<f64>,
    /// Where each cell's corners begin, in points; the last number is how many there are.
    pub vertex_offsets: Vec<i64>,
    /// The facets' corners by their number in `vertices`, counter-clockwise from outside.
    pub corners: Vec<i64>,
    /// Where each facet's corners begin.
    pub corner_offsets: Vec<i64>,
    /// Where each cell's facets begin.
    pub facet_offsets: Vec<i64>,
    /// Behind each facet: the site's index, or −1 − k for wall k.
    pub neighbors: Vec<i64>,
    /// By how many periods along each axis that neighbor is moved.
    pub images: Vec<i8>,
    /// The facets' areas (L²; in the plane lengths, L).
    pub areas: Vec<f64>,
    /// Their outward unit normals.
    pub normals: Vec<f64>,
    /// The cells' volumes (L³; in the plane areas, L²).
    pub volumes: Vec<f64>,
    /// Their centroids (L).
    pub centroids: Vec<f64>,
    /// How far each asks for neighbors: sites farther than this from its own cannot change it (L).
    pub radii: Vec<f64>,
    /// Whether all of the domain within that radius lies where all sites are known.
    pub certified: Vec<bool>,
}

/// What is asked of the cells.
#[derive(Clone, Copy, Debug)]
pub struct CellQuery<'a> {
    /// The sites whose cells are wanted; all if none are named.
    pub chosen: Option<&'a [usize]>,
    /// Whether corners are wanted: vertices and the facets' loops of them.
    pub shapes: bool,
    /// A box within which the diagram has all sites there are (L), in space; the whole domain if none.
    pub known: Option<Bounds<3>>,
}

impl CellArrays {
    /// The cells of `diagram` that are asked for.
    ///
    /// # Errors
    /// As [`Diagram::map_cells`], and [`DiagramError::NoSuchSite`].
    pub fn in_space(diagram: &Diagram<'_>, query: &CellQuery<'_>) -> Result<Self, DiagramError> {
        let (count, domain) = (diagram.len(), diagram.domain());
        let all = || (0..count).collect::<Vec<_>>();
        let chosen = query.chosen.map_or_else(all, <[_]>::to_vec);
        let blocks = diagram.map_blocks(&chosen, CELLS_PER_BLOCK, |cells: &mut Cells, cell| {
            cells.push(domain, &cell, query);
        })?;
        let (order, blocks): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
        Ok(gathered(3, chosen.len(), &order, blocks))
    }

    /// The cells of sites of the plane.
    ///
    /// # Errors
    /// When the sites have no diagram.
    pub fn in_plane(
        domain: &PlaneDomain,
        sites: &[Point2<f64>],
        query: &CellQuery<'_>,
    ) -> Result<Self, PlaneDiagramError> {
        let diagram = PlaneDiagram::new(domain, sites)?;
        let all = || (0..sites.len()).collect::<Vec<_>>();
        let chosen = query.chosen.map_or_else(all, <[_]>::to_vec);
        if let Some(&site) = chosen.iter().find(|&&site| site >= sites.len()) {
            let count = sites.len();
            return Err(PlaneDiagramError::NoSuchSite { site, count });
        }
        let mut cells = Cells::default();
        for &site in &chosen {
            cells.push_plane(domain, &diagram.cells[site], query);
        }
        let order = (0..chosen.len()).collect();
        Ok(gathered(2, chosen.len(), &[order], vec![cells]))
    }
}

/// Cells one after the other, before they are gathered.
#[derive(Debug, Default)]
struct Cells {
    vertices: Vec<f64>,
    /// The facets' corners by their number among the cell's own.
    corners: Vec<u32>,
    /// How many corners each facet has.
    sizes: Vec<u32>,
    neighbors: Vec<i64>,
    images: Vec<i8>,
    areas: Vec<f64>,
    normals: Vec<f64>,
    volumes: Vec<f64>,
    centroids: Vec<f64>,
    radii: Vec<f64>,
    certified: Vec<bool>,
    /// Per cell: how many points, corners and facets there are to its end.
    ends: Vec<[usize; 3]>,
    scratch: Scratch,
}

#[derive(Debug, Default)]
struct Scratch {
    pieces: PieceScratch,
    /// The new number of each vertex, by the one that it is welded to; assigned when a facet first needs it.
    numbers: Vec<u32>,
    ring: Vec<u32>,
}

impl Cells {
    fn push(&mut self, domain: &dyn Domain, cell: &Cell<'_>, query: &CellQuery<'_>) {
        let (volume, center) = if domain.is_convex() {
            extent(cell.polyhedron())
        } else {
            let moments = cell.moments();
            (moments.mass, moments.center())
        };
        self.volumes.push(volume);
        self.centroids
            .extend((cell.position + center).coords.iter());
        let reach = cell.reach();
        self.radii.push(reach);
        let known = query.known.as_ref();
        self.certified
            .push(known.is_none_or(|known| cell.is_certified(known)));
        let first = self.vertices.len();
        let mut pieces = std::mem::take(&mut self.scratch.pieces);
        domain.outline(
            &cell.position,
            cell.polyhedron(),
            &mut pieces,
            &mut |piece| {
                self.push_piece(cell, piece, (first, query.shapes));
            },
        );
        self.scratch.pieces = pieces;
        self.end(3);
    }

    /// The facets of a piece of the cell whose vertices begin at `first`.
    fn push_piece(&mut self, cell: &Cell<'_>, piece: Piece<'_>, (first, shapes): (usize, bool)) {
        let places = piece.vertices();
        let extent = cell.bounds().extent();
        let welded = has_near(&places, WELD * extent.max()).then(|| weld(&places));
        let mut ring = std::mem::take(&mut self.scratch.ring);
        self.scratch.numbers.clear();
        self.scratch.numbers.resize(places.len(), u32::MAX);
        piece.visit_polygons(|label, normal, corners| {
            ring.clear();
            match &welded {
                // A piece's facets name its own vertices only.
                Some(welded) => {
                    ring.extend(welded_ring(welded, 0, corners.iter().copied()).unwrap_or_default())
                }
                None => ring.extend_from_slice(corners),
            }
            let area = area(&places, &ring);
            if ring.len() >= 3 {
                self.push_facet(label, area, &normal.normalize());
                if shapes {
                    self.push_loop(&places, &ring, (first, &cell.position));
                }
            }
        });
        self.scratch.ring = ring;
    }

    fn push_facet(&mut self, label: Label, area: f64, normal: &Vector3<f64>) {
        let (neighbor, image) = behind(label);
        self.neighbors.push(neighbor);
        self.images.extend(image);
        self.areas.push(area);
        self.normals.extend(normal.iter());
    }

    fn push_loop(
        &mut self,
        places: &[Point3<f64>],
        ring: &[u32],
        (first, site): (usize, &Point3<f64>),
    ) {
        for &vertex in ring {
            let number = &mut self.scratch.numbers[vertex as usize];
            if *number == u32::MAX {
                *number = ((self.vertices.len() - first) / 3) as u32;
                let place = places[vertex as usize] + site.coords;
                self.vertices.extend(place.coords.iter());
            }
            self.corners.push(*number);
        }
        self.sizes.push(ring.len() as u32);
    }

    fn push_plane(&mut self, domain: &PlaneDomain, cell: &PlaneCell, query: &CellQuery<'_>) {
        let (area, center) = cell.centroid();
        self.volumes.push(area);
        self.centroids.extend((cell.site + center).coords.iter());
        let reach = security_radius(&cell.polygon);
        self.radii.push(reach);
        let known = query.known.as_ref();
        self.certified.push(known.is_none_or(|known| {
            let known = [known.min, known.max].map_each(|end| [end.x, end.y]);
            holds_ball(
                &domain.bounds(),
                &domain.periods(),
                &cell.site,
                reach,
                &known,
            )
        }));
        for piece in cell.pieces() {
            let first = self.vertices.len() / 2 - self.ends.last().map_or(0, |ends| ends[0]);
            let corners = piece.vertices().len() as u32;
            for (number, edge) in (0..).zip(piece.edges()) {
                let along = edge.end - edge.start;
                let (neighbor, image) = behind(edge.label);
                if query.shapes {
                    self.vertices
                        .extend((edge.start + cell.site.coords).coords.iter());
                }
                if neighbor == i64::MIN || along.norm() <= 0.0 {
                    continue;
                }
                self.neighbors.push(neighbor);
                self.images.extend(&image[..2]);
                self.areas.push(along.norm());
                self.normals
                    .extend([along.y / along.norm(), -along.x / along.norm()]);
                if query.shapes {
                    self.corners
                        .extend([number, (number + 1) % corners].map_each(|n| first as u32 + n));
                    self.sizes.push(2);
                }
            }
        }
        self.end(2);
    }

    fn end(&mut self, dimension: usize) {
        let points = self.vertices.len() / dimension;
        self.ends
            .push([points, self.corners.len(), self.areas.len()]);
    }
}

/// What lies behind a facet: a site and its image, −1 − k for wall k, `i64::MIN` within a cell.
fn behind(label: Label) -> (i64, [i8; 3]) {
    match FacetKind::of(label) {
        FacetKind::Neighbor { site, image } => (i64::from(site), image),
        FacetKind::Wall(wall) => (-1 - i64::from(wall), [0; 3]),
        FacetKind::Inner => (i64::MIN, [0; 3]),
    }
}

/// Volume and centroid of a convex cell, from its cones over the site.
fn extent(cell: &Polyhedron) -> (f64, Vector3<f64>) {
    let (mut volume, mut first) = (0.0, Vector3::zeros());
    for [a, b, c] in cell.facets().flat_map(|facet| facet.triangles()) {
        let six = a.dot(&b.cross(&c));
        volume += six;
        first += (a + b + c) * six;
    }
    (volume / 6.0, first / (4.0 * volume))
}

/// The area of a polygon (L²).
fn area(places: &[Point3<f64>], ring: &[u32]) -> f64 {
    let arm = |corner: usize| places[ring[corner] as usize] - places[ring[0] as usize];
    let fan = (2..ring.len()).map(|corner| arm(corner - 1).cross(&arm(corner)));
    0.5 * fan.sum::<Vector3<f64>>().norm()
}

/// Whether two vertices lie within `reach` of each other along every axis.
fn has_near(places: &[Point3<f64>], reach: f64) -> bool {
    let is_near = |one: &Point3<f64>, other: &Point3<f64>| {
        // Not one expression: along x alone most pairs are far.
        (one.x - other.x).abs() <= reach
            && (one.y - other.y).abs() <= reach
            && (one.z - other.z).abs() <= reach
    };
    let mut numbered = places.iter().enumerate();
    numbered.any(|(number, one)| places[..number].iter().any(|other| is_near(one, other)))
}

/// Where the cells of blocks stand, and where they go.
struct Gathering {
    /// Per chosen site: the block that holds its cell, and its number in there.
    places: Vec<(u32, u32)>,
    /// Per block and cell: how many points, corners and facets come before it in the block.
    ends: Vec<Vec<[usize; 3]>>,
}

/// The parts of a cell: how many of which there are.
#[derive(Clone, Copy)]
enum Part {
    Points,
    Corners,
    Facets,
}

impl Gathering {
    /// The part of a block's array that a cell's `part`s take, `width` numbers each.
    fn span(
        &self,
        (block, number): (u32, u32),
        part: Part,
        width: usize,
    ) -> std::ops::Range<usize> {
        let ends = &self.ends[block as usize];
        let at = |number: usize| ends[number][part as usize] * width;
        at(number as usize)..at(number as usize + 1)
    }

    /// Where each cell's `part`s begin in the gathered array, and how many there are.
    fn offsets(&self, part: Part) -> Vec<i64> {
        let lengths = self
            .places
            .iter()
            .map(|&place| self.span(place, part, 1).len() as i64);
        let sums = lengths.scan(0, |sum, length| {
            *sum += length;
            Some(*sum)
        });
        std::iter::once(0).chain(sums).collect()
    }

    /// The numbers of all cells' `part`s, `width` each, as `of` takes them over, which is given the cell too.
    fn gather<From: Sync, To: Copy + Default + Send>(
        &self,
        (part, width): (Part, usize),
        blocks: &[Vec<From>],
        of: impl Fn(usize, &From) -> To + Sync,
    ) -> Vec<To> {
        let length = |&place: &(u32, u32)| self.span(place, part, width).len();
        let mut all = vec![To::default(); self.places.iter().map(length).sum()];
        let mut rest = &mut all[..];
        let mut tasks = Vec::new();
        for (task, places) in self.places.chunks(CELLS_PER_BLOCK).enumerate() {
            let (head, tail) = rest.split_at_mut(places.iter().map(length).sum());
            tasks.push((task * CELLS_PER_BLOCK, places, head));
            rest = tail;
        }
        tasks.into_par_iter().for_each(|(first, places, mut goal)| {
            for (cell, &place) in (first..).zip(places) {
                let from = &blocks[place.0 as usize][self.span(place, part, width)];
                let (head, tail) = goal.split_at_mut(from.len());
                for (goal, from) in head.iter_mut().zip(from) {
                    *goal = of(cell, from);
                }
                goal = tail;
            }
        });
        all
    }

    /// One number, or `width` of them, per cell.
    fn per_cell<T: Copy + Default>(&self, width: usize, blocks: &[Vec<T>]) -> Vec<T> {
        let of = |&(block, number): &(u32, u32)| {
            let first = number as usize * width;
            &blocks[block as usize][first..first + width]
        };
        self.places.iter().flat_map(of).copied().collect()
    }
}

/// Brings blocks of cells into the order in which the sites were chosen, of which `order` has the numbers.
fn gathered(
    dimension: usize,
    count: usize,
    order: &[Vec<usize>],
    mut blocks: Vec<Cells>,
) -> CellArrays {
    let mut places = vec![(0, 0); count];
    for (block, chosen) in (0..).zip(order) {
        for (number, &cell) in (0..).zip(chosen) {
            places[cell] = (block, number);
        }
    }
    let ends = blocks.iter().map(|block| {
        std::iter::once([0; 3])
            .chain(block.ends.iter().copied())
            .collect()
    });
    let gathering = Gathering {
        places,
        ends: ends.collect(),
    };
    let vertex_offsets = gathering.offsets(Part::Points);
    // Each array's blocks are freed as soon as it is whole.
    macro_rules! of {
        ($field:ident) => {
            &blocks
                .iter_mut()
                .map(|block| std::mem::take(&mut block.$field))
                .collect::<Vec<_>>()
        };
    }
    let (points, facets) = ((Part::Points, dimension), (Part::Facets, dimension));
    let sizes = if blocks.iter().any(|block| !block.sizes.is_empty()) {
        gathering.gather((Part::Facets, 1), of!(sizes), |_, &size| i64::from(size))
    } else {
        Vec::new()
    };
    CellArrays {
        dimension,
        vertices: gathering.gather(points, of!(vertices), |_, &x| x),
        corners: gathering.gather((Part::Corners, 1), of!(corners), |cell, &corner| {
            vertex_offsets[cell] + i64::from(corner)
        }),
        corner_offsets: running(&sizes),
        neighbors: gathering.gather((Part::Facets, 1), of!(neighbors), |_, &site| site),
        images: gathering.gather(facets, of!(images), |_, &image| image),
        areas: gathering.gather((Part::Facets, 1), of!(areas), |_, &area| area),
        normals: gathering.gather(facets, of!(normals), |_, &x| x),
        volumes: gathering.per_cell(1, of!(volumes)),
        centroids: gathering.per_cell(dimension, of!(centroids)),
        radii: gathering.per_cell(1, of!(radii)),
        certified: gathering.per_cell(1, of!(certified)),
        facet_offsets: gathering.offsets(Part::Facets),
        vertex_offsets,
    }
}

/// Zero and the sums of the first one, two, … numbers.
fn running(sizes: &[i64]) -> Vec<i64> {
    let sums = sizes.iter().scan(0, |sum, &size| {
        *sum += size;
        Some(*sum)
    });
    std::iter::once(0).chain(sums).collect()
}
