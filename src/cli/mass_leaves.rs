//! Files and groups with their densities and masses, weighed.

use std::path::{Path, PathBuf};

use crate::geometry::bounds::Bounds;
use crate::mass::body::Body;
use crate::mesh::formats::read::LabeledSolid;
use crate::scene::field::{GivenField, Weighed};

use crate::cli::failure::Failure;
use crate::cli::mass_parts::{ByName, GivenDensity, NamedSolid, groups};

/// A file, or a group of one, with one density.
#[derive(Debug)]
pub(crate) struct MassLeaf {
    /// The number of the file.
    pub(crate) part: usize,
    pub(crate) group: Option<String>,
    /// The file's name with the group's.
    pub(crate) name: PathBuf,
    pub(crate) labeled: LabeledSolid,
    pub(crate) density: GivenField,
    /// The density's text.
    pub(crate) text: String,
    /// What it weighs, if its density is to be scaled to that.
    mass: Option<f64>,
}

/// What options say about files and groups.
pub(crate) struct MassAsked<'a> {
    pub(crate) files: &'a [PathBuf],
    pub(crate) densities: ByName<'a>,
    pub(crate) masses: ByName<'a>,
    /// Masses are given in this many units of density times volume.
    pub(crate) mass_unit: f64,
}

/// The names by which densities and masses may be given: files, with and without folder and extension,
/// and groups.
pub(crate) fn known_names(files: &[PathBuf], wholes: &[LabeledSolid]) -> Vec<String> {
    let mut known: Vec<String> = files.iter().flat_map(|file| names_of(file)).collect();
    let groups = wholes
        .iter()
        .flat_map(|whole| whole.elements.groups.names());
    known.extend(groups.cloned());
    known
}

fn names_of(file: &Path) -> [String; 3] {
    let text =
        |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    [
        file.display().to_string(),
        text(file.file_name()),
        text(file.file_stem()),
    ]
}

impl MassAsked<'_> {
    /// What is said of a file: by its name, else by its place.
    fn of_file<'a>(&self, said: &ByName<'a>, part: usize) -> Option<&'a str> {
        let named = names_of(&self.files[part]);
        let named = named.iter().find_map(|name| said.get(name));
        let plain = match said.plain[..] {
            [one] => Some(one),
            _ => said.plain.get(part).copied(),
        };
        named.or(plain)
    }

    /// The density of every file.
    fn density(&self, part: usize) -> Result<GivenDensity, Failure> {
        GivenDensity::read(self.of_file(&self.densities, part).unwrap_or("1"))
    }

    /// The mass of a file, none where it is left to its density.
    fn mass(&self, part: usize) -> Result<Option<f64>, Failure> {
        let text = self.of_file(&self.masses, part);
        text.map_or(Ok(None), |text| self.mass_of(text))
    }

    fn mass_of(&self, text: &str) -> Result<Option<f64>, Failure> {
        if text.trim() == "_" {
            return Ok(None);
        }
        match text.trim().parse::<f64>() {
            Ok(mass) if mass > 0.0 && mass.is_finite() => Ok(Some(mass / self.mass_unit)),
            _ => Err(Failure::input(format!(
                "--mass {text}: a positive number is needed, or _ for a part that keeps its density"
            ))),
        }
    }

    /// The file as one leaf, or as its groups where one of them is named.
    pub(crate) fn leaves(
        &self,
        part: usize,
        whole: LabeledSolid,
    ) -> Result<Vec<MassLeaf>, Failure> {
        let file = self.files[part].display();
        let is_named =
            |name: &String| self.densities.get(name).is_some() || self.masses.get(name).is_some();
        let names = whole.elements.groups.names();
        let is_split = names.len() > 1 && names.iter().any(is_named);
        if !is_split {
            let own = names.iter().find_map(|name| self.densities.get(name));
            let own_mass = names.iter().find_map(|name| self.masses.get(name));
            let density = own.map_or_else(|| self.density(part), GivenDensity::read)?;
            let mass = own_mass.map_or_else(|| self.mass(part), |text| self.mass_of(text))?;
            return Ok(vec![self.leaf(part, None, whole, &density, mass)?]);
        }
        let groups = groups(&whole).map_err(|reason| {
            Failure::input(format!(
                "{file}: its groups are no parts of their own: {reason}; give the file one density"
            ))
        })?;
        let of_file = self.density(part)?;
        let leaf = |NamedSolid { name, labeled }: NamedSolid| {
            let own = self.densities.get(&name).map(GivenDensity::read);
            let density = own.unwrap_or_else(|| Ok(of_file.clone()))?;
            let mass = self
                .masses
                .get(&name)
                .map_or(Ok(None), |text| self.mass_of(text))?;
            self.leaf(part, Some(name), labeled, &density, mass)
        };
        groups.into_iter().map(leaf).collect()
    }

    /// The groups of a file that is one leaf, all of its density; none where they are no parts.
    pub(crate) fn groups_of(&self, leaf: &MassLeaf) -> Result<Vec<MassLeaf>, Failure> {
        let density = self.density(leaf.part)?;
        let groups = groups(&leaf.labeled).unwrap_or_default().into_iter();
        let leaf = |group: NamedSolid| {
            self.leaf(leaf.part, Some(group.name), group.labeled, &density, None)
        };
        groups.map(leaf).collect()
    }

    fn leaf(
        &self,
        part: usize,
        group: Option<String>,
        labeled: LabeledSolid,
        density: &GivenDensity,
        mass: Option<f64>,
    ) -> Result<MassLeaf, Failure> {
        let name = self.name(part, group.as_deref());
        let field = density.field(&labeled);
        Ok(MassLeaf {
            density: field.map_err(|fault| Failure::input(format!("{name}: {fault}")))?,
            text: density.text.clone(),
            name: name.into(),
            part,
            group,
            labeled,
            mass,
        })
    }

    fn name(&self, part: usize, group: Option<&str>) -> String {
        let file = self.files[part].display();
        group.map_or(file.to_string(), |group| format!("{file}, group {group}"))
    }

    /// A file's leaves weighed, scaled together to the file's mass if that is given.
    pub(crate) fn scaled(
        &self,
        part: usize,
        leaves: &[MassLeaf],
        mut weighed: Vec<Weighed>,
    ) -> Result<Vec<Weighed>, Failure> {
        if let ([_, _, ..], Some(mass)) = (leaves, self.mass(part)?) {
            let sum: f64 = weighed.iter().map(|leaf| leaf.body.mass).sum();
            for leaf in &mut weighed {
                *leaf = leaf.weighing(mass * (leaf.body.mass / sum));
            }
        }
        Ok(weighed)
    }
}

impl MassLeaf {
    /// Its mass properties.
    pub(crate) fn weigh(
        &self,
        extent: &Bounds<3>,
        tolerance: Option<f64>,
    ) -> Result<Weighed, Failure> {
        let weighed = self
            .density
            .field
            .weigh(&self.labeled.solid, extent, tolerance);
        let weighed =
            weighed.map_err(|error| Failure::input(format!("{}: {error}", self.name.display())))?;
        Ok(self.mass.map_or(weighed, |mass| weighed.weighing(mass)))
    }
}

/// The body of a file's leaves; its surface is that of the whole.
pub(crate) fn body_of(weighed: &[Weighed], whole_area: f64) -> Result<Body, Failure> {
    if let [only] = weighed {
        return Ok(only.body);
    }
    let bodies: Vec<Body> = weighed.iter().map(|leaf| leaf.body).collect();
    let body = Body::combined(&bodies).ok_or_else(|| Failure::run("the groups have no mass"))?;
    Ok(body.with_surface_area(whole_area))
}
