//! Heights of beads: as the slicer marks them, else by differences of z.
//!
//! The layer height in a file's header is not used: it may be wrong, and layers may vary.

/// Nozzle heights closer than this (mm) are one layer: files round to 0.001 mm.
const SAME: f64 = 1e-4;

/// Layers kept, from which objects printed one after the other find the one below.
const KEPT: usize = 4096;

/// Where the layer being printed lies, and how high it is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Layers {
    /// Whether the file marks where layers begin.
    marked: bool,
    /// The height that the slicer says (mm).
    said: Option<f64>,
    /// The nozzle's z in the layers so far, ascending: those that lie under the present one.
    below: Vec<f64>,
    z: f64,
    height: f64,
    /// The next bead is the first of its layer.
    begins: bool,
}

impl Layers {
    /// For a file that marks where layers begin, or for one that does not.
    pub(crate) fn new(marked: bool) -> Self {
        Self {
            marked,
            begins: true,
            ..Self::default()
        }
    }

    /// The slicer says the height of beads from here on (mm).
    pub(crate) fn say(&mut self, height: f64) {
        self.said = Some(height);
    }

    /// A layer begins.
    pub(crate) fn begin(&mut self) {
        self.begins = true;
    }

    /// The part begins: what lies on the bed so far is no layer of it.
    pub(crate) fn clear(&mut self) {
        self.below.clear();
        self.begins = true;
    }

    /// The height (mm) of a bead that ends at the nozzle's height `z`.
    pub(crate) fn height(&mut self, z: f64) -> f64 {
        if let Some(height) = self.said {
            return height;
        }
        let another = !self.marked && (z - self.z).abs() > SAME;
        if self.begins || another {
            self.settle(z);
        }
        self.height
    }

    /// A layer at `z` stands on the highest one below it, or on the bed at z = 0.
    fn settle(&mut self, z: f64) {
        while self.below.last().is_some_and(|&below| below > z - SAME) {
            self.below.pop();
        }
        self.height = (z - self.below.last().copied().unwrap_or(0.0)).max(0.0);
        if self.below.len() == KEPT {
            self.below.drain(..KEPT / 2);
        }
        self.below.push(z);
        self.z = z;
        self.begins = false;
    }
}
