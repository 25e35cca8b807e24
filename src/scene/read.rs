//! Scene text into a scene, or into an error with file, line, column and the nearest known key.
//!
//! serde tells unknown keys in its message only ("unknown field `a`, expected one of `b`, `c`");
//! `unknown_key` takes the words out of it again.

use std::path::Path;

use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::validate;

/// Reads the scene at `path`: defaults filled in, paths absolute, every number judged.
///
/// # Errors
/// When the file cannot be read, is not a scene ([`Error::Json`], [`Error::UnknownKey`]) or
/// holds a number that makes no sense ([`Error::Value`]).
pub fn scene(path: &Path) -> Result<Scene, Error> {
    let scene = unchecked(path)?;
    validate::scene(&scene)?;
    Ok(scene)
}

/// As [`scene()`], without judging the numbers: for a caller with overrides to apply first.
///
/// # Errors
/// As [`scene()`], but for [`Error::Value`].
pub fn unchecked(path: &Path) -> Result<Scene, Error> {
    let read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let text = std::fs::read_to_string(path).map_err(read)?;
    let mut scene = parse(&text, path)?;
    let folder = path.parent().unwrap_or(Path::new("")).join(".");
    scene.anchor(&folder.canonicalize().map_err(read)?);
    Ok(scene)
}

/// Parses a scene's `text`; `path` is for messages only. Defaults are filled in, relative paths
/// stay as they are.
///
/// # Errors
/// [`Error::Json`] or [`Error::UnknownKey`].
pub fn parse(text: &str, path: &Path) -> Result<Scene, Error> {
    let mut scene: Scene =
        serde_json::from_str(text).map_err(|error| describe(&error, text, path))?;
    scene.fill_defaults();
    Ok(scene)
}

fn describe(error: &serde_json::Error, text: &str, path: &Path) -> Error {
    let (line, column) = (error.line(), error.column());
    let message = bare_message(error);
    match unknown_key(&message) {
        Some((key, known)) => Error::UnknownKey {
            path: path.to_owned(),
            line,
            column: start_of(&key, text, line, column),
            nearest: nearest(&key, &known),
            known: known.join(", "),
            key,
        },
        None => Error::Json {
            path: path.to_owned(),
            line: line.max(1),
            column: column.max(1),
            message: mended(message, text),
        },
    }
}

/// The message without the position that serde_json appends.
pub(crate) fn bare_message(error: &serde_json::Error) -> String {
    let position = format!(" at line {} column {}", error.line(), error.column());
    let message = error.to_string();
    message
        .strip_suffix(&position)
        .unwrap_or(&message)
        .to_owned()
}

/// The unknown word and the known ones, where the message is about such.
fn unknown_key(message: &str) -> Option<(String, Vec<String>)> {
    let rest = message
        .strip_prefix("unknown field `")
        .or_else(|| message.strip_prefix("unknown variant `"))?;
    let (key, expected) = rest.split_once("`, expected ")?;
    let known = expected.split('`').skip(1).step_by(2);
    Some((key.to_owned(), known.map(str::to_owned).collect()))
}

fn nearest(key: &str, known: &[String]) -> String {
    let distance = |word: &&String| strsim::damerau_levenshtein(key, word);
    known
        .iter()
        .min_by_key(distance)
        .cloned()
        .unwrap_or_default()
}

/// serde_json points at the end of a key; this is its first column where it stands there.
fn start_of(key: &str, text: &str, line: usize, column: usize) -> usize {
    let row = text.lines().nth(line.saturating_sub(1)).unwrap_or("");
    let quoted = format!("\"{key}\"");
    match row.get(..column) {
        Some(before) if before.ends_with(&quoted) => column - quoted.len() + 1,
        _ => column.max(1),
    }
}

/// Adds the mend to messages that need one.
fn mended(message: String, text: &str) -> String {
    if text.trim().is_empty() {
        return "the file is empty; a scene needs at least {\"sites\": …}".to_owned();
    }
    if message.contains("invalid type: unit variant") {
        return format!("{message}; write the name as a key with its object: {{\"lloyd\": {{}}}}");
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refusal(text: &str) -> String {
        parse(text, Path::new("a.json")).unwrap_err().to_string()
    }

    #[test]
    fn an_unknown_key_is_named_with_place_and_nearest_key() {
        let text = "{\n  \"sites\": { \"list\": [[0, 0, 0]] },\n  \"nrm\": \"l2\"\n}";
        assert_eq!(
            refusal(text),
            "a.json, line 3, column 3: unknown key `nrm`; did you mean `norm`? \
             Known here: dimension, domain, density, sites, drop_outside, norm, order, \
             method, coarse_to_fine, frames, output"
        );
    }

    #[test]
    fn unknown_keys_deep_in_a_scene_are_found() {
        let jitter = refusal(r#"{"sites": {"grid": {"counts": [2,2,2], "jiter": 1}}}"#);
        assert!(
            jitter.contains("column 40: unknown key `jiter`; did you mean `jitter`"),
            "{jitter}"
        );
        let iterations = refusal(
            r#"{"sites": {"random": {"count": 1}}, "method": {"lloyd": {"iteration": 5}}}"#,
        );
        assert!(
            iterations.contains("did you mean `iterations`"),
            "{iterations}"
        );
        let method = refusal(r#"{"sites": {"random": {"count": 1}}, "method": {"loyd": {}}}"#);
        assert!(
            method.contains("unknown key `loyd`; did you mean `lloyd`"),
            "{method}"
        );
        let norm = refusal(r#"{"sites": {"random": {"count": 1}}, "norm": "linfty"}"#);
        assert!(norm.contains("did you mean `linf`"), "{norm}");
    }

    #[test]
    fn a_key_with_odd_characters_does_not_confuse_the_place() {
        let odd = refusal("{\"sités`, expected \": 1}");
        assert!(
            odd.contains("line 1, column") && odd.contains("did you mean"),
            "{odd}"
        );
    }

    #[test]
    fn broken_text_is_told_by_line_and_column() {
        assert!(refusal("{\n\"sites\": [,]}").starts_with("a.json, line 2, column"));
        assert!(refusal("").contains("the file is empty"));
        assert!(refusal("{}").contains("missing field `sites`"));
        let truncated = refusal("{\"sites\": {\"random\": {\"count\": 10");
        assert!(truncated.contains("EOF"), "{truncated}");
        let bare = refusal(r#"{"sites": {"random": {"count": 1}}, "method": "lloyd"}"#);
        assert!(bare.contains("{\"lloyd\": {}}"), "{bare}");
    }
}
