//! Densities over a domain: polynomials in boxes, or linear functions on tetrahedra.
//!
//! Cells of edge h everywhere need the density ρ = h^−(3+p), which is no polynomial although h is
//! one. So the domain is cut into boxes in which ρ changes by at most a factor of two, bounded by
//! the Bernstein form of h; in each, ρ is the parabola in h through its values at both ends and in the
//! middle of h's range there, again a polynomial. It is within half a percent of h^−(3+p), so that
//! edges are right to a part in eight hundred, and integrals over it are as exact as over any other.

use nalgebra::{Matrix3, Point3, Vector3};

use crate::domain::error::DomainError;
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::{DomainShape, PieceScratch};
use crate::domain::tet_mesh::IndexedTets;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::bernstein::Bernstein;
use crate::integrals::mesh_moments::of_piece;
use crate::integrals::polynomial::Polynomial;
use crate::mesh::tets::tet_volume;

/// The largest factor by which the density of a size may change within a box.
const LARGEST_CHANGE: f64 = 2.0;

/// The highest degree of a size: the density has twice that, the highest degree of integrals.
const HIGHEST_DEGREE: u32 = 8;

/// How often a box is halved at most for a size: sizes that need more come within a millionth of zero.
const SIZE_HALVINGS: u32 = 24;

/// The largest number of boxes: every cell is compared with each of them.
const MOST_REGIONS: usize = 4096;

/// How often a box is halved at most to decide whether a density is positive: into thirty-two parts
/// along every axis. What is undecided then is so near to zero that only more digits could decide it,
/// and is accepted.
const SIGN_HALVINGS: u32 = 15;

/// A positive density over a domain.
#[derive(Debug)]
pub struct Density {
    parts: Parts,
    mean: f64,
}

#[derive(Debug)]
enum Parts {
    /// Boxes that fill space, with densities in the domain's coordinates.
    Regions(Vec<DensityRegion>),
    /// Per tetrahedron the value at its first corner and the gradient.
    Tets(IndexedTets, Vec<(f64, Vector3<f64>)>),
}

/// A box, open to infinity where it ends with the domain, and the density there.
#[derive(Clone, Debug)]
pub(crate) struct DensityRegion {
    pub(crate) bounds: Bounds<3>,
    pub(crate) density: Polynomial,
}

impl DensityRegion {
    /// All of space.
    pub(crate) fn everywhere(density: Polynomial) -> Self {
        let Bounds { min, max } = Bounds::empty();
        let bounds = Bounds { min: max, max: min };
        Self { bounds, density }
    }
}

impl Density {
    /// The density in each of `regions`, which fill space.
    pub(crate) fn by_regions(
        shape: &dyn DomainShape,
        regions: Vec<DensityRegion>,
    ) -> Result<Self, DomainError> {
        let whole = ShapeIntegrator::new(shape);
        let masses = regions
            .iter()
            .map(|DensityRegion { bounds, density }| whole.mass_within(bounds, density));
        let mean = masses.sum::<f64>() / shape.volume();
        if !(mean.is_normal() && mean > 0.0) {
            return Err(DomainError::Density {
                value: mean,
                position: shape.bounds().center().into(),
            });
        }
        let parts = Parts::Regions(regions);
        Ok(Self { parts, mean })
    }

    /// The density that is linear on every tetrahedron and has these values at the vertices.
    pub(crate) fn on_tets(tets: IndexedTets, values: &[f64]) -> Result<Self, DomainError> {
        let mesh = &tets.mesh;
        for (&value, vertex) in values.iter().zip(&mesh.vertices) {
            if !(value.is_finite() && value > 0.0) {
                let position = (*vertex).into();
                return Err(DomainError::Density { value, position });
            }
        }
        let mut mass = 0.0;
        let mut linear = Vec::with_capacity(mesh.tets.len());
        for (vertices, corners) in mesh.tets.iter().zip(mesh.all_corners()) {
            let values = vertices.map(|vertex| values[vertex as usize]);
            mass += tet_volume(&corners) * values.iter().sum::<f64>() / 4.0;
            linear.push((values[0], gradient(&corners, &values)));
        }
        Ok(Self {
            mean: mass / mesh.volume(),
            parts: Parts::Tets(tets, linear),
        })
    }

    /// The mean over the domain.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Visits the signed pieces of `cell` ∩ `shape`, each with its density as a polynomial in the
    /// same coordinates, those relative to `site`.
    pub(crate) fn pieces(
        &self,
        shape: &dyn DomainShape,
        site: &Point3<f64>,
        cell: &Polyhedron,
        scratch: &mut PieceScratch,
        visit: &mut dyn FnMut(f64, Piece<'_>, Option<&Polynomial>),
    ) {
        let regions = match &self.parts {
            Parts::Regions(regions) => regions,
            Parts::Tets(tets, linear) => {
                return tets.visit_parts(site, cell, scratch, |tet, part| {
                    let (value, gradient) = linear[tet as usize];
                    let corner = tets.mesh.vertices[tets.mesh.tets[tet as usize][0] as usize];
                    let at_site = value - gradient.dot(&(corner - site));
                    let density = Polynomial::linear(at_site, &gradient);
                    visit(1.0, Piece::Convex(part), Some(&density));
                });
            }
        };
        let around = cell.bounds().translated(&site.coords);
        let near = |region: &&DensityRegion| region.bounds.overlaps(&around);
        for DensityRegion { bounds, density } in regions.iter().filter(near) {
            let density = density.relative_to(site);
            let mut weigh = |sign: f64, piece: Piece<'_>| visit(sign, piece, Some(&density));
            if bounds.contains(&around.min) && bounds.contains(&around.max) {
                return shape.pieces(site, cell, scratch, &mut weigh);
            }
            let mut part = std::mem::take(&mut scratch.part);
            part.assign_translated(cell, &Vector3::zeros());
            if clip_to_box(&mut part, site, bounds, &mut scratch.clip) {
                shape.signed_pieces(site, &part, false, scratch, &mut weigh);
            }
            scratch.part = part;
        }
    }
}

/// The gradient of the linear function with these values at a tetrahedron's corners; zero for a flat one.
fn gradient(corners: &[Point3<f64>; 4], values: &[f64; 4]) -> Vector3<f64> {
    let edges = [1, 2, 3].map(|k| corners[k] - corners[0]);
    let rises = Vector3::from([1, 2, 3].map(|k| values[k] - values[0]));
    let rows = Matrix3::from_columns(&edges).transpose();
    rows.lu().solve(&rises).unwrap_or_default()
}

/// A shape with the convex polyhedron around it from which the cell of the middle of its bounds
/// would be cut, relative to that middle.
struct ShapeIntegrator<'a> {
    shape: &'a dyn DomainShape,
    middle: Point3<f64>,
    start: Polyhedron,
}

impl<'a> ShapeIntegrator<'a> {
    fn new(shape: &'a dyn DomainShape) -> Self {
        let (middle, mut start) = (shape.bounds().center(), Polyhedron::default());
        shape.start(&middle, 0, &mut start);
        Self {
            shape,
            middle,
            start,
        }
    }

    /// ∫ density over what the shape and the box have in common.
    fn mass_within(&self, bounds: &Bounds<3>, density: &Polynomial) -> f64 {
        let (middle, mut scratch) = (&self.middle, PieceScratch::default());
        let mut part = self.start.clone();
        if !clip_to_box(&mut part, middle, bounds, &mut scratch.clip) {
            return 0.0;
        }
        let density = density.relative_to(middle);
        let mut mass = 0.0;
        let mut add = |sign: f64, piece: Piece<'_>| mass += sign * of_piece(piece, &density).mass;
        self.shape
            .signed_pieces(middle, &part, false, &mut scratch, &mut add);
        mass
    }

    /// Whether the shape fills a part of the box, however small beyond rounding.
    fn fills_some(&self, bounds: &Bounds<3>) -> bool {
        let volume = self.mass_within(bounds, &Polynomial::constant(1.0));
        let rounding = f64::EPSILON * self.shape.bounds().volume();
        volume > rounding
    }

    /// A corner of the box, in the shape, at which the polynomial has a refused value, and that value.
    fn refused_corner(
        &self,
        part: &Bernstein,
        is_valid: impl Fn(f64) -> bool,
    ) -> Option<([f64; 3], f64)> {
        let mut corners = part.corners();
        let refused = corners.find(|(corner, value)| {
            let is_refused = !is_valid(*value);
            is_refused && self.shape.contains(corner)
        });
        refused.map(|(corner, value)| (corner.into(), value))
    }
}

/// Clips `part`, in coordinates relative to `site`, to the box, whose infinite sides cut nothing,
/// and returns whether anything is left.
fn clip_to_box(
    part: &mut Polyhedron,
    site: &Point3<f64>,
    bounds: &Bounds<3>,
    scratch: &mut ClipScratch,
) -> bool {
    for axis in 0..3 {
        let mut normal = Vector3::zeros();
        normal[axis] = 1.0;
        let upper = bounds.max[axis] - site[axis];
        let lower = site[axis] - bounds.min[axis];
        for (normal, offset) in [(normal, upper), (-normal, lower)] {
            let side = HalfSpace { normal, offset };
            let label = FacetKind::Inner.label();
            if offset.is_finite() && clip(part, &side, label, scratch) == Clip::Emptied {
                return false;
            }
        }
    }
    true
}

/// Refuses a density that is not positive somewhere in the domain: the domain's box is halved until
/// Bernstein's bounds or the value at a corner decide.
///
/// # Errors
/// [`DomainError::Density`] with a place.
pub(crate) fn check_positive(
    shape: &dyn DomainShape,
    density: &Polynomial,
) -> Result<(), DomainError> {
    let whole = ShapeIntegrator::new(shape);
    let mut rest = vec![(Bernstein::new(density, &shape.bounds()), 0)];
    while let Some((part, halvings)) = rest.pop() {
        let [low, high] = part.range();
        if low >= 0.0 && high > 0.0 {
            continue;
        }
        if let Some((position, value)) = refused_density(&whole, &part) {
            return Err(DomainError::Density { value, position });
        }
        if high > 0.0 && halvings < SIGN_HALVINGS {
            let halves = part.halves(part.steepest_axis()).into_iter();
            rest.extend(halves.map(|half| (half, halvings + 1)));
        }
    }
    Ok(())
}

/// A place in the box at which the density is not positive or not finite, and its value or a bound.
fn refused_density(whole: &ShapeIntegrator<'_>, part: &Bernstein) -> Option<([f64; 3], f64)> {
    let is_valid = |value: f64| value.is_finite() && value >= 0.0;
    let [_, high] = part.range();
    whole.refused_corner(part, is_valid).or_else(|| {
        let is_refused = high <= 0.0 && whole.fills_some(part.bounds());
        is_refused.then(|| (part.bounds().center().into(), high))
    })
}

/// The boxes and densities for cells whose edge is `size`, of energies of order `order`.
///
/// # Errors
/// When the size is not positive somewhere in the domain, changes too fast, or has too high a
/// degree.
pub(crate) fn regions(
    shape: &dyn DomainShape,
    size: &Polynomial,
    order: u32,
) -> Result<Vec<DensityRegion>, DomainError> {
    let degree = size.degree();
    if degree > HIGHEST_DEGREE {
        let highest = HIGHEST_DEGREE;
        return Err(DomainError::SizeDegree { degree, highest });
    }
    let whole = ShapeIntegrator::new(shape);
    let exponent = 3 + order as i32;
    let change = LARGEST_CHANGE.powf(1.0 / f64::from(exponent));
    let all = DensityRegion::everywhere(Polynomial::default()).bounds;
    let mut rest = vec![(Bernstein::new(size, &shape.bounds()), all, 0)];
    let mut regions = Vec::new();
    while let Some((part, bounds, halvings)) = rest.pop() {
        let [low, high] = part.range();
        if low > 0.0 && high <= low * change {
            let density = parabola(size, low, high, exponent);
            regions.push(DensityRegion { bounds, density });
            continue;
        }
        if low <= 0.0 {
            if let Some((position, value)) = whole.refused_corner(&part, |value| value > 0.0) {
                return Err(DomainError::Size { value, position });
            }
            if !whole.fills_some(&bounds) {
                continue;
            }
        }
        if high <= 0.0 || halvings == SIZE_HALVINGS || regions.len() + rest.len() >= MOST_REGIONS {
            let value = low.max(0.0);
            return Err(DomainError::SizeTooSteep {
                value,
                change: high - value,
                position: part.bounds().center().into(),
            });
        }
        let axis = part.steepest_axis();
        let middle = part.bounds().center()[axis];
        let [lower, upper] = part.halves(axis);
        let (mut below, mut above) = (bounds, bounds);
        below.max[axis] = middle;
        above.min[axis] = middle;
        rest.push((upper, above, halvings + 1));
        rest.push((lower, below, halvings + 1));
    }
    Ok(regions)
}

/// The parabola in h through h^−exponent at `low`, `high` and between, with `size` for h.
fn parabola(size: &Polynomial, low: f64, high: f64, exponent: i32) -> Polynomial {
    let middle = 0.5 * (low + high);
    let half = 0.5 * (high - low);
    let [a, b, c] = [low, middle, high].map(|h| h.powi(-exponent));
    if half <= 0.0 {
        return Polynomial::constant(b);
    }
    // In u = (h − middle)/half: b + (c − a)/2 u + (a − 2b + c)/2 u².
    let u = (size.clone() + Polynomial::constant(-middle)) * Polynomial::constant(1.0 / half);
    let square = u.clone() * u.clone();
    Polynomial::constant(b)
        + u * Polynomial::constant(0.5 * (c - a))
        + square * Polynomial::constant(0.5 * (a - 2.0 * b + c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain::cuboid::Cuboid;
    use nalgebra::Point3;

    #[test]
    fn densities_are_those_of_the_size_everywhere() {
        for (text, order) in [
            ("0.1 + 0.2*x", 1),
            ("0.05 + 0.1*(x - 0.5)^2 + 0.1*y*z", 1),
            ("0.3", 1),
            ("0.2 - 0.1*z", 4),
        ] {
            let size: Polynomial = text.parse().expect("a polynomial");
            let regions = regions(&Cuboid::unit(), &size, order).expect("it is positive");
            for k in 0..1000_u32 {
                let share = |k: u32| (f64::from(k) + 0.5) / 10.0;
                let place = Point3::new(share(k % 10), share(k / 10 % 10), share(k / 100));
                let mut here = regions.iter().filter(|part| part.bounds.contains(&place));
                let density = here
                    .next()
                    .expect("boxes fill the domain")
                    .density
                    .at(&place);
                let wanted = size.at(&place).powi(-3 - order as i32);
                assert!((density / wanted - 1.0).abs() < 6e-3, "{text} at {place}");
            }
        }
    }

    #[test]
    fn sizes_that_reach_zero_are_refused() {
        for text in ["x", "0.1 - x", "(x - 0.3)^2", "(x - 0.5)^2", "-1"] {
            let size: Polynomial = text.parse().expect("a polynomial");
            let refused = regions(&Cuboid::unit(), &size, 1)
                .expect_err(text)
                .to_string();
            assert!(refused.contains("size"), "{text}: {refused}");
        }
    }
}
