//! The mesh of L∞ cells, whose points and faces neighbors share to the bit.
//!
//! All planes of an L∞ diagram in a box are y_k = c or y_k ± y_l = c, and all its edges run along vectors of
//! components −1, 0 and 1. With sites and walls on a grid of 2⁻⁴⁷ of the domain's size, which moves them by
//! their last digits, every coordinate of every vertex is a multiple of half the grid's step: cells are
//! computed without rounding, and so is who lies on whose edge.
//!
//! A facet is all polygons of one neighbor in one plane; on each line the polygons' edges add up, and what
//! does not cancel bounds the facet. Edges are divided at all vertices of the diagram that lie on them.

use std::collections::{BTreeMap, HashMap};

use nalgebra::{Point3, Vector3};

use crate::complex::grid_lines::{
    DIRECTIONS, LineKey, Place, direction_of, line_of, line_through, parts_of, place_on,
};
use crate::complex::loop_corner::LoopCorner;
use crate::complex::loops::CellLoops;
use crate::complex::mesh_builder::MeshBuilder;
use crate::complex::numbered_facets::{NumberedFacet, is_paired, loops_of};
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
use crate::voronoi::diagram::Diagram;
use crate::voronoi::linf::cell::{LinfCell, Ties};

/// Digits of a coordinate beyond the grid's step: half steps, doubled by sums of two, still fit in 53 bits.
const DIGITS: i32 = 47;

/// A plane of a cell's boundary: what is beyond, the normal's number, and the offset in half steps.
type PlaneKey = (Label, u8, i64);

/// Where signed edges begin and end on the lines of a plane, and how many.
type Coverage = BTreeMap<LineKey, BTreeMap<i64, i32>>;

/// The normals of planes, up to their sign: the directions with a component that is zero.
const NORMALS: &[Place] = DIRECTIONS.split_at(9).0;

/// A facet: what is beyond, its outward normal, and its directed edges.
#[derive(Clone, Debug)]
struct GridFacet {
    label: Label,
    normal: Place,
    edges: Vec<[Place; 2]>,
}

/// The facets of all cells.
type CellFacets = Vec<Vec<GridFacet>>;

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

/// Where cells end between two of their cones, sites are moved apart by steps of the grid, if that leaves the
/// volumes of all cells as they are up to this share of the domain's.
const SAME_VOLUME: f64 = 1e-13;

/// Vertices are on a wall of a convex polyhedron that are so near to it, relative to the domain's size.
const ON_WALL: f64 = 32.0 * f64::EPSILON;

/// The mesh of the L∞ cells of sites in a box or a convex polyhedron, in site order. None where distinct
/// sites are one on the grid, and where regions are tied that are more than rounding: there a cell does not
/// know who is beyond.
pub(crate) fn linf_mesh(domain: &dyn DomainShape, sites: &[Point3<f64>]) -> Option<PolyMesh> {
    let grid = WholeGrid::of(domain)?;
    let (cuboid, sites) = grid.snapped(domain, sites)?;
    let (volumes, cells) = grid.cells(&cuboid, &sites)?;
    if let Some(cells) = cells {
        return grid.mesh(domain, cells);
    }
    let (apart, cells) = grid.cells(&cuboid, &grid.apart(&cuboid, &sites))?;
    let slack = SAME_VOLUME * cuboid.volume();
    let mut pairs = volumes.iter().zip(&apart);
    let is_same = pairs.all(|(one, other)| (one - other).abs() <= slack);
    cells
        .filter(|_| is_same)
        .and_then(|cells| grid.mesh(domain, cells))
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

    /// The volumes of all cells (L³), and their facets if none ends between two of its cones.
    fn cells(
        &self,
        cuboid: &Cuboid,
        sites: &[Point3<f64>],
    ) -> Option<(Vec<f64>, Option<CellFacets>)> {
        let diagram = Diagram::new(cuboid, sites).ok()?;
        let of_cell = |(): &mut (), cell: LinfCell<'_>| (cell.volume(), facets(self, &cell));
        let cells = diagram.map_linf(Ties::ToSmallerIndex, of_cell).ok()?;
        let (volumes, facets): (Vec<_>, Vec<_>) = cells.into_iter().unzip();
        Some((volumes, facets.into_iter().collect()))
    }

    /// The sites, those of one coordinate moved apart along its axis by a step each.
    fn apart(&self, cuboid: &Cuboid, sites: &[Point3<f64>]) -> Vec<Point3<f64>> {
        let mut moved = sites.to_vec();
        for axis in 0..3 {
            let mut order: Vec<usize> = (0..sites.len()).collect();
            order.sort_by(|&a, &b| sites[a][axis].total_cmp(&sites[b][axis]).then(a.cmp(&b)));
            let mut last = f64::NEG_INFINITY;
            for &site in &order {
                let along = &mut moved[site][axis];
                *along = along.max(last + 2.0 * self.unit);
                last = *along;
            }
            // Those at the upper wall go the other way.
            let mut next = self.walls[axis][1] as f64 * self.unit;
            for &site in order.iter().rev() {
                let along = &mut moved[site][axis];
                *along = along.min(next);
                next = *along - 2.0 * self.unit;
            }
        }
        moved.iter().map(|site| cuboid.wrap(site)).collect()
    }

    /// The mesh of cells with these facets, within the domain; none if they do not fit together.
    fn mesh(&self, domain: &dyn DomainShape, cells: CellFacets) -> Option<PolyMesh> {
        let vertices = GridVertices::new(self, &cells);
        let numbered = cells.into_iter().map(|facets| {
            let facets = facets.into_iter();
            facets.map(|facet| vertices.numbered(self, facet)).collect()
        });
        let mut cells: Vec<Vec<NumberedFacet>> = numbered.collect();
        let mut positions: Vec<_> = vertices.places.iter().map(|at| self.position(at)).collect();
        drop(vertices);
        if !domain.is_box() {
            cells = self.clipped(domain, cells, &mut positions)?;
        }
        let periods = Vector3::from(self.periods.map(|steps| steps as f64 * self.unit));
        let loops = cells.into_iter();
        let loops: Vec<CellLoops> = loops
            .map(|facets| loops_of(&facets, &positions, &periods))
            .collect();
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
    lines: HashMap<LineKey, Vec<i64>>,
}

impl GridVertices {
    fn new(grid: &WholeGrid, cells: &CellFacets) -> Self {
        let mut lines: HashMap<LineKey, Vec<i64>> = HashMap::new();
        let mut places: Vec<Place> = Vec::new();
        for edge in cells.iter().flatten().flat_map(|facet| &facet.edges) {
            lines.entry(line_of(edge)).or_default();
            places.push(grid.wrapped(edge[0]).0);
        }
        places.sort_unstable();
        places.dedup();
        for vertex in places.iter().flat_map(|place| grid.copies(*place)) {
            for (number, direction) in (0..).zip(&DIRECTIONS) {
                let (key, along) = line_through(&vertex, number, direction);
                if let Some(places) = lines.get_mut(&key) {
                    places.push(along);
                }
            }
        }
        lines.values_mut().for_each(|places| places.sort_unstable());
        Self { places, lines }
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
        let edges = edges.flat_map(|edge| parts_of(edge, &self.lines));
        NumberedFacet {
            label: facet.label,
            normal: Vector3::from(facet.normal.map(|along| along as f64)),
            edges: edges.map(|edge| edge.each_ref().map(corner)).collect(),
        }
    }
}

/// The facets of a cell; none where they are not on the grid or the cell ends between two of its cones.
fn facets(grid: &WholeGrid, cell: &LinfCell<'_>) -> Option<Vec<GridFacet>> {
    let mut planes: BTreeMap<PlaneKey, Coverage> = BTreeMap::new();
    let mut is_on_grid = true;
    cell.visit_boundary(|(label, ..), corners| {
        let places = corners
            .iter()
            .map(|corner| grid.place(&(cell.position + corner)));
        let added = places
            .collect::<Option<Vec<Place>>>()
            .and_then(|places| add_polygon(&mut planes, label, &places));
        is_on_grid &= added.is_some();
    });
    let facets = planes.iter().map(|(key, lines)| facet_of(key, lines));
    let facets = facets.filter(|facet| facet.as_ref().is_none_or(|facet| !facet.edges.is_empty()));
    let facets = facets.collect::<Option<Vec<_>>>().filter(|_| is_on_grid)?;
    let is_known = |facet: &GridFacet| FacetKind::of(facet.label) != FacetKind::Inner;
    facets.iter().all(is_known).then_some(facets)
}

/// Adds the edges of a polygon to those of its plane.
fn add_polygon(
    planes: &mut BTreeMap<PlaneKey, Coverage>,
    label: Label,
    places: &[Place],
) -> Option<()> {
    let offset = |normal: &Place, at: &Place| -> i64 { (0..3).map(|k| normal[k] * at[k]).sum() };
    let mut through = (0..).zip(NORMALS).filter(|(_, normal)| {
        places
            .iter()
            .all(|at| offset(normal, at) == offset(normal, &places[0]))
    });
    let (number, normal) = through.next()?;
    if through.next().is_some() {
        // All corners are on a line.
        return Some(());
    }
    let lines = planes
        .entry((label, number, offset(normal, &places[0])))
        .or_default();
    for (from, to) in places.iter().zip(places.iter().cycle().skip(1)) {
        if from == to {
            continue;
        }
        let (number, sign) = direction_of(from, to)?;
        let [(key, start), (_, end)] =
            [from, to].map(|at| line_through(at, number, &DIRECTIONS[usize::from(number)]));
        let line = lines.entry(key).or_default();
        *line.entry(start.min(end)).or_default() += sign;
        *line.entry(start.max(end)).or_default() -= sign;
    }
    Some(())
}

/// The facet in a plane with what is left of its edges; none if they overlap.
fn facet_of(&(label, normal, _): &PlaneKey, lines: &Coverage) -> Option<GridFacet> {
    let mut edges = Vec::new();
    for (key, line) in lines {
        let (mut sign, mut since) = (0, 0);
        for (&along, change) in line.iter().filter(|(_, change)| **change != 0) {
            match sign {
                0 => {}
                1 => edges.push([since, along].map(|along| place_on(key, along))),
                -1 => edges.push([along, since].map(|along| place_on(key, along))),
                _ => return None,
            }
            (sign, since) = (sign + change, along);
        }
    }
    let mut facet = GridFacet {
        label,
        normal: NORMALS[usize::from(normal)],
        edges,
    };
    if facet.doubled_area() < 0.0 {
        facet.normal = facet.normal.map(|along| -along);
    }
    Some(facet)
}

impl GridFacet {
    /// The area along the normal, up to a positive factor.
    fn doubled_area(&self) -> f64 {
        let Some([origin, _]) = self.edges.first() else {
            return 0.0;
        };
        let arm = |at: &Place| Vector3::from([0, 1, 2].map(|k| (at[k] - origin[k]) as f64));
        let normal = Vector3::from(self.normal.map(|along| along as f64));
        let edges = self.edges.iter();
        edges
            .map(|[from, to]| normal.dot(&arm(from).cross(&arm(to))))
            .sum()
    }
}
