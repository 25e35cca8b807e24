//! `density.vtu` and the picture of a cut, of a density over solids: for `mass`, `stand` and `spin`.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use nalgebra::{Point3, Vector3};

use crate::cli::cell_files::PNG_SCALE;
use crate::cli::failure::{Failure, write_file};
use crate::complex::assemble::assemble_whole;
use crate::domain::domain::Domain;
use crate::domain::tri_surface::solid::SurfaceSolid;
use crate::export::field_vtu::write_simplices;
use crate::export::mesh_vtu::{CellColumn, write_mesh};
use crate::geometry::bounds::Bounds;
use crate::geometry::half_space::HalfSpace;
use crate::mass::density::SolidDensity;
use crate::mass::evaluate::DensityFunction;
use crate::mass::linear_pieces::{LinearPieces, WeighError, linear_pieces};
use crate::mesh::slabs::slabs;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::Solid;
use crate::parallel::map;
use crate::plot::color::Color;
use crate::plot::density_cut::{DensityCut, Mark, MarkShape, density_cut};
use crate::plot::patches::PlaneCut;
use crate::plot::png::png;
use crate::plot::svg::svg;
use crate::scene::field::{Field, FieldError, shape};
use crate::voronoi::diagram::Diagram;

/// What [`write_density`] writes.
const FILES: [&str; 3] = ["density.vtu", "section.svg", "section.png"];

/// Solids, each with its density, and the box of them all.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DensityBody<'a> {
    pub(crate) solids: &'a [Solid],
    /// One for each.
    pub(crate) fields: &'a [&'a Field],
    pub(crate) extent: &'a Bounds<3>,
}

/// How a density's picture is cut, and what is marked in it.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    /// The plane and the directions of the picture.
    pub(crate) cut: PlaneCut,
    /// The title.
    pub(crate) title: String,
    /// The marks, later ones upon earlier ones.
    pub(crate) marks: Vec<Mark>,
}

/// The files that [`write_density`] will write in `folder`.
pub(crate) fn density_files(folder: &Path) -> Vec<PathBuf> {
    FILES.iter().map(|name| folder.join(name)).collect()
}

/// A plane through a place across the axis along which the body is thinnest, seen so that coordinates
/// grow to the right and upward.
pub(crate) fn widest_cut(extent: &Bounds<3>, through: &Point3<f64>) -> PlaneCut {
    coordinate_cut(extent.extent().imin(), through)
}

/// The plane through a place across an axis.
pub(crate) fn coordinate_cut(axis: usize, through: &Point3<f64>) -> PlaneCut {
    let sign = if axis == 1 { -1.0 } else { 1.0 };
    let normal = Vector3::from_fn(|row, _| if row == axis { sign } else { 0.0 });
    PlaneCut::new(HalfSpace {
        normal,
        offset: normal.dot(&through.coords),
    })
}

/// The center of mass as a mark.
pub(crate) fn center_mark(name: &str, color: Color, center: &Point3<f64>) -> Mark {
    let [x, y, z] = <[f64; 3]>::from(*center);
    Mark {
        name: format!("{name} ({x:.5}, {y:.5}, {z:.5})"),
        color,
        shape: MarkShape::Point(*center),
    }
}

/// Writes the files of a density into `folder`, which is made if it is not there.
pub(crate) fn write_density(
    folder: &Path,
    body: DensityBody<'_>,
    section: &Section,
) -> Result<(), Failure> {
    make_folder(folder)?;
    write_vtu(&folder.join(FILES[0]), body)?;
    let density = body.function()?;
    let figure = density_cut(&DensityCut {
        surface: &body.surface(),
        cut: section.cut,
        density: &density,
        title: &section.title,
        marks: &section.marks,
    });
    let bytes = png(&figure, PNG_SCALE).map_err(Failure::run)?;
    let text = svg(&figure);
    for (name, bytes) in FILES[1..].iter().zip([text.as_bytes(), &bytes]) {
        write_file(&folder.join(name), |file| file.write_all(bytes)).map_err(Failure::run)?;
    }
    Ok(())
}

fn make_folder(folder: &Path) -> Result<(), Failure> {
    fs::create_dir_all(folder)
        .map_err(|error| Failure::input(format!("cannot make {}: {error}", folder.display())))
}

impl DensityBody<'_> {
    /// The boundaries of all solids.
    fn surface(&self) -> SurfaceMesh {
        let mut all = SurfaceMesh::default();
        for solid in self.solids {
            append(&mut all, boundary(solid));
        }
        all
    }

    /// The density of the solid at a point; of several solids the first that holds it.
    fn function(&self) -> Result<DensityFunction<'_>, Failure> {
        let pairs = self.solids.iter().zip(self.fields);
        let functions = pairs.map(|(solid, field)| field.function(solid, self.extent));
        let mut functions = functions
            .collect::<Result<Vec<_>, FieldError>>()
            .map_err(Failure::input)?;
        if functions.len() == 1 {
            return Ok(functions.remove(0));
        }
        let shapes: Vec<SurfaceSolid> = (self.solids.iter().map(shape))
            .collect::<Result<_, _>>()
            .map_err(Failure::input)?;
        Ok(Box::new(move |point| {
            let holder = shapes
                .iter()
                .position(|shape| shape.shape().contains(point));
            holder.map_or(f64::NAN, |solid| functions[solid](point))
        }))
    }
}

/// Cells as polyhedra with one density each, tetrahedra or else surfaces, with values at the points.
fn write_vtu(path: &Path, body: DensityBody<'_>) -> Result<(), Failure> {
    let failed = |error| Failure::run(format!("cannot write {}: {error}", path.display()));
    match (body.solids, body.fields) {
        ([solid], [Field::Cells { sites, values }]) => {
            let shape = shape(solid).map_err(Failure::input)?;
            let diagram = Diagram::borrowed(&shape, sites).map_err(Failure::input)?;
            let mesh = assemble_whole(&diagram).map_err(Failure::run)?;
            let numbers = CellColumn::Integers((0..sites.len() as i64).collect());
            let reals = CellColumn::Reals(values.clone());
            let columns = [("site", numbers), ("density", reals)];
            write_mesh(path, &mesh, &columns, false).map_err(failed)
        }
        ([solid @ Solid::Tets(sound, _)], [field]) => {
            let LinearPieces { mesh, densities } = pieces(solid, sound.mesh(), field, body.extent)?;
            let columns = [("density", &densities[..])];
            write_simplices(path, &mesh.vertices, &mesh.tets, &columns).map_err(failed)
        }
        _ => {
            let (mut surface, mut values) = (SurfaceMesh::default(), Vec::new());
            for (solid, field) in body.solids.iter().zip(body.fields) {
                let density = field.function(solid, body.extent).map_err(Failure::input)?;
                let part = bent(solid, field);
                values.extend(map(part.vertices.len(), &|vertex| {
                    density(&part.vertices[vertex])
                }));
                append(&mut surface, part);
            }
            let columns = [("density", &values[..])];
            write_simplices(path, &surface.vertices, &surface.triangles, &columns).map_err(failed)
        }
    }
}

/// The triangles that bound a solid.
fn boundary(solid: &Solid) -> SurfaceMesh {
    match solid {
        Solid::Surface(closed, _) => closed.mesh().clone(),
        Solid::Tets(sound, _) => sound.mesh().boundary(),
    }
}

/// The boundary of a solid; where its density bends at planes, that of the slabs between them, in each of
/// which it is linear.
fn bent(solid: &Solid, field: &Field) -> SurfaceMesh {
    let surface = boundary(solid);
    let Field::Solid(SolidDensity::Profile(profile)) = field else {
        return surface;
    };
    let offsets: Vec<f64> = profile.breaks().iter().map(|[place, _]| *place).collect();
    let mut all = SurfaceMesh::default();
    for slab in slabs(&surface, profile.direction(), &offsets) {
        append(&mut all, slab);
    }
    all
}

/// Adds a surface's triangles to others.
fn append(all: &mut SurfaceMesh, part: SurfaceMesh) {
    let first = all.vertices.len() as u32;
    let moved = |triangle: [u32; 3]| triangle.map(|corner| first + corner);
    all.triangles.extend(part.triangles.into_iter().map(moved));
    all.vertices.extend(part.vertices);
}

/// Tetrahedra with the density at their vertices: cut where it bends if it is linear in between, else
/// those of the mesh.
fn pieces(
    solid: &Solid,
    mesh: &TetMesh,
    given: &Field,
    extent: &Bounds<3>,
) -> Result<LinearPieces, Failure> {
    if let Field::Solid(density) = given {
        match linear_pieces(mesh, density, extent) {
            Err(WeighError::NotLinear) => {}
            pieces => return pieces.map_err(Failure::input),
        }
    }
    let densities = match given {
        Field::Vertices(values) => values.clone(),
        Field::Tets(values) => return Ok(apart(mesh, values)),
        _ => {
            let density = given.function(solid, extent).map_err(Failure::input)?;
            map(mesh.vertices.len(), &|vertex| {
                density(&mesh.vertices[vertex])
            })
        }
    };
    let mesh = mesh.clone();
    Ok(LinearPieces { mesh, densities })
}

/// Tetrahedra on vertices of their own, each with its constant density there.
fn apart(mesh: &TetMesh, values: &[f64]) -> LinearPieces {
    let corners = mesh.all_corners().flatten();
    let numbers = (0..mesh.tets.len() as u32).map(|tet| [0, 1, 2, 3].map(|k| 4 * tet + k));
    LinearPieces {
        mesh: TetMesh {
            vertices: corners.collect(),
            tets: numbers.collect(),
            vertex_data: Vec::new(),
        },
        densities: values.iter().flat_map(|&value| [value; 4]).collect(),
    }
}
