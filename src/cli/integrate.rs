//! `chebloyd integrate`: integrals of polynomials over surfaces and solids.

use std::path::{Path, PathBuf};

use clap::Args;
use nalgebra::{Point3, Vector3};

use crate::integrals::monomials::MonomialIntegrals;
use crate::integrals::polynomial::Polynomial;
use crate::integrals::polynomial_text::HIGHEST_DEGREE;
use crate::mesh::formats::mesh::{Mesh, MeshFile};
use crate::mesh::formats::read::{LabeledSolid, read_file};
use crate::mesh::report::Refusal;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{Solid, check_elements};

use crate::cli::failure::{Failure, print_report};
use crate::cli::integrate_report::{Asked, Integrals, IntegralsReport, face_figures};

/// Print integrals of polynomials over a surface and the solid within it, exactly
///
/// The double integrals over the surface and the triple integrals over the volume of every monomial
/// x^a y^b z^c up to a degree, with [Cattani & Paoluzzi]'s first and second moments and products of
/// inertia, [Mirtich]'s ten integrals, and every face's area and normal. An open surface has no volume:
/// its moments are those of the surface. Any mesh is read, Mirtich's own ASCII polyhedra, and polygons
/// with holes as JSON: {"vertices": [[x,y,z],…], "faces": [[outer loop, hole, …],…]}, loops being lists of
/// vertices counted from zero.
#[derive(Debug, Args)]
pub(crate) struct IntegrateOptions {
    /// A surface, open or closed, tetrahedra, or polygons with holes
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The highest degree of the monomials
    #[arg(long, value_name = "D", default_value_t = 2,
          value_parser = clap::value_parser!(u32).range(0..=i64::from(HIGHEST_DEGREE)))]
    monomials: u32,
    /// Also the integral of this polynomial, such as '1 + 2*x - 0.5*y*z^3'
    #[arg(long, value_name = "POLYNOMIAL", allow_hyphen_values = true)]
    of: Option<String>,
    /// Over the surface, count faces that show their front to this direction positive, their back
    /// negative, on edge not at all: so a fan of triangles is the polygon it spans
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, allow_hyphen_values = true)]
    signed: Option<[f64; 3]>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(options: &IntegrateOptions) -> Result<(), Failure> {
    let of = options.of.as_deref().map(polynomial).transpose()?;
    let body = IntegrationBody::read(&options.file)?;
    let highest = of.as_ref().map_or(0, |(_, polynomial)| polynomial.degree());
    let integrals = body.integrals(options, highest.max(options.monomials).max(2));
    let asked = Asked {
        degree: options.monomials,
        of,
        signed: options.signed,
    };
    let faces = face_figures(&body.surface, &body.polygons);
    let mut report = IntegralsReport::new(&asked, &integrals, faces.figures);
    report.notes = body.notes;
    report.notes.extend(faces.note);
    if let Some(what) = report.overflow() {
        let file = options.file.display();
        return Err(Failure::run(format!(
            "{file}: the integral of {what} is no 64-bit number; scale the mesh or lower the degree"
        )));
    }
    print_report(&report, options.json, || report.table())
}

/// A polynomial with its text.
fn polynomial(text: &str) -> Result<(String, Polynomial), Failure> {
    let parsed = text.parse::<Polynomial>();
    parsed
        .map(|polynomial| (text.to_owned(), polynomial))
        .map_err(|error| {
            Failure::input(format!(
                "--of: `{text}` is not a polynomial in x, y, z: {error}"
            ))
        })
}

/// Three numbers that are not all zero.
fn direction(text: &str) -> Result<[f64; 3], String> {
    let numbers = text.split(',').map(|number| {
        let number = number.trim().parse::<f64>().ok();
        number.filter(|number| number.is_finite())
    });
    let numbers: Option<Vec<f64>> = numbers.collect();
    match numbers.as_deref() {
        Some(&[0.0, 0.0, 0.0]) => Err("a direction has a length, such as 0,0,1".into()),
        Some(&[x, y, z]) => Ok([x, y, z]),
        _ => Err("three numbers separated by commas are needed, such as 0,0,1".into()),
    }
}

/// What is integrated over.
struct IntegrationBody {
    surface: SurfaceMesh,
    /// The polygon of every triangle; empty where every triangle is a face of its own.
    polygons: Vec<u32>,
    is_closed: bool,
    tets: Option<TetMesh>,
    notes: Vec<String>,
}

impl IntegrationBody {
    fn read(path: &Path) -> Result<Self, Failure> {
        let file = read_file(path).map_err(Failure::input)?;
        let refused = |refusal: Refusal| {
            let path = path.display();
            Failure::input(format!("{path} {refusal}"))
        };
        match LabeledSolid::of(&file, 0.0) {
            Ok(solid) => Ok(Self::of_solid(solid)),
            Err(refusal) => Self::open(file, &refusal).ok_or_else(|| refused(refusal)),
        }
    }

    /// A solid, within its surface or given by tetrahedra.
    fn of_solid(labeled: LabeledSolid) -> Self {
        let LabeledSolid {
            solid, elements, ..
        } = labeled;
        let notes = solid.notes();
        let (surface, tets) = match solid {
            Solid::Surface(surface, _) => (surface.into_mesh(), None),
            Solid::Tets(tets, _) => (tets.mesh().boundary(), Some(tets.into_mesh())),
        };
        Self {
            polygons: elements.polygons,
            is_closed: true,
            surface,
            tets,
            notes,
        }
    }

    /// A surface that bounds no solid; none if it is no surface either.
    fn open(file: MeshFile, refusal: &Refusal) -> Option<Self> {
        let Mesh::Surface(surface) = file.mesh else {
            return None;
        };
        check_elements(&surface.vertices, &surface.triangles, "triangles").ok()?;
        let note = format!("the surface {refusal}; so there are no integrals over a volume");
        Some(Self {
            surface,
            polygons: file.elements.polygons,
            is_closed: false,
            tets: None,
            notes: vec![note],
        })
    }

    fn integrals(&self, options: &IntegrateOptions, degree: u32) -> Integrals {
        let side = options.signed.map(Vector3::from);
        let (vertices, triangles): (&[Point3<f64>], _) =
            (&self.surface.vertices, &self.surface.triangles);
        let surface = MonomialIntegrals::over_surface(vertices, triangles, degree, side.as_ref());
        let volume = match &self.tets {
            Some(tets) => Some(MonomialIntegrals::over_solid(
                &tets.vertices,
                &tets.tets,
                degree,
            )),
            None => self
                .is_closed
                .then(|| MonomialIntegrals::over_solid(vertices, triangles, degree)),
        };
        Integrals { surface, volume }
    }
}
