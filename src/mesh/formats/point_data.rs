//! Data of a file's points as they stand there, and which of them are one finite value per vertex.
//!
//! Gaps, repetitions and numbers that are not finite are refused only where the data are used, so
//! they are kept with a sentence about the first node at fault. Nodes of no tetrahedron do not
//! count.

use crate::mesh::tets::{VertexData, used_vertices};

/// A scalar field of a file.
#[derive(Clone, Debug)]
pub(crate) struct PointData {
    name: String,
    /// The last value given to every vertex, NaN where none was.
    values: Vec<f64>,
    /// How often every vertex was given a value.
    times: Vec<u8>,
    /// What is wrong with the field as a whole.
    fault: Option<String>,
}

impl PointData {
    /// A field that gives no vertex a value yet.
    pub(crate) fn empty(name: String, vertices: usize) -> Self {
        Self {
            name,
            values: vec![f64::NAN; vertices],
            times: vec![0; vertices],
            fault: None,
        }
    }

    /// A field with all values in vertex order; another number of them than of vertices is a fault.
    pub(crate) fn of(name: String, values: Vec<f64>, vertices: usize) -> Self {
        if values.len() != vertices {
            let found = values.len();
            return Self::faulty(name, format!("it has {found} values for {vertices} points"));
        }
        let times = vec![1; vertices];
        let fault = None;
        Self {
            name,
            values,
            times,
            fault,
        }
    }

    /// A field that cannot be used for a reason of its own.
    pub(crate) fn faulty(name: String, fault: String) -> Self {
        Self {
            name,
            values: Vec::new(),
            times: Vec::new(),
            fault: Some(fault),
        }
    }

    /// The field's name.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Gives a vertex its value.
    pub(crate) fn set(&mut self, vertex: u32, value: f64) {
        self.values[vertex as usize] = value;
        let times = &mut self.times[vertex as usize];
        *times = times.saturating_add(1);
    }

    /// Appends the values of further vertices, which `other` has.
    pub(crate) fn append(&mut self, other: Self) {
        self.fault = self.fault.take().or(other.fault);
        self.values.extend(other.values);
        self.times.extend(other.times);
    }

    /// What is wrong with the values of the vertices that are `used`, if anything is.
    fn first_fault(&self, used: &[bool], node: impl Fn(usize) -> String) -> Option<String> {
        if self.fault.is_some() || self.values.len() != used.len() {
            let gap = || {
                format!(
                    "it has {} values for {} points",
                    self.values.len(),
                    used.len()
                )
            };
            return Some(self.fault.clone().unwrap_or_else(gap));
        }
        let is_bad =
            |at: &usize| used[*at] && (self.times[*at] != 1 || !self.values[*at].is_finite());
        let at = (0..used.len()).find(is_bad)?;
        let node = node(at);
        Some(match self.times[at] {
            0 => format!("{node} has no value"),
            1 => format!("{node} has the value {}", self.values[at]),
            times => format!("{node} has {times} values"),
        })
    }

    fn into_vertex_data(mut self, vertices: usize, fault: Option<String>) -> VertexData {
        self.values.resize(vertices, f64::NAN);
        VertexData {
            name: self.name,
            values: self.values,
            fault,
        }
    }
}

/// The fields by name with what is wrong with each; `node` names a vertex as the file does.
pub(crate) fn vertex_data(
    data: Vec<PointData>,
    tets: &[[u32; 4]],
    vertices: usize,
    node: impl Fn(usize) -> String,
) -> Vec<VertexData> {
    let used = used_vertices(tets, vertices);
    let mut fields: Vec<VertexData> = Vec::with_capacity(data.len());
    for field in data {
        if let Some(earlier) = fields.iter_mut().find(|other| other.name == field.name) {
            earlier.fault = Some("the file holds several fields of this name".to_owned());
            continue;
        }
        let fault = field.first_fault(&used, &node);
        fields.push(field.into_vertex_data(vertices, fault));
    }
    fields
}
