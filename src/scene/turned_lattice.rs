//! A lattice of cubes along turned axes that fits into a solid's box along them.

use nalgebra::{Point3, Rotation3, Vector3};

use crate::geometry::bounds::Bounds;

/// The centers of equal boxes along the axes of `turn`, of sides near to `edge` (L), that fill the box along
/// those axes about `vertices`.
pub(crate) fn turned_lattice(
    vertices: &[Point3<f64>],
    edge: f64,
    turn: Rotation3<f64>,
) -> impl Iterator<Item = Point3<f64>> + use<> {
    let mut bounds = Bounds::empty();
    let back = turn.inverse();
    vertices
        .iter()
        .for_each(|vertex| bounds.include(&(back * vertex)));
    let counts = bounds.extent().map(|side| (side / edge).round().max(1.0));
    let steps = bounds.extent().component_div(&counts);
    let [x, y, z] = [0, 1, 2].map(|axis| counts[axis] as usize);
    let place = move |number: usize| {
        let at = [number / (y * z), number / z % y, number % z];
        let at = Vector3::from(at.map(|along| along as f64 + 0.5));
        turn * (bounds.min + at.component_mul(&steps))
    };
    let count = if vertices.is_empty() { 0 } else { x * y * z };
    (0..count).map(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_box_is_filled_along_its_own_sides() {
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.5);
        let corners = [0, 1, 2, 3, 4, 5, 6, 7].map(|n| {
            let corner = [n & 1, n >> 1 & 1, n >> 2].map(f64::from);
            turn * Point3::new(3.0 * corner[0], 2.0 * corner[1], corner[2])
        });
        let sites: Vec<_> = turned_lattice(&corners, 0.99, turn).collect();
        assert_eq!(sites.len(), 6);
        for site in sites {
            let at = (turn.inverse() * site).coords.map(|x| x - x.floor() - 0.5);
            assert!(at.amax() < 1e-14);
        }
    }
}
