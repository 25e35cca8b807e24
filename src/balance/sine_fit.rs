//! The density sin(k|y − p|) + 1 (\[BL\] eq. 5) fitted to conditions: p and k by least squares with gradients.
//!
//! Of places drawn at random the best are starts, descended on elements (the density at each one's centroid) by
//! Levenberg-Marquardt; where that meets the conditions, Newton's method on exact integrals over the solid's
//! surface goes on ([`sine_jet`]). Of the fields that meet them exactly, the one nearest to a constant is kept.
//! Most descents end in minima that are not zero: about 1 in 80 of random starts meets a rocker arm's
//! conditions, and 1 in 35 of the best sixteenth of them.

use nalgebra::{DMatrix, DVector, Point3, Vector4};

use crate::balance::conditions::Condition;
use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::geometry::random::Random;
use crate::integrals::sine_jet::sine_jet;
use crate::mesh::surface::SurfaceMesh;
use crate::parallel::map;

/// Steps of a descent.
const MOST_STEPS: usize = 60;

/// Residuals on elements below this share of their sizes are worth exact steps: the elements' own error.
const COARSE_GOAL: f64 = 1e-9;

/// Exact residuals below this share of their sizes are rounding.
const EXACT_GOAL: f64 = 3e-14;

/// Exact residuals that will do.
const EXACT_ENOUGH: f64 = 1e-11;

/// Gauss nodes along a triangle for the first exact steps and for the last.
const NODES: [usize; 2] = [3, 5];

/// k times the solid's diagonal is drawn between these.
const WAVES: [f64; 2] = [2.0, 40.0];

/// Places drawn for every start; a look at one costs a fortieth of a descent.
const DRAWS: usize = 16;

/// Fields nearer than this share of the solid's diagonal, and of k, are one.
const SAME: f64 = 1e-5;

/// A sine field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SineField {
    /// p.
    pub(crate) point: Point3<f64>,
    /// k.
    pub(crate) k: f64,
}

/// The best of the fields found.
#[derive(Clone, Debug)]
pub(crate) struct SineFit {
    /// None where no start led to one.
    pub(crate) field: Option<SineField>,
    /// How many starts met the conditions.
    pub(crate) met: usize,
    /// Evaluations on elements and exact ones.
    pub(crate) evaluations: [usize; 2],
}

/// What sine fields are fitted to.
pub(crate) struct SineProblem<'a> {
    /// The solid's surface.
    pub(crate) surface: &'a SurfaceMesh,
    /// Elements of it, moments from `origin`.
    pub(crate) moments: &'a [Moments],
    /// Where they are measured from.
    pub(crate) origin: Point3<f64>,
    /// Four conditions.
    pub(crate) conditions: &'a [Condition],
}

/// A point of a descent: residuals as shares of their sizes, and their derivatives by p and k.
#[derive(Clone, Debug)]
struct FitPoint {
    residual: DVector<f64>,
    jacobian: DMatrix<f64>,
}

impl SineField {
    /// The density at a point.
    pub(crate) fn at(&self, place: &Point3<f64>) -> f64 {
        (self.k * (place - self.point).norm()).sin() + 1.0
    }

    /// As `--density` takes it.
    pub(crate) fn text(&self) -> String {
        let Point3 { coords: p } = self.point;
        format!("sine:point={},{},{},k={}", p.x, p.y, p.z, self.k)
    }

    fn moved(&self, step: &DVector<f64>) -> Self {
        let way = nalgebra::Vector3::new(step[0], step[1], step[2]);
        Self {
            point: self.point + way,
            k: self.k + step[3],
        }
    }
}

impl SineProblem<'_> {
    /// Fits from so many starts.
    pub(crate) fn fit(&self, starts: usize, seed: u64) -> SineFit {
        let (rows, sizes) = (self.rows(), self.sizes());
        let on_elements = |field: &SineField| self.on_elements(field, &rows, &sizes);
        let best = self.best_of_draws(starts, seed, &on_elements);
        let found = map(best.len(), &|start| {
            descend(best[start], COARSE_GOAL, on_elements)
        });
        let descents: usize = found.iter().map(|(_, _, count)| count).sum();
        let coarse = found
            .iter()
            .filter(|(_, residual, _)| *residual <= COARSE_GOAL);
        let coarse: Vec<SineField> = coarse.map(|(field, ..)| *field).collect();
        let distinct = self.distinct(&coarse);
        let refined = map(distinct.len(), &|place| {
            let (field, starts) = distinct[place];
            (self.refine(field, &sizes), starts)
        });
        let exact = || {
            let exact = refined.iter();
            exact.filter(|((_, residual, _), _)| *residual <= EXACT_ENOUGH)
        };
        let spread = |field: &SineField| self.spread(field);
        SineFit {
            field: exact()
                .map(|((field, ..), _)| *field)
                .min_by(|one, other| spread(one).total_cmp(&spread(other))),
            met: exact().map(|(_, starts)| starts).sum(),
            evaluations: [
                descents + starts * DRAWS,
                refined.iter().map(|((_, _, count), _)| count).sum(),
            ],
        }
    }

    /// The starts of least residual among all draws.
    fn best_of_draws(
        &self,
        starts: usize,
        seed: u64,
        on_elements: &(impl Fn(&SineField) -> FitPoint + Sync),
    ) -> Vec<SineField> {
        let bounds = self.surface.bounds();
        let mut draws: Vec<(f64, u64, SineField)> = map(starts * DRAWS, &|draw| {
            let draw = draw as u64;
            let field = drawn(&bounds, &mut Random::stream(seed, draw));
            (on_elements(&field).residual.norm(), draw, field)
        });
        draws.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        draws.truncate(starts);
        draws.into_iter().map(|(.., field)| field).collect()
    }

    /// Fields that differ, and how many there were of each.
    fn distinct(&self, fields: &[SineField]) -> Vec<(SineField, usize)> {
        let extent = self.surface.bounds().extent().norm();
        let mut kept: Vec<(SineField, usize)> = Vec::new();
        for field in fields {
            let same = kept.iter_mut().find(|(other, _)| {
                (field.point - other.point).norm() < SAME * extent
                    && (field.k / other.k - 1.0).abs() < SAME
            });
            match same {
                Some((_, count)) => *count += 1,
                None => kept.push((*field, 1)),
            }
        }
        kept
    }

    /// Newton's method on exact integrals from a field that nearly does it.
    pub(crate) fn refine(&self, field: SineField, sizes: &DVector<f64>) -> (SineField, f64, usize) {
        let exact = |nodes: usize| move |field: &SineField| self.exact(field, sizes, nodes);
        let (field, _, first) = descend(field, 1e-8, exact(NODES[0]));
        let (field, residual, second) = descend(field, EXACT_GOAL, exact(NODES[1]));
        (field, residual, first + second)
    }

    /// ∫|φ_k|, by elements.
    pub(crate) fn sizes(&self) -> DVector<f64> {
        let size = |condition: &Condition| {
            let parts = self
                .moments
                .iter()
                .map(|m| condition.of(m, &self.origin).abs());
            parts.sum::<f64>()
        };
        DVector::from_iterator(self.conditions.len(), self.conditions.iter().map(size))
    }

    /// ∫ φ_k over every element.
    fn rows(&self) -> Vec<(Point3<f64>, Vec<f64>)> {
        let row = |moments: &Moments| {
            let all = self.conditions.iter().map(|c| c.of(moments, &self.origin));
            (self.origin + moments.center(), all.collect())
        };
        self.moments.iter().map(row).collect()
    }

    /// The variance of the density as a share of its squared mean.
    fn spread(&self, field: &SineField) -> f64 {
        let sums = self
            .moments
            .iter()
            .fold([0.0; 3], |[volume, mass, square], m| {
                let density = field.at(&(self.origin + m.center()));
                let weight = m.mass;
                [
                    volume + weight,
                    mass + weight * density,
                    square + weight * density * density,
                ]
            });
        let [volume, mass, square] = sums;
        square * volume / (mass * mass) - 1.0
    }

    /// The residuals where every element has the density at its centroid.
    fn on_elements(
        &self,
        field: &SineField,
        rows: &[(Point3<f64>, Vec<f64>)],
        sizes: &DVector<f64>,
    ) -> FitPoint {
        let count = sizes.len();
        let mut residual = DVector::zeros(count);
        let mut jacobian = DMatrix::zeros(count, 4);
        for (place, row) in rows {
            let (sine, slopes) = sine_at(field, place);
            for (k, weight) in row.iter().enumerate() {
                let share = weight / sizes[k];
                residual[k] += share * (sine + 1.0);
                for unknown in 0..4 {
                    jacobian[(k, unknown)] += share * slopes[unknown];
                }
            }
        }
        FitPoint { residual, jacobian }
    }

    /// The residuals of the solid itself.
    fn exact(&self, field: &SineField, sizes: &DVector<f64>, nodes: usize) -> FitPoint {
        let (vertices, triangles) = (&self.surface.vertices, &self.surface.triangles);
        let jet = sine_jet(vertices, triangles, &field.point, field.k, nodes);
        let count = sizes.len();
        let (mut residual, mut jacobian) = (DVector::zeros(count), DMatrix::zeros(count, 4));
        for (k, condition) in self.conditions.iter().enumerate() {
            let seen = condition.seen_from(&field.point);
            let of = |moments: &Moments| seen.of(moments, &field.point) / sizes[k];
            residual[k] = of(&jet.volume);
            // ∫ f ∇φ, and ∫ f (3 φ + r·∇φ) by degrees.
            let (volume, quadratic) = (&jet.volume, seen.quadratic);
            let slopes = seen.gradient * volume.mass + quadratic * volume.first * 2.0;
            for axis in 0..3 {
                jacobian[(k, axis)] = slopes[axis] / sizes[k] - of(&jet.normal[axis]);
            }
            let weighted = 3.0 * seen.constant * volume.mass
                + 4.0 * seen.gradient.dot(&volume.first)
                + 5.0 * quadratic.component_mul(&volume.second).sum();
            jacobian[(k, 3)] = (of(&jet.height) - weighted / sizes[k]) / field.k;
        }
        FitPoint { residual, jacobian }
    }
}

/// sin k|r| at a place r from the field's point, and the derivatives of it by that point and k.
fn sine_at(field: &SineField, place: &Point3<f64>) -> (f64, Vector4<f64>) {
    let arm = place - field.point;
    let distance = arm.norm();
    let (sine, cosine) = (field.k * distance).sin_cos();
    let outward = arm / distance.max(f64::MIN_POSITIVE);
    let slope = outward * (-field.k * cosine);
    let slopes = Vector4::new(slope.x, slope.y, slope.z, distance * cosine);
    (sine, slopes)
}

/// A start: p within twice the box, k of some waves.
fn drawn(bounds: &Bounds<3>, random: &mut Random) -> SineField {
    let extent = bounds.extent();
    let around = bounds.grown(&nalgebra::Vector3::repeat(0.75 * extent.max()));
    let point = random.point(&around);
    let [low, high] = WAVES;
    SineField {
        point,
        k: (low + (high - low) * random.uniform()) / extent.norm(),
    }
}

/// Levenberg-Marquardt: the field, its largest residual, evaluations.
fn descend(
    start: SineField,
    goal: f64,
    evaluate: impl Fn(&SineField) -> FitPoint,
) -> (SineField, f64, usize) {
    let (mut field, mut point, mut evaluations) = (start, evaluate(&start), 1);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        if point.residual.amax() <= goal || damping > 1e8 {
            break;
        }
        let normal = point.jacobian.transpose() * &point.jacobian;
        let right = -point.jacobian.transpose() * &point.residual;
        let damped = &normal + DMatrix::from_diagonal(&(normal.diagonal() * damping));
        let step = damped.cholesky().map(|factor| factor.solve(&right));
        let Some(step) = step else {
            damping *= 10.0;
            continue;
        };
        let next = field.moved(&step);
        let trial = evaluate(&next);
        evaluations += 1;
        if trial.residual.norm() < point.residual.norm() {
            (field, point) = (next, trial);
            damping *= 0.1;
        } else {
            damping = (damping * 10.0).max(1e-6);
        }
    }
    (field, point.residual.amax(), evaluations)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::conditions::SpinAxis;
    use crate::balance::spin::SpinState;
    use crate::mass::body::Body;
    use crate::mesh::shapes::bracket;
    use nalgebra::Vector3;

    fn problem(surface: &SurfaceMesh) -> (SpinAxis, Vec<Condition>) {
        let middle = surface.bounds().center() + Vector3::new(0.05, 0.02, -0.03);
        let axis = SpinAxis::new(&middle, &Vector3::new(0.1, 0.2, 1.0)).expect("a direction");
        let conditions = [axis.center_on(), axis.principal()].concat();
        (axis, conditions)
    }

    #[test]
    fn derivatives_of_exact_integrals_are_those_of_differences() {
        let surface = bracket(3);
        let (axis, conditions) = problem(&surface);
        let problem = SineProblem {
            surface: &surface,
            moments: &[],
            origin: axis.through,
            conditions: &conditions,
        };
        let sizes = DVector::repeat(4, 1.0);
        let extent = surface.bounds().extent().norm();
        let field = SineField {
            point: surface.bounds().center() + Vector3::new(0.7, -0.4, 0.3) * extent,
            k: 6.0 / extent,
        };
        let here = problem.exact(&field, &sizes, 6);
        let scale = here.jacobian.amax();
        for unknown in 0..4 {
            let step = 1e-5;
            let moved = |sign: f64| {
                let mut way = DVector::zeros(4);
                way[unknown] = sign * step;
                problem.exact(&field.moved(&way), &sizes, 6).residual
            };
            let slope = (moved(1.0) - moved(-1.0)) / (2.0 * step);
            let error = (slope - here.jacobian.column(unknown)).amax();
            assert!(error < 1e-7 * scale, "{unknown}: {error:e} {scale:e}");
        }
    }

    #[test]
    fn exact_steps_find_the_field_whose_axis_was_taken() {
        let surface = bracket(2);
        let bounds = surface.bounds();
        let extent = bounds.extent().norm();
        let wanted = SineField {
            point: bounds.center() + Vector3::new(0.6, -0.5, 0.4) * extent,
            k: 7.0 / extent,
        };
        let (vertices, triangles) = (&surface.vertices, &surface.triangles);
        let jet = sine_jet(vertices, triangles, &wanted.point, wanted.k, 5);
        let body = Body::from_moments(1.0, 1.0, &jet.volume, &wanted.point);
        let axis = SpinAxis::new(&body.center_of_mass(), &body.principal().axes[2]);
        let axis = axis.expect("a direction");
        let conditions = [axis.center_on(), axis.principal()].concat();
        let problem = SineProblem {
            surface: &surface,
            moments: &[],
            origin: axis.through,
            conditions: &conditions,
        };
        let lengths = vec![extent, extent, extent.powi(2), extent.powi(2)];
        let sizes = DVector::from_vec(lengths) * surface.volume();
        let start = SineField {
            point: wanted.point + Vector3::new(0.002, 0.001, -0.002) * extent,
            k: wanted.k * 1.002,
        };
        let (field, residual, _) = problem.refine(start, &sizes);
        assert!(residual < EXACT_ENOUGH, "{residual:e}");
        let off = (field.point - wanted.point).norm() / extent;
        assert!(
            off < 0.05 && (field.k / wanted.k - 1.0).abs() < 0.05,
            "{field:?}"
        );
    }

    /// The fields of `density.md` 2.3, started beside them.
    #[test]
    #[ignore = "needs ../shared/models"]
    fn the_rocker_arm_has_the_sines_of_the_references() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../shared/models/rocker-arm.obj");
        let surface = crate::mesh::formats::read::read_surface(&path).expect("the model");
        let through = Point3::new(0.0, 0.067_179_41, 0.084_916_92);
        let along = Vector3::new(0.999_972_85, -0.007_270_18, 0.001_201_18);
        let axis = SpinAxis::new(&through, &along).expect("a direction");
        let conditions = [axis.center_on(), axis.principal()].concat();
        let problem = SineProblem {
            surface: &surface,
            moments: &[],
            origin: through,
            conditions: &conditions,
        };
        let sizes = DVector::from_vec(vec![0.01, 0.01, 0.002, 0.002]);
        let volume = surface.volume();
        for (start, k, wanted, wanted_k, mass, center) in [
            (
                [-0.51, 0.069, -0.08],
                8.2,
                [-0.497_130_37, 0.067_910_98, -0.078_121_14],
                8.388_242_481_667_419,
                0.008_158_539_489_577_96,
                Some([-0.023_023_88, 0.067_346_8, 0.084_889_26]),
            ),
            (
                [-0.67, 0.077, -0.102],
                15.27,
                [-0.670_634_12, 0.077_159_27, -0.102_318_97],
                15.285_668_399_471_652,
                0.020_311_201_086_132_6,
                None,
            ),
        ] {
            let start = SineField {
                point: start.into(),
                k,
            };
            let (field, residual, _) = problem.refine(start, &sizes);
            assert!(residual < 1e-11, "{residual:e}");
            let off = (field.point - Point3::from(wanted)).norm() + (field.k - wanted_k).abs();
            assert!(off < 1e-5, "{field:?}");
            let (vertices, triangles) = (&surface.vertices, &surface.triangles);
            let jet = sine_jet(vertices, triangles, &wanted.into(), wanted_k, 5);
            assert!(
                (jet.volume.mass - mass).abs() < 1e-11,
                "{}",
                jet.volume.mass
            );
            let moments = jet.volume.translated(&(Point3::from(wanted) - through));
            let state = SpinState::of(&moments, volume, 1.0, &axis);
            assert!(state.distance < 1e-7, "{:e}", state.distance);
            assert!(state.angle_degrees < 1e-4, "{:e}", state.angle_degrees);
            if let Some(center) = center {
                let off = state.body.center_of_mass() - Point3::from(center);
                assert!(off.amax() < 1e-8, "{off}");
            }
        }
    }
}
