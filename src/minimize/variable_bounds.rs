//! Bounds of variables.

/// Bounds `l ≤ x ≤ u`, of every variable or of a few after which they repeat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VariableBounds<'a> {
    /// `l`.
    pub(crate) lower: &'a [f64],
    /// `u`, as many.
    pub(crate) upper: &'a [f64],
}

impl VariableBounds<'_> {
    /// The bounds of all variables, one after the other without end.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (f64, f64)> {
        let pairs = self.lower.iter().copied().zip(self.upper.iter().copied());
        pairs.cycle()
    }

    /// Where a variable that moves along `way` meets a bound.
    pub(crate) fn ahead(&self, variable: usize, way: f64) -> f64 {
        let variable = variable % self.lower.len();
        facing((self.lower[variable], self.upper[variable]), way)
    }
}

/// That of two bounds which a variable that moves along `way` meets.
pub(crate) fn facing((lower, upper): (f64, f64), way: f64) -> f64 {
    if way > 0.0 { upper } else { lower }
}
