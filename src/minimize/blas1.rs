//! Dot products, scaled sums and norms of long vectors, in an order that depends on their length only.

/// Partial sums kept side by side, so that the compiler may use vector registers.
const LANES: usize = 8;

/// `a · b`; the shorter length counts. Bit-identical when `a` and `b` are exchanged.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let length = a.len().min(b.len());
    let (a_chunks, a_rest) = a[..length].as_chunks::<LANES>();
    let (b_chunks, b_rest) = b[..length].as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, b) in a_chunks.iter().zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

/// `a · (end − start)`, as [`dot`] of the difference would be to the bit.
pub(crate) fn dot_difference(a: &[f64], end: &[f64], start: &[f64]) -> f64 {
    let length = a.len().min(end.len()).min(start.len());
    let (a_chunks, a_rest) = a[..length].as_chunks::<LANES>();
    let (end_chunks, end_rest) = end[..length].as_chunks::<LANES>();
    let (start_chunks, start_rest) = start[..length].as_chunks::<LANES>();
    let mut sums = [0.0; LANES];
    for (a, (end, start)) in a_chunks.iter().zip(end_chunks.iter().zip(start_chunks)) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * (end[lane] - start[lane]);
        }
    }
    let ways = end_rest
        .iter()
        .zip(start_rest)
        .map(|(end, start)| end - start);
    let rest: f64 = a_rest.iter().zip(ways).map(|(a, way)| a * way).sum();
    sums.iter().sum::<f64>() + rest
}

/// `target += factor · source`.
pub(crate) fn add_scaled(target: &mut [f64], factor: f64, source: &[f64]) {
    for (target, source) in target.iter_mut().zip(source) {
        *target += factor * source;
    }
}

/// `max(0, largest Euclidean length of `group` consecutive entries)`.
pub(crate) fn largest_group(vector: &[f64], group: usize) -> f64 {
    vector
        .chunks(group.max(1))
        .map(|entries| entries.iter().map(|x| x * x).sum::<f64>())
        .fold(0.0, f64::max)
        .sqrt()
}

/// `max(0, largest Euclidean distance of `group` consecutive entries)`.
pub(crate) fn farthest_group(end: &[f64], start: &[f64], group: usize) -> f64 {
    let groups = end.chunks(group.max(1)).zip(start.chunks(group.max(1)));
    let squares = groups.map(|(end, start)| {
        let ways = end.iter().zip(start).map(|(end, start)| end - start);
        ways.map(|way| way * way).sum::<f64>()
    });
    squares.fold(0.0, f64::max).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_cover_whole_chunks_and_the_rest() {
        let numbers: Vec<f64> = (0..21).map(f64::from).collect();
        assert!((dot(&numbers, &numbers) - 2870.0).abs() < 1e-12);
        let half: Vec<f64> = numbers.iter().map(|x| 0.1 * x).collect();
        let way: Vec<f64> = numbers.iter().zip(&half).map(|(x, y)| x - y).collect();
        let [one, other] = [dot(&half, &way), dot_difference(&half, &numbers, &half)];
        assert_eq!(one.to_bits(), other.to_bits());
        assert!((farthest_group(&numbers, &half, 3) - largest_group(&way, 3)).abs() < 1e-15);
        assert!((largest_group(&[3.0, 4.0, 0.0, -1.0], 2) - 5.0).abs() < 1e-15);
    }
}
