//! A first look through a whole file, for what decides how it is read: settings, which slicers write
//! at the end, and the kinds of marks there are.

use std::io::Read;

use crate::gcode::comments::{Mark, ObjectMark, foreign_mark, mark};
use crate::gcode::error::GcodeError;
use crate::gcode::lines::Lines;
use crate::gcode::settings::Settings;
use crate::gcode::words::{Content, Words, content};

/// So many numbers of E under G91, and this share of them above the one before, tell absolute E:
/// relative ones rise about every other time.
const RISING: (u32, f64) = (8, 0.75);

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
    /// Whether E is absolute under G91.
    pub(crate) absolute_e: bool,
}

/// Numbers of E under G91 where neither M82 nor M83 came after it. Marlin and Klipper read them as
/// relative, RepRapFirmware as M82 or M83 said before: the numbers themselves tell.
#[derive(Debug)]
struct RelativeMoves {
    words: Words,
    relative: bool,
    /// M83.
    relative_e: bool,
    /// M82 or M83 since G91.
    said_e: bool,
    before: f64,
    count: u32,
    rises: u32,
}

impl RelativeMoves {
    fn new() -> Self {
        Self {
            words: Words::new(),
            relative: false,
            relative_e: false,
            said_e: false,
            before: 0.0,
            count: 0,
            rises: 0,
        }
    }

    /// Takes notice of a line that begins with G, M or N; what is wrong with it is told later.
    fn notice(&mut self, text: &[u8]) {
        let is_open = self.relative && !self.said_e && !self.relative_e;
        let is_mode = text.get(1) == Some(&b'9') || !matches!(text[0], b'G' | b'g');
        if !is_open && !is_mode {
            return;
        }
        let Ok(Content::Command(command)) = content(text) else {
            return;
        };
        match (command.letter, command.number, command.fraction) {
            (b'G', 90 | 91, 0) => {
                self.relative = command.number == 91;
                self.said_e = false;
            }
            (b'M', 82 | 83, _) => {
                self.relative_e = command.number == 83;
                self.said_e = true;
            }
            (b'G', 0..=3 | 92, 0) if is_open && self.words.read(text, &command).is_ok() => {
                let Ok(Some(e)) = self.words.number(b'E') else {
                    return;
                };
                if command.number < 4 {
                    self.count += 1;
                    self.rises += u32::from(e > self.before);
                }
                self.before = e;
            }
            _ => {}
        }
    }

    fn tell_absolute(&self) -> bool {
        let (least, share) = RISING;
        self.count >= least && f64::from(self.rises) > share * f64::from(self.count)
    }
}

/// Looks through the whole of `source`.
pub(crate) fn survey(source: impl Read) -> Result<Survey, GcodeError> {
    let mut lines = Lines::new(source);
    let mut survey = Survey::default();
    let mut moves = RelativeMoves::new();
    while let Some(line) = lines.next()? {
        let text = line.text.trim_ascii_start();
        if let Some(b'G' | b'g' | b'M' | b'm' | b'N' | b'n') = text.first() {
            moves.notice(text);
        }
        survey.notice_line(text);
    }
    survey.settings.finish();
    survey.absolute_e = moves.tell_absolute();
    Ok(survey)
}

impl Survey {
    fn notice_line(&mut self, text: &[u8]) {
        match text.first() {
            Some(b';') => {
                self.settings.notice(&text[1..]);
                self.notice(mark(&text[1..]));
            }
            Some(b'E' | b'e') => self.notice(foreign_mark(text)),
            Some(b'M' | b'm') if text[1..].starts_with(b"486") => {
                let object = Mark::Object(ObjectMark::Marlin, None);
                self.notice(Some(object));
            }
            _ => {}
        }
    }
    fn notice(&mut self, mark: Option<Mark>) {
        match mark {
            Some(Mark::Type(_)) => self.types = true,
            Some(Mark::Layer(_)) => self.layers = true,
            Some(Mark::Object(kind, _)) => self.objects = self.objects.max(Some(kind)),
            _ => {}
        }
    }
}
