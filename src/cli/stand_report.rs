//! The figures of `chebloyd stand`, as JSON and as a table.

use nalgebra::Point3;
use serde::Serialize;

use crate::balance::sensitivity::ClampDerivatives;
use crate::balance::solid::{AffineForm, SolidBalance};
use crate::balance::stand::{RANGE_ROOM, StandField, StandGoal, StandPlan, Standing};
use crate::balance::support::Support;
use crate::cli::failure::Failure;
use crate::cli::mass_report::{figure, rows};
use crate::cli::modifiers::ModifiersReport;
use crate::mass::body::Body;
use crate::mass::density::SolidDensity;
use crate::mass::weigh::weigh_surface;
use crate::mesh::surface::SurfaceMesh;

/// The body that is to stand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StandBody<'a> {
    /// Its parts.
    pub(crate) surfaces: &'a [SurfaceMesh],
    /// Its moments above planes.
    pub(crate) balance: &'a SolidBalance<'a>,
}

/// What is printed, in this order.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct StandReport {
    /// With a constant density already.
    stands: bool,
    feasible: bool,
    /// Infinite is null.
    least_contrast: Option<f64>,
    outside_hull: bool,
    /// Given LO and the mass.
    #[serde(skip_serializing_if = "Option::is_none")]
    least_high: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wanted_mass: Option<f64>,
    mass: Option<f64>,
    center_of_mass: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nearest_center: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    nearest_distance: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    certificate: Option<Certificate>,
    /// How far within the support; none of a target.
    slack: Option<f64>,
    /// The tilt of the ground that it stands.
    tilt_degrees: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    inertia_center: Option<[[f64; 3]; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    principal_moments: Option<[f64; 3]>,
    goal: &'static str,
    /// Infinite is null.
    range: [Option<f64>; 2],
    range_chosen: bool,
    prefer: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    field: Option<ClampReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sensitivity: Option<Sensitivity>,
    #[serde(skip_serializing_if = "Option::is_none")]
    modifiers: Option<ModifiersReport>,
    support: SupportReport,
    native: NativeReport,
    multipliers: Vec<f64>,
    residuals: Vec<f64>,
    iterations: usize,
    evaluations: usize,
    contrast_evaluations: usize,
    /// Of solving, without reading and writing.
    seconds: f64,
}

/// A plane: what is heavy lies on the side of the normal.
#[derive(Clone, Copy, Debug, Serialize)]
struct Certificate {
    point: [f64; 3],
    normal: [f64; 3],
}

/// clamp(low, high, value + gradient·y).
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct ClampReport {
    pub(crate) low: f64,
    pub(crate) high: Option<f64>,
    pub(crate) value: f64,
    pub(crate) gradient: [f64; 3],
}

/// How the center of mass moves with the field's low and high end, its value everywhere, and its gradient
/// about the middle of the body's box (row: coordinate of the center, column: component of the gradient).
#[derive(Clone, Copy, Debug, Serialize)]
struct Sensitivity {
    center_by_low: [f64; 3],
    center_by_high: [f64; 3],
    center_by_value: [f64; 3],
    center_by_gradient: [[f64; 3]; 3],
}

#[derive(Clone, Debug, Serialize)]
struct SupportReport {
    kind: &'static str,
    up: [f64; 3],
    ground: f64,
    corners: Vec<[f64; 3]>,
}

/// The body at a constant density.
#[derive(Clone, Copy, Debug, Serialize)]
struct NativeReport {
    volume: f64,
    center_of_mass: [f64; 3],
    slack: Option<f64>,
    tilt_degrees: Option<f64>,
}

impl StandReport {
    pub(crate) fn new(
        body: StandBody<'_>,
        plan: &StandPlan,
        standing: &Standing,
        seconds: f64,
    ) -> Result<Self, Failure> {
        let middle = body.balance.middle;
        let (whole, native) = (&body.balance.whole, native_center(body.balance));
        let contrast = 1.0 + standing.contrast.growth;
        let field = standing.field.as_ref().ok();
        let refusal = standing.field.as_ref().err();
        let weighed = field.map(|field| body.weigh(field)).transpose()?;
        let center = weighed.as_ref().map(Body::center_of_mass);
        let proof = refusal.map_or(&standing.contrast_form, |refusal| &refusal.proof);
        let nearest = refusal.and_then(|refusal| refusal.nearest);
        let range = match (field, refusal) {
            (Some(field), _) => [field.range.low, field.range.high],
            (None, refusal) => refusal.map_or([0.0; 2], |refusal| refusal.range),
        };
        let solution = field.map(|field| &field.solution);
        let [slack, tilt_degrees] = slack(plan, center.as_ref());
        let [native_slack, native_tilt] = slack_of(plan, &native);
        Ok(Self {
            stands: standing.stands,
            feasible: field.is_some(),
            least_contrast: finite(contrast),
            outside_hull: contrast.is_infinite(),
            least_high: standing.least_high.and_then(finite),
            wanted_mass: plan.mass,
            mass: weighed.as_ref().map(|body| body.mass),
            center_of_mass: center.map(Into::into),
            nearest_center: nearest.map(|nearest| nearest.center.into()),
            nearest_distance: nearest.map(|nearest| nearest.distance),
            certificate: certificate(proof, &middle),
            slack,
            tilt_degrees,
            inertia_center: weighed.as_ref().map(|body| rows(&body.inertia_center())),
            principal_moments: weighed.as_ref().map(|body| body.principal().moments.into()),
            goal: goal_name(plan.goal),
            range: range.map(finite),
            range_chosen: plan.range.is_none(),
            prefer: field.map_or(plan.prefer.unwrap_or(range[0]), |field| field.range.prefer),
            field: field.map(|field| clamp_report(field, &middle)),
            sensitivity: field.map(|field| sensitivity(body.balance, field)),
            modifiers: None,
            support: SupportReport::of(plan),
            native: NativeReport {
                volume: whole.mass,
                center_of_mass: native.into(),
                slack: native_slack,
                tilt_degrees: native_tilt,
            },
            multipliers: solution.map_or_else(Vec::new, |s| s.multipliers.as_slice().to_vec()),
            residuals: solution.map_or_else(Vec::new, |s| s.residual.as_slice().to_vec()),
            iterations: solution.map_or(standing.contrast.iterations, |s| s.iterations()),
            evaluations: solution.map_or(0, |s| s.evaluations),
            contrast_evaluations: standing.contrast.evaluations,
            seconds,
        })
    }

    /// With the bodies that were written.
    pub(crate) fn with(self, modifiers: Option<ModifiersReport>) -> Self {
        Self { modifiers, ..self }
    }

    /// The field.
    pub(crate) fn field(&self) -> Option<&ClampReport> {
        self.field.as_ref()
    }

    /// The centers before and after.
    pub(crate) fn centers(&self) -> [Option<Point3<f64>>; 2] {
        [Some(self.native.center_of_mass), self.center_of_mass]
            .map(|center| center.map(Point3::from))
    }

    /// Why there is no field.
    pub(crate) fn refusal(&self) -> Option<String> {
        if self.feasible {
            return None;
        }
        let [low, high] = self.range.map(|end| end.unwrap_or(f64::INFINITY));
        let asked = format!("no density between {low} and {high} does this");
        let volume = self.native.volume;
        if let Some(mass) = self.wanted_mass
            && !(low * volume..=high * volume).contains(&mass)
        {
            let (least, most) = (low * volume, high * volume);
            return Some(format!("{asked}: it weighs {least} to {most}, not {mass}"));
        }
        Some(match (self.least_contrast, self.least_high) {
            (None, _) => format!(
                "{asked}, nor does any other: what is asked lies outside the solid's convex hull"
            ),
            (Some(least), None) => format!(
                "{asked}; it takes a contrast of {least:.9} (greatest density to least): widen --range, \
                 or ask for less"
            ),
            (Some(least), Some(high)) => format!(
                "{asked}; with this LO and this mass it takes HI {high:.9}, for any mass a contrast of \
                 {least:.9}: widen --range, or ask for less"
            ),
        })
    }

    pub(crate) fn json(&self) -> Result<String, Failure> {
        let text = serde_json::to_string_pretty(self).map_err(Failure::run)?;
        Ok(text + "\n")
    }

    /// A line for every figure.
    pub(crate) fn table(&self) -> String {
        let mut text = String::new();
        let mut line = |name: &str, numbers: &[f64]| {
            let numbers: String = numbers.iter().map(|&number| figure(number)).collect();
            text += &format!("{name:<24}{numbers}\n");
        };
        line("volume", &[self.native.volume]);
        line("center before", &self.native.center_of_mass);
        if let Some(slack) = self.native.slack {
            line("slack before", &[slack]);
        }
        line(
            "least contrast",
            &[self.least_contrast.unwrap_or(f64::INFINITY)],
        );
        line("range", &self.range.map(|end| end.unwrap_or(f64::INFINITY)));
        let optional = [("mass", self.mass), ("slack", self.slack)];
        for (name, value) in optional {
            value.iter().for_each(|value| line(name, &[*value]));
        }
        if let Some(tilt) = self.tilt_degrees {
            line("stands a tilt (degrees)", &[tilt]);
        }
        if let Some(center) = self.center_of_mass {
            line("center of mass", &center);
        }
        if let Some(field) = self.field {
            line("density at the origin", &[field.value]);
            line("… grows by", &field.gradient);
        }
        if let (Some(center), Some(distance)) = (self.nearest_center, self.nearest_distance) {
            line("nearest center", &center);
            line("… still off by", &[distance]);
        }
        if let Some(Certificate { point, normal }) = self.certificate {
            line("least contrast's plane", &point);
            line("… heavy towards", &normal);
        }
        if let Some(modifiers) = &self.modifiers {
            text += &modifiers.table();
        }
        text + &self.notes()
    }

    /// Sentences below the table.
    fn notes(&self) -> String {
        let mut text = String::new();
        if self.stands {
            text += "note: it stands with a constant density already\n";
        }
        if self.range_chosen && self.feasible {
            text += &format!(
                "note: no --range was given: the range is {RANGE_ROOM} times the least contrast\n"
            );
        }
        let (kind, corners) = (self.support.kind, self.support.corners.len());
        let (iterations, evaluations) = (self.iterations, self.evaluations);
        text + &format!(
            "support: {kind} ({corners} corners); {iterations} iterations, {evaluations} evaluations\n"
        )
    }
}

impl StandBody<'_> {
    /// The mass properties with a field.
    fn weigh(&self, field: &StandField) -> Result<Body, Failure> {
        let clamp = clamp_report(field, &self.balance.middle);
        let density = clamp.density().map_err(Failure::run)?;
        let weighed = self.surfaces.iter();
        let weighed = weighed.map(|surface| weigh_surface(surface, &density, &surface.bounds()));
        let parts: Vec<Body> = weighed.collect::<Result<_, _>>().map_err(Failure::run)?;
        Body::combined(&parts).ok_or_else(|| Failure::run("the parts have no mass"))
    }
}

impl ClampReport {
    /// The field as a density.
    pub(crate) fn density(&self) -> Result<SolidDensity, crate::mass::density::DensityError> {
        let high = self.high.unwrap_or(f64::INFINITY);
        SolidDensity::clamp(self.low, high, self.value, &self.gradient.into())
    }
}

impl SupportReport {
    fn of(plan: &StandPlan) -> Self {
        let at = |place: &nalgebra::Point2<f64>| plan.ground.at(place).into();
        let (kind, corners) = match &plan.support {
            Support::Polygon(corners) => ("polygon", corners.iter().map(at).collect()),
            Support::Segment(ends) => ("line", ends.iter().map(at).collect()),
            Support::Point(place) => ("point", vec![at(place)]),
            Support::Target(_) => ("target", Vec::new()),
        };
        Self {
            kind,
            up: plan.ground.up.into_inner().into(),
            ground: plan.ground.height,
            corners,
        }
    }
}

/// The center at a constant density.
fn native_center(balance: &SolidBalance<'_>) -> Point3<f64> {
    balance.middle + balance.whole.center()
}

fn clamp_report(field: &StandField, middle: &Point3<f64>) -> ClampReport {
    let gradient = field.form.gradient;
    ClampReport {
        low: field.range.low,
        high: finite(field.range.high),
        value: field.form.value - gradient.dot(&middle.coords),
        gradient: gradient.into(),
    }
}

fn sensitivity(body: &SolidBalance<'_>, field: &StandField) -> Sensitivity {
    let derivatives = ClampDerivatives::of(body, &field.form, &field.range);
    let moments = body.clamped(&field.form, &field.range);
    let [low, high, value] = derivatives.center(&moments).map(Into::into);
    Sensitivity {
        center_by_low: low,
        center_by_high: high,
        center_by_value: value,
        center_by_gradient: rows(&derivatives.center_by_gradient(&moments)),
    }
}

fn certificate(form: &AffineForm, middle: &Point3<f64>) -> Option<Certificate> {
    let (point, normal) = form.plane_at(middle)?;
    Some(Certificate {
        point: point.into(),
        normal: normal.into(),
    })
}

/// Slack and tilt in degrees, none without a center.
fn slack(plan: &StandPlan, center: Option<&Point3<f64>>) -> [Option<f64>; 2] {
    center.map_or([None; 2], |center| slack_of(plan, center))
}

fn slack_of(plan: &StandPlan, center: &Point3<f64>) -> [Option<f64>; 2] {
    let slack = plan.support.slack(&plan.ground, center);
    slack.map_or([None; 2], |[slack, tangent]| {
        [Some(slack), Some(tangent.atan().to_degrees())]
    })
}

fn goal_name(goal: StandGoal) -> &'static str {
    match goal {
        StandGoal::LeastVariance => "least-variance",
        StandGoal::LeastContrast => "least-contrast",
        StandGoal::MostStable => "most-stable",
    }
}

fn finite(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}
