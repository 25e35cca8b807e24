//! Which sites of the plane have a diagram.

use nalgebra::Point2;

use crate::domain::planar::PlaneDomain;
use crate::voronoi::plane::PlaneDiagramError;

/// Whether `sites` have a diagram in `domain`; of several flaws the first is named.
pub(crate) fn check(domain: &PlaneDomain, sites: &[Point2<f64>]) -> Result<(), PlaneDiagramError> {
    if sites.is_empty() {
        return Err(PlaneDiagramError::NoSites);
    }
    for (site, point) in sites.iter().enumerate() {
        let Point2 { coords } = point;
        let (x, y) = (coords.x, coords.y);
        if !(x.is_finite() && y.is_finite()) {
            return Err(PlaneDiagramError::NotFinite { site, x, y });
        }
        if !domain.contains(point) {
            return Err(PlaneDiagramError::Outside { site, x, y });
        }
    }
    check_distinct(sites)
}

fn check_distinct(sites: &[Point2<f64>]) -> Result<(), PlaneDiagramError> {
    // Adding zero makes −0 and 0 equal in the total order as well.
    let key = |&site: &usize| (sites[site].x + 0.0, sites[site].y + 0.0);
    let mut order: Vec<usize> = (0..sites.len()).collect();
    order.sort_by(|a, b| {
        let ((ax, ay), (bx, by)) = (key(a), key(b));
        ax.total_cmp(&bx).then(ay.total_cmp(&by)).then(a.cmp(b))
    });
    let pair = order
        .windows(2)
        .filter(|pair| sites[pair[0]] == sites[pair[1]])
        .min();
    match pair {
        Some(pair) => Err(PlaneDiagramError::Duplicate {
            first: pair[0],
            second: pair[1],
            x: sites[pair[0]].x,
            y: sites[pair[0]].y,
        }),
        None => Ok(()),
    }
}
