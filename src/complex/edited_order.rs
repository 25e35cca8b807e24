//! A changed mesh in OpenFOAM's order.

use std::collections::BTreeMap;

use crate::complex::edit_mesh::{Behind, EditMesh};
use crate::mesh::poly_mesh::{MeshPatch, PolyMesh};

impl EditMesh {
    /// The mesh in OpenFOAM's order. Faces, points and cells that are gone leave nothing behind.
    #[must_use]
    pub(crate) fn finish(&self) -> PolyMesh {
        let numbers = self.cell_numbers();
        let number = |cell: u32| numbers[cell as usize];
        let mut mesh = PolyMesh::default();
        let alive = (0..self.of_cell.len()).filter(|&cell| !self.of_cell[cell].is_empty());
        mesh.sites
            .extend(alive.filter_map(|cell| self.sites.get(cell)));
        mesh.cell_count = numbers.iter().filter(|&&number| number != GONE).count();
        let mut inner = Vec::new();
        let mut borders: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for face in
            (0..self.faces.len() as u32).filter(|&face| !self.faces[face as usize].is_empty())
        {
            let owner = number(self.owner[face as usize]);
            match self.behind[face as usize] {
                Behind::Cell(cell) => {
                    let other = number(cell);
                    inner.push((owner.min(other), owner.max(other), face, other < owner));
                }
                Behind::Wall(patch) => borders.entry(patch).or_default().push(face),
                Behind::Image { patch, .. } => borders.entry(patch).or_default().push(face),
            }
        }
        inner.sort_unstable();
        let mut output = Numbering::new(self, mesh);
        for &(owner, neighbor, face, is_turned) in &inner {
            let corners = &self.faces[face as usize];
            match is_turned {
                false => output.push(owner, corners.iter().copied()),
                true => output.push(owner, corners.iter().rev().copied()),
            }
            output.mesh.neighbor.push(neighbor);
        }
        self.push_patches(&mut output, borders, &numbers);
        output.mesh
    }

    fn push_patches(
        &self,
        output: &mut Numbering<'_>,
        mut borders: BTreeMap<u32, Vec<u32>>,
        numbers: &[u32],
    ) {
        let left: Vec<u32> = borders.keys().copied().collect();
        for faces in borders.values_mut() {
            faces.sort_by_key(|&face| (numbers[self.owner[face as usize] as usize], face));
        }
        for &patch in &left {
            let (name, partner) = &self.patches[patch as usize];
            let partner = partner.and_then(|(other, way)| {
                let place = left.binary_search(&(other as u32)).ok()?;
                Some((place, way))
            });
            let start = output.mesh.face_count();
            let faces = match partner {
                // The order of the first of the two.
                Some((place, _)) if left[place] < patch => {
                    let first = borders[&left[place]].iter();
                    first.map(|&face| self.image(face)).collect()
                }
                _ => borders[&patch].clone(),
            };
            for &face in &faces {
                let owner = numbers[self.owner[face as usize] as usize];
                match partner {
                    Some((place, _)) if left[place] < patch => {
                        output.push(owner, self.image_loop(face).into_iter());
                    }
                    _ => output.push(owner, self.faces[face as usize].iter().copied()),
                }
            }
            output.mesh.patches.push(MeshPatch {
                name: name.clone(),
                start,
                count: faces.len(),
                partner,
            });
        }
    }

    /// The face one period away.
    fn image(&self, face: u32) -> u32 {
        match self.behind[face as usize] {
            Behind::Image { face, .. } => face,
            _ => face,
        }
    }

    /// The loop of a face from the corner on at which its image begins.
    fn image_loop(&self, face: u32) -> Vec<u32> {
        let corners = &self.faces[face as usize];
        let first = self.faces[self.image(face) as usize].first();
        let start = first.and_then(|&first| {
            let is_image = |&corner: &u32| self.copies.are_images(corner, first);
            corners.iter().position(is_image)
        });
        let (before, after) = corners.split_at(start.unwrap_or(0));
        [after, before].concat()
    }

    /// New numbers of the cells that are left.
    fn cell_numbers(&self) -> Vec<u32> {
        let mut next = 0;
        let number = |faces: &Vec<u32>| {
            let is_gone = faces.is_empty();
            next += u32::from(!is_gone);
            if is_gone { GONE } else { next - 1 }
        };
        self.of_cell.iter().map(number).collect()
    }
}

/// The number of what is gone.
const GONE: u32 = u32::MAX;

/// Points numbered on their first use.
struct Numbering<'a> {
    edited: &'a EditMesh,
    numbers: Vec<u32>,
    mesh: PolyMesh,
}

impl<'a> Numbering<'a> {
    fn new(edited: &'a EditMesh, mesh: PolyMesh) -> Self {
        Self {
            numbers: vec![GONE; edited.points.len()],
            edited,
            mesh,
        }
    }

    fn push(&mut self, owner: u32, corners: impl Iterator<Item = u32>) {
        self.mesh.owner.push(owner);
        let points = corners.map(|point| {
            let number = &mut self.numbers[point as usize];
            if *number == GONE {
                *number = self.mesh.points.len() as u32;
                self.mesh.points.push(self.edited.points[point as usize]);
            }
            *number
        });
        let points: Vec<u32> = points.collect();
        self.mesh.push_corners(points);
    }
}
