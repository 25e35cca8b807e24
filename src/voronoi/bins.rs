//! Into how many bins a box of sites is divided along each axis.

use nalgebra::Vector3;

/// Three sites a bin: the 3×3×3 block around a site then holds about 81, of which a typical cell
/// needs the nearest 30.
const SITES_PER_BIN: f64 = 3.0;

/// Bins per axis: near-cubic ones along the axes that are longer than a bin, one along the others.
pub(crate) fn bin_counts(extent: Vector3<f64>, sites: usize) -> [usize; 3] {
    let bins = (sites as f64 / SITES_PER_BIN).max(1.0);
    let mut long = [0, 1, 2].map(|axis| extent[axis] > 0.0);
    loop {
        let lengths: Vec<f64> = (0..3).filter(|&k| long[k]).map(|k| extent[k]).collect();
        if lengths.is_empty() {
            return [1; 3];
        }
        // The geometric mean by logarithms: the product of three extents may underflow.
        let sum: f64 = lengths.iter().map(|length| length.ln()).sum();
        let width = ((sum - bins.ln()) / lengths.len() as f64).exp();
        let short = (0..3).find(|&axis| long[axis] && extent[axis] < width);
        match short {
            Some(axis) if lengths.len() > 1 => long[axis] = false,
            _ => {
                let count = |axis: usize| (extent[axis] / width).round().max(1.0) as usize;
                return [0, 1, 2].map(|axis| if long[axis] { count(axis) } else { 1 });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_are_near_cubic_and_flat_axes_have_one() {
        assert_eq!(bin_counts(Vector3::new(1.0, 1.0, 1.0), 3000), [10, 10, 10]);
        assert_eq!(bin_counts(Vector3::new(4.0, 2.0, 1.0), 3 * 512), [16, 8, 4]);
        assert_eq!(bin_counts(Vector3::new(1.0, 1.0, 0.0), 300), [10, 10, 1]);
        assert_eq!(bin_counts(Vector3::new(1e3, 1.0, 1.0), 30), [10, 1, 1]);
        assert_eq!(bin_counts(Vector3::zeros(), 5), [1, 1, 1]);
    }
}
