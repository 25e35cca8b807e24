//! Fields as the background density of cells: a polynomial in each of the regions that fill space.
//!
//! Clamps and profiles are cut at the planes where they bend, and fields of cells at those cells'
//! bisectors: both exactly. Other fields are cubics in boxes, and how far they are off is told.

use nalgebra::Point3;

use crate::domain::density_fit::{FittedDensity, fitted};
use crate::domain::density_region::{DensityRegion, everywhere};
use crate::domain::domain::{Domain, WeightedDomain};
use crate::domain::facet_kind::FacetKind;
use crate::domain::shape::DomainShape;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::polynomial::Polynomial;
use crate::mass::density::SolidDensity;
use crate::mass::numeric::FormulaField;
use crate::mass::profile::Profile;
use crate::mesh::surface::SurfaceMesh;
use crate::scene::error::Error;
use crate::scene::field::Field;
use crate::voronoi::diagram::Diagram;

/// `domain` with a field as density, and a note where that is not exact; with `size` the field is the
/// wanted edge h of cells, the density h^`size`.
///
/// # Errors
/// When the field is not positive, or not of this domain.
pub(crate) fn by_field(
    domain: Box<dyn Domain>,
    field: &Field,
    size: Option<i32>,
) -> Result<(WeightedDomain, Option<String>), Error> {
    if domain.periods().iter().any(Option::is_some) {
        let message =
            "of a periodic domain it is a polynomial that does not change along the period";
        return Err(Error::value("density", message));
    }
    let (regions, note) = match (field, size) {
        (Field::Cells { sites, values }, _) => {
            let of_value = |value: f64| size.map_or(value, |exponent| value.powi(exponent));
            let values: Vec<f64> = values.iter().map(|&value| of_value(value)).collect();
            (cell_regions(&*domain, sites, &values)?, None)
        }
        (Field::Solid(SolidDensity::Constant(value)), None) => {
            let density = Polynomial::constant(*value);
            return Ok((WeightedDomain::new(domain, density)?, None));
        }
        (Field::Solid(SolidDensity::Polynomial(density)), None) => {
            return Ok((WeightedDomain::new(domain, density.clone())?, None));
        }
        (Field::Solid(SolidDensity::Ramp(ramp)), None) => {
            let linear = ramp.over(&domain.bounds(), &Point3::origin());
            let density = Polynomial::linear(linear.value, &linear.gradient);
            return Ok((WeightedDomain::new(domain, density)?, None));
        }
        (Field::Solid(SolidDensity::Profile(profile)), None) => (layers(profile)?, None),
        _ => {
            let shape: &dyn DomainShape = &*domain;
            let value = function(field, shape)?;
            let power = |place: &Point3<f64>| match size {
                Some(exponent) => value(place).powi(exponent),
                None => value(place),
            };
            let FittedDensity { regions, error } = fitted(shape, &power)?;
            let (count, percent) = (regions.len(), 100.0 * error);
            let note = format!(
                "the density is approximated by cubics in {count} boxes, within {percent:.2} % of its \
                 largest value in each"
            );
            (regions, Some(note))
        }
    };
    Ok((WeightedDomain::by_regions(domain, regions)?, note))
}

/// The value at a point.
type ValueAt<'a> = Box<dyn Fn(&Point3<f64>) -> f64 + 'a>;

/// A field without vertex data as a function of position.
fn function<'a>(field: &'a Field, shape: &dyn DomainShape) -> Result<ValueAt<'a>, Error> {
    Ok(match field {
        Field::Radial(density) => Box::new(|place| density.at(place)),
        Field::Formula(formula) => {
            let field = FormulaField::new(formula, || surface(shape));
            Box::new(move |place| field.at(place, &mut 0))
        }
        Field::Solid(SolidDensity::Constant(value)) => Box::new(|_| *value),
        Field::Solid(SolidDensity::Polynomial(polynomial)) => Box::new(|at| polynomial.at(at)),
        Field::Solid(SolidDensity::Profile(profile)) => Box::new(|at| profile.at_point(at)),
        Field::Solid(SolidDensity::Ramp(ramp)) => {
            let origin = shape.bounds().center();
            let linear = ramp.over(&shape.bounds(), &origin);
            Box::new(move |at| linear.value + linear.gradient.dot(&(at - origin)))
        }
        Field::Solid(SolidDensity::Vertex(_) | SolidDensity::VertexRamp(_))
        | Field::Vertices(_)
        | Field::Tets(_)
        | Field::Sampled(_)
        | Field::Cells { .. } => {
            let message = "values at vertices give the density of a solid only where tetrahedra \
                           fill it, {\"tets\": …}";
            return Err(Error::value("density", message));
        }
    })
}

/// The layers of a profile.
fn layers(profile: &Profile) -> Result<Vec<DensityRegion>, Error> {
    let (breaks, direction) = (profile.breaks(), profile.direction());
    if let Some([place, value]) = breaks.iter().find(|[_, value]| *value < 0.0) {
        let message = format!("it is {value} at {place} along {direction:?}; give a positive one");
        return Err(Error::value("density", message));
    }
    let ends = |number: usize| {
        let start = number.checked_sub(1).map(|before| breaks[before][0]);
        (start, breaks.get(number).map(|pair| pair[0]))
    };
    let layer = |number: usize| {
        let (start, end) = ends(number);
        let below = end.map(|offset| HalfSpace {
            normal: *direction,
            offset,
        });
        let above = start.map(|start| HalfSpace {
            normal: -direction,
            offset: -start,
        });
        let density = profile.linear_in(number);
        let planes = below.into_iter().chain(above).collect();
        let greatest = profile.greatest_in(number);
        DensityRegion::within(everywhere(), planes, density, greatest)
    };
    Ok((0..=breaks.len()).map(layer).collect())
}

/// The Voronoi cells of `sites` with their densities; in and about the domain they fill space.
fn cell_regions(
    domain: &dyn Domain,
    sites: &[Point3<f64>],
    values: &[f64],
) -> Result<Vec<DensityRegion>, Error> {
    if let Some(number) = values
        .iter()
        .position(|value| value.is_nan() || *value <= 0.0)
    {
        let message = format!(
            "the field's cell {number} has the value {}; all must be positive",
            values[number]
        );
        return Err(Error::value("density", message));
    }
    let refused = |error: &dyn std::fmt::Display| Error::value("density", error.to_string());
    let diagram = Diagram::borrowed(domain, sites).map_err(|error| refused(&error))?;
    let cells = diagram.map_cells(|cell| {
        let site = cell.position;
        let polyhedron = cell.polyhedron();
        let reach = domain.bounds().extent() * OPEN;
        let planes = polyhedron
            .facets()
            .filter_map(|facet| match FacetKind::of(facet.label()) {
                FacetKind::Neighbor { site: other, .. } => {
                    Some(bisector(&site, &sites[other as usize]))
                }
                FacetKind::Wall(_) | FacetKind::Inner => None,
            });
        let bounds = polyhedron.bounds().translated(&site.coords).grown(&reach);
        (planes.collect(), bounds)
    });
    let cells = cells.map_err(|error| refused(&error))?;
    let regions = cells
        .into_iter()
        .zip(values)
        .map(|((planes, bounds), &value)| {
            DensityRegion::within(bounds, planes, Polynomial::constant(value), value)
        });
    Ok(regions.collect())
}

/// How far a cell's box reaches beyond the cell, as a share of the domain's extent, so that its planes
/// bound it and not its box.
const OPEN: f64 = 1e-6;

/// The points nearer to `site`, the same plane from both sides to the last bit.
fn bisector(site: &Point3<f64>, other: &Point3<f64>) -> HalfSpace {
    let normal = other - site;
    HalfSpace {
        normal,
        offset: 0.5 * normal.dot(&(other.coords + site.coords)),
    }
}

/// The boundary of a shape, of a convex one that of the polyhedron from which its cells are cut.
fn surface(shape: &dyn DomainShape) -> SurfaceMesh {
    if let Some(mesh) = shape.surface_mesh() {
        return mesh.clone();
    }
    let (middle, mut start) = (shape.bounds().center(), Polyhedron::default());
    shape.start(&middle, 0, &mut start);
    let mut mesh = SurfaceMesh::default();
    for triangle in start.facets().flat_map(|facet| facet.triangles()) {
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(triangle.map(|corner| middle + corner));
        mesh.triangles.push([first, first + 1, first + 2]);
    }
    mesh
}
