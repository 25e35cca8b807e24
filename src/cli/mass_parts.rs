//! The parts of a body that `chebloyd mass` weighs: files, placed, and the groups that they name.

use std::collections::HashMap;
use std::path::Path;

use crate::mesh::elements::Elements;
use crate::mesh::formats::read::{LabeledSolid, LoadError, read_file};
use crate::mesh::report::Refusal;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::{TetMesh, VertexData};
use crate::mesh::validate::{Solid, number_surface, number_tets};
use crate::scene::field::{Field, GivenField};

use crate::cli::failure::Failure;
use crate::cli::mass_place::Placement;

/// The groups' volumes sum to the solid's within this share of it.
const WHOLE: f64 = 1e-9;

/// A file as a solid, where it is placed; vertices up to `weld` apart (L) are merged where it is open.
pub(crate) fn load_placed(
    path: &Path,
    placement: Option<&Placement>,
    weld: f64,
) -> Result<LabeledSolid, Failure> {
    let mut file = read_file(path).map_err(Failure::input)?;
    if let Some(placement) = placement {
        placement.apply(&mut file.mesh);
    }
    LabeledSolid::of(&file, weld).map_err(|refusal| {
        let file = path.to_path_buf();
        Failure::input(LoadError::Refused { file, refusal })
    })
}

/// A named group of a solid, a solid itself.
#[derive(Clone, Debug)]
pub(crate) struct NamedSolid {
    pub(crate) name: String,
    pub(crate) labeled: LabeledSolid,
}

/// The groups of a solid, each a solid; none where it has fewer than two.
///
/// # Errors
/// Why a group is no solid of its own.
pub(crate) fn groups(whole: &LabeledSolid) -> Result<Vec<NamedSolid>, String> {
    let as_read = whole.grouped.as_ref().map(|grouped| &grouped.groups);
    let groups = as_read.unwrap_or(&whole.elements.groups);
    if groups.names().len() < 2 {
        return Ok(Vec::new());
    }
    let mut numbers = vec![Vec::new(); groups.names().len()];
    for (element, &group) in (0_u32..).zip(groups.of_elements()) {
        numbers[group as usize].push(element);
    }
    let mut found = Vec::new();
    let filled = groups.names().iter().zip(&numbers);
    for (name, numbers) in filled.filter(|(_, numbers)| !numbers.is_empty()) {
        let labeled = match (&whole.grouped, &whole.solid) {
            (Some(grouped), _) => surface_group(&grouped.mesh, numbers),
            (None, Solid::Tets(tets, _)) => tet_group(tets.mesh(), &whole.elements, numbers),
            (None, Solid::Surface(surface, _)) => surface_group(surface.mesh(), numbers),
        };
        let labeled = labeled.map_err(|refusal| format!("group `{name}` {refusal}"))?;
        let name = name.clone();
        found.push(NamedSolid { name, labeled });
    }
    let sum: f64 = found.iter().map(|group| group.labeled.solid.volume()).sum();
    let volume = whole.solid.volume();
    if (sum - volume).abs() > WHOLE * volume {
        return Err(format!(
            "the groups' volumes sum to {sum}, the solid's is {volume}: one of them bounds a cavity of \
             another, or lies in it"
        ));
    }
    Ok(found)
}

/// The solid within some triangles.
fn surface_group(mesh: &SurfaceMesh, numbers: &[u32]) -> Result<LabeledSolid, Refusal> {
    let (triangles, vertices) = used(&mesh.triangles, numbers);
    let mesh = SurfaceMesh {
        vertices: (vertices
            .iter()
            .map(|&vertex| mesh.vertices[vertex as usize]))
        .collect(),
        triangles,
    };
    let (surface, report, _) = number_surface(&mesh, 0.0)?;
    Ok(LabeledSolid {
        solid: Solid::Surface(surface, report),
        elements: Elements::default(),
        grouped: None,
    })
}

/// The solid of some tetrahedra, with their values.
fn tet_group(
    mesh: &TetMesh,
    elements: &Elements,
    numbers: &[u32],
) -> Result<LabeledSolid, Refusal> {
    let (tets, vertices) = used(&mesh.tets, numbers);
    let vertex_data = data_of(&mesh.vertex_data, &vertices);
    let mesh = TetMesh {
        vertices: (vertices
            .iter()
            .map(|&vertex| mesh.vertices[vertex as usize]))
        .collect(),
        tets,
        vertex_data,
    };
    let (tets, report, kept) = number_tets(&mesh, 0.0)?;
    Ok(LabeledSolid {
        solid: Solid::Tets(tets, report),
        elements: elements.of_kept(numbers).of_kept(&kept),
        grouped: None,
    })
}

/// Data with their values at some vertices.
fn data_of(data: &[VertexData], vertices: &[u32]) -> Vec<VertexData> {
    let mut data = data.to_vec();
    for field in &mut data {
        let values = vertices.iter().map(|&vertex| field.values[vertex as usize]);
        field.values = values.collect();
    }
    data
}

/// Some elements on the vertices that they use, and which vertices those are.
fn used<const K: usize>(elements: &[[u32; K]], numbers: &[u32]) -> (Vec<[u32; K]>, Vec<u32>) {
    let (mut renumbered, mut vertices) = (HashMap::new(), Vec::new());
    let elements = numbers.iter().map(|&number| {
        elements[number as usize].map(|vertex| {
            *renumbered.entry(vertex).or_insert_with(|| {
                vertices.push(vertex);
                vertices.len() as u32 - 1
            })
        })
    });
    (elements.collect(), vertices)
}

/// A density by its text, for all of a part or for one of its groups.
#[derive(Clone, Debug)]
pub(crate) struct GivenDensity {
    pub(crate) text: String,
    kind: DensityKind,
}

#[derive(Clone, Debug)]
enum DensityKind {
    Field(GivenField),
    /// Cell data of the file, by name.
    Cell(Option<String>),
}

impl GivenDensity {
    /// # Errors
    /// When the text is no density.
    pub(crate) fn read(text: &str) -> Result<Self, Failure> {
        let plain = text.trim();
        let cell = match plain.strip_prefix("cell:") {
            Some(name) => Some(Some(name.trim().to_owned())),
            None => (plain == "cell").then_some(None),
        };
        let kind = match cell {
            Some(name) => DensityKind::Cell(name),
            None => DensityKind::Field(
                GivenField::read(text)
                    .map_err(|error| Failure::input(format!("--density: {error}")))?,
            ),
        };
        let text = plain.to_owned();
        Ok(Self { text, kind })
    }

    /// The field that it is on a solid.
    ///
    /// # Errors
    /// When it needs cell data that the solid's file does not have.
    pub(crate) fn field(&self, labeled: &LabeledSolid) -> Result<GivenField, String> {
        let name = match &self.kind {
            DensityKind::Field(field) => return Ok(field.clone()),
            DensityKind::Cell(name) => name,
        };
        let fields = &labeled.elements.cell_data;
        let names: Vec<_> = fields
            .iter()
            .map(|field| format!("`{}`", field.name))
            .collect();
        let there = if names.is_empty() {
            "none".into()
        } else {
            names.join(", ")
        };
        if matches!(labeled.solid, Solid::Surface(..)) {
            return Err(
                "`cell` density needs a tetrahedral mesh with cell data; this is a surface".into(),
            );
        }
        let found = match (name, &fields[..]) {
            (Some(name), _) => fields.iter().find(|field| field.name == *name),
            (None, [only]) => Some(only),
            (None, _) => {
                return Err(format!(
                    "`cell` density needs one field of cell data to choose; the mesh has {there}"
                ));
            }
        };
        let named = name.as_deref().unwrap_or_default();
        let field = found.ok_or(format!(
            "the mesh has no cell data `{named}`; it has {there}"
        ))?;
        if let Some(tet) = field.values.iter().position(|value| !value.is_finite()) {
            let (name, value) = (&field.name, field.values[tet]);
            return Err(format!(
                "the cell data `{name}` have the value {value} at tetrahedron {tet}; every one needs one \
                 finite value, or choose another density"
            ));
        }
        Ok(GivenField::of(Field::Tets(field.values.clone())))
    }
}

/// What options of one name say: for every file, or for names of files and groups.
#[derive(Debug)]
pub(crate) struct ByName<'a> {
    /// Without a name, in order.
    pub(crate) plain: Vec<&'a str>,
    /// With one.
    pub(crate) named: Vec<(&'a str, &'a str)>,
}

impl<'a> ByName<'a> {
    /// Tells `NAME=TEXT`, NAME one of `known`, from plain texts.
    ///
    /// # Errors
    /// When a name is none of those.
    pub(crate) fn of(option: &str, texts: &'a [String], known: &[String]) -> Result<Self, Failure> {
        let (mut plain, mut named) = (Vec::new(), Vec::new());
        for text in texts {
            // The longest known name before an equals sign: names may hold such signs themselves.
            let places = text.match_indices('=').map(|(at, _)| at);
            let mut names = places.filter(|&at| known.iter().any(|name| name == text[..at].trim()));
            match names.next_back() {
                Some(at) => named.push((text[..at].trim(), &text[at + 1..])),
                None => {
                    refuse_unknown(option, text, known)?;
                    plain.push(text.as_str());
                }
            }
        }
        Ok(Self { plain, named })
    }

    /// What is said of a name, the last of several.
    pub(crate) fn get(&self, name: &str) -> Option<&'a str> {
        let found = self.named.iter().rev().find(|(known, _)| *known == name);
        found.map(|(_, text)| *text)
    }
}

/// Refuses a text that looks like `NAME=TEXT` with a name that is not there.
fn refuse_unknown(option: &str, text: &str, known: &[String]) -> Result<(), Failure> {
    let Some((name, _)) = text.split_once('=') else {
        return Ok(());
    };
    let is_formula = name.contains([':', '(', '@', '*', '<', '>', '!']);
    if is_formula {
        return Ok(());
    }
    let names: Vec<_> = known.iter().map(|name| format!("`{name}`")).collect();
    Err(Failure::input(format!(
        "--{option} {text}: there is no file or group `{}`; there are {}",
        name.trim(),
        names.join(", ")
    )))
}
