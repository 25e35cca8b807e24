//! A cell from its pattern and the sites: planes, vertices, and whether they are beyond doubt.
//!
//! # When a realized cell is a convex polyhedron
//!
//! A pattern is a sphere made of facets, three to a vertex, since every cut leaves one. Let n_f be
//! the facets' unit normals and place every vertex where its three planes meet. The three normals
//! around a vertex span a cone; if all of them turn the right way (det > 0) and just one of them
//! holds a given direction, the cones cover every direction exactly once: they are a complete fan.
//! If also every edge runs from its one end to the other in the right direction, the support
//! function of the planes is strictly convex across every wall of the fan, hence convex, and
//! {y : n_f·y ≤ d_f for all f} is a polytope with this very pattern. That is checked here, each with
//! a margin far above rounding. A cell that fails is *in doubt*. It is kept as it was cut.
//!
//! What the margins are good for beyond that: see [`carried`](crate::voronoi::carried).

use nalgebra::Vector3;
use wide::f64x4;

use crate::geometry::half_space::HalfSpace;
use crate::geometry::simd::{cross, dot};
use crate::geometry::small_polyhedron::{BLOCK, EDGES, SmallPolyhedron};
use crate::voronoi::pattern::MOST;

/// The least volume that three unit normals span: vertices are then known to some 1e-13 of the
/// cell's radius.
const FLATTEST: f64 = 1e-3;

/// The least distance of a vertex from the planes at the other ends of its edges, relative to the
/// cell's radius: far above what rounding does to vertices, and rare.
const MARGIN: f64 = 1e-7;

/// The least such distance with which a cell is expected to keep its pattern. One in seven relaxed
/// cells has less; so have most where sites are within a tenth of their distance of a lattice.
const FRAGILE: f64 = 3e-3;

/// The least distance of a neighbor relative to the cell's radius: bisectors of nearer sites could
/// pass by a vertex within rounding unseen.
const NEAREST: f64 = 0.02;

/// How many bytes behind an edge, the last part of its number, is the facet that it leaves.
const THIRD: [usize; 4] = [2, 2, EDGES - 1, 0];

/// A direction along no edge or facet that people draw.
const UP: [f64; 3] = [0.737_368_878, 0.577_350_269, 0.350_918_142];

/// The planes of a cell.
#[derive(Clone, Debug)]
pub(crate) struct Realizer {
    /// Unit normals and offsets.
    planes: [[f64; 4]; MOST],
    /// The least offset of a neighbor's bisector: half its squared distance.
    nearest: f64,
    /// Of all numbers: not finite if one of them is not.
    sum: f64,
    /// The room of the cell last placed, relative to its radius.
    room: f64,
}

impl Default for Realizer {
    fn default() -> Self {
        Self {
            planes: [[0.0; 4]; MOST],
            nearest: f64::INFINITY,
            sum: 0.0,
            room: 0.0,
        }
    }
}

/// What meeting planes tell.
struct Meeting {
    /// The least volume of three normals.
    flattest: f64,
    /// The greatest squared distance of a vertex.
    radius_squared: f64,
    /// How many vertices have a cone of normals that holds [`UP`].
    summits: u32,
    /// How far the end of an edge is inside the plane that the edge leaves, at least: it runs along
    /// the other two at its start.
    room: f64,
}

impl Realizer {
    /// Forgets the planes.
    pub(crate) fn clear(&mut self) {
        (self.nearest, self.sum) = (f64::INFINITY, 0.0);
    }

    /// Adds a plane, for a neighbor its bisector, to those of `cell`.
    #[inline]
    pub(crate) fn add(&mut self, plane: &HalfSpace, is_neighbor: bool, cell: &mut SmallPolyhedron) {
        cell.planes.push(*plane);
        self.sum += plane.offset + plane.normal.sum();
        let away = if is_neighbor {
            plane.offset
        } else {
            f64::INFINITY
        };
        self.nearest = if away < self.nearest {
            away
        } else {
            self.nearest
        };
    }

    /// Places the vertices of `cell`, which is a pattern to which all planes have been added; returns
    /// whether it is beyond doubt.
    #[must_use]
    pub(crate) fn realize(&mut self, cell: &mut SmallPolyhedron) -> bool {
        if !self.is_finite() {
            return false;
        }
        cell.normalize();
        for (plane, HalfSpace { normal, offset }) in self.planes.iter_mut().zip(&cell.planes) {
            *plane = [normal.x, normal.y, normal.z, *offset];
        }
        let Meeting {
            flattest,
            radius_squared,
            summits,
            room,
        } = self.meet(cell);
        let radius = radius_squared.sqrt();
        self.room = room / radius;
        flattest >= FLATTEST
            && (2.0 * self.nearest).sqrt() >= NEAREST * radius
            && summits == 1
            && room >= MARGIN * radius
    }

    /// Whether an edge of the cell last placed is so short that hardly a move leaves it as it is.
    pub(crate) fn is_fragile(&self) -> bool {
        self.room < FRAGILE
    }

    /// Calls `found` for every edge of the cell just placed that runs the wrong way, with the facets left
    /// and right of it and those at its ends.
    pub(crate) fn visit_reversed(&self, cell: &SmallPolyhedron, mut found: impl FnMut([u8; 4])) {
        for edge in cell.upward() {
            let twin = usize::from(cell.twins[edge]);
            let facet = |byte: usize| cell.facets[byte % EDGES];
            let [near, far] = [edge, twin].map(|edge| facet(edge + THIRD[edge % 4]));
            let [x, y, z, offset] = self.planes[usize::from(far) % MOST];
            let along = Vector3::new(x, y, z).dot(&cell.vertex(edge / 4));
            if along > offset {
                found([facet(edge + 1), facet(edge), near, far]);
            }
        }
    }

    /// Whether all planes are sound.
    pub(crate) fn is_finite(&self) -> bool {
        self.sum.is_finite()
    }

    /// How far four vertices are inside the planes that their edges leave at the other end, at least.
    #[inline(always)]
    fn room_at(&self, vertices: [usize; BLOCK], at: &[f64x4; 3], cell: &SmallPolyhedron) -> f64x4 {
        let room = |edge: usize| {
            let [x, y, z, offset] = self.gather(vertices.map(|vertex| {
                let twin = usize::from(cell.twins[4 * vertex + edge]);
                cell.facets[(twin + THIRD[twin % 4]) % EDGES]
            }));
            offset - dot(&[x, y, z], at)
        };
        room(0).fast_min(room(1)).fast_min(room(2))
    }

    /// Four planes.
    #[inline(always)]
    fn gather(&self, facets: [u8; BLOCK]) -> [f64x4; 4] {
        let plane = |facet: u8| f64x4::new(self.planes[usize::from(facet) % MOST]);
        f64x4::transpose(facets.map(plane))
    }

    /// Places all vertices, four at a time.
    fn meet(&self, cell: &mut SmallPolyhedron) -> Meeting {
        let count = cell.alive.count_ones() as usize;
        let mut flattest = f64x4::splat(f64::INFINITY);
        let (mut far, mut room) = (f64x4::ZERO, f64x4::splat(f64::INFINITY));
        let mut summits = 0;
        for first in (0..count).step_by(BLOCK) {
            // Lanes beyond the last vertex repeat the first.
            let vertex = |lane: usize| {
                if first + lane < count {
                    first + lane
                } else {
                    0
                }
            };
            let vertices = [vertex(0), vertex(1), vertex(2), vertex(3)];
            let around = |slot: usize| {
                self.gather(vertices.map(|vertex| cell.facets[4 * vertex + slot + 1]))
            };
            let [ax, ay, az, d] = around(0);
            let [bx, by, bz, e] = around(1);
            let [cx, cy, cz, f] = around(2);
            let (a, b, c) = ([ax, ay, az], [bx, by, bz], [cx, cy, cz]);
            let [ab, bc, ca] = [cross(&a, &b), cross(&b, &c), cross(&c, &a)];
            let volume = dot(&a, &bc);
            flattest = flattest.fast_min(volume);
            // The cone of three normals holds what is a sum of them.
            let up = UP.map(f64x4::splat);
            let shares = dot(&up, &bc)
                .fast_min(dot(&up, &ca))
                .fast_min(dot(&up, &ab));
            let lanes = (1 << (count - first).min(BLOCK)) - 1;
            summits += (shares.simd_gt(f64x4::ZERO).to_bitmask() & lanes).count_ones();
            let scale = f64x4::ONE / volume;
            let [d, e, f] = [d * scale, e * scale, f * scale];
            let position = [0, 1, 2].map(|axis| d * bc[axis] + e * ca[axis] + f * ab[axis]);
            room = room.fast_min(self.room_at(vertices, &position, cell));
            let square = dot(&position, &position);
            far = far.fast_max(square);
            let all = [&mut cell.x, &mut cell.y, &mut cell.z, &mut cell.square];
            let [x, y, z] = position;
            for (all, along) in all.into_iter().zip([x, y, z, square]) {
                all[first..][..BLOCK].copy_from_slice(&along.to_array());
            }
        }
        // An empty slot is at no distance.
        for slot in count..count.next_multiple_of(BLOCK) {
            cell.square[slot] = 0.0;
        }
        let least = |[a, b, c, d]: [f64; 4]| a.min(b).min(c.min(d));
        let most = |[a, b, c, d]: [f64; 4]| a.max(b).max(c.max(d));
        Meeting {
            flattest: least(flattest.to_array()),
            radius_squared: most(far.to_array()),
            summits,
            room: least(room.to_array()),
        }
    }
}
