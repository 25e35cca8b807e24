//! Standing as conditions on a body's center: over the hull of its contacts, or over a place.
//!
//! With the outward normal n of an edge through p, the margin μ and a ground that may tilt by θ to any side,
//! the center C stays over the polygon where (n + tan θ up)·(C − p) ≤ −μ, p on the ground.

use nalgebra::{Point2, Point3, Unit, Vector3};

use crate::balance::conditions::Condition;

/// A direction up and two across it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Upright {
    pub(crate) up: Unit<Vector3<f64>>,
    across: [Vector3<f64>; 2],
}

impl Upright {
    /// `None` without a length.
    pub(crate) fn new(up: &Vector3<f64>) -> Option<Self> {
        let up = Unit::try_new(up / up.amax(), 0.5)?;
        let helper = Vector3::ith(up.iamin(), 1.0);
        let first = helper.cross(&up).normalize();
        // Seen from above, x and y themselves.
        let across = if up.z >= 1.0 {
            [Vector3::x(), Vector3::y()]
        } else {
            [first, up.cross(&first)]
        };
        Some(Self { up, across })
    }

    /// The place seen along gravity.
    pub(crate) fn flat(&self, point: &Point3<f64>) -> Point2<f64> {
        let [x, y] = self.across.map(|direction| direction.dot(&point.coords));
        Point2::new(x, y)
    }

    pub(crate) fn height(&self, point: &Point3<f64>) -> f64 {
        self.up.dot(&point.coords)
    }

    /// The point over a flat place at a height.
    fn at(&self, place: &Point2<f64>, height: f64) -> Point3<f64> {
        let [u, v] = self.across;
        Point3::from(u * place.x + v * place.y + self.up.as_ref() * height)
    }

    /// The center lies over `place`.
    pub(crate) fn over(&self, place: &Point2<f64>) -> Vec<Condition> {
        let at = self.at(place, 0.0);
        let level = |direction: &Vector3<f64>| Condition::center_level(&at, direction);
        self.across.iter().map(level).collect()
    }
}

/// A polygon on the ground.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Support {
    pub(crate) upright: Upright,
    /// The ground's height.
    pub(crate) ground: f64,
    /// Corners of the convex hull, counterclockwise.
    pub(crate) corners: Vec<Point2<f64>>,
}

impl Support {
    /// The hull of contacts; `None` if they have no area.
    pub(crate) fn new(upright: Upright, ground: f64, contacts: &[Point2<f64>]) -> Option<Self> {
        let corners = convex_hull(contacts);
        (corners.len() > 2).then_some(Self {
            upright,
            ground,
            corners,
        })
    }

    /// Corner and outward normal of each edge.
    fn edges(&self) -> impl Iterator<Item = (Point3<f64>, Vector3<f64>)> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(from, to)| {
            let way = (to - from).normalize();
            let [u, v] = self.upright.across;
            (self.upright.at(from, self.ground), u * way.y - v * way.x)
        })
    }

    /// The center lies over the polygon, `margin` within it, on ground tilted by `degrees` to any side.
    pub(crate) fn conditions(&self, margin: f64, degrees: f64) -> Vec<Condition> {
        let tilt = degrees.to_radians().tan();
        let edge = |(corner, normal): (Point3<f64>, Vector3<f64>)| {
            let gradient = normal + self.upright.up.as_ref() * tilt;
            Condition::affine(&corner, -margin, -gradient).at_least()
        };
        self.edges().map(edge).collect()
    }

    /// How far within the polygon a center lies, and by how many degrees the ground may tilt.
    pub(crate) fn slack(&self, center: &Point3<f64>) -> [f64; 2] {
        let inside =
            |(corner, normal): (Point3<f64>, Vector3<f64>)| -normal.dot(&(center - corner));
        let least = self.edges().map(inside).fold(f64::INFINITY, f64::min);
        let height = self.upright.height(center) - self.ground;
        [least, least.atan2(height).to_degrees()]
    }
}

/// The convex hull, counterclockwise, by Andrew's chains (*Another efficient algorithm for convex hulls in
/// two dimensions*, 1979).
pub(crate) fn convex_hull(points: &[Point2<f64>]) -> Vec<Point2<f64>> {
    let mut sorted: Vec<_> = points.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    sorted.dedup();
    let chain = |points: &mut dyn Iterator<Item = &Point2<f64>>| {
        let mut chain: Vec<Point2<f64>> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp(&(point - b)) <= 0.0
            {
                chain.pop();
            }
            chain.push(*point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut sorted.iter());
    hull.extend(chain(&mut sorted.iter().rev()));
    hull
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::moments::Moments;

    #[test]
    fn a_hull_holds_all_points_and_has_no_others() {
        let mut points = Vec::new();
        for k in 0..200 {
            let (sine, cosine) = (f64::from(k) * 2.4).sin_cos();
            let radius = f64::from(k % 10 + 1) / 10.0;
            points.push(Point2::new(radius * cosine, 0.5 * radius * sine));
        }
        let hull = convex_hull(&points);
        assert!(hull.len() > 10 && hull.iter().all(|corner| points.contains(corner)));
        let support = Support::new(Upright::new(&Vector3::z()).unwrap(), 0.0, &points).unwrap();
        for point in &points {
            let [inside, _] = support.slack(&Point3::new(point.x, point.y, 1.0));
            assert!(inside > -1e-12, "{point}");
        }
        assert_eq!(convex_hull(&points[..1]).len(), 0);
    }

    #[test]
    fn conditions_say_what_slack_says() {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(Point2::from);
        for up in [Vector3::z(), Vector3::new(1.0, 2.0, -0.5), -Vector3::x()] {
            let upright = Upright::new(&up).unwrap();
            let support = Support::new(upright, 0.3, &square).unwrap();
            for place in [[0.0, 0.0], [0.5, 0.2], [0.9, -0.3], [1.2, 0.0]] {
                let center = upright.at(&place.into(), 2.3);
                let [inside, degrees] = support.slack(&center);
                let expected = 1.0 - f64::max(place[0].abs(), place[1].abs());
                assert!((inside - expected).abs() < 1e-12);
                let body = Moments {
                    mass: 3.0,
                    first: center.coords * 3.0,
                    ..Moments::default()
                };
                let holds = |margin: f64, tilt: f64| {
                    let conditions = support.conditions(margin, tilt);
                    let least = conditions
                        .iter()
                        .map(|one| one.of(&body, &Point3::origin()));
                    least.fold(f64::INFINITY, f64::min) >= 0.0
                };
                assert!(holds(inside - 1e-9, 0.0) && !holds(inside + 1e-9, 0.0));
                if degrees > 0.0 {
                    assert!(holds(0.0, degrees - 1e-6) && !holds(0.0, degrees + 1e-6));
                }
            }
            let over = upright.over(&Point2::new(0.4, 0.1));
            let center = upright.at(&Point2::new(0.4, 0.1), 7.0);
            for condition in &over {
                assert!(condition.at(&center).abs() < 1e-12);
            }
        }
    }
}
