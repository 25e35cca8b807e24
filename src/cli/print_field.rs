//! The field that multiplies a print's flow: as a text or file gives it, placed on the bed.

use nalgebra::{Point3, Vector3};

use crate::cli::failure::Failure;
use crate::geometry::bounds::Bounds;
use crate::mesh::shapes::cuboid;
use crate::mesh::validate::{Solid, validate_surface};
use crate::scene::field::{FieldError, GivenField};

/// By how much the solid that stands for the part is larger than its box (mm).
const THICKNESS: f64 = 1e-3;

/// A field with its place on the bed.
#[derive(Debug)]
pub(crate) struct PlacedField {
    given: GivenField,
    /// The part's box in the field's coordinates, as a solid.
    solid: Solid,
    extent: Bounds<3>,
    /// Bed coordinates less those of the field.
    offset: Vector3<f64>,
}

/// A multiplier at a point of the bed.
pub(crate) type Multiplier<'a> = Box<dyn Fn(&Point3<f64>) -> f64 + 'a>;

impl PlacedField {
    /// The field `text` over a part within `part`; `place` is given by the user.
    pub(crate) fn new(
        text: &str,
        given: GivenField,
        part: &Bounds<3>,
        place: Option<[f64; 3]>,
    ) -> Result<Self, Failure> {
        let kind = text.trim();
        let spans = ["linear:", "profile:"];
        let spanning = spans.iter().find(|name| kind.starts_with(**name));
        if let (Some(name), Some(_)) = (spanning, place) {
            return Err(Failure::input(format!(
                "--place moves formulas and field files; `{name}` spans the part's box wherever it lies"
            )));
        }
        let middles = given.bounds().map(|solid| part.center() - solid.center());
        let offset = match (spanning, place) {
            (Some(&"profile:"), _) => part.min.coords,
            (_, Some(place)) => Vector3::from(place),
            _ => middles.unwrap_or_default(),
        };
        let extent = part.translated(&-offset);
        // A print of one bead is flat.
        let thick = extent.grown(&Vector3::repeat(THICKNESS));
        let (closed, report) = validate_surface(&cuboid(&thick)).map_err(Failure::input)?;
        Ok(Self {
            given,
            solid: Solid::Surface(closed, report),
            extent,
            offset,
        })
    }

    /// The field as a function of the place on the bed.
    pub(crate) fn function(&self) -> Result<Multiplier<'_>, Failure> {
        let refuse = |error: FieldError| match error {
            FieldError::Weigh(_) | FieldError::Vertices { .. } => Failure::input(format!(
                "--density: a print has no vertices: {error}; give a formula, or cells (spin --basis \
                 cells:N)"
            )),
            other => Failure::input(format!("--density: {other}")),
        };
        let function = self.given.field.function(&self.solid, &self.extent);
        let function = function.map_err(refuse)?;
        let offset = self.offset;
        Ok(Box::new(move |place| function(&(place - offset))))
    }

    /// Where the field lies.
    pub(crate) fn note(&self) -> Option<String> {
        let [x, y, z] = <[f64; 3]>::from(self.offset);
        let file = self.given.file.as_ref()?.display();
        let why = if self.given.bounds().is_some() {
            ""
        } else {
            " (it does not say for which solid it was made; --place moves it)"
        };
        Some(format!(
            "{file} is placed at ({x:.3}, {y:.3}, {z:.3}) on the bed{why}"
        ))
    }
}
