//! A first look through a whole file, for what decides how it is read: settings, which slicers write
//! at the end, and the kinds of marks there are.

use std::io::Read;

use crate::gcode::comments::{Mark, ObjectMark, foreign_mark, mark};
use crate::gcode::error::GcodeError;
use crate::gcode::lines::Lines;
use crate::gcode::settings::Settings;

/// What the file has somewhere.
#[derive(Clone, Debug, Default)]
pub(crate) struct Survey {
    pub(crate) settings: Settings,
    /// Whether feature types are marked.
    pub(crate) types: bool,
    /// Whether layers are marked.
    pub(crate) layers: bool,
    /// The kind of marks for objects that is to be trusted.
    pub(crate) objects: Option<ObjectMark>,
}

/// Looks through the whole of `source`.
pub(crate) fn survey(source: impl Read) -> Result<Survey, GcodeError> {
    let mut lines = Lines::new(source);
    let mut survey = Survey::default();
    while let Some(line) = lines.next()? {
        let text = line.text.trim_ascii_start();
        match text.first() {
            Some(b';') => {
                survey.settings.notice(&text[1..]);
                survey.notice(mark(&text[1..]));
            }
            Some(b'E' | b'e') => survey.notice(foreign_mark(text)),
            Some(b'M' | b'm') if text[1..].starts_with(b"486") => {
                let object = Mark::Object(ObjectMark::Marlin, None);
                survey.notice(Some(object));
            }
            _ => {}
        }
    }
    survey.settings.finish();
    Ok(survey)
}

impl Survey {
    fn notice(&mut self, mark: Option<Mark>) {
        match mark {
            Some(Mark::Type(_)) => self.types = true,
            Some(Mark::Layer(_)) => self.layers = true,
            Some(Mark::Object(kind, _)) => self.objects = self.objects.max(Some(kind)),
            _ => {}
        }
    }
}
