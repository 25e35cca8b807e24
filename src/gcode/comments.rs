//! Marks that slicers leave in comments and commands: feature types, layers, heights, objects.

/// A mark.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Mark {
    /// The feature type of what follows.
    Type(String),
    /// The height of beads from here on (mm).
    Height(f64),
    /// A layer begins; Cura's number, below zero in a raft.
    Layer(i64),
    /// An object begins, by a kind of mark; `None`: it ends.
    Object(ObjectMark, Option<String>),
    /// Filament is flushed from here on, or no longer.
    Flush(bool),
    /// The slicer's own end of the file.
    End,
}

/// The kinds of marks for objects, the one to be trusted most last: files with several kinds name
/// every object by each of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ObjectMark {
    /// Cura's `;MESH:`.
    Mesh,
    /// PrusaSlicer's, OrcaSlicer's and Bambu Studio's `; printing object`.
    Comment,
    /// Marlin's `M486`.
    Marlin,
    /// Klipper's `EXCLUDE_OBJECT_START`.
    Klipper,
}

/// Names are kept up to this many bytes.
const LONGEST_NAME: usize = 200;

/// Comments that no file has before its end.
const ENDS: [&str; 5] = [
    "End of Gcode",
    "EXECUTABLE_BLOCK_END",
    "CONFIG_BLOCK_END",
    "prusaslicer_config = end",
    "filament used",
];

/// The mark in a comment, given without its semicolon.
pub(crate) fn mark(comment: &[u8]) -> Option<Mark> {
    let comment = comment.trim_ascii();
    let mark = match comment.first()? {
        b'T' | b'F' | b'f' => type_or_flush(comment),
        b'H' => after(comment, "HEIGHT:").and_then(height),
        b'L' => layer(comment),
        b'M' => after(comment, "MESH:").map(mesh),
        b'C' | b'W' => block(comment),
        b's' | b'p' => object(comment),
        _ => None,
    };
    let is_end = || ENDS.iter().any(|end| comment.starts_with(end.as_bytes()));
    mark.or_else(|| is_end().then_some(Mark::End))
}

/// `;TYPE:Perimeter` (PrusaSlicer, OrcaSlicer, Cura), `; FEATURE: Outer wall` (Bambu Studio),
/// `; feature outer perimeter` (Simplify3D); Bambu Studio's flushing.
fn type_or_flush(comment: &[u8]) -> Option<Mark> {
    let starts = ["TYPE:", "FEATURE:", "feature "];
    let name = starts.iter().find_map(|start| after(comment, start));
    match (name, comment) {
        (Some(name), _) => Some(Mark::Type(text(name))),
        (None, b"FLUSH_START") => Some(Mark::Flush(true)),
        (None, b"FLUSH_END") => Some(Mark::Flush(false)),
        _ => None,
    }
}

/// `;LAYER_CHANGE`, `;LAYER:3` (Cura), `; LAYER_HEIGHT: 0.2` (Bambu Studio).
fn layer(comment: &[u8]) -> Option<Mark> {
    if comment == b"LAYER_CHANGE" {
        return Some(Mark::Layer(0));
    }
    if let Some(rest) = after(comment, "LAYER_HEIGHT:") {
        return height(rest);
    }
    number(after(comment, "LAYER:")?).map(Mark::Layer)
}

/// `; CHANGE_LAYER` (Bambu Studio); the blocks of a wipe tower and of a tool change.
fn block(comment: &[u8]) -> Option<Mark> {
    match comment {
        b"CHANGE_LAYER" => Some(Mark::Layer(0)),
        b"CP TOOLCHANGE START" | b"WIPE_TOWER_START" => Some(Mark::Flush(true)),
        b"CP TOOLCHANGE END" | b"WIPE_TOWER_END" => Some(Mark::Flush(false)),
        _ => None,
    }
}

fn height(value: &[u8]) -> Option<Mark> {
    let height = number(value).filter(|height| *height > 0.0 && *height < 100.0)?;
    Some(Mark::Height(height))
}

/// `;MESH:part.stl`, and `;MESH:NONMESH` between meshes.
fn mesh(name: &[u8]) -> Mark {
    let name = (name != b"NONMESH").then(|| text(name));
    Mark::Object(ObjectMark::Mesh, name)
}

/// `; printing object NAME`, `; start printing object, unique label id: 7`, `; stop printing object…`.
fn object(comment: &[u8]) -> Option<Mark> {
    let kind = ObjectMark::Comment;
    if after(comment, "stop printing object").is_some() {
        return Some(Mark::Object(kind, None));
    }
    let starts = ["printing object ", "start printing object, "];
    let name = starts.iter().find_map(|start| after(comment, start))?;
    Some(Mark::Object(kind, Some(text(name))))
}

/// The mark in a line that is no command of G-code: Klipper's `EXCLUDE_OBJECT_START NAME=…`.
pub(crate) fn foreign_mark(line: &[u8]) -> Option<Mark> {
    let mut words = line.splitn(2, |byte| byte.is_ascii_whitespace());
    let name = words.next()?.to_ascii_uppercase();
    let rest = words.next().unwrap_or_default();
    match &name[..] {
        b"EXCLUDE_OBJECT_START" => {
            let name = argument(rest, "NAME")?;
            Some(Mark::Object(ObjectMark::Klipper, Some(name)))
        }
        b"EXCLUDE_OBJECT_END" => Some(Mark::Object(ObjectMark::Klipper, None)),
        b"PRINT_END" | b"END_PRINT" => Some(Mark::End),
        _ => None,
    }
}

/// The value of `key=value` among a macro's arguments, which may be quoted.
pub(crate) fn argument(arguments: &[u8], key: &str) -> Option<String> {
    let line = String::from_utf8_lossy(arguments);
    let at = line.to_ascii_uppercase().find(&format!("{key}="))?;
    let value = &line[at + key.len() + 1..];
    let quote = value
        .chars()
        .next()
        .filter(|sign| matches!(sign, '"' | '\''));
    let value = match quote {
        Some(quote) => value[1..].split(quote).next(),
        None => value.split_whitespace().next(),
    };
    value.map(|value| text(value.as_bytes()))
}

/// What follows `start` in `text`, without blanks around.
pub(crate) fn after<'a>(text: &'a [u8], start: &str) -> Option<&'a [u8]> {
    text.strip_prefix(start.as_bytes()).map(<[u8]>::trim_ascii)
}

/// A number, up to a blank.
fn number<T: std::str::FromStr>(bytes: &[u8]) -> Option<T> {
    let word = bytes.split(u8::is_ascii_whitespace).next()?;
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A name as text, of bounded length.
pub(crate) fn text(bytes: &[u8]) -> String {
    let bytes = bytes.trim_ascii();
    String::from_utf8_lossy(&bytes[..bytes.len().min(LONGEST_NAME)]).into_owned()
}
