//! A pattern that is being changed: its corners one by one, in no order.
//!
//! Near sites change partners in *flips*: five sites whose cells meet in two vertices afterwards meet
//! in three, or the other way round. Each of their cells sees it as a flip of its own boundary: among
//! four of its facets, some meet in threes and the others do not, and afterwards just those others do.
//! One vertex becomes three (a new facet opens there), two are exchanged for two, or three become one
//! (a facet with three corners vanishes). These are bistellar moves (Pachner, *P.L. homeomorphic
//! manifolds are equivalent by elementary shellings*, European J. Combin. 12, 1991): a sphere stays one.

use crate::geometry::label::Label;
use crate::voronoi::pattern::{MOST, Pattern};

/// Four labels, and sets of them by bits: bit k is the corner of all but the k-th.
pub(crate) type Four = [Label; 4];

/// The corners of a cell.
#[derive(Clone, Debug, Default)]
pub(crate) struct Corners {
    /// Facets that have vanished keep their number.
    labels: Vec<Label>,
    /// The numbers of the facets around each corner, counter-clockwise.
    around: Vec<[u8; 3]>,
}

impl Corners {
    /// Forgets all corners.
    pub(crate) fn clear(&mut self) {
        self.labels.clear();
        self.around.clear();
    }

    /// Becomes those of a pattern.
    pub(crate) fn assign(&mut self, pattern: &Pattern) {
        self.clear();
        self.labels.extend_from_slice(pattern.labels());
        self.around.extend(pattern.around());
    }

    /// Which of the four corners there are.
    pub(crate) fn view(&self, four: &Four) -> u8 {
        let numbers = four.map(|label| self.number(label));
        (0..4).fold(0, |set, omitted| {
            set | u8::from(self.find(&numbers, omitted).is_some()) << omitted
        })
    }

    /// Exchanges those of the four corners that there are for the others; returns which there were,
    /// or nothing if that cannot be.
    pub(crate) fn flip(&mut self, four: &Four) -> Option<u8> {
        let known = four.map(|label| self.number(label));
        let found = [0, 1, 2, 3].map(|omitted| self.find(&known, omitted));
        let view = (0..4).fold(0, |set, k| set | u8::from(found[k].is_some()) << k);
        if !self.may_flip(&known, view) {
            return None;
        }
        // As the boundary of a tetrahedron, all turn the same way.
        let turns = [0, 1, 2, 3].map(|k| found[k].map(|(_, is_even)| is_even == (k % 2 == 0)));
        let is_outward = turns.into_iter().flatten().next()?;
        if turns.into_iter().flatten().any(|turn| turn != is_outward) {
            return None;
        }
        let numbers = self.numbers(four)?;
        let mut gone = found.map(|found| found.map(|(corner, _)| corner));
        gone.sort_unstable();
        for corner in gone.into_iter().flatten().rev() {
            self.around.swap_remove(corner);
        }
        for omitted in (0..4).filter(|k| view >> k & 1 == 0) {
            let [a, b, c] = others(&numbers, omitted);
            // The other side of the tetrahedron turns the other way.
            let is_even = is_outward != (omitted % 2 == 0);
            self.around
                .push(if is_even { [a, b, c] } else { [a, c, b] });
        }
        Some(view)
    }

    /// Whether the corners of the view can be exchanged for the others.
    fn may_flip(&self, numbers: &[Option<u8>; 4], view: u8) -> bool {
        let are_beside = |[one, other]: [Option<u8>; 2]| {
            let pair = one.zip(other);
            pair.is_some_and(|(one, other)| {
                let mut all = self.around.iter();
                all.any(|corner| corner.contains(&one) && corner.contains(&other))
            })
        };
        let members = |is_there: bool| {
            let is_member = move |k: &usize| (view >> k & 1 == 1) == is_there;
            (0..4).filter(is_member)
        };
        match view.count_ones() {
            // The facet that opens is not yet there.
            1 => members(true).all(|new| {
                let new = numbers[new];
                new.is_none_or(|new| !self.around.as_flattened().contains(&new))
            }),
            // The facets that part have an edge in common, those that meet have none.
            2 => {
                let mut pair = members(true);
                let pair = [pair.next(), pair.next()].map(|k| k.and_then(|k| numbers[k]));
                !are_beside(pair)
            }
            // The facet that vanishes has no other corner.
            3 => members(false).all(|gone| {
                let corners = self.around.as_flattened().iter();
                numbers[gone].is_some_and(|gone| corners.filter(|&&of| of == gone).count() == 3)
            }),
            _ => false,
        }
    }

    /// The number of a facet.
    fn number(&self, label: Label) -> Option<u8> {
        let place = self.labels.iter().position(|&other| other == label);
        place.map(|place| place as u8)
    }

    /// The numbers of four facets, some of which may be new.
    fn numbers(&mut self, four: &Four) -> Option<[u8; 4]> {
        let mut numbers = [0; 4];
        for (number, &label) in numbers.iter_mut().zip(four) {
            *number = match self.number(label) {
                Some(known) => known,
                None if self.labels.len() >= MOST => return None,
                None => {
                    self.labels.push(label);
                    (self.labels.len() - 1) as u8
                }
            };
        }
        Some(numbers)
    }

    /// The corner of three of four facets, and whether they are around it in an even order.
    fn find(&self, numbers: &[Option<u8>; 4], omitted: usize) -> Option<(usize, bool)> {
        let [a, b, c] = others(numbers, omitted);
        let (a, b, c) = (a?, b?, c?);
        let is_around = |corner: &[u8; 3]| [a, b, c].iter().all(|facet| corner.contains(facet));
        let corner = self.around.iter().position(is_around)?;
        let [x, y, z] = self.around[corner];
        Some((
            corner,
            [[x, y, z], [y, z, x], [z, x, y]].contains(&[a, b, c]),
        ))
    }

    /// The pattern of these corners in its one possible order, if they are a sphere's.
    #[must_use]
    pub(crate) fn write(&self, pattern: &mut Pattern) -> bool {
        let mut counts = [0_u8; MOST];
        for &facet in self.around.as_flattened() {
            counts[usize::from(facet)] += 1;
        }
        let has_room = self.around.len() <= MOST;
        if !has_room || counts.iter().any(|&corners| corners == 1 || corners == 2) {
            return false;
        }
        let (mut facets, mut count) = ([(0, 0); MOST], 0);
        for (number, &label) in self.labels.iter().enumerate() {
            if counts[number] > 0 {
                facets[count] = (label, number as u8);
                count += 1;
            }
        }
        let Some(numbers) = pattern.assign_labels(facets[..count].iter().copied()) else {
            return false;
        };
        let around = self.around.iter();
        pattern.assign_corners(around.map(|corner| corner.map(|facet| numbers[usize::from(facet)])))
    }
}

/// All but one, in order.
fn others<T: Copy>(four: &[T; 4], omitted: usize) -> [T; 3] {
    let place = |k: usize| four[k + usize::from(k >= omitted)];
    [place(0), place(1), place(2)]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::domain::facet_kind::FacetKind;
    use crate::geometry::bounds::Bounds;
    use crate::geometry::half_space::HalfSpace;
    use crate::geometry::polyhedron::Polyhedron;
    use crate::geometry::small_polyhedron::{SmallPolyhedron, slots};
    use crate::geometry::small_polyhedron_clip::SmallClipScratch;

    const SITE: u32 = 1000;

    fn label(site: u32) -> Label {
        let image = [0; 3];
        FacetKind::Neighbor { site, image }.label()
    }

    fn pattern(cell: &SmallPolyhedron) -> Pattern {
        let mut pattern = Pattern::default();
        assert!(pattern.assign(cell, SITE));
        // The same edges, told by what is around their ends.
        let ends = |around: &[u8], twins: &[u8], labels: &[Label], slots: &[usize]| {
            let corner = |slot: usize| {
                let mut three = [1, 2, 3].map(|byte| labels[usize::from(around[4 * slot + byte])]);
                three.sort_unstable();
                three
            };
            let edges = slots
                .iter()
                .flat_map(|slot| [0, 1, 2].map(|edge| 4 * slot + edge));
            let ends = edges.map(|edge| [edge / 4, usize::from(twins[edge] / 4)].map(corner));
            let mut all: Vec<_> = ends.collect();
            all.sort_unstable();
            all
        };
        let (places, slots): (Vec<_>, Vec<_>) = slots(cell.alive).enumerate().unzip();
        assert_eq!(
            ends(&pattern.facets, &pattern.twins, pattern.labels(), &places),
            ends(&cell.facets, &cell.twins, &cell.labels, &slots),
        );
        pattern
    }

    fn is_same(one: &Pattern, other: &Pattern) -> bool {
        let bytes = 4 * one.vertex_count;
        one.labels() == other.labels()
            && one.vertex_count == other.vertex_count
            && one.facets[..bytes] == other.facets[..bytes]
            && (0..bytes).all(|edge| edge % 4 == 3 || one.twins[edge] == other.twins[edge])
    }

    /// A cube cut by planes in many directions.
    fn cell() -> SmallPolyhedron {
        let corner = Point3::new(1.0, 1.0, 1.0);
        let bounds = Bounds {
            min: -corner,
            max: corner,
        };
        let mut cell = SmallPolyhedron::default();
        let labels = [0, 1, 2, 3, 4, 5].map(|wall| FacetKind::Wall(wall).label());
        assert!(cell.assign(&Polyhedron::cuboid(&bounds, labels)));
        for number in 0..18 {
            let turn = f64::from(number);
            let away = Vector3::new((2.3 * turn).sin(), (3.7 * turn).cos(), (1.9 * turn).sin());
            let plane = HalfSpace::bisector(away.normalize() * 2.0);
            let scratch = &mut SmallClipScratch::default();
            cell.clip(&plane, || label(number as u32), scratch).unwrap();
        }
        cell
    }

    #[test]
    fn a_corner_cut_off_is_a_flip() {
        let cell = cell();
        let before = pattern(&cell);
        for slot in slots(cell.alive) {
            // A plane that leaves just this vertex beyond.
            let vertex = cell.vertex(slot);
            let along = |other: usize| vertex.dot(&cell.vertex(other)) / vertex.norm_squared();
            let others = slots(cell.alive).filter(|&other| other != slot);
            let nearest = others.map(along).fold(f64::NEG_INFINITY, f64::max);
            if nearest >= 1.0 {
                continue;
            }
            let plane = HalfSpace {
                normal: vertex,
                offset: vertex.norm_squared() * (1.0 + nearest) / 2.0,
            };
            let mut cut = cell.clone();
            let scratch = &mut SmallClipScratch::default();
            cut.clip(&plane, || label(500), scratch).unwrap();
            let around = [1, 2, 3].map(|byte| usize::from(cell.facets[4 * slot + byte]));
            let [a, b, c] = around.map(|facet| cell.labels[facet]);
            let (mut corners, mut flipped) = (Corners::default(), Pattern::default());
            corners.assign(&before);
            let four = [a, label(500), c, b];
            assert_eq!(corners.view(&four), 0b0010);
            assert_eq!(corners.flip(&four), Some(0b0010));
            assert!(corners.write(&mut flipped));
            assert!(is_same(&flipped, &pattern(&cut)));
            // Back, and as it was.
            assert_eq!(corners.flip(&four), Some(0b1101));
            assert!(corners.write(&mut flipped));
            assert!(is_same(&flipped, &before));
        }
    }

    #[test]
    fn an_edge_that_turns_is_a_flip_and_other_exchanges_are_none() {
        let before = pattern(&cell());
        let mut corners = Corners::default();
        let mut turned = 0;
        for edge in (0..4 * before.vertex_count).filter(|edge| edge % 4 < 3) {
            corners.assign(&before);
            let twin = usize::from(before.twins[edge]);
            let third = |edge: usize| before.facets[4 * (edge / 4) + 1 + (edge % 4 + 1) % 3];
            let facets = [
                before.facets[edge + 1],
                before.facets[edge],
                third(edge),
                third(twin),
            ];
            let four = facets.map(|facet| before.labels[usize::from(facet)]);
            let view = corners.view(&four);
            assert_eq!(view & 0b1100, 0b1100, "both ends are there");
            if view != 0b1100 {
                continue;
            }
            assert_eq!(corners.flip(&four), Some(0b1100));
            turned += 1;
            let mut flipped = Pattern::default();
            assert!(corners.write(&mut flipped));
            assert_eq!(flipped.vertex_count, before.vertex_count);
            assert_eq!(corners.view(&four), 0b0011);
            corners.assign(&before);
            // Among facets that do not meet nothing is exchanged.
            let strangers = [label(600), label(601), four[2], four[3]];
            assert_eq!(corners.flip(&strangers), None);
            assert_eq!(corners.flip(&four), Some(0b1100));
            assert_eq!(corners.flip(&four), Some(0b0011));
            assert!(corners.write(&mut flipped));
            assert!(is_same(&flipped, &before));
        }
        assert!(turned > 40, "{turned}");
    }
}
