//! 3MF packages: the meshes that their build items place, components within components, as one surface.
//!
//! A package is a ZIP archive whose `.rels` names the model, an XML file of objects (a mesh or
//! components) and build items; either is placed by twelve numbers, the rows of a 4×3 matrix M with
//! [x y z 1] M the new place. Components may lie in other models of the package (the production
//! extension's `path`). Objects for support are left out. Format: 3MF Core Specification 1.3.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::mesh::formats::error::{ErrorKind, ParseError};
use crate::mesh::formats::mesh::{Mesh, MeshFile, not_empty};
use crate::mesh::formats::words::{integer, line_of, shown};
use crate::mesh::formats::xml::{Tag, next_tag};
use crate::mesh::formats::zip::ZipArchive;
use crate::mesh::surface::SurfaceMesh;

/// Components nest at most so deep.
const DEEPEST: usize = 32;

/// At most so many placements, and triangles after them, are made of a package: components of
/// components could multiply without end.
const MOST_PLACEMENTS: usize = 100_000;
const MOST_TRIANGLES: usize = 100_000_000;

/// Reads all that the build places.
pub(crate) fn read(bytes: &[u8]) -> Result<MeshFile, ParseError> {
    let archive = ZipArchive::new(bytes).map_err(ParseError::whole)?;
    let main = main_model(&archive)?;
    let mut package = Package {
        archive,
        models: HashMap::new(),
        mesh: SurfaceMesh::default(),
        placements: 0,
        left_out: 0,
    };
    package.load(&main)?;
    let model = &package.models[&main];
    let (unit, items) = (model.unit.clone(), model.items.clone());
    for item in &items {
        package.add(item, &main, &Placing::Identity, 0)?;
    }
    let notes = package.notes(&unit);
    let what = "objects in its build";
    let mesh = not_empty(package.mesh, what, "export it with the objects to print")?;
    let file = MeshFile::plain(Mesh::Surface(mesh));
    Ok(MeshFile { notes, ..file })
}

/// The name of the model in which the build stands.
fn main_model(archive: &ZipArchive<'_>) -> Result<String, ParseError> {
    let relations = archive.file("_rels/.rels").map_err(ParseError::whole)?;
    let relations = relations.unwrap_or_default();
    let mut position = 0;
    while let Some(tag) = next_tag(&relations, position) {
        position = tag.end;
        let kind = tag.attribute("Type").unwrap_or_default();
        if tag.name == b"Relationship" && kind.ends_with(b"/3dmodel") {
            return Ok(text(tag.attribute("Target").unwrap_or_default()));
        }
    }
    let model = archive.names().find(|name| name.ends_with(".model"));
    let what = "3-D model; it is a ZIP archive of other files";
    model
        .map(str::to_owned)
        .ok_or_else(|| ParseError::missing(what, "give a 3MF package, or unpack it"))
}

/// Where an object or a component is placed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Placing {
    Identity,
    /// The rows of M.
    Matrix([f64; 12]),
}

impl Placing {
    fn point(&self, point: &Point3<f64>) -> Point3<f64> {
        let Self::Matrix(m) = self else {
            return *point;
        };
        Point3::from(std::array::from_fn(|axis| {
            point.x * m[axis] + point.y * m[3 + axis] + point.z * m[6 + axis] + m[9 + axis]
        }))
    }

    /// This placing, then `outer`.
    fn then(&self, outer: &Self) -> Self {
        let (Self::Matrix(inner), Self::Matrix(_)) = (self, outer) else {
            return if *self == Self::Identity {
                *outer
            } else {
                *self
            };
        };
        let origin = outer.point(&Point3::origin());
        let mut rows = [0.0; 12];
        for row in 0..4 {
            let point = Point3::from_slice(&inner[3 * row..3 * row + 3]);
            let placed = outer.point(&point);
            for axis in 0..3 {
                let shift = if row < 3 { origin[axis] } else { 0.0 };
                rows[3 * row + axis] = placed[axis] - shift;
            }
        }
        Self::Matrix(rows)
    }

    /// Whether left and right are exchanged.
    fn mirrors(&self) -> bool {
        let Self::Matrix(m) = self else { return false };
        nalgebra::Matrix3::from_row_slice(&m[..9]).determinant() < 0.0
    }
}

/// A build item or a component.
#[derive(Clone, Debug)]
struct Reference {
    /// The model that holds the object, if not the one that refers to it.
    path: Option<String>,
    object: i64,
    placing: Placing,
    line: usize,
}

#[derive(Clone, Debug, Default)]
struct Object {
    is_support: bool,
    mesh: SurfaceMesh,
    components: Vec<Reference>,
}

#[derive(Clone, Debug, Default)]
struct Model {
    unit: String,
    objects: HashMap<i64, Object>,
    items: Vec<Reference>,
}

struct Package<'a> {
    archive: ZipArchive<'a>,
    models: HashMap<String, Model>,
    mesh: SurfaceMesh,
    placements: usize,
    /// How many placed objects are for support.
    left_out: usize,
}

impl Package<'_> {
    /// Parses the model of this name, once.
    fn load(&mut self, name: &str) -> Result<(), ParseError> {
        if self.models.contains_key(name) {
            return Ok(());
        }
        let content = self.archive.file(name).map_err(ParseError::whole)?;
        let missing = || {
            let kind = ErrorKind::Damaged(format!("the package lacks {}", shown(name.as_bytes())));
            ParseError::whole(kind)
        };
        let model = Model::parse(&content.ok_or_else(missing)?)?;
        self.models.insert(name.to_owned(), model);
        Ok(())
    }

    /// Adds the object that `reference` in the model `home` names, placed by `outer` too.
    fn add(
        &mut self,
        reference: &Reference,
        home: &str,
        outer: &Placing,
        depth: usize,
    ) -> Result<(), ParseError> {
        let on_line = |kind| ParseError::on_line(reference.line, kind);
        let name = reference.path.clone().unwrap_or_else(|| home.to_owned());
        self.load(&name)?;
        let object = self.models[&name].objects.get(&reference.object);
        let Some(object) = object.cloned() else {
            let found = reference.object.to_string();
            return Err(on_line(ErrorKind::expected("an object's number", found)));
        };
        self.placements += 1;
        let triangles = self.mesh.triangles.len() + object.mesh.triangles.len();
        if depth > DEEPEST || self.placements > MOST_PLACEMENTS || triangles > MOST_TRIANGLES {
            let what = "a package whose components multiply without end";
            return Err(on_line(ErrorKind::unsupported(
                what,
                "export one plain mesh",
            )));
        }
        if object.is_support {
            self.left_out += 1;
            return Ok(());
        }
        let placing = reference.placing.then(outer);
        self.append(&object.mesh, &placing).map_err(on_line)?;
        let mut components = object.components.iter();
        components.try_for_each(|component| self.add(component, &name, &placing, depth + 1))
    }

    fn append(&mut self, mesh: &SurfaceMesh, placing: &Placing) -> Result<(), ErrorKind> {
        let base = self.mesh.vertices.len();
        ErrorKind::check_limit("vertices", base + mesh.vertices.len())?;
        let placed = mesh.vertices.iter().map(|vertex| placing.point(vertex));
        self.mesh.vertices.extend(placed);
        let mirrors = placing.mirrors();
        self.mesh
            .triangles
            .extend(mesh.triangles.iter().map(|triangle| {
                let [a, b, c] = triangle.map(|vertex| vertex + base as u32);
                if mirrors { [a, c, b] } else { [a, b, c] }
            }));
        Ok(())
    }

    fn notes(&self, unit: &str) -> Vec<String> {
        let mut notes = vec![format!("lengths are in the file's unit, the {unit}")];
        if self.left_out > 0 {
            let count = self.left_out;
            notes.push(format!("{count} objects for support are left out"));
        }
        if self.has_modifiers() {
            notes.push(
                "modifiers of the slicer count as parts of the solid; export without them"
                    .to_owned(),
            );
        }
        notes
    }

    /// Whether the settings of a slicer name modifiers.
    fn has_modifiers(&self) -> bool {
        let settings = ["Slic3r_PE_model.config", "model_settings.config"];
        let settings = settings.map(|name| self.archive.file(&format!("Metadata/{name}")));
        let names_some = |text: Vec<u8>| {
            text.windows(8)
                .any(|word| word == b"odifier\"" || word == b"odifier_")
        };
        let mut texts = settings.into_iter().filter_map(|file| file.ok().flatten());
        texts.any(names_some)
    }
}

impl Model {
    fn parse(bytes: &[u8]) -> Result<Self, ParseError> {
        let mut model = Self {
            unit: "millimeter".to_owned(),
            ..Self::default()
        };
        let (mut position, mut current) = (0, 0);
        while let Some(tag) = next_tag(bytes, position) {
            position = tag.end;
            let read = model.read_tag(&tag, &mut current, || line_of(bytes, tag.end));
            read.map_err(|kind| ParseError::on_line(line_of(bytes, tag.end), kind))?;
            if tag.name == b"/model" {
                return Ok(model);
            }
        }
        let expected = "</model>";
        let kind = ErrorKind::Truncated { expected };
        Err(ParseError::on_line(line_of(bytes, bytes.len()), kind))
    }

    /// Takes up a tag within the object numbered `current`.
    fn read_tag(
        &mut self,
        tag: &Tag<'_>,
        current: &mut i64,
        line: impl Fn() -> usize,
    ) -> Result<(), ErrorKind> {
        match tag.name {
            b"model" => {
                if let Some(unit) = tag.attribute("unit") {
                    self.unit = text(unit);
                }
            }
            b"object" => {
                *current = whole(tag, "id")?;
                let kind = tag.attribute("type").unwrap_or(b"model");
                let object = Object {
                    is_support: !matches!(kind, b"model" | b"surface"),
                    ..Object::default()
                };
                self.objects.insert(*current, object);
            }
            b"item" => self.items.push(reference(tag, line())?),
            b"component" => {
                let component = reference(tag, line())?;
                self.object(*current)?.components.push(component);
            }
            b"vertex" => {
                let [x, y, z] = ["x", "y", "z"].map(|name| coordinate(tag, name));
                let vertices = &mut self.object(*current)?.mesh.vertices;
                vertices.push(Point3::new(x?, y?, z?));
                ErrorKind::check_limit("vertices", vertices.len())?;
            }
            b"triangle" => {
                let corners = ["v1", "v2", "v3"].map(|name| whole(tag, name));
                let mesh = &mut self.object(*current)?.mesh;
                let mut triangle = [0; 3];
                for (corner, index) in triangle.iter_mut().zip(corners) {
                    *corner = ErrorKind::check_vertex(index?, mesh.vertices.len(), 0)?;
                }
                mesh.triangles.push(triangle);
                ErrorKind::check_limit("triangles", mesh.triangles.len())?;
            }
            _ => {}
        }
        Ok(())
    }

    fn object(&mut self, number: i64) -> Result<&mut Object, ErrorKind> {
        let missing = || ErrorKind::expected("an object around it", "none");
        self.objects.get_mut(&number).ok_or_else(missing)
    }
}

fn reference(tag: &Tag<'_>, line: usize) -> Result<Reference, ErrorKind> {
    let path = tag.attribute("p:path").or_else(|| tag.attribute("path"));
    let placing = match tag.attribute("transform") {
        None => Placing::Identity,
        Some(numbers) => Placing::Matrix(matrix(numbers)?),
    };
    Ok(Reference {
        path: path.map(text),
        object: whole(tag, "objectid")?,
        placing,
        line,
    })
}

fn matrix(numbers: &[u8]) -> Result<[f64; 12], ErrorKind> {
    let words = numbers.split(u8::is_ascii_whitespace);
    let words = words.filter(|word| !word.is_empty());
    let numbers: Vec<f64> = words.map(number).collect::<Result<_, _>>()?;
    let count = numbers.len().to_string();
    <[f64; 12]>::try_from(numbers)
        .map_err(|_| ErrorKind::expected("twelve numbers of a transform", count))
}

fn number(word: &[u8]) -> Result<f64, ErrorKind> {
    let found = shown(word);
    let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
    match parsed {
        Some(number) if f64::is_finite(number) => Ok(number),
        Some(_) => Err(ErrorKind::NotFinite { found }),
        None => Err(ErrorKind::expected("a number", found)),
    }
}

fn coordinate(tag: &Tag<'_>, name: &'static str) -> Result<f64, ErrorKind> {
    let missing = || ErrorKind::expected("the coordinates x, y and z", "less");
    number(tag.attribute(name).ok_or_else(missing)?.trim_ascii())
}

fn whole(tag: &Tag<'_>, name: &str) -> Result<i64, ErrorKind> {
    let word = tag.attribute(name).unwrap_or_default().trim_ascii();
    let found = format!("{name}={}", shown(word));
    integer(word).ok_or_else(|| ErrorKind::expected("a whole number", found))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
