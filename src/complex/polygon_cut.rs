//! Polygons cut into triangles along diagonals so that the worst triangle is best.

/// The triangles, by places in the polygon and in its sense, of the triangulation whose least `worth` is
/// greatest: all triangulations by Klincsek's recursion over sub-polygons, O(n³).
#[must_use]
pub(crate) fn cut_polygon(count: usize, worth: impl Fn([usize; 3]) -> f64) -> Vec<[usize; 3]> {
    // best[i][j]: the least worth over the polygon i, i + 1, …, j, and the third corner at its chord.
    let mut best = vec![vec![(f64::INFINITY, 0); count]; count];
    for length in 2..count {
        for start in 0..count - length {
            let end = start + length;
            let choices = (start + 1..end).map(|middle| {
                let parts = best[start][middle].0.min(best[middle][end].0);
                (parts.min(worth([start, middle, end])), middle)
            });
            let first = (f64::NEG_INFINITY, start + 1);
            best[start][end] = choices.fold(
                first,
                |best, choice| {
                    if choice.0 > best.0 { choice } else { best }
                },
            );
        }
    }
    let mut triangles = Vec::new();
    let mut chords = vec![(0, count - 1)];
    while let Some((start, end)) = chords.pop() {
        if end - start >= 2 {
            let middle = best[start][end].1;
            triangles.push([start, middle, end]);
            chords.extend([(start, middle), (middle, end)]);
        }
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_better_of_all_triangulations_is_found() {
        // Worth by a fixed table; brute force over the five triangulations of a pentagon, all fans.
        let value = |[a, b, c]: [usize; 3]| ((a * 31 + b * 17 + c * 7) % 11) as f64;
        let fan = |apex: usize| {
            let triangles = (1..4).map(|step| {
                let mut places = [apex, (apex + step) % 5, (apex + step + 1) % 5];
                places.sort_unstable();
                value(places)
            });
            triangles.fold(f64::INFINITY, f64::min)
        };
        let wanted = (0..5).map(fan).fold(f64::NEG_INFINITY, f64::max);
        let cut = cut_polygon(5, value);
        assert_eq!(cut.len(), 3);
        let found = cut.into_iter().map(value).fold(f64::INFINITY, f64::min);
        assert_eq!(
            found.total_cmp(&wanted),
            std::cmp::Ordering::Equal,
            "{found} {wanted}"
        );
    }
}
