//! Placements of files: 4×4 matrices that map a file's coordinates to the body's.

use std::path::Path;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::mesh::formats::mesh::Mesh;

/// The map y ↦ `linear` y + `shift`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Placement {
    linear: Matrix3<f64>,
    shift: Vector3<f64>,
}

impl Placement {
    /// A text of 16 numbers row by row, or the name of a file that holds them; `_` leaves the file where
    /// it is.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        if text.trim() == "_" {
            let (linear, shift) = (Matrix3::identity(), Vector3::zeros());
            return Ok(Self { linear, shift });
        }
        if let Some(numbers) = numbers(text) {
            return Self::of(&numbers).map_err(|fault| format!("--place {text}: {fault}"));
        }
        let content = std::fs::read_to_string(Path::new(text)).map_err(|error| {
            format!("--place {text}: neither 16 numbers nor a file that can be read ({error})")
        })?;
        let read = numbers(&content).ok_or("it holds something else than numbers".to_owned());
        read.and_then(|numbers| Self::of(&numbers))
            .map_err(|fault| format!("--place {text}: {fault}; give 16 numbers, row by row"))
    }

    fn of(numbers: &[f64]) -> Result<Self, String> {
        let &[a, b, c, x, d, e, f, y, g, h, i, z, l, m, n, o] = numbers else {
            return Err(format!("16 numbers are needed, not {}", numbers.len()));
        };
        let last_row = [l, m, n, o - 1.0];
        if last_row
            .iter()
            .any(|entry| entry.abs() > 0.0 || entry.is_nan())
        {
            return Err(format!(
                "the last row of a placement is 0 0 0 1, not {l} {m} {n} {o}; give the matrix row by row"
            ));
        }
        let linear = Matrix3::new(a, b, c, d, e, f, g, h, i);
        if linear.determinant() == 0.0 || !linear.determinant().is_finite() {
            let message = "its determinant is 0, or no number: the part would have no volume";
            return Err(message.to_owned());
        }
        let shift = Vector3::new(x, y, z);
        Ok(Self { linear, shift })
    }

    /// Moves a mesh; where the map is a mirror, elements are turned, so that they show the same side
    /// outward.
    pub(crate) fn apply(&self, mesh: &mut Mesh) {
        let map = |vertex: &mut Point3<f64>| {
            *vertex = Point3::from(self.linear * vertex.coords + self.shift);
        };
        let is_mirror = self.linear.determinant() < 0.0;
        match mesh {
            Mesh::Surface(surface) => {
                surface.vertices.iter_mut().for_each(map);
                let turned = surface.triangles.iter_mut().filter(|_| is_mirror);
                turned.for_each(|triangle| triangle.swap(1, 2));
            }
            Mesh::Tets(tets) => {
                tets.vertices.iter_mut().for_each(map);
                let turned = tets.tets.iter_mut().filter(|_| is_mirror);
                turned.for_each(|tet| tet.swap(1, 2));
            }
        }
    }
}

/// Numbers between white space, commas, semicolons and brackets, all finite.
fn numbers(text: &str) -> Option<Vec<f64>> {
    let is_between = |c: char| c.is_whitespace() || ",;[]".contains(c);
    let words = text.split(is_between).filter(|word| !word.is_empty());
    let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
    words.map(number).collect()
}
