//! Segments: the parts of interfaces on a facet.
//!
//! A facet's boundary crosses interfaces, and diagonals pierce its inside. Both are endpoints of
//! segments; paired up interface by interface they make the subdivision of the facet into sectors.

use nalgebra::Vector3;

use crate::chebyshev::integrand::FacetConstants;
use crate::chebyshev::sector::{Interface, diagonal_ray, pierced};
use crate::chebyshev::visit::{FacetView, Visit};

/// Where segments begin and end on the interfaces of a facet.
#[derive(Clone, Debug)]
pub(crate) struct Endpoints {
    /// The interfaces with a start, as a set of bits, and those with an end.
    seen: [u16; 2],
    /// Per role and interface, the point.
    points: [[Vector3<f64>; Interface::COUNT]; 2],
    /// Second starts or ends on an interface. A convex facet has none but by rounding.
    spare: Vec<Endpoint>,
}

#[derive(Clone, Copy, Debug)]
struct Endpoint {
    interface: Interface,
    role: Role,
    point: Vector3<f64>,
}

/// What an endpoint is to a segment with the interface's first sector on its left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Start,
    End,
}

impl Role {
    #[inline]
    pub(crate) fn start_if(is_start: bool) -> Self {
        if is_start { Self::Start } else { Self::End }
    }
}

impl Default for Endpoints {
    fn default() -> Self {
        Self {
            seen: [0; 2],
            points: [[Vector3::zeros(); Interface::COUNT]; 2],
            spare: Vec::new(),
        }
    }
}

impl Endpoints {
    /// Forgets all endpoints.
    #[inline]
    pub(crate) fn clear(&mut self) {
        self.seen = [0; 2];
        self.spare.clear();
    }

    /// Adds an endpoint.
    #[inline]
    pub(crate) fn add(&mut self, interface: Interface, role: Role, point: Vector3<f64>) {
        let seen = &mut self.seen[role as usize];
        if *seen & interface.bit() == 0 {
            *seen |= interface.bit();
            self.points[role as usize][interface.number()] = point;
        } else {
            self.spare.push(Endpoint {
                interface,
                role,
                point,
            });
        }
    }

    /// The interfaces with an odd number of endpoints.
    fn crossed(&self) -> u16 {
        let spare = self.spare.iter().map(|endpoint| endpoint.interface.bit());
        spare.fold(self.seen[0] ^ self.seen[1], |set, bit| set ^ bit)
    }

    /// One of the points, if there are any.
    fn any_point(&self) -> Option<Vector3<f64>> {
        let [starts, ends] = self.seen;
        let (role, seen) = if starts != 0 { (0, starts) } else { (1, ends) };
        (seen != 0).then(|| self.points[role][Interface::lowest(seen).number()])
    }

    /// Pairs starts with ends of the same interface. Which of several go together makes no
    /// difference: they lie on one line, on which signed segments of the same ends add up to the same.
    fn pair(&mut self, mut report: impl FnMut(Interface, &Vector3<f64>, &Vector3<f64>)) {
        let mut both = self.seen[0] & self.seen[1];
        while both != 0 {
            let interface = Interface::lowest(both);
            let [start, end] = [0, 1].map(|role| &self.points[role][interface.number()]);
            report(interface, start, end);
            both ^= interface.bit();
        }
        while let Some(one) = self.spare.pop() {
            let Endpoint {
                interface, role, ..
            } = one;
            let partner = |other: &Endpoint| other.interface == interface && other.role != role;
            let Some(place) = self.spare.iter().position(partner) else {
                continue;
            };
            let point = self.spare.swap_remove(place).point;
            match role {
                Role::Start => report(interface, &one.point, &point),
                Role::End => report(interface, &point, &one.point),
            }
        }
    }
}

/// Reports the segments of a facet whose boundary crosses interfaces at `endpoints`. They are used
/// up.
pub(crate) fn report_segments(
    constants: &FacetConstants,
    view: &FacetView,
    endpoints: &mut Endpoints,
    visitor: &mut impl Visit,
) {
    push_diagonals(constants, view, endpoints);
    endpoints.pair(|interface, u, v| {
        let fan = (u - view.anchor).cross(&(v - view.anchor));
        visitor.segment(view, interface, constants.normal.dot(&fan), u, v);
    });
}

/// Adds the points in which diagonals pierce the facet, each an endpoint of three interfaces.
fn push_diagonals(constants: &FacetConstants, view: &FacetView, endpoints: &mut Endpoints) {
    let mut inside = pierced(endpoints.crossed());
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
            endpoints.any_point().unwrap_or(view.anchor)
        };
        for (interface, ends) in Interface::at_diagonal(diagonal) {
            endpoints.add(interface, Role::start_if(ends != seen_from_inside), point);
        }
    }
}

fn members(mut set: u8) -> impl Iterator<Item = u8> {
    std::iter::from_fn(move || {
        let member = set.trailing_zeros() as u8;
        set &= set.wrapping_sub(1);
        (member < 8).then_some(member)
    })
}
