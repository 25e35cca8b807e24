//! Consistent orientation by flood fill.
//!
//! Two triangles at an edge agree if they run along it in opposite directions. From a first
//! triangle the fill crosses every edge that has exactly two triangles; edges with more are
//! not crossed, so parts that merely touch there are components of their own.

use crate::mesh::edges::{EdgeTable, NO_PARTNER, SurfaceEdge, side_vertices};
use crate::mesh::report::{EdgePlace, Refusal, Tally};
use crate::mesh::surface::SurfaceMesh;

/// The components of a surface and the turns that make each consistent.
#[derive(Clone, Debug)]
pub(crate) struct Orientation {
    /// The component of every triangle, numbered by their first triangles.
    pub(crate) component: Vec<u32>,
    /// How many components there are.
    pub(crate) components: usize,
    /// Which triangles must be turned: in each component the minority.
    pub(crate) turned: Vec<bool>,
    /// The first side at which a component contradicts itself: it is one-sided.
    pub(crate) contradiction: Option<u32>,
}

const UNVISITED: u32 = u32::MAX;

/// Orients `triangles`, whose edges are `edges`.
pub(crate) fn orient(triangles: &[[u32; 3]], edges: &EdgeTable) -> Orientation {
    let partners = edges.partners();
    let mut orientation = Orientation {
        component: vec![UNVISITED; triangles.len()],
        components: 0,
        turned: vec![false; triangles.len()],
        contradiction: None,
    };
    for first in 0..triangles.len() as u32 {
        if orientation.component[first as usize] == UNVISITED {
            flood(first, triangles, &partners, &mut orientation);
            orientation.components += 1;
        }
    }
    orientation
}

fn flood(first: u32, triangles: &[[u32; 3]], partners: &[u32], orientation: &mut Orientation) {
    let number = orientation.components as u32;
    let mut members = vec![first];
    orientation.component[first as usize] = number;
    let mut next = 0;
    while next < members.len() {
        let triangle = members[next];
        next += 1;
        for side in 3 * triangle..3 * triangle + 3 {
            let partner = partners[side as usize];
            if partner == NO_PARTNER {
                continue;
            }
            let neighbor = partner / 3;
            let agree = side_vertices(triangles, side) != side_vertices(triangles, partner);
            let turn = orientation.turned[triangle as usize] == agree;
            if orientation.component[neighbor as usize] == UNVISITED {
                orientation.component[neighbor as usize] = number;
                orientation.turned[neighbor as usize] = turn;
                members.push(neighbor);
            } else if orientation.turned[neighbor as usize] != turn {
                orientation.contradiction.get_or_insert(side);
            }
        }
    }
    turn_minority(&members, &mut orientation.turned);
}

fn turn_minority(members: &[u32], turned: &mut [bool]) {
    let count = members
        .iter()
        .filter(|&&member| turned[member as usize])
        .count();
    if 2 * count > members.len() {
        for &member in members {
            turned[member as usize] ^= true;
        }
    }
}

/// Places of sides in the mesh as read, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgePlaces<'a> {
    /// The triangles as read.
    pub(crate) read: &'a [[u32; 3]],
    /// The number as read of every triangle now.
    pub(crate) numbers: &'a [u32],
}

impl<'a> EdgePlaces<'a> {
    /// The places in `mesh` as read of triangles with these numbers there.
    pub(crate) fn of(mesh: &'a SurfaceMesh, numbers: &'a [u32]) -> Self {
        let read = &mesh.triangles;
        Self { read, numbers }
    }

    /// The place of a side, numbered before any triangle was turned.
    pub(crate) fn of_side(&self, side: u32) -> EdgePlace {
        let triangle = self.numbers[side as usize / 3];
        let vertices = side_vertices(self.read, 3 * triangle + side % 3);
        EdgePlace { vertices, triangle }
    }
}

/// Turns the minority of each component; returns which.
pub(crate) fn turn_to_neighbors(
    triangles: &mut [[u32; 3]],
    orientation: &Orientation,
    places: &EdgePlaces<'_>,
) -> Result<Tally<u32>, Refusal> {
    if let Some(side) = orientation.contradiction {
        let first = places.of_side(side);
        return Err(Refusal::OneSided { first });
    }
    let mut tally = Tally::default();
    for (at, triangle) in triangles.iter_mut().enumerate() {
        if orientation.turned[at] {
            triangle.swap(1, 2);
            tally.add(places.numbers[at]);
        }
    }
    Ok(tally)
}

/// The edges of more than two triangles.
pub(crate) fn touching(edges: &EdgeTable, places: &EdgePlaces<'_>) -> Tally<EdgePlace> {
    let overfull = edges.iter().filter(|edge| edge.sides.len() > 2);
    overfull.map(|edge| places.of_side(edge.sides[0])).collect()
}

/// Refuses edges of more than two triangles unless each component runs along them as often
/// forward as backward. `triangles` are turned already, `edges` are those from before, whose sides
/// still name the right triangles.
pub(crate) fn check_balance(
    triangles: &[[u32; 3]],
    edges: &EdgeTable,
    orientation: &Orientation,
    places: &EdgePlaces<'_>,
) -> Result<(), Refusal> {
    let overfull = edges.iter().filter(|edge| edge.sides.len() > 2);
    let wrong = overfull.filter(|edge| !is_balanced(triangles, edge, orientation));
    let Tally { count, first } = wrong.map(|edge| places.of_side(edge.sides[0])).collect();
    match first {
        Some(first) => Err(Refusal::NonManifold { count, first }),
        None => Ok(()),
    }
}

/// Whether every edge is run along as often in one direction as in the other.
pub(crate) fn is_closed(triangles: &[[u32; 3]], edges: &EdgeTable) -> bool {
    edges.iter().all(|edge| {
        let sides = edge.sides.iter().map(|&side| side as usize / 3);
        sides
            .map(|t| direction(triangles[t], edge.vertices))
            .sum::<i32>()
            == 0
    })
}

fn is_balanced(triangles: &[[u32; 3]], edge: &SurfaceEdge<'_>, orientation: &Orientation) -> bool {
    let use_of = |&side: &u32| {
        let triangle = side as usize / 3;
        (
            orientation.component[triangle],
            direction(triangles[triangle], edge.vertices),
        )
    };
    let mut uses: Vec<(u32, i32)> = edge.sides.iter().map(use_of).collect();
    uses.sort_unstable();
    let mut groups = uses.chunk_by(|one, other| one.0 == other.0);
    groups.all(|group| group.iter().map(|&(_, direction)| direction).sum::<i32>() == 0)
}

/// +1 if the triangle runs from the first to the second vertex, −1 if back.
pub(crate) fn direction([a, b, c]: [u32; 3], edge: [u32; 2]) -> i32 {
    let runs_along = [[a, b], [b, c], [c, a]].contains(&edge);
    if runs_along { 1 } else { -1 }
}
