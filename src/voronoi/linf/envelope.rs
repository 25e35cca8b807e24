//! The upper envelope of concave piecewise linear demands over the square of a cone's directions.

use crate::integrals::simplex::linear_power;
use crate::voronoi::linf::ring::{CORNERS, Ring, Split};

/// The most linear functions of a demand.
pub(crate) const FORMS: usize = 3;

/// Differences of functions below this share of their size are rounding. The envelope is then too
/// low by no more than that, or its parts are displaced by as much in the square.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Rings with more corners are halved before they are kept: inserting a demand may add six.
const MOST_KEPT: usize = CORNERS - 6;

/// The linear function constant + by_u u + by_v v of a direction, a gauge (1/L).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Gauge {
    pub(crate) constant: f64,
    pub(crate) by_u: f64,
    pub(crate) by_v: f64,
}

impl Gauge {
    #[inline]
    fn at(&self, u: f64, v: f64) -> f64 {
        self.constant + self.by_u * u + self.by_v * v
    }

    /// The largest absolute value that its terms add up to in the square.
    #[inline]
    fn size(&self) -> f64 {
        self.constant.abs() + self.by_u.abs() + self.by_v.abs()
    }
}

/// A demand g ≥ the least of the first `count` functions.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Demand {
    functions: [Gauge; FORMS],
    /// Names the kind of each function to whoever made the demand.
    forms: [u8; FORMS],
    count: usize,
}

impl Demand {
    /// The demand of one function.
    pub(crate) fn single(form: u8, function: Gauge) -> Self {
        let mut demand = Self::default();
        demand.push(form, function);
        demand
    }

    /// Adds a function: at most [`FORMS`] in all.
    #[inline]
    pub(crate) fn push(&mut self, form: u8, function: Gauge) {
        self.functions[self.count % FORMS] = function;
        self.forms[self.count % FORMS] = form;
        self.count += 1;
    }

    /// Whether it demands nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    fn functions(&self) -> &[Gauge] {
        &self.functions[..self.count.min(FORMS)]
    }
}

/// A convex polygon of directions in which one function is the envelope.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Patch {
    /// Corners u, v and the gauge there (1/L).
    ring: Ring<3>,
    /// Whose demand it is, and which of its functions.
    pub(crate) source: u32,
    pub(crate) form: u8,
}

impl Patch {
    /// Its corners: u, v and the gauge (1/L).
    pub(crate) fn corners(&self) -> &[[f64; 3]] {
        self.ring.corners()
    }

    /// The gauge of a direction in the patch (1/L), from the triangle of its fan that holds it.
    fn gauge_at(&self, [u, v]: [f64; 2]) -> f64 {
        let [first, others @ ..] = self.corners() else {
            return 0.0;
        };
        let mut best = (f64::NEG_INFINITY, first[2]);
        for pair in others.windows(2) {
            let arms =
                [pair[0], pair[1], [u, v, 0.0]].map(|at| [at[0] - first[0], at[1] - first[1]]);
            let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
            let whole = cross(arms[0], arms[1]);
            let shares =
                [cross(arms[2], arms[1]), cross(arms[0], arms[2])].map(|part| part / whole);
            let rest = 1.0 - shares[0] - shares[1];
            let depth = shares[0].min(shares[1]).min(rest);
            if depth > best.0 {
                let gauge = shares[0] * pair[0][2] + shares[1] * pair[1][2] + rest * first[2];
                best = (depth, gauge);
            }
        }
        best.1
    }

    /// Whether a function exceeds the patch's own somewhere by more than rounding.
    #[inline]
    fn is_exceeded(&self, function: &Gauge) -> bool {
        let rounding = ROUNDING * function.size();
        let exceeds = |[u, v, gauge]: &[f64; 3]| function.at(*u, *v) - gauge > rounding;
        self.ring.corners().iter().any(exceeds)
    }
}

/// The envelope of the demands so far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Envelope {
    patches: Vec<Patch>,
    least: f64,
    /// What a patch is being replaced by.
    made: Vec<Patch>,
}

/// u, v, the gauge, and the values of a demand's functions.
type Rivals = [f64; 3 + FORMS];

impl Envelope {
    /// Demands nothing.
    pub(crate) fn clear(&mut self) {
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        self.patches.clear();
        self.patches.push(Patch {
            ring: Ring::new(&square.map(|[u, v]| [u, v, 0.0])),
            source: u32::MAX,
            form: 0,
        });
        self.least = 0.0;
    }

    /// The patches.
    pub(crate) fn patches(&self) -> &[Patch] {
        &self.patches
    }

    /// The least gauge (1/L).
    pub(crate) fn least(&self) -> f64 {
        self.least
    }

    /// The gauge of a direction (1/L): that of the patch in which the direction lies deepest.
    pub(crate) fn at(&self, u: f64, v: f64) -> f64 {
        let depth = |patch: &&Patch| patch.ring.depth([u, v]);
        let patch = self
            .patches
            .iter()
            .max_by(|a, b| depth(a).total_cmp(&depth(b)));
        patch.map_or(0.0, |patch| patch.gauge_at([u, v]))
    }

    /// Raises the envelope to a constant gauge (1/L) of no source.
    pub(crate) fn insert_constant(&mut self, constant: f64) {
        let demand = Demand::single(
            u8::MAX,
            Gauge {
                constant,
                ..Gauge::default()
            },
        );
        self.insert(&demand, u32::MAX);
    }

    /// Raises the envelope to a demand of `source`; says whether that changes it.
    pub(crate) fn insert(&mut self, demand: &Demand, source: u32) -> bool {
        let mut is_changed = false;
        for number in 0..self.patches.len() {
            let patch = &self.patches[number];
            let mut functions = demand.functions().iter();
            if functions.all(|function| patch.is_exceeded(function)) {
                is_changed |= self.overtake(number, demand, source);
            }
        }
        if is_changed {
            let corners = self.patches.iter().flat_map(Patch::corners);
            self.least = corners.fold(f64::INFINITY, |least, corner| least.min(corner[2]));
        }
        is_changed
    }

    /// Gives the part of a patch in which all functions exceed it to `source`, if there is any.
    fn overtake(&mut self, number: usize, demand: &Demand, source: u32) -> bool {
        let patch = self.patches[number];
        let mut inside: Ring<{ 3 + FORMS }> = patch.ring.map(|&[u, v, gauge]| {
            let values = demand.functions.map(|function| function.at(u, v));
            [u, v, gauge, values[0], values[1], values[2]]
        });
        let mut kept = [None; FORMS];
        for (form, function) in demand.functions().iter().enumerate() {
            let size = function.size();
            match inside.split(|values| without_rounding(values[3 + form], values[2], size)) {
                Split::Positive => {}
                Split::Negative => return false,
                Split::Both(positive, negative) => {
                    kept[form] = Some(negative);
                    inside = positive;
                }
            }
        }
        self.made.clear();
        for ring in kept.into_iter().flatten() {
            let ring = ring.map(|values| [values[0], values[1], values[2]]);
            self.keep(Patch { ring, ..patch });
        }
        self.divide(&inside, demand, source, (0, 1));
        if let Some(last) = self.made.pop() {
            self.patches[number] = last;
        }
        self.patches.append(&mut self.made);
        true
    }

    /// Divides a ring among the functions of a demand: `least` is the least of those before `next`.
    fn divide(
        &mut self,
        ring: &Ring<{ 3 + FORMS }>,
        demand: &Demand,
        source: u32,
        (least, next): (usize, usize),
    ) {
        if next >= demand.count {
            // Own values, not the least of all: where two functions are equal but for rounding, the
            // steeper one would displace the other's corners by its own rounding.
            let corner = |values: &Rivals| {
                let (gauge, value) = (values[2], values[3 + least]);
                [
                    values[0],
                    values[1],
                    if value > gauge { value } else { gauge },
                ]
            };
            return self.keep(Patch {
                ring: ring.map(corner),
                source,
                form: demand.forms[least],
            });
        }
        let size = demand.functions[least].size() + demand.functions[next].size();
        match ring.split(|values| without_rounding(values[3 + next], values[3 + least], size)) {
            Split::Positive => self.divide(ring, demand, source, (least, next + 1)),
            Split::Negative => self.divide(ring, demand, source, (next, next + 1)),
            Split::Both(positive, negative) => {
                self.divide(&positive, demand, source, (least, next + 1));
                self.divide(&negative, demand, source, (next, next + 1));
            }
        }
    }

    fn keep(&mut self, patch: Patch) {
        if patch.corners().len() > MOST_KEPT {
            for ring in patch.ring.halves() {
                self.made.push(Patch { ring, ..patch });
            }
        } else {
            self.made.push(patch);
        }
    }

    /// ∫ h^p over the cone (L^(3+p)), h the distance along its axis.
    ///
    /// Over the triangle of three directions with area A in the square lies a tetrahedron of volume
    /// A h_1 h_2 h_3 / 3.
    pub(crate) fn integral(&self, order: u32) -> f64 {
        let mut sum = 0.0;
        for patch in &self.patches {
            let [first, others @ ..] = patch.corners() else {
                continue;
            };
            for pair in others.windows(2) {
                let [[u1, v1, _], [u2, v2, _]] = [0, 1].map(|n| {
                    let [u, v, gauge] = pair[n];
                    [u - first[0], v - first[1], gauge]
                });
                let [a, b, c] = [first[2], pair[0][2], pair[1][2]].map(|gauge| 1.0 / gauge);
                let volume = (u1 * v2 - u2 * v1) * (a * b * c) / 6.0;
                sum += match order {
                    0 => volume,
                    1 => volume * (a + b + c) * 0.25,
                    _ => linear_power(volume, &[0.0, a, b, c], order),
                };
            }
        }
        sum
    }
}

/// The difference of two values of functions whose sizes add up to `size`, or zero if it is rounding.
#[inline]
fn without_rounding(one: f64, other: f64, size: f64) -> f64 {
    let difference = one - other;
    if difference.abs() <= ROUNDING * size {
        0.0
    } else {
        difference
    }
}
