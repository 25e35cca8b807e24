//! Scene text into a scene, or into an error with file, line, column and the nearest known key.

use std::path::Path;

use crate::scene::description::Scene;
use crate::scene::error::{Error, json_error};

/// Reads the scene at `path`: defaults filled in, paths absolute, every number validated.
///
/// # Errors
/// When the file cannot be read, is not a scene ([`Error::Json`], [`Error::UnknownKey`]) or
/// holds a number that makes no sense ([`Error::Value`]).
pub fn scene(path: &Path) -> Result<Scene, Error> {
    let scene = unchecked(path)?;
    scene.validate()?;
    Ok(scene)
}

/// As [`scene()`], without validating the numbers: for a caller with overrides to apply first.
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
    let mut scene: Scene = serde_json::from_str(text)
        .map_err(|error| json_error(&error, path, text, |message| mended(message, text)))?;
    scene.fill_defaults();
    Ok(scene)
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
             Known here: dimension, domain, density, sites, drop_outside, cells, \
             norm, order, method, coarse_to_fine, frames, output"
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
    fn broken_text_is_refused_by_line_and_column() {
        assert!(refusal("{\n\"sites\": [,]}").starts_with("a.json, line 2, column"));
        assert!(refusal("").contains("the file is empty"));
        assert!(refusal("{}").contains("missing field `sites`"));
        let truncated = refusal("{\"sites\": {\"random\": {\"count\": 10");
        assert!(truncated.contains("EOF"), "{truncated}");
        let bare = refusal(r#"{"sites": {"random": {"count": 1}}, "method": "lloyd"}"#);
        assert!(bare.contains("{\"lloyd\": {}}"), "{bare}");
    }
}
