//! The reasons why a G-code file is refused, each with its line and the mend.

use thiserror::Error;

/// Why a G-code file cannot be weighed.
#[derive(Debug, Error)]
pub(crate) enum GcodeError {
    /// The file cannot be read.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] std::io::Error),
    /// PrusaSlicer's binary G-code.
    #[error(
        "is binary G-code: switch off 'Supports binary G-code' (binary_gcode) in PrusaSlicer's \
         printer settings, or 'Use binary G-code when the printer supports it' in its preferences, \
         and export again"
    )]
    Binary,
    /// A project or plate of Bambu Studio or OrcaSlicer.
    #[error(
        "is an archive (.gcode.3mf), not plain text: in Bambu Studio or OrcaSlicer export by \
         File > Export > Export G-code, with the printer's 'Use 3MF instead of G-code' (use_3mf) off"
    )]
    Archive,
    /// A line is wrong.
    #[error("line {line}: {fault}")]
    Line {
        /// Its number, from 1.
        line: u64,
        /// What is wrong.
        fault: Fault,
    },
    /// Too many kinds of deposit.
    #[error(
        "line {line}: more than {limit} combinations of feature type, tool and object: these are \
         not a slicer's comments"
    )]
    TooManyKinds {
        /// The line with the first beyond the limit.
        line: u64,
        /// The limit.
        limit: usize,
    },
    /// No plastic at all.
    #[error(
        "deposits nothing: no move pushes filament (E) beyond what was retracted; lines read: {lines}"
    )]
    Nothing {
        /// The number of lines.
        lines: u64,
    },
}

/// What is wrong with a line.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum Fault {
    /// A byte 0.
    #[error(
        "a byte 0 stands in it: this is no text, or text of two bytes a letter (UTF-16); export plain G-code"
    )]
    Nul,
    /// No end in sight.
    #[error("it is longer than {limit} bytes: this is no G-code")]
    Endless {
        /// The most bytes of a line.
        limit: usize,
    },
    /// A byte that no command holds.
    #[error("the byte {byte:#04x} at column {column} belongs in no command: this is no G-code")]
    Byte {
        /// The byte.
        byte: u8,
        /// Its column, from 1.
        column: usize,
    },
    /// A sign where a letter was expected.
    #[error("'{sign}' at column {column} where a letter with a number was expected")]
    Sign {
        /// The sign.
        sign: char,
        /// Its column, from 1.
        column: usize,
    },
    /// A letter alone.
    #[error("{letter} has no number (column {column}): the line may be cut")]
    NoNumber {
        /// The letter.
        letter: char,
        /// Its column, from 1.
        column: usize,
    },
    /// A letter twice.
    #[error("{letter} stands twice, with {first} and {second}: which one is meant is unknown")]
    Twice {
        /// The letter.
        letter: char,
        /// Its first number.
        first: f64,
        /// Its second number.
        second: f64,
    },
    /// A number too large.
    #[error("{letter}{value} is out of reach of any printer (limit {limit:e} mm)")]
    OutOfReach {
        /// The letter.
        letter: char,
        /// Its number.
        value: f64,
        /// The limit.
        limit: f64,
    },
    /// A wrong checksum.
    #[error("its checksum is *{written}, its bytes give *{computed}: the line is damaged")]
    Checksum {
        /// The one written.
        written: u64,
        /// The one of its bytes.
        computed: u8,
    },
    /// The file ends inside the line.
    #[error(
        "the file ends inside this command, without a line end: it is cut; if it is whole, end its last line"
    )]
    Cut,
    /// A command whose motion is not known.
    #[error("{name} is refused: {why}")]
    Unknown {
        /// The command or word.
        name: String,
        /// Why its meaning is unknown.
        why: &'static str,
    },
    /// A moving axis gets a new number.
    #[error(
        "G92 resets the moving axis {axis} from {from} to {to} mm: where the part lies from there \
         on is unknown; only E may be reset"
    )]
    AxisReset {
        /// The axis.
        axis: char,
        /// The position (mm).
        from: f64,
        /// The new number (mm).
        to: f64,
    },
    /// An arc that is none.
    #[error("the arc has no circle: {0}")]
    Arc(ArcFault),
    /// A factor of flow below zero.
    #[error("M221 S{0}: a flow below zero")]
    NegativeFlow(f64),
}

/// Why an arc has no circle.
#[derive(Clone, Debug, Error, PartialEq)]
pub(crate) enum ArcFault {
    /// No center and no radius.
    #[error("neither I nor J nor R is given")]
    NoCenter,
    /// Both.
    #[error("both a center (I, J) and a radius (R) are given")]
    Both,
    /// A full circle by its radius.
    #[error("with R its end must differ from its start")]
    FullByRadius,
    /// A radius too short.
    #[error("R is {radius} mm, half the distance of its ends is {half} mm")]
    Short {
        /// The radius (mm).
        radius: f64,
        /// Half the chord (mm).
        half: f64,
    },
    /// Ends at different distances.
    #[error("its start is {start} mm from the center, its end {end} mm")]
    Uneven {
        /// The start's distance (mm).
        start: f64,
        /// The end's distance (mm).
        end: f64,
    },
    /// A plane other than x, y.
    #[error("it lies in a plane other than x, y (G18 or G19)")]
    Plane,
}
