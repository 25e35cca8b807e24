//! What lies around a site: the near sites in order, and where to look for the others.

use nalgebra::{Point3, Vector3};

use crate::voronoi::index::{Shift, SiteIndex};

/// Near sites at most. More would take longer to sort than they are worth: the look is then too far.
const MOST: usize = 256;

/// The bits of a sorting key that number a candidate.
const NUMBER: u64 = (1 << 12) - 1;

/// How often the first look is drawn in, each time to a quarter of its square, before it is given up.
const DRAWN_IN: usize = 40;

/// A site, or a periodic image of one, near another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate {
    /// The way to it (L).
    pub(crate) displacement: Vector3<f64>,
    /// The squared distance (L²).
    pub(crate) distance_squared: f64,
    /// Its place in the index.
    pub(crate) place: u32,
    /// The number of its image among the index's shifts.
    pub(crate) shift: u32,
}

/// A subtree that has not been looked through.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Subtree {
    /// The squared distance of its box (L²).
    pub(crate) gap_squared: f64,
    /// Its node.
    pub(crate) node: u32,
    /// The number of its image among the index's shifts.
    pub(crate) shift: u32,
}

/// What has been found around a site.
#[derive(Clone, Debug, Default)]
pub(crate) struct Surroundings {
    /// All sites of the leaves looked through.
    pub(crate) candidates: Vec<Candidate>,
    /// Those within the first look, nearest first, as sorting keys.
    keys: Vec<u64>,
    /// Subtrees beyond the first look, in the order in which they were met.
    pub(crate) beyond: Vec<Subtree>,
    stack: Vec<Subtree>,
}

/// From where one looks.
struct View<'a> {
    index: &'a SiteIndex,
    place: usize,
    site: Point3<f64>,
}

impl Surroundings {
    /// Looks around the site in `place` as far as the root of `limit`, or less far where that is too
    /// much, and returns the square within which all sites are found.
    pub(crate) fn look(&mut self, index: &SiteIndex, place: usize, mut limit: f64) -> f64 {
        for _ in 0..DRAWN_IN {
            if self.look_within(index, place, limit) {
                self.keys.sort_unstable();
                return limit;
            }
            limit *= 0.25;
        }
        self.look_within(index, place, -1.0);
        -1.0
    }

    /// The sites within the first look, nearest first.
    pub(crate) fn near(&self) -> impl Iterator<Item = &Candidate> {
        let number = |key: &u64| (key & NUMBER) as usize;
        self.keys
            .iter()
            .map(move |key| &self.candidates[number(key)])
    }

    fn look_within(&mut self, index: &SiteIndex, place: usize, limit: f64) -> bool {
        self.candidates.clear();
        self.keys.clear();
        self.beyond.clear();
        let site = index.position(place);
        let view = View { index, place, site };
        for (number, shift) in index.shifts().iter().enumerate() {
            let root = Subtree {
                gap_squared: 0.0,
                node: 1,
                shift: number as u32,
            };
            if limit < 0.0 {
                self.beyond.push(root);
                continue;
            }
            self.stack.clear();
            self.stack.push(root);
            if !self.walk(&view, shift, limit) {
                return false;
            }
        }
        true
    }

    /// Looks through what is on the stack; returns whether not too much is near.
    fn walk(&mut self, view: &View<'_>, shift: &Shift, limit: f64) -> bool {
        let here = view.site - shift.by;
        while let Some(mut here_now) = self.stack.pop() {
            loop {
                if view.index.is_leaf(here_now.node) {
                    self.collect(view, &here_now, &shift.by, limit);
                    break;
                }
                let [near, far] = here_now.children(view.index, &here);
                if far.gap_squared <= limit {
                    self.stack.push(far);
                } else {
                    self.beyond.push(far);
                }
                if near.gap_squared > limit {
                    self.beyond.push(near);
                    break;
                }
                here_now = near;
            }
            if self.keys.len() > MOST || self.candidates.len() as u64 > NUMBER - 64 {
                return false;
            }
        }
        true
    }

    /// Appends the sites of a leaf.
    #[inline]
    fn collect(&mut self, view: &View<'_>, leaf: &Subtree, by: &Vector3<f64>, limit: f64) {
        for place in view.index.places(leaf.node) {
            if place == view.place {
                continue;
            }
            let candidate = Candidate::new(view.index, &view.site, (place, leaf.shift), by);
            if candidate.distance_squared <= limit {
                let number = self.candidates.len() as u64;
                self.keys
                    .push(candidate.distance_squared.to_bits() & !NUMBER | number);
            }
            self.candidates.push(candidate);
        }
    }
}

impl Subtree {
    /// The children, the nearer one first.
    #[inline]
    pub(crate) fn children(&self, index: &SiteIndex, here: &Point3<f64>) -> [Self; 2] {
        let gaps = index.gaps_squared(self.node, here);
        let child = |side: u32| Self {
            gap_squared: gaps[side as usize],
            node: 2 * self.node + side,
            shift: self.shift,
        };
        let far = u32::from(gaps[0] <= gaps[1]);
        [child(1 - far), child(far)]
    }
}

impl Candidate {
    /// The image of the site in `place`, moved `by`, as seen from `here`.
    #[inline]
    #[must_use]
    pub(crate) fn new(
        index: &SiteIndex,
        here: &Point3<f64>,
        (place, shift): (usize, u32),
        by: &Vector3<f64>,
    ) -> Self {
        let displacement = index.position(place) - here + by;
        Self {
            displacement,
            distance_squared: displacement.norm_squared(),
            place: place as u32,
            shift,
        }
    }
}
