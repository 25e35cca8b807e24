//! The sweep of a cone from its site outward: the rectangles of its sections, and where they change.
//!
//! At the height h the cone's section is the square \[−h, h\]² of coordinates across it. From its start on,
//! at half its distance along the cone at least, a neighbor at (D, a, b) is nearer where y_u ≥ a − h if
//! a > 0, y_u ≤ h + a if a < 0, and the same with b: a quadrant of one of the square's corners that moves
//! with speed 1 along both axes. What is left of the section is bounded, along u, by the fronts of quadrants
//! from either side; between two fronts it is one [`Column`], bounded along v by the farthest quadrant of
//! either end. All that changes, changes at a height that is a coordinate, a half or a sum of two: there the
//! columns are laid anew, and decided by the same expression, so that nothing is left to rounding.

use crate::arrays::MapEach;
use crate::voronoi::linf::block::{Block, Column, Lasting};
use crate::voronoi::linf::columns::{Boundary, Cap, ColumnWalk, Front, NO_CAP};
use crate::voronoi::linf::quadrant::{ConeWalls, Quadrant};

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
        let [from_left, from_below] = quadrant.is_low.map_each(usize::from);
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

fn covers_at_once<V: SweepVisitor>(_: &V, quadrant: &Quadrant) -> bool {
    V::WANTS_COVERED && quadrant.is_ahead
}
