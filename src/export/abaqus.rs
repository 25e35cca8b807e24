//! `mesh.inp`: the input format of Abaqus and CalculiX, a surface for every patch.
//!
//! Sources: Abaqus Analysis User's Guide, sections 28.1.4 (solid elements, faces S1, S2, …) and 2.3.2
//! (surfaces); CalculiX CrunchiX manual, sections 6.2.1, 6.2.12. CalculiX has no pyramids: they are C3D8 whose
//! upper four nodes are one. Numbers count from one.

use std::collections::{BTreeMap, HashMap};
use std::io::{self, Write};
use std::path::Path;

use crate::complex::element::CellElement;
use crate::complex::element_mesh::ElementMesh;
use crate::export::atomic_write;

/// Types and sets in the order of [`crate::complex::element::KINDS`].
const TYPES: [(&str, &str); 4] = [
    ("C3D8", "HEXAHEDRA"),
    ("C3D6", "PRISMS"),
    ("C3D8", "PYRAMIDS"),
    ("C3D4", "TETRAHEDRA"),
];

/// The faces S1, S2, … of every kind by places in its points.
const SIDES: [&[&[usize]]; 4] = [
    &[
        &[0, 1, 2, 3],
        &[4, 7, 6, 5],
        &[0, 4, 5, 1],
        &[1, 5, 6, 2],
        &[2, 6, 7, 3],
        &[3, 7, 4, 0],
    ],
    &[
        &[0, 1, 2],
        &[3, 5, 4],
        &[0, 3, 4, 1],
        &[1, 4, 5, 2],
        &[2, 5, 3, 0],
    ],
    // S2 is the apex.
    &[
        &[0, 1, 2, 3],
        &[],
        &[0, 4, 1],
        &[1, 4, 2],
        &[2, 4, 3],
        &[3, 4, 0],
    ],
    &[&[0, 1, 2], &[0, 3, 1], &[1, 3, 2], &[2, 3, 0]],
];

/// Writes a mesh of elements.
///
/// # Errors
/// The error of the system; the file is then as it was before.
pub(crate) fn write_abaqus(path: &Path, mesh: &ElementMesh) -> io::Result<()> {
    atomic_write::write(path, |file| {
        writeln!(file, "*HEADING\nchebloyd\n*NODE, NSET=ALL")?;
        for (number, point) in (1..).zip(&mesh.points) {
            let number: u32 = number;
            writeln!(
                file,
                "{number}, {:?}, {:?}, {:?}",
                point.x, point.y, point.z
            )?;
        }
        let numbers = write_elements(file, mesh)?;
        write_surfaces(file, mesh, &numbers)
    })
}

/// Writes the elements by kind; returns their numbers.
fn write_elements(file: &mut impl Write, mesh: &ElementMesh) -> io::Result<Vec<u32>> {
    let mut numbers = vec![0; mesh.elements.len()];
    let (mut next, mut sets) = (0, Vec::new());
    for (kind, (name, set)) in TYPES.into_iter().enumerate() {
        let is_kind = |element: &CellElement| element.kind() == kind;
        if !mesh.elements.iter().any(is_kind) {
            continue;
        }
        writeln!(file, "*ELEMENT, TYPE={name}, ELSET={set}")?;
        sets.push(set);
        for (number, element) in numbers.iter_mut().zip(&mesh.elements) {
            if is_kind(element) {
                next += 1;
                *number = next;
                write_element(file, next, element)?;
            }
        }
    }
    writeln!(file, "*ELSET, ELSET=SOLID\n{}", sets.join(", "))?;
    Ok(numbers)
}

fn write_element(file: &mut impl Write, number: u32, element: &CellElement) -> io::Result<()> {
    write!(file, "{number}")?;
    for corner in element.corners() {
        write!(file, ", {}", corner + 1)?;
    }
    if let CellElement::Pyramid([.., apex]) = element {
        let apex = apex + 1;
        write!(file, ", {apex}, {apex}, {apex}")?;
    }
    writeln!(file)
}

/// Writes the faces of patches as sides of elements.
fn write_surfaces(file: &mut impl Write, mesh: &ElementMesh, numbers: &[u32]) -> io::Result<()> {
    let sorted = |corners: &mut dyn Iterator<Item = u32>| -> Vec<u32> {
        let mut corners: Vec<u32> = corners.collect();
        corners.sort_unstable();
        corners
    };
    let patches: HashMap<Vec<u32>, u32> = mesh
        .walls
        .iter()
        .map(|(corners, patch)| (sorted(&mut corners.iter().copied()), *patch))
        .collect();
    let mut surfaces: BTreeMap<u32, Vec<(u32, usize)>> = BTreeMap::new();
    for (element, &number) in mesh.elements.iter().zip(numbers) {
        let corners = element.corners();
        for (side, places) in (1..).zip(SIDES[element.kind()]) {
            let key = sorted(&mut places.iter().map(|&place| corners[place]));
            if let Some(&patch) = patches.get(&key) {
                surfaces.entry(patch).or_default().push((number, side));
            }
        }
    }
    for (patch, sides) in surfaces {
        // Names hold letters, digits and underscores.
        let name = mesh.patches[patch as usize].replace(|c: char| !c.is_ascii_alphanumeric(), "_");
        writeln!(file, "*SURFACE, NAME={name}, TYPE=ELEMENT")?;
        for (number, side) in sides {
            writeln!(file, "{number}, S{side}")?;
        }
    }
    Ok(())
}
