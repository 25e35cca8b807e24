//! The periodic images in which a site's neighbors are looked for.

use nalgebra::Vector3;

/// A periodic image: by how many periods, and how far (L).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// How many periods along each axis.
    pub image: [i8; 3],
    /// The displacement.
    pub by: Vector3<f64>,
}

/// The image itself first, then its periodic copies.
pub(crate) fn shifts(periods: [Option<f64>; 3]) -> Vec<Shift> {
    let copies = periods.map(|period| {
        if period.is_some() {
            &[0, 1, -1][..]
        } else {
            &[0]
        }
    });
    let mut shifts = Vec::new();
    for &z in copies[2] {
        for &y in copies[1] {
            for &x in copies[0] {
                let image = [x, y, z];
                let by = |axis: usize| f64::from(image[axis]) * periods[axis].unwrap_or(0.0);
                shifts.push(Shift {
                    image,
                    by: Vector3::new(by(0), by(1), by(2)),
                });
            }
        }
    }
    shifts
}
