//! Consistent orientation by flood fill.
//!
//! Two triangles at an edge agree if they run along it in opposite directions. From a first
//! triangle the fill crosses every edge that has exactly two triangles; edges with more are
//! not crossed, so parts that merely touch there are components of their own.

use crate::mesh::edges::{EdgeTable, NO_PARTNER, side_vertices};

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

const UNSEEN: u32 = u32::MAX;

/// Orients `triangles`, whose edges are `edges`.
pub(crate) fn orient(triangles: &[[u32; 3]], edges: &EdgeTable) -> Orientation {
    let partners = edges.partners();
    let mut orientation = Orientation {
        component: vec![UNSEEN; triangles.len()],
        components: 0,
        turned: vec![false; triangles.len()],
        contradiction: None,
    };
    for first in 0..triangles.len() as u32 {
        if orientation.component[first as usize] == UNSEEN {
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
            if orientation.component[neighbor as usize] == UNSEEN {
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
