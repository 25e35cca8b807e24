//! Fragments along the axes of space, and their tetrahedra.

use nalgebra::{Point3, Rotation3};

use crate::energy::fragments::fragments_in_frame;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;

/// The fragments of `piece` about `center`.
pub(crate) fn fragments(piece: &Polyhedron, center: &Point3<f64>, label: Label) -> [Polyhedron; 6] {
    fragments_in_frame(piece, center, &Rotation3::identity(), label)
}

/// The tetrahedra of a fragment: `center` with the fan triangles of every facet (\[BL\] section
/// 3.5). Those on facets through the center are flat.
pub(crate) fn tetrahedra<'a>(
    fragment: &'a Polyhedron,
    center: &'a Point3<f64>,
) -> impl Iterator<Item = [Point3<f64>; 4]> + 'a {
    fragment.facets().flat_map(move |facet| {
        let mut corners = facet.corners();
        let anchor = corners.next();
        let rest: Vec<_> = corners.collect();
        let fan = move |(a, b): (Point3<f64>, Point3<f64>)| anchor.map(|q| [*center, q, a, b]);
        let pairs: Vec<_> = rest
            .iter()
            .copied()
            .zip(rest.iter().copied().skip(1))
            .collect();
        pairs.into_iter().filter_map(fan)
    })
}
