//! One cell of the plane: its energy, its minimizer, its figures. In the figures read square for cube and
//! edge for facet.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Point2, Vector2};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::domain::planar_density::PlaneDensity;
use crate::energy::center::{BOUNDARY_FRACTION, Center, CenterSearch};
use crate::energy::planar_cell::PlaneCellEnergy;
use crate::geometry::bounds::Bounds;
use crate::geometry::half_plane::HalfPlane;
use crate::geometry::label::Label;
use crate::geometry::polygon::ConvexPolygon;
use crate::minimize::problem::Evaluation;
use crate::relax::metrics::{ALIGNED, CellMetrics, FACET_SHARE};
use crate::relax::objective::CellTerms;
use crate::relax::relaxation_space::{CellCrowding, CellResult, EnergySpec, Norm};
use crate::voronoi::planar::diagram::PlaneCell;

/// A reach above this means that the center lies inside or on the border.
const ON_BORDER: f64 = 1.0 - 1e-12;

/// A cell in its domain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellInPlane<'a> {
    pub(crate) domain: &'a PlaneDomain,
    pub(crate) cell: &'a PlaneCell,
}

impl<'a> CellInPlane<'a> {
    /// The cell's energy of an order, relative to the site.
    pub(crate) fn energy(&self, order: u32) -> PlaneCellEnergy<'a> {
        let density = self.domain.density();
        let density = density.map(|density| density.about(&self.cell.site));
        PlaneCellEnergy::new(self.cell.pieces(), order, density)
    }

    /// The energy at the site in the norm and order of `spec`.
    pub(crate) fn energy_at_site(&self, spec: EnergySpec) -> f64 {
        match spec.norm {
            Norm::Linf => self.energy(spec.order).at_site(),
            Norm::L2 => self.energy(1).moments().second,
        }
    }

    /// The energy of order 1 at the site, per mean density.
    fn chebyshev(&self) -> f64 {
        self.energy(1).at_site() / self.mean_density()
    }

    fn mean_density(&self) -> f64 {
        self.domain.density().map_or(1.0, PlaneDensity::mean)
    }

    pub(crate) fn assess(&self, spec: EnergySpec) -> CellResult<2> {
        let found = self.minimum(spec);
        let volume = self.cell.area();
        CellResult {
            volume,
            energy: found.at_site.value,
            chebyshev: match (spec.norm, spec.order) {
                (Norm::Linf, 1) => found.at_site.value / self.mean_density(),
                _ => self.chebyshev(),
            },
            target: self.target(found.minimizer, spec),
            evaluations: found.evaluations,
        }
    }

    /// Where the site moves that wants to go by `step`.
    fn target(&self, step: Vector2<f64>, spec: EnergySpec) -> Point2<f64> {
        let PlaneCell { site, polygon, .. } = self.cell;
        let mut step = match spec.norm {
            Norm::Linf => step_inside(polygon, &Point2::from(step)),
            Norm::L2 if self.domain.is_convex() => step,
            Norm::L2 => step_inside(polygon, &Point2::from(step)),
        };
        if !self.domain.is_convex() || self.domain.has_linf_cells() {
            if let Some((share, _)) = self.domain.wall_ahead(site, &step) {
                step *= BOUNDARY_FRACTION * share;
            }
            // Rounding may put a point that is nearly on a side beyond it.
            while step.norm() > 0.0 && !self.domain.contains(&(site + step)) {
                step *= 0.5;
            }
        }
        self.within_walls(&self.domain.wrap(&(site + step)))
    }

    /// The place itself, or the wall of the box around the domain beyond which rounding has put it.
    fn within_walls(&self, place: &Point2<f64>) -> Point2<f64> {
        let inside = self.domain.bounds().clamp(place);
        let periods = self.domain.periods();
        Point2::from([0, 1].map_each(|axis| match periods[axis] {
            Some(_) => place[axis],
            None => inside[axis],
        }))
    }

    /// The energy at the site and its minimizer.
    fn minimum(&self, spec: EnergySpec) -> PlaneMinimum {
        match spec.norm {
            Norm::Linf => self.center(spec),
            Norm::L2 => self.centroid(),
        }
    }

    /// The minimum of the energy over the cell's own bounding box; the site for a cell that rounding has
    /// left without area.
    fn center(&self, spec: EnergySpec) -> PlaneMinimum {
        let mut energy = self.energy(spec.order);
        let volume = self.cell.area();
        if volume <= 0.0 {
            let at_site = energy.evaluate(&Point2::origin());
            return PlaneMinimum {
                energy: at_site.value,
                at_site,
                minimizer: Vector2::zeros(),
                evaluations: 0,
            };
        }
        let search = CenterSearch {
            minimizer: spec.minimizer,
            order: spec.order,
            volume,
            mass: energy.mass(),
            bounds: self.bounds(),
        };
        let mut first = None;
        let Center {
            point,
            energy,
            evaluations,
            ..
        } = search.center(|c: &Vector2<f64>| {
            let evaluation = energy.evaluate(&Point2::from(*c));
            first.get_or_insert(evaluation);
            evaluation
        });
        PlaneMinimum {
            at_site: first.unwrap_or_default(),
            minimizer: point,
            energy,
            evaluations,
        }
    }

    /// The box around the cell, and the site where that lies outside its own cell's pieces.
    fn bounds(&self) -> Bounds<2> {
        let mut bounds = Bounds::of(self.cell.pieces().iter().flat_map(ConvexPolygon::vertices));
        if !self.domain.is_convex() || self.domain.has_linf_cells() {
            bounds.include(&Point2::origin());
        }
        bounds
    }

    /// The same for ∫ ρ |y − c|₂², whose center is the centroid: the gradient is 2 m (c − centroid).
    fn centroid(&self) -> PlaneMinimum {
        let moments = self.energy(1).moments();
        let centroid = moments.centroid();
        PlaneMinimum {
            at_site: Evaluation {
                value: moments.second,
                gradient: -2.0 * moments.first,
                hessian: Matrix2::from_diagonal_element(2.0 * moments.mass),
            },
            minimizer: centroid,
            energy: moments.second - moments.mass * centroid.norm_squared(),
            evaluations: 1,
        }
    }

    /// The figures of the cell.
    pub(crate) fn metrics(&self, spec: EnergySpec) -> CellMetrics<2> {
        let (found, moments) = (self.minimum(spec), self.energy(1).moments());
        let volume = self.cell.area();
        let site = self.cell.site;
        let place = |step: Vector2<f64>| self.domain.wrap(&(site + step));
        let edges = EdgeSums::of(self.cell.pieces(), self.domain.has_linf_cells());
        CellMetrics {
            volume,
            centroid: place(moments.centroid()),
            energy: found.at_site.value,
            gradient: found.at_site.gradient,
            center: place(found.minimizer),
            center_energy: found.energy,
            facets: edges.facets(volume),
            chebyshev: self.chebyshev(),
            relative_density: self.relative_density(moments.mass, volume),
            cubeness: squareness(self.cell.pieces(), volume),
            axis_aligned: edges.axis_aligned(),
        }
    }

    fn relative_density(&self, mass: f64, volume: f64) -> f64 {
        if volume > 0.0 {
            mass / (volume * self.mean_density())
        } else {
            1.0
        }
    }

    /// The cell's terms of the global objective; `displacement` is from the site to another one's image.
    pub(crate) fn terms(
        &self,
        order: u32,
        displacement: impl Fn(u32, [i8; 3]) -> Vector2<f64>,
    ) -> CellTerms<2> {
        let mut energy = self.energy(order);
        let inside = energy.evaluate(&Point2::origin());
        let (mut gradient, mut across) = (inside.gradient, Vec::new());
        // On L∞ bisectors both distances agree, so that moving them costs nothing.
        let is_neighbor = |label| {
            let kind = FacetKind::of(label);
            !self.domain.has_linf_cells() && matches!(kind, FacetKind::Neighbor { .. })
        };
        energy.visit_edges(is_neighbor, |edge| {
            if let FacetKind::Neighbor { site, image } = FacetKind::of(edge.label) {
                let to_neighbor = displacement(site, image);
                let distance = to_neighbor.norm();
                gradient += edge.first / distance;
                across.push((site, (to_neighbor * edge.weight - edge.first) / distance));
            }
        });
        let chebyshev = match order {
            1 => inside.value / self.mean_density(),
            _ => self.chebyshev(),
        };
        CellTerms {
            volume: self.cell.area(),
            energy: inside.value,
            chebyshev,
            gradient,
            across,
        }
    }

    /// How crowded the cell is.
    pub(crate) fn crowding(&self) -> CellCrowding<2> {
        let vertices = self.cell.pieces().iter().flat_map(ConvexPolygon::vertices);
        let farthest = vertices.fold(Vector2::zeros(), |farthest: Vector2<f64>, vertex| {
            if vertex.coords.amax() > farthest.amax() {
                vertex.coords
            } else {
                farthest
            }
        });
        CellCrowding {
            energy: self.energy(1).at_site(),
            vertex: self.within_walls(&self.domain.wrap(&(self.cell.site + farthest))),
            distance: farthest.amax(),
        }
    }
}

/// The energy at the site, its minimizer and the energy there.
struct PlaneMinimum {
    at_site: Evaluation<2>,
    /// From the site to the minimizer.
    minimizer: Vector2<f64>,
    energy: f64,
    evaluations: u32,
}

/// Where a site moves that wants to go to `center`: all the way if that lies in the cell
/// `polygon` (which has the site as origin), else along the straight line, up to just before the
/// cell's boundary.
fn step_inside(polygon: &ConvexPolygon, center: &Point2<f64>) -> Vector2<f64> {
    let reach = polygon.reach(&Point2::origin(), &center.coords);
    if reach >= ON_BORDER {
        center.coords
    } else {
        center.coords * (reach * BOUNDARY_FRACTION)
    }
}

/// The sums of the edges with the same label, as vectors, those of L∞ cells apart by direction.
struct EdgeSums(BTreeMap<(Label, usize), Vector2<f64>>);

impl EdgeSums {
    fn of(pieces: &[ConvexPolygon], has_linf_cells: bool) -> Self {
        let mut sums = BTreeMap::new();
        for edge in pieces.iter().flat_map(ConvexPolygon::edges) {
            let along = edge.end - edge.start;
            let direction = match FacetKind::of(edge.label) {
                FacetKind::Inner => continue,
                FacetKind::Neighbor { .. } if has_linf_cells => direction_number(&along),
                _ => 0,
            };
            *sums.entry((edge.label, direction)).or_default() += along;
        }
        Self(sums)
    }

    /// How many are longer than [`FACET_SHARE`] of √V.
    fn facets(&self, area: f64) -> u32 {
        let least = FACET_SHARE * area.max(0.0).sqrt();
        self.0.values().filter(|sum| sum.norm() > least).count() as u32
    }

    /// The share of the perimeter whose unit normal has a component of at least [`ALIGNED`].
    fn axis_aligned(&self) -> f64 {
        let perimeter: f64 = self.0.values().map(Vector2::norm).sum();
        let aligned = |sum: &&Vector2<f64>| sum.amax() >= ALIGNED * sum.norm();
        let aligned: f64 = self.0.values().filter(aligned).map(Vector2::norm).sum();
        if perimeter > 0.0 {
            aligned / perimeter
        } else {
            0.0
        }
    }
}

/// Numbers the directions of an L∞ bisector: along the axes and the diagonals.
fn direction_number(along: &Vector2<f64>) -> usize {
    let size = along.amax();
    along.iter().fold(0, |number, &part| {
        let step = if part.abs() < 0.5 * size {
            0
        } else if part > 0.0 {
            1
        } else {
            2
        };
        3 * number + step
    })
}

/// The overlap of the pieces with the square of their own area about the origin, over their union.
fn squareness(pieces: &[ConvexPolygon], area: f64) -> f64 {
    if area <= 0.0 {
        return 0.0;
    }
    let offset = 0.5 * area.sqrt();
    let within = |piece: &ConvexPolygon| {
        let mut common = piece.clone();
        for normal in [Vector2::x(), Vector2::y(), -Vector2::x(), -Vector2::y()] {
            common.clip(&HalfPlane { normal, offset }, FacetKind::Inner.label());
        }
        common.area()
    };
    let overlap: f64 = pieces.iter().map(within).sum();
    overlap / (2.0 * area - overlap)
}
