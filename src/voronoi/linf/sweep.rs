//! The sweep of a cone from its site outward: the rectangles of its sections, and where they change.
//!
//! At the height h the cone's section is the square \[−h, h\]² of coordinates across it. From its start on,
//! at half its distance along the cone at least, a neighbor at (D, a, b) is nearer where y_u ≥ a − h if
//! a > 0, y_u ≤ h + a if a < 0, and the same with b: a quadrant of one of the square's corners that moves
//! with speed 1 along both axes. What is left of the section is bounded, along u, by the fronts of quadrants
//! from either side; between two fronts it is one [`Column`], bounded along v by the farthest quadrant of
//! either end. All that changes, changes at a height that is a coordinate, a half or a sum of two: there the
//! columns are laid anew, and decided by the same expression, so that nothing is left to rounding.

use crate::voronoi::linf::block::{Block, CONE_SIDE, Column, Lasting, Line};

/// Where a neighbor is nearer than the site, in one cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quadrant {
    /// The height from which on it is in the section (L).
    pub(crate) start: f64,
    /// The neighbor's distances along u and v (L).
    pub(crate) across: [f64; 2],
    /// Whether it lies towards negative u and v.
    pub(crate) is_low: [bool; 2],
    /// Whether it starts at once on all of its extent: half-way to the neighbor.
    pub(crate) is_ahead: bool,
    pub(crate) source: u32,
}

impl Quadrant {
    fn contains(&self, other: &Self) -> bool {
        self.is_low == other.is_low
            && self.across[0] <= other.across[0]
            && self.across[1] <= other.across[1]
            && self.start <= other.start
    }

    /// The height at which the direction (1, u, v) comes into it (L).
    fn entry(&self, direction: [f64; 2]) -> f64 {
        let along = |along: usize| {
            let sign = if self.is_low[along] { -1.0 } else { 1.0 };
            let (distance, rate) = (self.across[along], 1.0 + sign * direction[along]);
            if distance > 0.0 { distance / rate } else { 0.0 }
        };
        self.start.max(along(0)).max(along(1))
    }

    /// The coordinate of its side along an axis across.
    pub(crate) fn side(&self, along: usize) -> Line {
        front_line(self.across[along], self.is_low[along], self.source)
    }
}

/// Walls along the axes: the distance (L) and who is beyond, along u and v, low and high, and ahead.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConeWalls {
    pub(crate) across: [[(f64, u32); 2]; 2],
    pub(crate) ahead: (f64, u32),
}

impl Default for ConeWalls {
    fn default() -> Self {
        let none = (f64::INFINITY, CONE_SIDE);
        Self {
            across: [[none; 2]; 2],
            ahead: none,
        }
    }
}

impl ConeWalls {
    /// The section's own end along an axis: the wall once it is reached, else the cone's side.
    #[inline]
    fn end(&self, along: usize, is_high: bool, height: f64) -> Line {
        let (distance, source) = self.across[along][usize::from(is_high)];
        let sign = if is_high { 1.0 } else { -1.0 };
        if distance <= height {
            return Line {
                offset: sign * distance,
                slope: 0.0,
                source,
            };
        }
        Line {
            offset: 0.0,
            slope: sign,
            source: CONE_SIDE,
        }
    }

    /// The first wall beyond a height (L).
    fn next(&self, height: f64) -> f64 {
        let walls = self.across.iter().flatten().map(|wall| wall.0);
        let beyond = walls.filter(|&distance| distance > height);
        beyond.fold(self.ahead.0, f64::min)
    }
}

/// A front along u of quadrants from one side, and what they and the fronts before it leave along v.
#[derive(Clone, Copy, Debug)]
struct Front {
    at: f64,
    source: u32,
    caps: [Cap; 2],
}

/// The nearest quadrant from one end along v: its distance and who it is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Cap {
    at: f64,
    source: u32,
}

const NO_CAP: Cap = Cap {
    at: f64::INFINITY,
    source: CONE_SIDE,
};

/// The line of a quadrant's side, offset from the site by `at`, that comes from below or above.
#[inline]
fn front_line(at: f64, is_low: bool, source: u32) -> Line {
    let sign = if is_low { -1.0 } else { 1.0 };
    Line {
        offset: sign * at,
        slope: -sign,
        source,
    }
}

/// What is done with the columns of a sweep.
pub(crate) trait SweepVisitor {
    /// Whether [`SweepVisitor::covered`] is wanted.
    const WANTS_COVERED: bool;

    /// The columns from a height on, until the next call.
    fn columns(&mut self, columns: &[Column], height: f64);

    /// A quadrant covers what it holds of the columns at once.
    fn covered(&mut self, columns: &[Column], height: f64, by: &Quadrant);
}

/// Makes blocks of columns.
#[derive(Clone, Debug, Default)]
struct BlockMaker {
    lasting: Lasting<Column>,
    blocks: Vec<Block>,
}

impl BlockMaker {
    fn clear(&mut self) {
        self.blocks.clear();
        self.lasting.clear();
    }
}

impl SweepVisitor for BlockMaker {
    const WANTS_COVERED: bool = false;

    fn columns(&mut self, columns: &[Column], height: f64) {
        let open = columns.iter().filter(|column| column.closing() > height);
        let blocks = &mut self.blocks;
        self.lasting.turn(open.copied(), height, |column, heights| {
            blocks.push(Block { column, heights });
        });
    }

    fn covered(&mut self, _: &[Column], _: f64, _: &Quadrant) {}
}

/// What a sweep keeps at its height.
#[derive(Clone, Debug, Default)]
struct SweepState {
    height: f64,
    /// Fronts from the right and from the left, by distance.
    fronts: [Vec<Front>; 2],
    columns: Vec<Column>,
    /// The next height at which anything changes.
    event: f64,
    is_open: bool,
}

/// A cone of a site: what cuts it, and its blocks.
#[derive(Clone, Debug, Default)]
pub(crate) struct ConeSweep {
    pub(crate) walls: ConeWalls,
    quadrants: Vec<Quadrant>,
    is_sorted: bool,
    maker: BlockMaker,
    state: SweepState,
    reach: f64,
}

impl ConeSweep {
    /// Starts anew between walls.
    pub(crate) fn clear(&mut self, walls: ConeWalls) {
        self.walls = walls;
        self.quadrants.clear();
        self.is_sorted = false;
        self.reach = f64::INFINITY;
    }

    /// Adds a quadrant; says whether it may cut. Sources come in ascending order.
    pub(crate) fn add(&mut self, quadrant: Quadrant) -> bool {
        let is_new = !self.quadrants.iter().any(|other| other.contains(&quadrant));
        if is_new {
            self.quadrants.push(quadrant);
            self.is_sorted = false;
        }
        is_new
    }

    /// The parts of the cone that no quadrant covers, as of the last [`ConeSweep::update`].
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.maker.blocks
    }

    /// The height above which there is nothing, as of the last [`ConeSweep::update`]: infinite before.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }

    /// The height at which the direction (1, u, v) leaves the uncovered part between the walls (L).
    pub(crate) fn exit(&self, across: [f64; 2]) -> f64 {
        let wall = |along: usize| {
            let distance = self.walls.across[along][usize::from(across[along] > 0.0)].0;
            distance / across[along].abs()
        };
        let walls = self.walls.ahead.0.min(wall(0)).min(wall(1));
        let exits = self.quadrants.iter().map(|quadrant| quadrant.entry(across));
        exits.fold(walls, f64::min)
    }

    /// Makes the blocks if quadrants have been added.
    pub(crate) fn update(&mut self) {
        if self.is_sorted {
            return;
        }
        (self.quadrants).sort_unstable_by(|a, b| {
            let by_source = a.source.cmp(&b.source);
            a.start.total_cmp(&b.start).then(by_source)
        });
        self.is_sorted = true;
        self.maker.clear();
        let (walls, quadrants) = (&self.walls, &self.quadrants);
        self.reach = self.state.run(walls, quadrants, &mut self.maker);
    }

    /// Shows the cone's columns to a visitor.
    pub(crate) fn visit(&self, visitor: &mut impl SweepVisitor) {
        SweepState::default().run(&self.walls, &self.quadrants, visitor);
    }
}

impl SweepState {
    /// Sweeps up to where nothing is left, and returns that height (L).
    fn run(
        &mut self,
        walls: &ConeWalls,
        quadrants: &[Quadrant],
        visitor: &mut impl SweepVisitor,
    ) -> f64 {
        self.begin();
        let mut waiting = quadrants;
        loop {
            waiting = self.start_quadrants(walls, waiting, visitor);
            let next = waiting.first().map_or(f64::INFINITY, |next| next.start);
            self.event = walls.next(self.height).min(next);
            self.lay(walls);
            visitor.columns(&self.columns, self.height);
            if !self.is_open || self.height >= walls.ahead.0 {
                break;
            }
            if self.event == f64::INFINITY {
                return f64::INFINITY;
            }
            self.height = self.event;
        }
        if self.is_open {
            self.end(walls, visitor);
        }
        self.height
    }

    fn begin(&mut self) {
        self.height = 0.0;
        self.fronts.iter_mut().for_each(Vec::clear);
    }

    /// The wall ahead covers all that is left.
    fn end(&mut self, walls: &ConeWalls, visitor: &mut impl SweepVisitor) {
        let everything = Quadrant {
            start: self.height,
            across: [0.0; 2],
            is_low: [false; 2],
            is_ahead: true,
            source: walls.ahead.1,
        };
        visitor.covered(&self.columns, self.height, &everything);
        visitor.columns(&[], self.height);
    }

    /// Starts the quadrants that start here, and returns the others.
    fn start_quadrants<'a>(
        &mut self,
        walls: &ConeWalls,
        mut waiting: &'a [Quadrant],
        visitor: &mut impl SweepVisitor,
    ) -> &'a [Quadrant] {
        while let [first, others @ ..] = waiting {
            if first.start > self.height {
                break;
            }
            if covers_at_once(visitor, first) {
                self.lay(walls);
                visitor.covered(&self.columns, self.height, first);
            }
            self.push(first);
            waiting = others;
        }
        waiting
    }

    /// Adds a quadrant to the fronts.
    fn push(&mut self, quadrant: &Quadrant) {
        let [at, cap] = quadrant.across;
        let [from_left, from_below] = quadrant.is_low.map(usize::from);
        let fronts = &mut self.fronts[from_left];
        let place = fronts.partition_point(|front| front.at <= at);
        let mut caps = place.checked_sub(1).map_or([NO_CAP; 2], |n| fronts[n].caps);
        let end = 1 - from_below;
        if caps[end].at <= cap {
            return;
        }
        let source = quadrant.source;
        let new = Cap { at: cap, source };
        caps[end] = new;
        fronts.insert(place, Front { at, source, caps });
        for front in &mut fronts[place + 1..] {
            if cap < front.caps[end].at {
                front.caps[end] = new;
            }
        }
        // A front behind which nothing changes is none.
        fronts.dedup_by(|later, earlier| later.caps == earlier.caps);
    }

    /// Lays the columns from the left end to the right one, and finds the next event.
    fn lay(&mut self, walls: &ConeWalls) {
        let mut walk = ColumnWalk::new(walls, &self.fronts, self.height);
        let mut event = self.event.min(walk.next_hiding());
        let mut ending: Option<f64> = None;
        self.columns.clear();
        self.is_open = false;
        loop {
            let boundary = walk.boundary();
            let column = walk.column(boundary);
            let closing = column.closing();
            if closing > self.height {
                self.is_open = true;
                event = event.min(closing);
            }
            self.columns.push(column);
            match boundary {
                Boundary::Begins(front) => {
                    // A front that ends here and one that begins move towards each other.
                    event = ending.map_or(event, |at| event.min(0.5 * (front.at + at)));
                    ending = None;
                }
                Boundary::Ends(front) => ending = Some(front.at),
                Boundary::Wall => break,
            }
            walk.pass(boundary);
        }
        self.event = event;
    }
}

/// What is at the right end of a column.
#[derive(Clone, Copy, Debug)]
enum Boundary<'a> {
    /// A front from the right begins.
    Begins(&'a Front),
    /// A front from the left ends.
    Ends(&'a Front),
    Wall,
}

/// The way from the left end of a section to its right one.
struct ColumnWalk<'a> {
    walls: &'a ConeWalls,
    /// From the right and from the left.
    fronts: [&'a [Front]; 2],
    height: f64,
    /// How many fronts from the right have begun, and from the left not yet ended.
    counts: [usize; 2],
    /// How many fronts from either side are beyond the other end.
    hidden: [usize; 2],
    /// The left end of the next column.
    start: Line,
}

impl<'a> ColumnWalk<'a> {
    fn new(walls: &'a ConeWalls, fronts: &'a [Vec<Front>; 2], height: f64) -> Self {
        let hidden = [0, 1].map(|side| {
            let wall = walls.across[0][side].0;
            hidden(&fronts[side], wall, height)
        });
        Self {
            walls,
            fronts: [&fronts[0], &fronts[1]],
            height,
            counts: [hidden[0], fronts[1].len()],
            hidden,
            start: walls.end(0, false, height),
        }
    }

    /// The height at which the next front reaches the wall at the other end.
    fn next_hiding(&self) -> f64 {
        let of_side = |side: usize| {
            let wall = self.walls.across[0][side].0;
            let front = self.fronts[side].get(self.hidden[side]);
            let front = front.filter(|_| wall <= self.height);
            front.map_or(f64::INFINITY, |front| front.at + wall)
        };
        of_side(0).min(of_side(1))
    }

    #[inline]
    fn boundary(&self) -> Boundary<'a> {
        let [begun, left] = self.counts;
        let begins = self.fronts[0].get(begun);
        let ends = if left > self.hidden[1] {
            self.fronts[1].get(left - 1)
        } else {
            None
        };
        match (begins, ends) {
            (Some(begins), Some(ends)) if begins.at + ends.at > 2.0 * self.height => {
                Boundary::Ends(ends)
            }
            (Some(begins), _) => Boundary::Begins(begins),
            (None, Some(ends)) => Boundary::Ends(ends),
            (None, None) => Boundary::Wall,
        }
    }

    /// The column up to a boundary.
    #[inline]
    fn column(&mut self, boundary: Boundary<'_>) -> Column {
        let end = match boundary {
            Boundary::Begins(front) => front_line(front.at, false, front.source),
            Boundary::Ends(front) => front_line(front.at, true, front.source),
            Boundary::Wall => self.walls.end(0, true, self.height),
        };
        let start = std::mem::replace(&mut self.start, end);
        let v = lines(self.walls, self.height, caps(self.fronts, self.counts));
        Column { u: [start, end], v }
    }

    #[inline]
    fn pass(&mut self, boundary: Boundary<'_>) {
        match boundary {
            Boundary::Begins(_) => self.counts[0] += 1,
            Boundary::Ends(_) => self.counts[1] -= 1,
            Boundary::Wall => {}
        }
    }
}

fn covers_at_once<V: SweepVisitor>(_: &V, quadrant: &Quadrant) -> bool {
    V::WANTS_COVERED && quadrant.is_ahead
}

/// How many fronts have reached the other end of the section, a wall at this distance or the cone's side.
#[inline]
fn hidden(fronts: &[Front], wall: f64, height: f64) -> usize {
    let is_hidden = |front: &&Front| front.at <= 0.0 || wall <= height && front.at + wall <= height;
    fronts.iter().take_while(is_hidden).count()
}

/// The nearer caps of the first fronts from the right and from the left, so many of each.
#[inline]
fn caps(fronts: [&[Front]; 2], counts: [usize; 2]) -> [Cap; 2] {
    let of = |side: usize| match counts[side].checked_sub(1) {
        Some(last) => fronts[side][last].caps,
        None => [NO_CAP; 2],
    };
    let (right, left) = (of(0), of(1));
    [0, 1].map(|end| {
        if left[end].at < right[end].at {
            left[end]
        } else {
            right[end]
        }
    })
}

/// The low and the high line along v that caps leave.
#[inline]
fn lines(walls: &ConeWalls, height: f64, caps: [Cap; 2]) -> [Line; 2] {
    [0, 1].map(|end| {
        let Cap { at, source } = caps[end];
        if at < f64::INFINITY {
            front_line(at, end == 0, source)
        } else {
            walls.end(1, end == 1, height)
        }
    })
}
