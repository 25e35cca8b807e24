//! Solids that `chebloyd spin` reads, and their elements: cells, vertices or points.

use std::path::PathBuf;
use std::str::FromStr;

use nalgebra::Point3;

use crate::balance::bases::{WeightedPoint, eighths, of_cells, of_vertices, points, tetrahedra};
use crate::cli::failure::Failure;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::geometry::moments::Moments;
use crate::integrals::mesh_moments::constant;
use crate::mesh::formats::read::load_within;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::validate::{Solid, validate_surface};
use crate::relax::method::Method;
use crate::relax::relaxation::{Relaxation, random_sites};
use crate::relax::relaxation_space::Norm;
use crate::scene::domain::SceneDomain;
use crate::scene::mesh_domain::MeshDomain;
use crate::voronoi::diagram::Diagram;

/// Moves of Lloyd's iteration that make random cells round and of like size.
const MOVES: u64 = 10;

/// Points that a cell's part of the solid gives at least.
const POINTS_PER_CELL: usize = 100;

/// More elements than this need more memory than most machines have.
const MOST_ELEMENTS: usize = 50_000_000;

/// What carries one density each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Basis {
    /// Voronoi cells, so many.
    Cells(usize),
    /// Points, at least so many.
    Points(usize),
    /// The vertices of a tetrahedral mesh.
    Vertex,
}

impl FromStr for Basis {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = "the basis is cells:N, points:N or vertex";
        if text == "vertex" {
            return Ok(Self::Vertex);
        }
        let (kind, count) = text.split_once(':').ok_or(known)?;
        let count = count.parse::<usize>().ok();
        let count = count.filter(|count| (1..=MOST_ELEMENTS).contains(count));
        let count = count.ok_or(format!("N is a whole number from 1 to {MOST_ELEMENTS}"))?;
        match kind {
            "cells" => Ok(Self::Cells(count)),
            "points" => Ok(Self::Points(count)),
            _ => Err(known.to_owned()),
        }
    }
}

/// One solid, of one file or of several.
#[derive(Debug)]
pub(crate) struct SpinSolid {
    /// Its boundary as a domain.
    pub(crate) domain: SurfaceSolid,
    /// The solid; several as the surface of all.
    pub(crate) solid: Solid,
    /// The domain for a field file; none of several files.
    pub(crate) scene_domain: Option<SceneDomain>,
    /// What was repaired.
    pub(crate) notes: Vec<String>,
}

/// The elements of a solid.
#[derive(Debug)]
pub(crate) enum SpinElements {
    /// Cells of sites.
    Cells(Vec<Point3<f64>>, Vec<Moments>),
    /// Points of these tetrahedra.
    Points(Vec<[Point3<f64>; 4]>, Vec<Moments>),
    /// Hat functions of vertices.
    Vertices(Vec<Moments>),
}

impl SpinElements {
    /// The moments of each.
    pub(crate) fn moments(&self) -> &[Moments] {
        match self {
            Self::Cells(_, moments) | Self::Points(_, moments) | Self::Vertices(moments) => moments,
        }
    }

    /// What they are called.
    pub(crate) fn kind(&self) -> &'static str {
        match self {
            Self::Cells(..) => "cells",
            Self::Points(..) => "points",
            Self::Vertices(_) => "vertices",
        }
    }

    /// Eight times as many points, to tell how far a formula's own moments are from those of the points.
    pub(crate) fn finer(&self) -> Vec<WeightedPoint> {
        match self {
            Self::Points(tets, _) => points(&eighths(tets)),
            _ => Vec::new(),
        }
    }
}

impl SpinSolid {
    /// The solid of all files together; vertices up to `weld` apart (L) are merged in open ones.
    pub(crate) fn read(files: &[PathBuf], weld: Option<f64>) -> Result<Self, Failure> {
        let solids: Vec<Solid> = files
            .iter()
            .map(|file| load_within(file, weld.unwrap_or(0.0)).map_err(Failure::input))
            .collect::<Result<_, _>>()?;
        let mut notes = Vec::new();
        for (file, solid) in files.iter().zip(&solids) {
            let of_file = solid.notes().into_iter();
            notes.extend(of_file.map(|note| format!("{}: {note}", file.display())));
        }
        let names: Vec<_> = files
            .iter()
            .map(|file| file.display().to_string())
            .collect();
        let united = united(&solids)
            .map_err(|reason| Failure::input(format!("{}: {reason}", names.join(", "))))?;
        let Solid::Surface(surface, _) = &united else {
            return Err(Failure::run("the solids have no surface"));
        };
        let domain = SurfaceSolid::new(surface).map_err(Failure::input)?;
        let scene_domain = match (&solids[..], files) {
            ([solid], [file]) => Some(scene_domain(solid, file, weld)?),
            _ => None,
        };
        let solid = match <[Solid; 1]>::try_from(solids) {
            Ok([solid]) => solid,
            Err(_) => united,
        };
        Ok(Self {
            domain,
            solid,
            scene_domain,
            notes,
        })
    }

    /// Its moments at density 1, measured from `origin`.
    pub(crate) fn moments(&self, origin: &Point3<f64>) -> Moments {
        let surface = self.domain.surface();
        constant(&surface.vertices, &surface.triangles, origin)
    }

    /// The elements of a basis, measured from `origin`.
    pub(crate) fn elements(
        &self,
        basis: Basis,
        seed: u64,
        origin: &Point3<f64>,
    ) -> Result<SpinElements, Failure> {
        match basis {
            Basis::Vertex => match &self.solid {
                Solid::Tets(tets, _) => {
                    Ok(SpinElements::Vertices(of_vertices(tets.mesh(), origin)))
                }
                Solid::Surface(..) => Err(Failure::input(
                    "--basis vertex needs one tetrahedral mesh; for a surface choose cells:N",
                )),
            },
            Basis::Cells(count) => {
                let sites = self.sites(count, seed)?;
                let diagram = Diagram::new(&self.domain, &sites).map_err(Failure::run)?;
                let moments = of_cells(&diagram, origin).map_err(Failure::run)?;
                Ok(SpinElements::Cells(sites, moments))
            }
            Basis::Points(count) => {
                let sites = self.sites(count.div_ceil(POINTS_PER_CELL), seed)?;
                let diagram = Diagram::new(&self.domain, &sites).map_err(Failure::run)?;
                let mut tets = tetrahedra(&diagram).map_err(Failure::run)?;
                while 4 * tets.len() < count {
                    tets = eighths(&tets);
                }
                let points = points(&tets);
                let moments = points.iter().map(|point| point.moments(origin)).collect();
                Ok(SpinElements::Points(tets, moments))
            }
        }
    }

    /// Random sites, relaxed for a few moves.
    fn sites(&self, count: usize, seed: u64) -> Result<Vec<Point3<f64>>, Failure> {
        let mut sites = random_sites(&self.domain, count, seed).map_err(Failure::run)?;
        let lloyd = Method::lloyd(MOVES).norm(Norm::L2);
        let relaxation = Relaxation::new(self.domain.clone()).method(lloyd);
        relaxation.run(&mut sites).map_err(Failure::run)?;
        Ok(sites)
    }
}

/// The solid within the surfaces of all.
fn united(solids: &[Solid]) -> Result<Solid, String> {
    let mut all = SurfaceMesh::default();
    for solid in solids {
        match solid {
            Solid::Surface(surface, _) => all.append(surface.mesh()),
            Solid::Tets(tets, _) => all.append(&tets.mesh().boundary()),
        }
    }
    let (surface, report) = validate_surface(&all).map_err(|refusal| refusal.to_string())?;
    if let Some(reason) = report.no_domain() {
        return Err(format!("the surface {reason}"));
    }
    Ok(Solid::Surface(surface, report))
}

/// The domain of a file, by its full path.
fn scene_domain(
    solid: &Solid,
    file: &std::path::Path,
    weld: Option<f64>,
) -> Result<SceneDomain, Failure> {
    let full = file
        .canonicalize()
        .map_err(|error| Failure::input(format!("cannot find {}: {error}", file.display())))?;
    let mesh = MeshDomain {
        file: full,
        scale_to: None,
        weld,
    };
    Ok(match solid {
        Solid::Surface(..) => SceneDomain::Surface(mesh),
        Solid::Tets(..) => SceneDomain::Tets(mesh),
    })
}
