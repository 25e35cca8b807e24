//! Cells at walls that are not along the axes: their blocks and boundaries, clipped.

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::bounds::Bounds;
use crate::geometry::clip::{Clip, ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::integrals::simplex::linear_power;
use crate::voronoi::linf::block::Block;
use crate::voronoi::linf::cone::Cone;

/// Walls that are not along the axes, relative to the site.
#[derive(Clone, Debug, Default)]
pub(crate) struct ObliqueWalls {
    walls: Vec<(HalfSpace, Label)>,
}

impl ObliqueWalls {
    pub(crate) fn clear(&mut self) {
        self.walls.clear();
    }

    pub(crate) fn push(&mut self, wall: HalfSpace, label: Label) {
        self.walls.push((wall, label));
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.walls.is_empty()
    }

    /// Whether a displacement from the site lies within all walls.
    pub(crate) fn contain(&self, displacement: &Vector3<f64>) -> bool {
        let place = Point3::from(*displacement);
        (self.walls.iter()).all(|(wall, _)| wall.excess(&place) <= 0.0)
    }

    /// The share of a displacement from the site that lies within all walls.
    pub(crate) fn share_within(&self, displacement: &Vector3<f64>) -> f64 {
        let share = |(wall, _): &(HalfSpace, Label)| {
            let rate = wall.normal.dot(displacement);
            let is_towards = rate > 0.0;
            is_towards.then(|| (wall.offset / rate).max(0.0))
        };
        self.walls
            .iter()
            .filter_map(share)
            .fold(f64::INFINITY, f64::min)
    }

    /// Clips a convex polygon.
    pub(crate) fn clip_polygon(&self, corners: &mut Vec<Vector3<f64>>) {
        for (wall, _) in &self.walls {
            let excess = |corner: &Vector3<f64>| wall.excess(&Point3::from(*corner));
            if corners.iter().all(|corner| excess(corner) <= 0.0) {
                continue;
            }
            let mut kept = Vec::with_capacity(corners.len() + 1);
            for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                let (here, there) = (excess(from), excess(to));
                if here <= 0.0 {
                    kept.push(*from);
                }
                if (here < 0.0 && there > 0.0) || (here > 0.0 && there < 0.0) {
                    kept.push(from + (to - from) * (here / (here - there)));
                }
            }
            *corners = kept;
        }
    }
}

/// The memory in which blocks are clipped.
#[derive(Debug, Default)]
pub(crate) struct ClippedBlock {
    part: Polyhedron,
    scratch: ClipScratch,
}

impl ClippedBlock {
    /// ∫ h^p over the part of a block within the walls (L^(3+p)).
    pub(crate) fn integral(
        &mut self,
        cone: Cone,
        block: &Block,
        walls: &ObliqueWalls,
        order: u32,
    ) -> f64 {
        let corners = block
            .corners()
            .map(|corner| Point3::from(cone.displacement(corner)));
        let is_within = |(wall, _): &(HalfSpace, Label)| {
            corners.iter().all(|corner| wall.excess(corner) <= 0.0)
        };
        if walls.walls.iter().all(is_within) {
            return block.integral(order);
        }
        self.clip(cone, block, walls);
        self.height_integral(cone, order)
    }

    /// Passes on the facets of the part of a block within the walls that lie in walls.
    pub(crate) fn visit_walls(
        &mut self,
        cone: Cone,
        block: &Block,
        walls: &ObliqueWalls,
        mut visit: impl FnMut(Label, Vec<Vector3<f64>>),
    ) {
        self.clip(cone, block, walls);
        for facet in self.part.facets() {
            if facet.label() != FacetKind::Inner.label() {
                let corners = facet.corners().map(|corner| corner.coords).collect();
                visit(facet.label(), corners);
            }
        }
    }

    /// Makes the part of a block within the walls.
    fn clip(&mut self, cone: Cone, block: &Block, walls: &ObliqueWalls) {
        let inner = FacetKind::Inner.label();
        let corners = block
            .corners()
            .map(|corner| Point3::from(cone.displacement(corner)));
        self.part.assign_cuboid(&Bounds::of(&corners), [inner; 6]);
        for (along, lines) in [block.column.u, block.column.v].into_iter().enumerate() {
            for (line, sign) in lines.into_iter().zip([-1.0, 1.0]) {
                // sign · (coordinate − slope h) ≤ sign · offset
                let mut normal = [-sign * line.slope, 0.0, 0.0];
                normal[along + 1] = sign;
                let plane = HalfSpace {
                    normal: cone.displacement(normal),
                    offset: sign * line.offset,
                };
                self.cut(&plane, inner);
            }
        }
        for (wall, label) in &walls.walls {
            self.cut(wall, *label);
        }
    }

    fn cut(&mut self, plane: &HalfSpace, label: Label) {
        if !self.part.is_empty()
            && clip(&mut self.part, plane, label, &mut self.scratch) == Clip::Emptied
        {
            self.part.clear();
        }
    }

    /// ∫ h^p over the part, by tetrahedra from its first corner to the triangles of its facets.
    fn height_integral(&self, cone: Cone, order: u32) -> f64 {
        if self.part.is_empty() {
            return 0.0;
        }
        let apex = self.part.vertex(0).coords;
        let height = |at: &Vector3<f64>| cone.coordinates(at)[0];
        let triangles = self.part.facets().flat_map(|facet| facet.triangles());
        triangles
            .map(|corners| {
                let [a, b, c] = corners.map_each(|corner| corner - apex);
                let volume = a.dot(&b.cross(&c)) / 6.0;
                let heights = [apex, corners[0], corners[1], corners[2]].map_each(|at| height(&at));
                linear_power(volume, &heights, order)
            })
            .sum()
    }
}
