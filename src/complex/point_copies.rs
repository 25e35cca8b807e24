//! The images of points in a periodic mesh.

use nalgebra::Vector3;

use crate::complex::shifted_union::ShiftedUnion;
use crate::complex::vertex_key::{NO_SHIFT, Shift, difference, displacement, sum};
use crate::mesh::poly_mesh::PolyMesh;

/// Classes of points that are whole periods apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct PointCopies {
    /// Per point: its class and where it stands there; nothing without periods.
    places: Vec<(u32, Shift)>,
    /// Per class: its points by their shifts.
    classes: Vec<Vec<(Shift, u32)>>,
    periods: Vector3<f64>,
}

impl PointCopies {
    /// The images that the pairs of patches of `mesh` show.
    #[must_use]
    pub(crate) fn of(mesh: &PolyMesh) -> Self {
        let pairs = mesh.patches.iter().filter_map(|patch| {
            let (partner, way) = patch.partner?;
            let other = &mesh.patches[partner];
            Some((patch.start..patch.start + patch.count, other.start, way))
        });
        let pairs: Vec<_> = pairs.collect();
        let mut periods = Vector3::zeros();
        for (.., way) in &pairs {
            for axis in 0..3 {
                let length: f64 = way[axis].abs();
                if length > 0.0 && (periods[axis] == 0.0 || length < periods[axis]) {
                    periods[axis] = length;
                }
            }
        }
        if pairs.is_empty() {
            return Self::default();
        }
        let mut classes = ShiftedUnion::new(mesh.points.len());
        for (faces, start, way) in pairs {
            let shift = shift_of(&way, &periods);
            let first = faces.start;
            for face in faces {
                let (here, there) = (mesh.face(face), mesh.face(start + face - first));
                let count = here.len();
                for (place, &point) in here.iter().enumerate() {
                    let image = there[(count - place) % count];
                    classes.unite((image, NO_SHIFT), (point, shift));
                }
            }
        }
        let places = (0..mesh.points.len() as u32).map(|point| classes.resolved((point, NO_SHIFT)));
        let places: Vec<(u32, Shift)> = places.collect();
        let mut lists = vec![Vec::new(); places.len()];
        for (point, &(class, shift)) in (0..).zip(&places) {
            lists[class as usize].push((shift, point));
        }
        Self {
            places,
            classes: lists,
            periods,
        }
    }

    /// Whether there are no periods.
    #[must_use]
    pub(crate) fn is_trivial(&self) -> bool {
        self.classes.is_empty()
    }

    /// A point and its images.
    #[must_use]
    pub(crate) fn of_point(&self, point: u32) -> Vec<u32> {
        match self.places.get(point as usize) {
            None => vec![point],
            Some(&(class, _)) => {
                let members = self.classes[class as usize].iter();
                members.map(|&(_, member)| member).collect()
            }
        }
    }

    /// Whether two points are images of each other.
    #[must_use]
    pub(crate) fn are_images(&self, one: u32, other: u32) -> bool {
        let class = |point: u32| self.places.get(point as usize).map(|place| place.0);
        one == other || class(one).is_some_and(|one| Some(one) == class(other))
    }

    /// The class of a point, and its shift from where another stands in its own.
    #[must_use]
    pub(crate) fn relative(&self, from: u32, to: u32) -> (u32, Shift) {
        match (self.places.get(from as usize), self.places.get(to as usize)) {
            (Some(from), Some(to)) => (to.0, difference(to.1, from.1)),
            _ => (to, NO_SHIFT),
        }
    }

    /// The way from a point to one of its images (L).
    #[must_use]
    pub(crate) fn way(&self, from: u32, to: u32) -> Vector3<f64> {
        match (self.places.get(from as usize), self.places.get(to as usize)) {
            (Some(from), Some(to)) => displacement(difference(to.1, from.1), &self.periods),
            _ => Vector3::zeros(),
        }
    }

    /// Makes one class of two points' classes, `gone` standing where `kept` does. Returns for every image
    /// of `gone` the image of `kept` in its place, none where it becomes that itself; and what undoes it.
    pub(crate) fn join(&mut self, kept: u32, gone: u32) -> (Vec<(u32, Option<u32>)>, Joined) {
        let (class, here) = self.places[kept as usize];
        let (old, there) = self.places[gone as usize];
        let members = std::mem::take(&mut self.classes[old as usize]);
        let mut pairs = Vec::with_capacity(members.len());
        let count = self.classes[class as usize].len();
        for &(shift, point) in &members {
            let wanted = sum(difference(shift, there), here);
            let known = self.classes[class as usize]
                .iter()
                .find(|(shift, _)| *shift == wanted)
                .map(|&(_, member)| member);
            if known.is_none() {
                self.classes[class as usize].push((wanted, point));
                self.places[point as usize] = (class, wanted);
            }
            pairs.push((point, known));
        }
        let joined = Joined {
            class,
            count,
            old,
            members,
        };
        (pairs, joined)
    }

    /// Undoes the last [`PointCopies::join`].
    pub(crate) fn part(&mut self, joined: Joined) {
        self.classes[joined.class as usize].truncate(joined.count);
        for &(shift, point) in &joined.members {
            self.places[point as usize] = (joined.old, shift);
        }
        self.classes[joined.old as usize] = joined.members;
    }
}

/// How two classes were before they became one.
#[derive(Clone, Debug)]
pub(crate) struct Joined {
    class: u32,
    /// How many members the class had.
    count: usize,
    old: u32,
    members: Vec<(Shift, u32)>,
}

/// A way by whole periods.
fn shift_of(way: &Vector3<f64>, periods: &Vector3<f64>) -> Shift {
    [0, 1, 2].map(|axis| match periods[axis] > 0.0 {
        true => (way[axis] / periods[axis]).round() as i16,
        false => 0,
    })
}
