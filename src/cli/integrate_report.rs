//! Integrals as `chebloyd integrate` prints them: tables, JSON, faces.

use nalgebra::{Point3, Vector3};
use serde::{Serialize, Serializer};

use crate::integrals::monomials::MonomialIntegrals;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::series::{Exponents, degree};
use crate::mesh::report::brief;
use crate::mesh::surface::SurfaceMesh;

use crate::cli::mass_report::figure;

/// So many faces are listed in the table.
const FACES_SHOWN: usize = 24;

/// A corner farther from the plane of its polygon than this share of the polygon's size is not in it.
const PLANAR: f64 = 1e-9;

/// The integrals that are there to be reported.
pub(crate) struct Integrals {
    pub(crate) surface: MonomialIntegrals,
    pub(crate) volume: Option<MonomialIntegrals>,
}

/// What is to be reported of them.
pub(crate) struct Asked {
    pub(crate) degree: u32,
    /// A polynomial and its text.
    pub(crate) of: Option<(String, Polynomial)>,
    pub(crate) signed: Option<[f64; 3]>,
}

/// What is printed, in this order.
#[derive(Debug, Serialize)]
pub(crate) struct IntegralsReport {
    #[serde(skip_serializing_if = "Option::is_none")]
    signed: Option<[f64; 3]>,
    surface: MonomialTable,
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<MonomialTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    of: Option<PolynomialIntegrals>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mirtich: Option<TenIntegrals>,
    /// Of the volume, or of an open surface.
    moments_of: &'static str,
    /// Of x, y, z.
    first_moments: [f64; 3],
    /// Of x², y², z².
    second_moments: [f64; 3],
    /// Of y z, x z, x y.
    products_of_inertia: [f64; 3],
    faces: Vec<FaceFigures>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) notes: Vec<String>,
}

/// Integrals by exponents.
#[derive(Debug)]
struct MonomialTable(Vec<(Exponents, f64)>);

impl Serialize for MonomialTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let entries = self.0.iter();
        serializer.collect_map(entries.map(|([a, b, c], value)| (format!("{a},{b},{c}"), value)))
    }
}

#[derive(Debug, Serialize)]
struct PolynomialIntegrals {
    polynomial: String,
    surface: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    volume: Option<f64>,
}

/// \[M\] eq. 18-27, by the names that his program prints.
#[derive(Debug, Serialize)]
#[serde(rename_all = "PascalCase")]
struct TenIntegrals {
    t1: f64,
    tx: f64,
    ty: f64,
    tz: f64,
    txx: f64,
    tyy: f64,
    tzz: f64,
    txy: f64,
    tyz: f64,
    tzx: f64,
}

/// A face, by its size and direction.
#[derive(Debug, Serialize)]
pub(crate) struct FaceFigures {
    area: f64,
    normal: [f64; 3],
}

/// The faces, and what is to be said about them.
pub(crate) struct Faces {
    pub(crate) figures: Vec<FaceFigures>,
    pub(crate) note: Option<String>,
}

impl IntegralsReport {
    pub(crate) fn new(asked: &Asked, integrals: &Integrals, faces: Vec<FaceFigures>) -> Self {
        let (surface, volume) = (&integrals.surface, integrals.volume.as_ref());
        let moments = volume.unwrap_or(surface);
        let three = |all: [Exponents; 3]| all.map(|exponents| moments.of(exponents));
        Self {
            signed: asked.signed,
            surface: MonomialTable::of(surface, asked.degree),
            volume: volume.map(|volume| MonomialTable::of(volume, asked.degree)),
            of: asked
                .of
                .as_ref()
                .map(|(text, polynomial)| PolynomialIntegrals {
                    polynomial: text.clone(),
                    surface: surface.of_polynomial(polynomial),
                    volume: volume.map(|volume| volume.of_polynomial(polynomial)),
                }),
            mirtich: volume.map(TenIntegrals::of),
            moments_of: if volume.is_some() {
                "volume"
            } else {
                "surface"
            },
            first_moments: three([[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
            second_moments: three([[2, 0, 0], [0, 2, 0], [0, 0, 2]]),
            products_of_inertia: three([[0, 1, 1], [1, 0, 1], [1, 1, 0]]),
            faces,
            notes: Vec::new(),
        }
    }

    /// The first integrand whose integral is no finite number.
    pub(crate) fn overflow(&self) -> Option<String> {
        let tables = [Some(&self.surface), self.volume.as_ref()];
        let mut entries = tables.into_iter().flatten().flat_map(|table| &table.0);
        let monomial = entries.find(|(_, value)| !value.is_finite());
        let of = self.of.as_ref().filter(|of| {
            !of.surface.is_finite() || of.volume.is_some_and(|volume| !volume.is_finite())
        });
        let monomial = monomial.map(|(exponents, _)| name(*exponents));
        monomial.or_else(|| of.map(|of| of.polynomial.clone()))
    }

    /// Tables of everything.
    pub(crate) fn table(&self) -> String {
        let over = |what: &str| format!("{what:>20}");
        let columns = over("surface")
            + &self
                .volume
                .as_ref()
                .map_or(String::new(), |_| over("volume"));
        let mut text = format!("{:<24}{columns}\n", "integral of");
        for (at, (exponents, value)) in self.surface.0.iter().enumerate() {
            let volume = self.volume.as_ref().map(|volume| volume.0[at].1);
            text += &line(&name(*exponents), *value, volume);
        }
        if let Some(of) = &self.of {
            text += &line(&of.polynomial, of.surface, of.volume);
        }
        text += &self.moments_table();
        text += &self.faces_table();
        if let Some([x, y, z]) = self.signed {
            text += &format!(
                "signed: over the surface, faces that show their front to ({x}, {y}, {z}) count positive, \
                 their back negative\n"
            );
        }
        for note in &self.notes {
            text += &format!("note: {note}\n");
        }
        text
    }

    fn moments_table(&self) -> String {
        let of = self.moments_of;
        let rows = [
            ("first moments", "x, y, z", self.first_moments),
            ("second moments", "x^2, y^2, z^2", self.second_moments),
            (
                "products of inertia",
                "yz, xz, xy",
                self.products_of_inertia,
            ),
        ];
        let mut text = String::new();
        for (name, integrands, values) in rows {
            let values = values.map(figure).concat();
            text += &format!("{name:<24}{values}  ({integrands} over the {of})\n");
        }
        text
    }

    fn faces_table(&self) -> String {
        let mut text = format!("{:<24}{:>20}{:>20}\n", "face", "area", "normal");
        for (at, face) in self.faces.iter().take(FACES_SHOWN).enumerate() {
            let normal = face.normal.map(figure).concat();
            text += &format!("{at:<24}{}{normal}\n", figure(face.area));
        }
        let more = self.faces.len().saturating_sub(FACES_SHOWN);
        if more > 0 {
            text += &format!("… and {more} more faces; --json lists all\n");
        }
        text
    }
}

/// A line of integrals over the surface and the volume.
fn line(name: &str, surface: f64, volume: Option<f64>) -> String {
    let volume = volume.map_or(String::new(), figure);
    format!("{name:<24}{}{volume}\n", figure(surface))
}

impl MonomialTable {
    fn of(integrals: &MonomialIntegrals, highest: u32) -> Self {
        let exponents = integrals.exponents().iter();
        let asked = exponents.filter(|&&exponents| degree(exponents) <= highest);
        Self(asked.map(|&e| (e, integrals.of(e))).collect())
    }
}

impl TenIntegrals {
    fn of(volume: &MonomialIntegrals) -> Self {
        let of = |exponents| volume.of(exponents);
        Self {
            t1: of([0, 0, 0]),
            tx: of([1, 0, 0]),
            ty: of([0, 1, 0]),
            tz: of([0, 0, 1]),
            txx: of([2, 0, 0]),
            tyy: of([0, 2, 0]),
            tzz: of([0, 0, 2]),
            txy: of([1, 1, 0]),
            tyz: of([0, 1, 1]),
            tzx: of([1, 0, 1]),
        }
    }
}

/// A monomial as one writes it.
fn name(exponents: Exponents) -> String {
    let factors = ["x", "y", "z"].iter().zip(exponents);
    let factors = factors
        .filter(|(_, power)| *power > 0)
        .map(|(axis, power)| {
            if power == 1 {
                (*axis).to_owned()
            } else {
                format!("{axis}^{power}")
            }
        });
    let name = factors.collect::<Vec<_>>().join(" ");
    if name.is_empty() {
        "1".to_owned()
    } else {
        name
    }
}

/// Area and normal of every polygon, which are runs of triangles with one number; without numbers,
/// of every triangle.
pub(crate) fn face_figures(surface: &SurfaceMesh, polygons: &[u32]) -> Faces {
    let all: Vec<[Point3<f64>; 3]> = surface.all_corners().collect();
    let number = |at: usize| polygons.get(at).map_or(at, |&polygon| polygon as usize);
    let numbered: Vec<_> = (0..all.len()).map(|at| (number(at), all[at])).collect();
    let (mut figures, mut bent) = (Vec::new(), Vec::new());
    for run in numbered.chunk_by(|one, other| one.0 == other.0) {
        let doubled = |[a, b, c]: &[Point3<f64>; 3]| (b - a).cross(&(c - a));
        let normals: Vec<Vector3<f64>> = run.iter().map(|(_, corners)| doubled(corners)).collect();
        let area = normals.iter().map(Vector3::norm).sum::<f64>() / 2.0;
        let total: Vector3<f64> = normals.iter().sum();
        let normal = total.try_normalize(0.0).unwrap_or_default();
        let depth = depth(run.iter().flat_map(|(_, corners)| corners), &normal);
        if run.len() > 1 && depth > 0.0 {
            bent.push((figures.len(), depth));
        }
        let normal = normal.into();
        figures.push(FaceFigures { area, normal });
    }
    let note = bent_note(&bent);
    Faces { figures, note }
}

/// The note on faces that are not planar, with the depth of each.
fn bent_note(bent: &[(usize, f64)]) -> Option<String> {
    bent.first().map(|(face, depth)| {
        let (count, depth) = (bent.len(), brief(*depth));
        format!("not planar: {count} of the faces, the first face {face}, with corners {depth} apart along its normal; their triangles are integrated")
    })
}

/// How far corners lie apart along a normal; 0 where it is rounding.
fn depth<'a>(corners: impl Iterator<Item = &'a Point3<f64>>, normal: &Vector3<f64>) -> f64 {
    let corners: Vec<_> = corners.collect();
    let offsets = corners.iter().map(|corner| *corner - corners[0]);
    let (mut low, mut high, mut size) = (0.0_f64, 0.0_f64, 0.0_f64);
    for offset in offsets {
        let height = offset.dot(normal);
        (low, high, size) = (low.min(height), high.max(height), size.max(offset.norm()));
    }
    if high - low > PLANAR * size {
        high - low
    } else {
        0.0
    }
}
