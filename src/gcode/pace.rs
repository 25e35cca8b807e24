//! Speeds of pieces whose flow changes, and the modal F that other moves rely on.

/// What stays as it was when the flow changes, and the printer's limits.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Pace {
    /// The volume in a second stays, and the speed changes: F ∝ 1/multiplier.
    pub(crate) keep_flow: bool,
    /// mm³/s that the printer melts.
    pub(crate) max_flow: Option<f64>,
    /// mm/s of pieces that become faster.
    pub(crate) max_speed: Option<f64>,
}

/// Multipliers below this do not make a piece any faster.
const LEAST: f64 = 0.05;

impl Pace {
    /// By what the speed (mm/s) of a piece of so much `section` (mm² as sliced) is multiplied.
    pub(crate) fn factor(&self, multiplier: f64, section: f64, speed: f64) -> f64 {
        let mut factor = 1.0;
        if self.keep_flow && multiplier > 0.0 {
            factor = 1.0 / multiplier.max(LEAST);
            if let Some(most) = self.max_speed {
                factor = factor.min((most / speed).max(1.0));
            }
        }
        let flow = multiplier * section * speed * factor;
        match self.max_flow {
            Some(most) if flow > most => factor * most / flow,
            _ => factor,
        }
    }
}

/// F as the file says it, and as the written file does.
#[derive(Clone, Debug, Default)]
pub(crate) struct Feed {
    said: Option<(f64, String)>,
    written: Option<f64>,
}

impl Feed {
    /// The file says F.
    pub(crate) fn say(&mut self, value: f64, text: &str) {
        self.said = Some((value, text.to_owned()));
    }

    /// What the file says.
    pub(crate) fn said(&self) -> Option<f64> {
        self.said.as_ref().map(|(value, _)| *value)
    }

    /// The written file says it too.
    pub(crate) fn keep(&mut self) {
        self.written = self.said();
    }

    /// Whether F must be written to hold.
    pub(crate) fn differs(&self, value: f64) -> bool {
        self.written
            .is_none_or(|written| (written - value).abs() > 0.0)
    }

    pub(crate) fn write(&mut self, value: f64) {
        self.written = Some(value);
    }

    /// The text of the number that must be said again before anything relies on it.
    pub(crate) fn owed(&mut self) -> Option<String> {
        let (value, text) = self.said.as_ref()?;
        if self.written.is_none() || !self.differs(*value) {
            return None;
        }
        self.written = Some(*value);
        Some(text.clone())
    }
}
