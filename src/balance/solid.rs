//! Solids under conditions on their center and mass: every integral from half-space moments of the surface.
//!
//! Conditions φ_k = b_k + g_k·r are affine, so Σ λ_k φ_k = β + w·r, and where it exceeds a bound is a
//! half-space. With A = {d₀ + Σ λ_k φ_k > lo}, B = {d₀ + Σ λ_k φ_k > hi} and φ_A, φ_B what is above zero there,
//! ∫ d φ = lo ∫φ + ∫_A φ φ_A − ∫_B φ φ_B, all from moments up to degree two.

use nalgebra::{DMatrix, DVector, Matrix3, Point3, Vector3};

use crate::balance::conditions::Condition;
use crate::balance::dual::{Balance, DensityRange, DualPoint, Relation};
use crate::geometry::bounds::Bounds;
use crate::geometry::moments::Moments;
use crate::integrals::half_space::{CutPlane, CuttableSolid, ThreeMoments};
use crate::mesh::surface::SurfaceMesh;

/// β + w·r, r measured from the middle of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct AffineForm {
    /// β.
    pub(crate) value: f64,
    /// w.
    pub(crate) gradient: Vector3<f64>,
}

/// Solids under affine conditions.
#[derive(Clone, Debug)]
pub(crate) struct SolidBalance<'a> {
    solids: Vec<CuttableSolid<'a>>,
    /// The middle of all, from which moments are measured.
    pub(crate) middle: Point3<f64>,
    /// Half of the edges of the box of all.
    half: Vector3<f64>,
    /// The moments of all at density 1.
    pub(crate) whole: Moments,
    relations: Vec<Relation>,
    /// φ_k.
    forms: Vec<AffineForm>,
    /// −wanted_k.
    constants: DVector<f64>,
}

impl<'a> SolidBalance<'a> {
    /// Solids by their closed surfaces, under conditions without quadratic terms.
    pub(crate) fn new(surfaces: &'a [SurfaceMesh], conditions: &[Condition]) -> Self {
        let cuttable = |mesh: &'a SurfaceMesh| CuttableSolid::new(&mesh.vertices, &mesh.triangles);
        let solids: Vec<_> = surfaces.iter().map(cuttable).collect();
        let corners = surfaces.iter().map(SurfaceMesh::bounds);
        let corners: Vec<_> = corners.flat_map(|box_| [box_.min, box_.max]).collect();
        let bounds = Bounds::of(&corners);
        let middle = bounds.center();
        let mut balance = Self {
            solids,
            middle,
            half: bounds.extent() * 0.5,
            whole: Moments::default(),
            relations: Vec::new(),
            forms: Vec::new(),
            constants: DVector::zeros(0),
        };
        balance.whole = balance.sum(|solid| solid.whole);
        balance.under(conditions)
    }

    /// The same solids under other conditions.
    pub(crate) fn under(&self, conditions: &[Condition]) -> Self {
        let form = |condition: &Condition| AffineForm {
            value: condition.at(&self.middle),
            gradient: condition.gradient,
        };
        let constants = conditions.iter().map(|condition| -condition.wanted);
        Self {
            relations: conditions.iter().map(|c| c.relation).collect(),
            forms: conditions.iter().map(form).collect(),
            constants: DVector::from_iterator(conditions.len(), constants),
            ..self.clone()
        }
    }

    /// What solids have, summed about the common middle.
    fn sum(&self, of: impl Fn(&CuttableSolid<'a>) -> Moments) -> Moments {
        let mut sum = Moments::default();
        for solid in &self.solids {
            sum += of(solid).translated(&(solid.middle - self.middle));
        }
        sum
    }

    /// Σ λ_k φ_k.
    pub(crate) fn combined(&self, multipliers: &DVector<f64>) -> AffineForm {
        let start = AffineForm {
            value: 0.0,
            gradient: Vector3::zeros(),
        };
        let pairs = self.forms.iter().zip(multipliers.iter());
        pairs.fold(start, |sum, (form, factor)| AffineForm {
            value: sum.value + form.value * factor,
            gradient: sum.gradient + form.gradient * *factor,
        })
    }

    /// The moments of where a form is positive.
    pub(crate) fn above(&self, form: &AffineForm) -> Moments {
        let Some(plane) = self.plane(form) else {
            return if form.value > 0.0 {
                self.whole
            } else {
                Moments::default()
            };
        };
        self.sum(|solid| solid.above(&plane))
    }

    /// The moments of where a form is positive, up to degree three.
    pub(crate) fn above_to_third(&self, form: &AffineForm) -> ThreeMoments {
        // Of a constant: all or nothing, by a plane beyond the body.
        let plane = self.plane(form).unwrap_or(CutPlane {
            normal: Vector3::x(),
            offset: self.middle.x - form.value.signum() * (1.0 + 4.0 * self.half.norm()),
        });
        let mut sum = ThreeMoments::default();
        for solid in &self.solids {
            let above = solid.above_to_third(&plane);
            sum = sum + above.translated(&(solid.middle - self.middle));
        }
        sum
    }

    /// The moments of where a form is zero.
    pub(crate) fn section(&self, form: &AffineForm) -> Moments {
        let plane = self.plane(form);
        plane.map_or_else(Moments::default, |plane| {
            self.sum(|solid| solid.section(&plane))
        })
    }

    /// The most by which a form of this gradient differs from its value in the middle, over the box.
    pub(crate) fn reach(&self, gradient: &Vector3<f64>) -> f64 {
        gradient.abs().dot(&self.half)
    }

    /// Where a form is zero, none of a constant.
    fn plane(&self, form: &AffineForm) -> Option<CutPlane> {
        let normal = form.gradient;
        let is_plane = normal.norm_squared() > 0.0 && normal.norm_squared().is_finite();
        is_plane.then(|| CutPlane {
            normal,
            offset: normal.dot(&self.middle.coords) - form.value,
        })
    }

    /// Mass, first and second moments of clamp(form, low, high) about the middle, second ones without the
    /// third moments that they would need: zero.
    pub(crate) fn clamped(&self, form: &AffineForm, range: &DensityRange) -> Moments {
        let excess = |bound: f64| {
            if bound == f64::INFINITY {
                return Moments::default();
            }
            let above = form.less(bound);
            above.weighted(&self.above(&above))
        };
        self.whole * range.low + excess(range.low) + excess(range.high) * -1.0
    }

    /// ∫ φ_k of a body of these moments.
    pub(crate) fn rows(&self, moments: &Moments) -> DVector<f64> {
        let row = |form: &AffineForm| form.value * moments.mass + form.gradient.dot(&moments.first);
        DVector::from_iterator(self.forms.len(), self.forms.iter().map(row))
    }

    /// ∫ φ_k φ_l of a body of these moments.
    pub(crate) fn products(&self, moments: &Moments) -> DMatrix<f64> {
        let forms = &self.forms;
        DMatrix::from_fn(forms.len(), forms.len(), |k, l| {
            forms[k].product(&forms[l], moments)
        })
    }
}

impl AffineForm {
    /// The form less a number.
    pub(crate) fn less(&self, bound: f64) -> Self {
        Self {
            value: self.value - bound,
            ..*self
        }
    }

    /// ∫ of the product with another.
    fn product(&self, other: &Self, moments: &Moments) -> f64 {
        let mixed = self.gradient * other.value + other.gradient * self.value;
        let second = self.gradient.dot(&(moments.second * other.gradient));
        self.value * other.value * moments.mass + mixed.dot(&moments.first) + second
    }

    /// Mass and first moments of a body whose density is the form.
    fn weighted(&self, moments: &Moments) -> Moments {
        Moments {
            mass: self.value * moments.mass + self.gradient.dot(&moments.first),
            first: moments.first * self.value + moments.second * self.gradient,
            second: Matrix3::zeros(),
        }
    }
}

impl Balance for SolidBalance<'_> {
    fn relations(&self) -> &[Relation] {
        &self.relations
    }

    fn constants(&self) -> DVector<f64> {
        self.constants.clone()
    }

    fn totals(&self) -> DVector<f64> {
        self.rows(&self.whole)
    }

    fn dual(&self, range: &DensityRange, multipliers: &DVector<f64>, whole: bool) -> DualPoint {
        let tilt = self.combined(multipliers);
        let free = tilt.less(-range.prefer);
        let above_low = free.less(range.low);
        let above = self.above(&above_low);
        let (over, beyond) = if range.high < f64::INFINITY {
            let above_high = free.less(range.high);
            let over = self.above(&above_high);
            (over, above_high.weighted(&over))
        } else {
            Default::default()
        };
        let density = self.whole * range.low + above_low.weighted(&above) + beyond * -1.0;
        let residual = self.rows(&density) + &self.constants;
        let slab = above + over * -1.0;
        let square = |bound: f64, volume: f64| match volume {
            0.0 => 0.0,
            _ => (bound - range.prefer).powi(2) * volume,
        };
        let clamped =
            square(range.low, self.whole.mass - above.mass) + square(range.high, over.mass);
        let between = tilt.product(&tilt, &slab);
        DualPoint {
            value: 0.5 * (clamped + between) - multipliers.dot(&residual),
            curvature: self.products(if whole { &self.whole } else { &slab }),
            residual,
        }
    }

    fn positive_part(&self, multipliers: &DVector<f64>) -> (f64, DVector<f64>) {
        let tilt = self.combined(multipliers);
        let above = self.above(&tilt);
        (tilt.weighted(&above).mass, self.rows(&above))
    }

    fn positive_curvature(&self, multipliers: &DVector<f64>) -> Option<DMatrix<f64>> {
        let tilt = self.combined(multipliers);
        let slope = tilt.gradient.norm();
        let products = self.products(&self.section(&tilt));
        Some(if slope > 0.0 {
            products / slope
        } else {
            products
        })
    }
}
