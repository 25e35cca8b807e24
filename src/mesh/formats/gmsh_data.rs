//! Fields of a Gmsh file: `$NodeData` and `$ElementData`.

use std::collections::HashMap;

use crate::mesh::elements::CellData;
use crate::mesh::formats::error::ParseError;
use crate::mesh::formats::gmsh::GmshFile;
use crate::mesh::formats::point_data::PointData;
use crate::mesh::formats::words::shown;

impl GmshFile<'_> {
    /// Reads a scalar field of the tetrahedra, later values over earlier ones.
    pub(crate) fn read_element_data(&mut self) -> Result<(), ParseError> {
        let (name, [_, components, count]) = self.read_data_head()?;
        if components != 1 {
            return Ok(());
        }
        self.input.start_data();
        let tags: HashMap<usize, usize> = self.tet_tags.iter().copied().zip(0..).collect();
        let mut values = vec![f64::NAN; tags.len()];
        let fields = &mut self.mesh.cell_data;
        if let Some(known) = fields.iter().position(|field| field.name == name) {
            values = fields.remove(known).values;
        }
        for _ in 0..count {
            let tag = self.input.count("an element's number")?;
            let value = self.input.value()?;
            if let Some(slot) = tags.get(&tag).and_then(|&tet| values.get_mut(tet)) {
                *slot = value;
            }
        }
        self.mesh.cell_data.push(CellData { name, values });
        Ok(())
    }

    /// Reads the name of a field, and its time step, number of components and number of values.
    fn read_data_head(&mut self) -> Result<(String, [usize; 3]), ParseError> {
        let name = self.read_name()?;
        for _ in 0..self.input.words.count("the number of real tags")? {
            self.input.words.value()?;
        }
        let integers = self.input.words.count("the number of integer tags")?;
        let mut layout = [0; 3];
        for at in 0..integers {
            let value = self.input.words.count("an integer tag")?;
            if let Some(slot) = layout.get_mut(at) {
                *slot = value;
            }
        }
        Ok((name, layout))
    }

    /// Reads a scalar field of the nodes; vectors and tensors are passed over.
    pub(crate) fn read_node_data(&mut self) -> Result<(), ParseError> {
        let (name, [step, components, count]) = self.read_data_head()?;
        if components != 1 {
            return Ok(());
        }
        self.input.start_data();
        let field = self.field_of(name, step);
        self.read_values(field, count)
    }

    /// The place of a field in the mesh's point data, emptied if it was of another time step.
    fn field_of(&mut self, name: String, step: usize) -> usize {
        let fields = &mut self.mesh.point_data;
        let place = fields.iter().position(|field| field.name() == name);
        let field = place.unwrap_or(fields.len());
        if place.is_some() && self.steps[field] == step {
            return field;
        }
        let empty = PointData::empty(name, self.mesh.vertices.len());
        if place.is_some() {
            fields[field] = empty;
            self.steps[field] = step;
        } else {
            fields.push(empty);
            self.steps.push(step);
        }
        field
    }

    /// Reads the string tags, one a line; returns the first, the field's name, without quotes.
    fn read_name(&mut self) -> Result<String, ParseError> {
        let mut name = String::new();
        let tags = self.input.words.count("the number of string tags")?;
        self.input.words.next_line();
        for at in 0..tags {
            if self.input.words.peek().is_none() {
                return Err(self.input.words.truncated("a string tag"));
            }
            let text = self.input.words.rest_of_line();
            if at == 0 {
                let inside = text.strip_prefix(b"\"");
                let inside = inside.and_then(|text| text.strip_suffix(b"\""));
                name = shown(inside.unwrap_or(text));
            }
        }
        Ok(name)
    }

    fn read_values(&mut self, field: usize, count: usize) -> Result<(), ParseError> {
        for _ in 0..count {
            let tag = self.input.count("a node's number")?;
            let vertex = self.vertex(tag)?;
            let value = self.input.value()?;
            self.mesh.point_data[field].set(vertex, value);
        }
        Ok(())
    }
}
