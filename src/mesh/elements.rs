//! Labels of a mesh's elements as its file has them: named groups, polygons, values of tetrahedra.
//!
//! They stand beside a mesh, not in it: element k of the mesh as read has label k. A list without
//! entries says that the file has none.

/// The labels of a mesh's elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Elements {
    /// The groups.
    pub(crate) groups: Groups,
    /// The polygon of the file from which every triangle was cut.
    pub(crate) polygons: Vec<u32>,
    /// Scalar fields with one value per tetrahedron.
    pub(crate) cell_data: Vec<CellData>,
}

/// One scalar per tetrahedron.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CellData {
    /// The field's name in the file.
    pub(crate) name: String,
    /// The values in the order of the tetrahedra, NaN where there is none.
    pub(crate) values: Vec<f64>,
}

/// Named groups, of which every element belongs to one.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Groups {
    /// The names, each once, in the file's order.
    names: Vec<String>,
    /// The group of every element.
    of: Vec<u32>,
}

impl Groups {
    /// The names in the file's order.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The group of every element; empty where the file has none.
    pub(crate) fn of_elements(&self) -> &[u32] {
        &self.of
    }

    /// The number of the group of this name, which is added if it is new.
    pub(crate) fn named(&mut self, name: &str) -> u32 {
        let known = self.names.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.names.len() - 1
        }) as u32
    }

    /// Gives all elements up to `count` that have none yet this group.
    pub(crate) fn fill(&mut self, count: usize, group: u32) {
        self.of.resize(count.max(self.of.len()), group);
    }

    /// The groups of the elements with these numbers as read; names that are left without an
    /// element are dropped.
    fn of_kept(&self, numbers: &[u32]) -> Self {
        let of = numbers
            .iter()
            .filter_map(|&number| self.of.get(number as usize));
        let of: Vec<u32> = of.copied().collect();
        let (names, renumbered) = self.used(&of);
        let of = of.into_iter().map(|group| renumbered[group as usize]);
        Self {
            of: of.collect(),
            names,
        }
    }

    /// The names of these groups, and the new number of every group.
    fn used(&self, of: &[u32]) -> (Vec<String>, Vec<u32>) {
        let mut is_used = vec![false; self.names.len()];
        for &group in of {
            is_used[group as usize] = true;
        }
        let (mut names, mut renumbered) = (Vec::new(), Vec::new());
        for (name, is_used) in self.names.iter().zip(is_used) {
            renumbered.push(names.len() as u32);
            if is_used {
                names.push(name.clone());
            }
        }
        (names, renumbered)
    }
}

impl Elements {
    /// The labels of the elements with these numbers as read, in their order.
    pub(crate) fn of_kept(&self, numbers: &[u32]) -> Self {
        let at = |number: &u32| *number as usize;
        let polygons = numbers
            .iter()
            .filter_map(|number| self.polygons.get(at(number)));
        let data = self.cell_data.iter().map(|field| CellData {
            name: field.name.clone(),
            values: numbers
                .iter()
                .map(|number| field.values.get(at(number)).copied().unwrap_or(f64::NAN))
                .collect(),
        });
        Self {
            groups: self.groups.of_kept(numbers),
            polygons: polygons.copied().collect(),
            cell_data: data.collect(),
        }
    }
}
