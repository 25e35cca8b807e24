//! One L∞ Voronoi cell: the blocks of its six cones.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};

use crate::arrays::MapEach;
use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::geometry::bounds::Bounds;
use crate::geometry::label::Label;
use crate::geometry::polyhedron::Polyhedron;
use crate::voronoi::kd_tree::tree::KdTree;
use crate::voronoi::linf::block::{Block, CONE_SIDE};
use crate::voronoi::linf::cone::{CONES, Cone};
use crate::voronoi::linf::corner_paths::CornerPathMaker;
use crate::voronoi::linf::facet_key::{BETWEEN_CONES, FacetKey};
use crate::voronoi::linf::oblique::{ClippedBlock, ObliqueWalls};
use crate::voronoi::linf::search::{Nearby, OutwardSearch};
use crate::voronoi::linf::strips::{Strip, StripMaker};
use crate::voronoi::linf::sweep::ConeSweep;
use crate::voronoi::search::Duplicate;

/// Which sites with an equal coordinate cut a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ties {
    /// Those of smaller index: cells fill the domain.
    ToSmallerIndex,
    /// All of them: what is left is nearer to the site than to any other.
    Cut,
}

/// An L∞ cell while it is visited, in coordinates relative to its site.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LinfCell<'a> {
    /// The site's index.
    pub(crate) site: u32,
    /// Its position.
    pub(crate) position: Point3<f64>,
    cones: &'a [ConeSweep; CONES],
    labels: &'a [Label],
    oblique: &'a ObliqueWalls,
    has_ties: bool,
}

/// A fragment of a facet of a cell: a convex polygon, counter-clockwise from outside. With the site
/// it spans a convex part of the cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Fragment {
    /// What is beyond.
    pub(crate) label: Label,
    /// Relative to the site (L).
    pub(crate) corners: Vec<Vector3<f64>>,
}

impl LinfCell<'_> {
    /// ∫ d∞^p over the part in each of the cones +x, −x, +y, −y, +z, −z (L^(3+p)).
    pub(crate) fn integrals(&self, order: u32) -> [f64; CONES] {
        std::array::from_fn(|number| self.integral(number, order, f64::INFINITY))
    }

    /// ∫ d∞^p over the part in a cone up to a height (L^(3+p)).
    fn integral(&self, number: usize, order: u32, height: f64) -> f64 {
        let blocks = self.cones[number].blocks().iter();
        let blocks = blocks.filter_map(|block| block.up_to(height));
        if self.oblique.is_empty() {
            return blocks.map(|block| block.integral(order)).sum();
        }
        let mut clipped = ClippedBlock::default();
        let cone = Cone::all()[number];
        blocks
            .map(|block| clipped.integral(cone, &block, self.oblique, order))
            .sum()
    }

    /// Its volume before it is clipped to a domain that is not convex (L³).
    pub(crate) fn volume(&self) -> f64 {
        self.integrals(0).iter().sum()
    }

    /// Whether no wall that is not along the axes cuts the cell: then it is all in its corner paths.
    pub(crate) fn is_along_axes(&self) -> bool {
        self.oblique.is_empty() || {
            let blocks = self.blocks();
            let mut corners = blocks.flat_map(|(cone, block)| {
                let corners = block.corners();
                corners.map_each(|corner| cone.displacement(corner))
            });
            corners.all(|corner| self.oblique.contain(&corner))
        }
    }

    /// Its convex parts: blocks with their cones, before they are clipped by oblique walls.
    fn blocks(&self) -> impl Iterator<Item = (Cone, &Block)> {
        let cones = Cone::all().into_iter().zip(self.cones);
        cones.flat_map(|(cone, sweep)| sweep.blocks().iter().map(move |block| (cone, block)))
    }

    /// The ways of the corners of the sections of a cone, as [`CornerPathMaker`] passes them on.
    pub(crate) fn visit_corner_paths(&self, number: usize, visit: impl FnMut([[f64; 3]; 2], bool)) {
        self.cones[number].visit(&mut CornerPathMaker::new(visit));
    }

    /// The fragments of its facets.
    pub(crate) fn visit_fragments(&self, mut visit: impl FnMut(&Fragment)) {
        self.visit_polygons(|_, fragment, is_side| {
            if !is_side {
                visit(fragment);
            }
        });
    }

    /// Passes the boundary of the cell to `visit`, as convex polygons that are counter-clockwise from
    /// outside: its fragments, and where regions are tied also the sides of its cones, which cancel
    /// except where the cell ends between two of them. Polygons of one facet have the same key.
    pub(crate) fn visit_boundary(&self, mut visit: impl FnMut(FacetKey, &[Vector3<f64>])) {
        self.visit_polygons(|key, fragment, is_side| {
            if !is_side || self.has_ties {
                visit(key, &fragment.corners);
            }
        });
    }

    /// Whether its site has a coordinate of another one nearby.
    pub(crate) fn has_ties(&self) -> bool {
        self.has_ties
    }

    /// Passes the polygons of all cones' boundaries with the keys of their facets, and whether they are
    /// sides of a cone.
    fn visit_polygons(&self, mut visit: impl FnMut(FacetKey, &Fragment, bool)) {
        for number in 0..CONES {
            self.visit_cone(number, &mut visit);
        }
    }

    /// Passes the polygons of a cone's boundary with the keys of their facets, and whether they are sides
    /// of the cone.
    pub(crate) fn visit_cone(
        &self,
        number: usize,
        mut visit: impl FnMut(FacetKey, &Fragment, bool),
    ) {
        let (mut fragment, mut clipped) = (Fragment::default(), ClippedBlock::default());
        let (cone, sweep) = (Cone::all()[number], &self.cones[number]);
        sweep.visit(&mut StripMaker::new(|strip: &Strip| {
            fragment.assign(cone, strip, self.labels);
            self.oblique.clip_polygon(&mut fragment.corners);
            if fragment.corners.len() > 2 {
                let is_side = strip.source == CONE_SIDE;
                visit(self.key(number, strip), &fragment, is_side);
            }
        }));
        if self.oblique.is_empty() {
            return;
        }
        for block in sweep.blocks() {
            clipped.visit_walls(cone, block, self.oblique, |label, corners| {
                (fragment.label, fragment.corners) = (label, corners);
                visit((label, 0, 0), &fragment, false);
            });
        }
    }

    /// What tells a polygon's facet from others.
    fn key(&self, number: usize, strip: &Strip) -> FacetKey {
        if strip.source == CONE_SIDE {
            let along = usize::from(strip.form) - 1;
            let side = Cone::all()[number].side(along, strip.is_low);
            return (BETWEEN_CONES, side, 0);
        }
        let label = self.labels[strip.source as usize];
        match FacetKind::of(label) {
            FacetKind::Neighbor { .. } => (label, number, strip.form),
            FacetKind::Wall(_) | FacetKind::Inner => (label, 0, 0),
        }
    }

    /// The share of a displacement from the site that lies in the cell, which is star-shaped: at least
    /// 1 for one that ends in it. Infinite for none.
    pub(crate) fn share_within(&self, displacement: &Vector3<f64>) -> f64 {
        let of_cone = |cone: &Cone| cone.coordinates(displacement)[0];
        let ahead = Cone::all().into_iter().enumerate();
        let Some((number, cone)) = ahead.max_by(|a, b| of_cone(&a.1).total_cmp(&of_cone(&b.1)))
        else {
            return f64::INFINITY;
        };
        let [height, along_u, along_v] = cone.coordinates(displacement);
        if height <= 0.0 {
            return f64::INFINITY;
        }
        let exit = self.cones[number].exit([along_u / height, along_v / height]);
        (exit / height).min(self.oblique.share_within(displacement))
    }

    /// An axis-aligned box around the cell, relative to its site: the least one in a box.
    pub(crate) fn bounds(&self) -> Bounds<3> {
        let mut bounds = Bounds::of(&[Point3::origin()]);
        for (cone, sweep) in Cone::all().into_iter().zip(self.cones) {
            let [low, high] = corner_range(sweep.blocks());
            for corner in [low, high] {
                bounds.include(&cone.displacement(corner).into());
            }
        }
        bounds
    }

    /// Its volume within the cube of half side `half` about the site (L³).
    pub(crate) fn volume_within(&self, half: f64) -> f64 {
        (0..CONES)
            .map(|number| self.integral(number, 0, half))
            .sum()
    }

    /// The area vectors of its facets (L²), by what is beyond and by the cone and the normal, of which
    /// a neighbor may have several.
    pub(crate) fn facet_areas(&self) -> BTreeMap<FacetKey, Vector3<f64>> {
        let mut areas: BTreeMap<_, Vector3<f64>> = BTreeMap::new();
        self.visit_boundary(|key, corners| {
            let arm = |corner: usize| corners[corner] - corners[0];
            let fan = (2..corners.len()).map(|corner| arm(corner - 1).cross(&arm(corner)) * 0.5);
            *areas.entry(key).or_default() += fan.sum::<Vector3<f64>>();
        });
        areas
    }
}

/// The least and the greatest coordinates (h, u, v) of the corners of blocks and of the site.
fn corner_range(blocks: &[Block]) -> [[f64; 3]; 2] {
    let (mut low, mut high) = ([0.0_f64; 3], [0.0_f64; 3]);
    let mut include = |axis: usize, at: f64| {
        low[axis] = low[axis].min(at);
        high[axis] = high[axis].max(at);
    };
    for Block { column, heights } in blocks {
        for &height in heights {
            include(0, height);
            for end in [0, 1] {
                include(1, column.u[end].at(height));
                include(2, column.v[end].at(height));
            }
        }
    }
    [low, high]
}

impl Fragment {
    fn assign(&mut self, cone: Cone, strip: &Strip, labels: &[Label]) {
        self.label = match strip.source {
            CONE_SIDE => BETWEEN_CONES,
            source => labels[source as usize],
        };
        self.corners.clear();
        let corners = strip.corners.iter();
        (self.corners).extend(corners.map(|&corner| cone.displacement(corner)));
        if cone.is_negative {
            self.corners.reverse();
        }
    }
}

/// The memory in which cells are built, one after the other.
#[derive(Debug, Default)]
pub(crate) struct LinfCellBuilder {
    start: Polyhedron,
    cones: [ConeSweep; CONES],
    labels: Vec<Label>,
    oblique: ObliqueWalls,
    search: OutwardSearch,
}

impl LinfCellBuilder {
    /// Builds the cell of the site in `place` of the tree.
    ///
    /// # Errors
    /// When another site, or an image of one, lies in the same place.
    pub(crate) fn build<'a>(
        &'a mut self,
        domain: &dyn Domain,
        tree: &KdTree,
        place: usize,
        ties: Ties,
    ) -> Result<LinfCell<'a>, Duplicate> {
        let (site, position) = (tree.site(place), tree.position(place));
        domain.start(&position, site, &mut self.start);
        self.begin();
        let Self {
            cones,
            labels,
            search,
            oblique,
            ..
        } = self;
        let mut has_ties = false;
        search.walk(tree, place, |shell| {
            for nearby in shell {
                if nearby.distance <= 0.0 {
                    let (first, second) = (site.min(nearby.site), site.max(nearby.site));
                    return Err(Duplicate { first, second });
                }
                has_ties |= nearby.displacement.iter().any(|&along| along == 0.0);
                let wins_ties = ties == Ties::Cut || nearby.site < site;
                if cut(cones, nearby, wins_ties, labels.len() as u32) {
                    labels.push(nearby.label(tree));
                }
            }
            Ok(security_distance(cones))
        })?;
        Ok(LinfCell {
            site,
            position,
            cones,
            labels,
            oblique,
            has_ties,
        })
    }

    /// Starts with the domain's walls: those along the axes, or those of the box around it, and others.
    fn begin(&mut self) {
        self.labels.clear();
        self.oblique.clear();
        let around = self.start.bounds();
        // What the box has beyond the domain's other walls.
        let no_wall = self.labels.len() as u32;
        self.labels.push(FacetKind::Inner.label());
        let mut walls: [[(f64, u32); 2]; 3] = std::array::from_fn(|axis| {
            [-around.min[axis], around.max[axis]].map_each(|distance| (distance.max(0.0), no_wall))
        });
        for facet in self.start.facets() {
            let (wall, source) = (facet.half_space(), self.labels.len() as u32);
            self.labels.push(facet.label());
            let axis = wall.normal.iamax();
            if wall.normal.iter().filter(|part| **part != 0.0).count() == 1 {
                walls[axis][usize::from(wall.normal[axis] > 0.0)].1 = source;
            } else {
                self.oblique.push(wall, facet.label());
            }
        }
        for (cone, sweep) in Cone::all().into_iter().zip(&mut self.cones) {
            sweep.clear(cone.walls(&walls));
        }
    }
}

/// Cuts the cones by a neighbor; says whether that may change any.
fn cut(cones: &mut [ConeSweep; CONES], nearby: &Nearby, wins_ties: bool, source: u32) -> bool {
    let mut is_changed = false;
    for (cone, sweep) in Cone::all().into_iter().zip(cones) {
        // Nothing starts below half the distance.
        if nearby.distance >= 2.0 * sweep.reach() {
            continue;
        }
        let walls = &sweep.walls;
        if let Some(quadrant) = cone.quadrant(&nearby.displacement, wins_ties, walls, source) {
            is_changed |= sweep.add(quadrant);
        }
    }
    is_changed
}

/// The distance beyond which no site cuts: twice that of the farthest point (L).
fn security_distance(cones: &mut [ConeSweep; CONES]) -> f64 {
    cones.iter_mut().for_each(ConeSweep::update);
    2.0 * cones.iter().map(ConeSweep::reach).fold(0.0, f64::max)
}
