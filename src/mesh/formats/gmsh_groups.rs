//! Physical groups of a Gmsh file: their names, and the entities of version 4 that belong to them.

use std::collections::HashMap;

use crate::mesh::formats::error::ParseError;
use crate::mesh::formats::gmsh_input::GmshInput;
use crate::mesh::formats::words::shown;

/// The group of what belongs to none.
const NONE: &str = "none";

/// Physical groups by dimension and number.
#[derive(Clone, Debug, Default)]
pub(crate) struct GmshGroups {
    names: HashMap<(usize, i64), String>,
    /// The first physical group of every entity.
    physical: HashMap<(usize, i64), i64>,
}

impl GmshGroups {
    /// The name of a physical group, its number where it has none.
    pub(crate) fn name(&self, dimension: usize, group: Option<i64>) -> String {
        let Some(group) = group.filter(|&group| group != 0) else {
            return NONE.to_owned();
        };
        let name = self.names.get(&(dimension, group));
        name.cloned().unwrap_or_else(|| group.to_string())
    }

    /// The name of the physical group of an entity of version 4.
    pub(crate) fn name_of_entity(&self, dimension: usize, entity: i64) -> String {
        let group = self.physical.get(&(dimension, entity));
        self.name(dimension, group.copied())
    }

    /// Reads `$PhysicalNames`: lines of dimension, number and name in quotes.
    pub(crate) fn read_names(&mut self, input: &mut GmshInput<'_>) -> Result<(), ParseError> {
        let count = input.words.count("the number of physical names")?;
        for _ in 0..count {
            let dimension = input.words.count("a group's dimension")?;
            let group = input.words.integer("a group's number")?;
            let text = input.words.rest_of_line();
            let inside = text.strip_prefix(b"\"");
            let inside = inside.and_then(|text| text.strip_suffix(b"\""));
            let name = shown(inside.unwrap_or(text));
            self.names.insert((dimension, group), name);
        }
        Ok(())
    }

    /// Reads `$Entities` of version 4.1, or of 4.0 where points have boxes too.
    pub(crate) fn read_entities(
        &mut self,
        input: &mut GmshInput<'_>,
        points_have_boxes: bool,
    ) -> Result<(), ParseError> {
        input.start_data();
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = input.size("a number of entities")?;
        }
        for (dimension, count) in counts.into_iter().enumerate() {
            let coordinates = if dimension > 0 || points_have_boxes {
                6
            } else {
                3
            };
            for _ in 0..count {
                self.read_entity(input, dimension, coordinates)?;
            }
        }
        Ok(())
    }

    fn read_entity(
        &mut self,
        input: &mut GmshInput<'_>,
        dimension: usize,
        coordinates: usize,
    ) -> Result<(), ParseError> {
        let entity = input.integer("an entity's number")?;
        for _ in 0..coordinates {
            input.value()?;
        }
        // A negative number turns the entity around.
        if let Some(group) = first_of_list(input)? {
            self.physical.insert((dimension, entity), group.abs());
        }
        if dimension > 0 {
            first_of_list(input)?;
        }
        input.end_line();
        Ok(())
    }
}

/// The first number of a list that begins with its length.
fn first_of_list(input: &mut GmshInput<'_>) -> Result<Option<i64>, ParseError> {
    let mut first = None;
    for _ in 0..input.size("the number of groups or entities")? {
        let number = input.integer("a group or entity")?;
        first.get_or_insert(number);
    }
    Ok(first)
}
