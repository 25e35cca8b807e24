//! A G-code file line by line: the beads that it deposits, each with its height and its kind (feature
//! type, tool and object). Weighing and rewriting read by it.

use std::collections::HashMap;
use std::io::{ErrorKind, Read, Seek, SeekFrom};

use crate::gcode::bead::Bead;
use crate::gcode::comments::{Mark, ObjectMark, argument, foreign_mark, mark, text};
use crate::gcode::error::{Fault, GcodeError};
use crate::gcode::labels::{FLUSH, Names, RAFT, START_CODE, UNTYPED, is_part};
use crate::gcode::layers::Layers;
use crate::gcode::lines::Line;
use crate::gcode::machine::Machine;
use crate::gcode::settings::{Filament, USUAL_DIAMETER};
use crate::gcode::survey::{Survey, survey};
use crate::gcode::words::{Command, Content, Words, content};

/// Kinds of deposit that are kept apart.
const MOST_KINDS: usize = 100_000;

/// Feature type, tool and object of beads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Kind {
    /// The type's place in [`Reader::types`].
    pub(crate) feature: usize,
    pub(crate) tool: u32,
    /// The object's place in [`Reader::objects`].
    pub(crate) object: Option<usize>,
}

/// A bead that a line deposits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Printed {
    pub(crate) bead: Bead,
    /// mm.
    pub(crate) height: f64,
    /// The place of its kind in [`Reader::kinds`].
    pub(crate) kind: usize,
}

/// Looks through the file `source`, and goes back to its beginning.
pub(crate) fn examine<R: Read + Seek>(source: &mut R) -> Result<Survey, GcodeError> {
    refuse_containers(source)?;
    let survey = survey(&mut *source)?;
    source.seek(SeekFrom::Start(0))?;
    Ok(survey)
}

/// Refuses binary G-code and archives, by their first bytes.
fn refuse_containers(source: &mut (impl Read + Seek)) -> Result<(), GcodeError> {
    let mut first = [0; 4];
    match source.read_exact(&mut first) {
        Err(error) if error.kind() != ErrorKind::UnexpectedEof => return Err(error.into()),
        _ => source.seek(SeekFrom::Start(0))?,
    };
    match &first {
        b"GCDE" => Err(GcodeError::Binary),
        b"PK\x03\x04" => Err(GcodeError::Archive),
        _ => Ok(()),
    }
}

/// The object being printed, as marks name it.
#[derive(Clone, Debug)]
enum Present {
    Named(String),
    /// M486 S.
    Numbered(i64),
}

/// The state of reading.
#[derive(Debug)]
pub(crate) struct Reader {
    survey: Survey,
    machine: Machine,
    layers: Layers,
    pub(crate) types: Names,
    pub(crate) objects: Names,
    /// The type that the file names.
    said: Option<String>,
    flushing: bool,
    raft: bool,
    /// Whether the part has begun.
    begun: bool,
    object: Option<Present>,
    /// M486: names of objects by their numbers.
    numbered: HashMap<i64, String>,
    /// The places of numbered objects that have plastic.
    numbered_places: HashMap<i64, usize>,
    pub(crate) kinds: Vec<Kind>,
    places: HashMap<Kind, usize>,
    /// The kind of beads, until type, tool or object change.
    present: Option<usize>,
    /// Lines of the last bead and of the last mark of an end.
    last_bead: u64,
    last_end: u64,
    /// The first flow other than 1, its tool and line.
    flow: Option<(f64, u32, u64)>,
    /// Tools whose E counted lengths.
    by_length: Vec<u32>,
}

impl Reader {
    /// What is `given` about the filament stands above what the file says.
    pub(crate) fn new(survey: Survey, given: Filament) -> Self {
        let filament = given.or(survey.settings.filament.clone());
        Self {
            machine: Machine::new(filament, survey.settings.volumetric, survey.absolute_e),
            layers: Layers::new(survey.layers),
            survey,
            types: Names::default(),
            objects: Names::default(),
            said: None,
            flushing: false,
            raft: false,
            begun: false,
            object: None,
            numbered: HashMap::new(),
            numbered_places: HashMap::new(),
            kinds: Vec::new(),
            places: HashMap::new(),
            present: None,
            last_bead: 0,
            last_end: 0,
            flow: None,
            by_length: Vec::new(),
        }
    }

    pub(crate) fn machine(&self) -> &Machine {
        &self.machine
    }

    /// Obeys a line; `words` is room for its words. Returns the bead that it deposits.
    pub(crate) fn line(
        &mut self,
        line: &Line<'_>,
        words: &mut Words,
    ) -> Result<Option<Printed>, GcodeError> {
        let refuse = |fault| line.refuse(fault);
        match content(line.text).map_err(refuse)? {
            Content::Blank => {}
            Content::Comment(comment) => {
                if let Some(mark) = mark(comment) {
                    self.mark(mark, line.number);
                }
            }
            Content::Foreign(code) => self.foreign(code, line.number),
            Content::Command(command) => {
                if line.end.is_empty() && moves(&command) {
                    return Err(line.refuse(Fault::Cut));
                }
                self.note_command(&command, line);
                let bead = self
                    .machine
                    .obey(line.text, &command, words)
                    .map_err(refuse)?;
                if let Some(bead) = bead {
                    return self.printed(bead, line.number).map(Some);
                }
            }
        }
        Ok(None)
    }

    /// Commands that say what is printed, or that it ends.
    fn note_command(&mut self, command: &Command, line: &Line<'_>) {
        match (command.letter, command.number) {
            (b'G', _) => {}
            (b'M', 486) => self.numbered_object(command.rest(line.text)),
            // M2 without a line end may be the beginning of M221.
            (b'M', 2 | 18 | 30 | 84) if !line.end.is_empty() => self.last_end = line.number,
            (b'M', 104) if command.rest(line.text).trim_ascii() == b"S0" => {
                self.last_end = line.number;
            }
            (b'T', _) | (b'M', 6 | 108 | 135) => self.present = None,
            _ => {}
        }
    }

    /// Macros that matter: objects, tools and modes of Klipper.
    fn foreign(&mut self, code: &[u8], number: u64) {
        if let Some(mark) = foreign_mark(code) {
            return self.mark(mark, number);
        }
        let name = code
            .split(u8::is_ascii_whitespace)
            .next()
            .unwrap_or_default();
        let is = |known: &str| name.eq_ignore_ascii_case(known.as_bytes());
        let state = || argument(code, "NAME").unwrap_or_default();
        if is("ACTIVATE_EXTRUDER") {
            let extruder = argument(code, "EXTRUDER").unwrap_or_default();
            let digits = extruder.trim_start_matches(|sign: char| !sign.is_ascii_digit());
            self.machine.take(digits.parse().unwrap_or(0));
            self.present = None;
        } else if is("SAVE_GCODE_STATE") {
            self.machine.save(state());
        } else if is("RESTORE_GCODE_STATE") {
            self.machine.restore(&state());
        }
    }

    fn mark(&mut self, mark: Mark, number: u64) {
        match mark {
            Mark::Type(name) => {
                if !self.survey.layers {
                    self.begin();
                }
                self.said = Some(name);
                self.present = None;
            }
            Mark::Height(height) => self.layers.say(height),
            Mark::Layer(layer) => {
                self.begin();
                self.layers.begin();
                self.raft = layer < 0;
                self.flushing = false;
                self.present = None;
            }
            Mark::Object(kind, name) => {
                if self.survey.objects == Some(kind) {
                    self.object = name.map(Present::Named);
                    self.present = None;
                }
            }
            Mark::Flush(flushing) => {
                self.flushing = flushing;
                self.present = None;
            }
            Mark::End => self.last_end = number,
        }
    }

    /// The part begins, with its first layer or first type.
    fn begin(&mut self) {
        if !self.begun {
            self.begun = true;
            self.layers.clear();
        }
    }

    /// M486: `S3` begins object 3, `S-1` ends it, `Aname` names it.
    fn numbered_object(&mut self, rest: &[u8]) {
        if self.survey.objects != Some(ObjectMark::Marlin) {
            return;
        }
        let rest = String::from_utf8_lossy(rest);
        for (at, _) in rest.match_indices(['S', 's', 'A', 'a']) {
            let before = rest[..at].chars().next_back();
            if before.is_some_and(|sign| !sign.is_whitespace()) {
                continue;
            }
            let value = &rest[at + 1..];
            if rest[at..].starts_with(['A', 'a']) {
                let name = value.trim().trim_matches(['"', '\'']);
                self.name_numbered(&text(name.as_bytes()));
                break;
            }
            let digits = value.split_whitespace().next().unwrap_or_default();
            self.begin_numbered(digits.parse().unwrap_or(-1));
        }
    }

    fn begin_numbered(&mut self, number: i64) {
        self.present = None;
        self.object = (number >= 0).then_some(Present::Numbered(number));
    }

    fn name_numbered(&mut self, name: &str) {
        if let Some(Present::Numbered(number)) = self.object
            && self.numbered.len() < MOST_KINDS
        {
            self.numbered.insert(number, name.to_owned());
        }
    }

    /// The place of the present object; objects of one name keep apart by their numbers.
    fn object_place(&mut self) -> Option<usize> {
        match self.object.as_ref()? {
            Present::Named(name) => Some(self.objects.place(name)),
            Present::Numbered(number) => {
                if let Some(&place) = self.numbered_places.get(number) {
                    return Some(place);
                }
                let name = match self.numbered.get(number) {
                    Some(name) if !self.objects.list().contains(name) => name.clone(),
                    Some(name) => format!("{name} (S{number})"),
                    None => number.to_string(),
                };
                let place = self.objects.place(&name);
                self.numbered_places.insert(*number, place);
                Some(place)
            }
        }
    }

    fn printed(&mut self, bead: Bead, number: u64) -> Result<Printed, GcodeError> {
        let height = self.layers.height(bead.path.last_z());
        let kind = match self.present {
            Some(place) => place,
            None => self.place(number)?,
        };
        self.last_bead = number;
        let flow = self.machine.flow();
        if self.flow.is_none() && (flow - 1.0).abs() > f64::EPSILON {
            self.flow = Some((flow, self.machine.tool(), number));
        }
        Ok(Printed { bead, height, kind })
    }

    /// The place of the present type, tool and object.
    fn place(&mut self, line: u64) -> Result<usize, GcodeError> {
        let feature = self.types.place(label(
            self.said.as_deref(),
            self.flushing,
            self.raft,
            self.begun || !(self.survey.layers || self.survey.types),
        ));
        let tool = self.machine.tool();
        if !self.machine.is_volumetric() && !self.by_length.contains(&tool) {
            self.by_length.push(tool);
        }
        let kind = Kind {
            feature,
            tool,
            object: self.object_place(),
        };
        let next = self.kinds.len();
        let place = *self.places.entry(kind).or_insert(next);
        if place == next {
            if next == MOST_KINDS {
                let limit = MOST_KINDS;
                return Err(GcodeError::TooManyKinds { line, limit });
            }
            self.kinds.push(kind);
        }
        self.present = Some(place);
        Ok(place)
    }

    /// What the file's user should know.
    pub(crate) fn notes(&self) -> Vec<String> {
        let filament = self.machine.filament();
        let mut notes = Vec::new();
        let unsaid = |tool: &&u32| filament.diameters.get(**tool).is_none();
        for tool in self.by_length.iter().filter(unsaid) {
            notes.push(format!(
                "the file does not say the filament's diameter of tool {tool}: {USUAL_DIAMETER} mm is \
                 taken; --filament gives another"
            ));
        }
        if let Some((flow, tool, line)) = self.flow {
            let percent = (flow * 1e8).round() / 1e6;
            notes.push(format!(
                "M221 sets the flow of tool {tool} to {percent} % (line {line}): so much is weighed"
            ));
        }
        if self.survey.absolute_e {
            notes.push(
                "E is read as absolute under G91, for its numbers rise; Marlin and Klipper would read \
                 it as relative unless M82 follows G91"
                    .into(),
            );
        }
        if !self.survey.types {
            notes.push(
                "the file marks no feature types: nothing can be left out as skirt or support"
                    .into(),
            );
        }
        if self.last_end < self.last_bead {
            notes.push(format!(
                "no end marker follows the last bead (line {}): the file may be cut",
                self.last_bead
            ));
        }
        notes
    }
}

/// The name of the type of a bead: the file's own unless nothing is said, or it is flushed or part
/// of a raft under the name of a part's feature.
fn label(said: Option<&str>, flushing: bool, raft: bool, begun: bool) -> &str {
    match said {
        Some(name) if !is_part(name) => name,
        _ if flushing => FLUSH,
        _ if raft => RAFT,
        Some(name) => name,
        None if begun => UNTYPED,
        None => START_CODE,
    }
}

/// Whether a command moves the nozzle or sets a register.
fn moves(command: &Command) -> bool {
    command.letter == b'G' && matches!(command.number, 0..=3 | 92)
}
