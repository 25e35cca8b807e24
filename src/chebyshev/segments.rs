//! Segments: the parts of interfaces on a facet.
//!
//! A facet's boundary crosses interfaces, and diagonals pierce its inside. Both are endpoints of
//! segments; paired up interface by interface they make the subdivision of the facet into sectors.

use nalgebra::Vector3;

use crate::chebyshev::integrand::FacetConstants;
use crate::chebyshev::sector::{Interface, diagonal_ray, pierced};
use crate::chebyshev::visit::{FacetView, Visit};

/// Where a segment on an interface begins or ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Endpoint {
    pub(crate) interface: Interface,
    pub(crate) role: Role,
    pub(crate) point: Vector3<f64>,
}

/// What an endpoint is to a segment with the interface's first sector on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Start,
    End,
    /// The end of a segment that has been reported.
    Taken,
}

impl Role {
    pub(crate) fn start_if(is_start: bool) -> Self {
        if is_start { Self::Start } else { Self::End }
    }
}

/// Reports the segments of a facet whose boundary crosses interfaces at `endpoints`. The list is
/// used up.
pub(crate) fn report_segments(
    constants: &FacetConstants,
    view: &FacetView,
    endpoints: &mut Vec<Endpoint>,
    visitor: &mut impl Visit,
) {
    let crossed = endpoints.iter().fold(0, |set, e| set ^ e.interface.bit());
    push_diagonals(constants, view, crossed, endpoints);
    for start in 0..endpoints.len() {
        let Endpoint {
            interface,
            role: Role::Start,
            point: u,
        } = endpoints[start]
        else {
            continue;
        };
        let end = endpoints
            .iter_mut()
            .find(|end| end.interface == interface && end.role == Role::End);
        if let Some(end) = end {
            end.role = Role::Taken;
            let v = end.point;
            let doubled_area = constants
                .normal
                .dot(&(u - view.anchor).cross(&(v - view.anchor)));
            visitor.segment(view, interface, doubled_area, &u, &v);
        }
    }
}

/// Adds the points in which diagonals pierce the facet, each an endpoint of three interfaces.
fn push_diagonals(
    constants: &FacetConstants,
    view: &FacetView,
    crossed: u16,
    endpoints: &mut Vec<Endpoint>,
) {
    let mut inside = pierced(crossed);
    let seen_from_inside = view.height >= 0.0;
    let steepness = |diagonal: u8| {
        let dot = constants.normal.dot(&diagonal_ray(diagonal));
        if seen_from_inside { dot } else { -dot }
    };
    if inside.count_ones() == 4 {
        // The facet spans a whole sector: this one or the opposite.
        let balance = |set: u8| -> f64 { members(set).map(steepness).sum() };
        if balance(!inside) > balance(inside) {
            inside = !inside;
        }
    }
    for diagonal in members(inside) {
        let slope = steepness(diagonal);
        let reach = view.height.abs() / slope;
        let point = if slope > 0.0 && reach.is_finite() {
            diagonal_ray(diagonal) * reach
        } else {
            // Rounding alone says that this diagonal pierces: its triangle has no area.
            endpoints.first().map_or(view.anchor, |first| first.point)
        };
        for (interface, ends) in Interface::at_diagonal(diagonal) {
            endpoints.push(Endpoint {
                interface,
                role: Role::start_if(ends != seen_from_inside),
                point,
            });
        }
    }
}

fn members(set: u8) -> impl Iterator<Item = u8> {
    (0..8).filter(move |member| set >> member & 1 == 1)
}
