//! The mesh of L∞ cells, whose points and faces neighbors share to the bit.
//!
//! All planes of an L∞ diagram in a box are y_k = c or y_k ± y_l = c, and all its edges run along vectors of
//! components −1, 0 and 1. With sites and walls on a grid of 2⁻⁴⁷ of the domain's size, which moves them by
//! their last digits, every coordinate of every vertex is a multiple of half the grid's step: cells are
//! computed without rounding, and so is who lies on whose edge.
//!
//! A facet is all polygons of one neighbor in one plane; on each line the polygons' edges add up, and what
//! does not cancel bounds the facet. Edges are divided at all vertices of the diagram that lie on them.

use nalgebra::{Point3, Vector3};

use crate::complex::grid_facets::{GridCell, GridFacet, Polygons};
use crate::complex::grid_lines::{LineKey, Place, PlacesOnLines, line_of};
use crate::complex::loop_corner::LoopCorner;
use crate::complex::loops::CellLoops;
use crate::complex::mesh_builder::MeshBuilder;
use crate::complex::numbered_facets::{NumberedFacet, is_paired, loops_of};
use crate::complex::tied_facets::name_tied;
use crate::complex::vertex_key::Shift;
use crate::complex::wall_clip::WallClip;
use crate::complex::wall_patches::WallPatches;
use crate::domain::cuboid::Cuboid;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::DomainShape;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::mesh::poly_mesh::PolyMesh;
use crate::parallel::map;
use crate::voronoi::diagram::Diagram;
use crate::voronoi::linf::cell::{LinfCell, Ties};

/// Digits of a coordinate beyond the grid's step: half steps, doubled by sums of two, still fit in 53 bits.
const DIGITS: i32 = 47;

/// The grid, and the box and its periods on it.
#[derive(Clone, Debug)]
struct WholeGrid {
    /// Half a step (L), a power of two.
    unit: f64,
    /// The box's own walls.
    bounds: Bounds<3>,
    walls: [[i64; 2]; 3],
    /// In half steps; zero along axes without period.
    periods: Place,
}

/// Vertices are on a wall of a convex polyhedron that are so near to it, relative to the domain's size.
const ON_WALL: f64 = 32.0 * f64::EPSILON;

/// The mesh of the L∞ cells of sites in a box or a convex polyhedron, in site order. None where distinct
/// sites are one on the grid.
pub(crate) fn linf_mesh(domain: &dyn DomainShape, sites: &[Point3<f64>]) -> Option<PolyMesh> {
    let grid = WholeGrid::of(domain)?;
    let (cuboid, sites) = grid.snapped(domain, sites)?;
    let mut cells = grid.cells(&cuboid, &sites)?;
    name_tied(&mut cells, &grid.periods)?;
    grid.mesh(domain, cells)
}

impl WholeGrid {
    fn of(domain: &dyn DomainShape) -> Option<Self> {
        let (bounds, periods) = (domain.bounds(), domain.periods());
        let is_solid = domain.is_convex() && periods.iter().all(Option::is_none);
        if !domain.is_box() && !is_solid {
            return None;
        }
        let size = bounds.min.coords.amax().max(bounds.max.coords.amax());
        let size = size.max(bounds.extent().max());
        let unit = (size.log2().ceil() as i32 - DIGITS - 1) as f64;
        let unit = unit.exp2();
        let mut grid = Self {
            unit,
            bounds,
            walls: [[0; 2]; 3],
            periods: [0; 3],
        };
        for axis in 0..3 {
            let ends = [bounds.min[axis], bounds.max[axis]].map(|end| grid.whole(grid.near(end)));
            grid.walls[axis] = [ends[0]?, ends[1]?];
            if periods[axis].is_some() {
                grid.periods[axis] = grid.walls[axis][1] - grid.walls[axis][0];
            }
        }
        Some(grid)
    }

    /// The nearest coordinate on the grid.
    fn near(&self, coordinate: f64) -> f64 {
        (coordinate / (2.0 * self.unit)).round() * (2.0 * self.unit)
    }

    /// A coordinate in half steps, if it is a whole number of them.
    fn whole(&self, coordinate: f64) -> Option<i64> {
        let steps = coordinate / self.unit;
        (steps.fract() == 0.0 && steps.abs() < 9e15).then_some(steps as i64)
    }

    fn place(&self, at: &Point3<f64>) -> Option<Place> {
        Some([self.whole(at.x)?, self.whole(at.y)?, self.whole(at.z)?])
    }

    /// The position of a place; on a wall that of the box itself.
    fn position(&self, at: &Place) -> Point3<f64> {
        Point3::from([0, 1, 2].map(|axis| {
            let [low, high] = self.walls[axis];
            match at[axis] {
                steps if steps == low => self.bounds.min[axis],
                steps if steps == high => self.bounds.max[axis],
                steps => steps as f64 * self.unit,
            }
        }))
    }

    /// The box and the sites, moved to the grid.
    fn snapped(
        &self,
        domain: &dyn DomainShape,
        sites: &[Point3<f64>],
    ) -> Option<(Cuboid, Vec<Point3<f64>>)> {
        let ends = [0, 1].map(|end| self.walls.map(|wall| wall[end] as f64 * self.unit));
        let bounds = Bounds::from_corners(ends[0], ends[1]);
        let periodic = domain.periods().map(|period| period.is_some());
        let cuboid = Cuboid::new(bounds, periodic).ok()?;
        let moved = sites.iter().map(|site| {
            let near = Point3::from(site.coords.map(|along| self.near(along)));
            cuboid.wrap(&bounds.clamp(&near))
        });
        let moved = moved.collect();
        Some((cuboid, moved))
    }

    /// The facets of all cells.
    fn cells(&self, cuboid: &Cuboid, sites: &[Point3<f64>]) -> Option<Vec<GridCell>> {
        let diagram = Diagram::new(cuboid, sites).ok()?;
        let of_cell = |(): &mut (), cell: LinfCell<'_>| facets(self, &cell);
        let cells = diagram.map_linf(Ties::ToSmallerIndex, of_cell).ok()?;
        cells.into_iter().collect()
    }

    /// The mesh of cells with these facets, within the domain; none if they do not fit together.
    fn mesh(&self, domain: &dyn DomainShape, cells: Vec<GridCell>) -> Option<PolyMesh> {
        let vertices = GridVertices::new(self, &cells);
        let mut positions: Vec<_> = vertices.places.iter().map(|at| self.position(at)).collect();
        let numbered = |site: usize| -> Vec<NumberedFacet> {
            let facets = cells[site].facets();
            facets.map(|facet| vertices.numbered(self, facet)).collect()
        };
        let periods = Vector3::from(self.periods.map(|steps| steps as f64 * self.unit));
        let loops: Vec<CellLoops> = if domain.is_box() {
            map(cells.len(), &|site| {
                loops_of(&numbered(site), &positions, &periods)
            })
        } else {
            let all = map(cells.len(), &numbered);
            let clipped = self.clipped(domain, all, &mut positions)?;
            map(clipped.len(), &|site| {
                loops_of(&clipped[site], &positions, &periods)
            })
        };
        drop((cells, vertices));
        is_paired(&loops)
            .then(|| MeshBuilder::new(&loops, &positions, periods).build(&WallPatches::Each))
    }

    /// The cells of the box within the walls of a convex polyhedron in it.
    fn clipped(
        &self,
        domain: &dyn DomainShape,
        mut cells: Vec<Vec<NumberedFacet>>,
        positions: &mut Vec<Point3<f64>>,
    ) -> Option<Vec<Vec<NumberedFacet>>> {
        let inner = FacetKind::Inner.label();
        let (sides, walls) = sides_and_walls(domain);
        for facet in cells.iter_mut().flatten() {
            if let FacetKind::Wall(side) = FacetKind::of(facet.label) {
                facet.label = sides[side as usize].unwrap_or(inner);
            }
        }
        let size = self.bounds.min.coords.amax();
        let size = size.max(self.bounds.max.coords.amax());
        for (wall, label) in walls {
            let mut clip = WallClip::new(wall, label, ON_WALL * size, positions);
            let clipped = cells.into_iter().map(|facets| clip.clip(facets));
            cells = clipped.collect::<Option<_>>()?;
        }
        // Of the box's own sides nothing is left but what are walls.
        let mut facets = cells.iter().flatten();
        facets.all(|facet| facet.label != inner).then_some(cells)
    }

    /// A place within the box but for whole periods, and those.
    fn wrapped(&self, mut at: Place) -> (Place, Shift) {
        let mut shift = [0; 3];
        for axis in (0..3).filter(|&axis| self.periods[axis] > 0) {
            let (period, low) = (self.periods[axis], self.walls[axis][0]);
            let periods = (at[axis] - low).div_euclid(period);
            at[axis] -= periods * period;
            shift[axis] = periods as i16;
        }
        (at, shift)
    }

    /// A place and its images up to half a period beyond the box.
    fn copies(&self, at: Place) -> Vec<Place> {
        let mut copies = vec![at];
        for axis in (0..3).filter(|&axis| self.periods[axis] > 0) {
            let (period, [low, high]) = (self.periods[axis], self.walls[axis]);
            let is_near =
                |along: i64| 2 * low - period <= 2 * along && 2 * along <= 2 * high + period;
            let moved = |copy: &Place, by: i64| {
                let mut moved = *copy;
                moved[axis] += by;
                moved
            };
            let more: Vec<Place> = copies
                .iter()
                .flat_map(|copy| [moved(copy, -period), moved(copy, period)])
                .filter(|copy| is_near(copy[axis]))
                .collect();
            copies.extend(more);
        }
        copies
    }
}

/// The labels of the walls along the axes of a convex polyhedron, in the order of a box's walls, and its
/// other walls.
fn sides_and_walls(domain: &dyn DomainShape) -> ([Option<Label>; 6], Vec<(HalfSpace, Label)>) {
    let mut solid = Polyhedron::default();
    domain.start(&Point3::origin(), 0, &mut solid);
    let (mut sides, mut walls) = ([None; 6], Vec::new());
    for facet in solid.facets() {
        let (wall, label) = (facet.half_space().normalized(), facet.label());
        let axis = wall.normal.iamax();
        if wall.normal.iter().filter(|part| **part != 0.0).count() == 1 {
            sides[2 * axis + usize::from(wall.normal[axis] > 0.0)] = Some(label);
        } else {
            walls.push((wall, label));
        }
    }
    (sides, walls)
}

/// The vertices of all cells in the order of their places, and which of them lie on the lines of edges.
struct GridVertices {
    places: Vec<Place>,
    on_lines: PlacesOnLines,
}

impl GridVertices {
    fn new(grid: &WholeGrid, cells: &[GridCell]) -> Self {
        let of_cells = map(cells.len(), &|site| {
            let mut lines: Vec<_> = cells[site].edges().map(|edge| line_of(&edge)).collect();
            lines.sort_unstable();
            lines.dedup();
            lines
        });
        let mut lines: Vec<LineKey> = Vec::with_capacity(of_cells.iter().map(Vec::len).sum());
        of_cells
            .into_iter()
            .for_each(|of_cell| lines.extend(of_cell));
        let places = cells.iter().flat_map(GridCell::places);
        let mut places: Vec<Place> = places.map(|place| grid.wrapped(*place).0).collect();
        places.sort_unstable();
        places.dedup();
        places.shrink_to_fit();
        let copies = |vertex: usize| grid.copies(places[vertex]);
        Self {
            on_lines: PlacesOnLines::new(lines, places.len(), &copies),
            places,
        }
    }

    /// A facet whose edges end at all vertices that lie on them.
    fn numbered(&self, grid: &WholeGrid, facet: GridFacet) -> NumberedFacet {
        let corner = |at: &Place| {
            let (place, shift) = grid.wrapped(*at);
            // All places of cells are numbered.
            let number = self.places.binary_search(&place).unwrap_or_default();
            LoopCorner::new(number as u32, shift)
        };
        let edges = facet.edges.iter();
        let edges = edges.flat_map(|edge| self.on_lines.parts_of(edge));
        NumberedFacet {
            label: facet.label,
            normal: Vector3::from(facet.normal.map(|along| along as f64)),
            edges: edges.map(|edge| edge.each_ref().map(corner)).collect(),
        }
    }
}

/// The facets of a cell; none where they are not on the grid.
fn facets(grid: &WholeGrid, cell: &LinfCell<'_>) -> Option<GridCell> {
    let mut polygons = Polygons::default();
    let mut is_on_grid = true;
    cell.visit_boundary(|(label, ..), corners| {
        let places = corners
            .iter()
            .map(|corner| grid.place(&(cell.position + corner)));
        let added = places
            .collect::<Option<Vec<Place>>>()
            .and_then(|places| polygons.add(label, &places));
        is_on_grid &= added.is_some();
    });
    let facets = polygons.facets().filter(|_| is_on_grid)?;
    Some(GridCell::new(&facets, cell.has_ties()))
}
