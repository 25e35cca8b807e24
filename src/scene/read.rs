//! Scene text into a scene, or into an error with file, line, column and the nearest known key.

use std::path::Path;

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::mesh::formats;
use crate::mesh::formats::mesh::Mesh;
use crate::mesh::formats::read::LoadError;
use crate::scene::description::Scene;
use crate::scene::domain::SceneDomain;
use crate::scene::error::{Error, json_error};
use crate::scene::mesh_domain::MeshDomain;
use crate::scene::sites::Sites;

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
    Ok(noted(path)?.0)
}

/// As [`unchecked`], with what there is to say about the file. A run's directory, or its `run.json`, is
/// the scene of the run: of a directory with the sites that the run has left. A mesh is the domain of
/// random sites.
pub(crate) fn noted(path: &Path) -> Result<(Scene, Vec<String>), Error> {
    if path.is_dir() {
        return of_run(path);
    }
    if !is_json(path) {
        return Ok((of_mesh(path)?, Vec::new()));
    }
    let (text, scene) = anchored(path)?;
    let is_run = serde_json::from_str::<RunText>(&text).is_ok();
    let note = || format!("{} is a run; its scene is taken", path.display());
    Ok((scene, is_run.then(note).into_iter().collect()))
}

/// The scene of the run in a directory, with the sites that it has left, if it has.
fn of_run(path: &Path) -> Result<(Scene, Vec<String>), Error> {
    let run = path.join("run.json");
    if !run.is_file() {
        let message = "is a directory without run.json, so it holds no run; name a scene, a mesh or what \
                       `relax --out` left";
        let (path, message) = (path.to_owned(), message.to_owned());
        return Err(Error::File { path, message });
    }
    let (_, mut scene) = anchored(&run)?;
    let sites = path.join("sites.csv");
    let which = if sites.is_file() {
        scene.sites = Sites::File(sites.canonicalize().map_err(Error::reading(&sites))?);
        (scene.sites_format, scene.drop_outside) = (None, false);
        "the sites that it left in sites.csv"
    } else {
        "the sites that it began with: it has left none yet"
    };
    let path = path.display();
    let note = format!("{path} is a run; its scene is taken with {which}");
    Ok((scene, vec![note]))
}

/// The solid of a mesh file as the domain of the embedded scene's random sites.
fn of_mesh(path: &Path) -> Result<Scene, Error> {
    let mesh = formats::read::read(path).map_err(LoadError::from)?;
    let file = path.canonicalize().map_err(Error::reading(path))?;
    let domain = MeshDomain {
        file,
        scale_to: None,
        weld: None,
    };
    let domain = match mesh {
        Mesh::Surface(_) => SceneDomain::Surface(domain),
        Mesh::Tets(_) => SceneDomain::Tets(domain),
    };
    Ok(Scene {
        domain,
        ..Scene::embedded()
    })
}

/// Whether a file is called or begins like JSON, or is not there: then the reader of scenes says so.
fn is_json(path: &Path) -> bool {
    let has_name = path
        .extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let bytes = if has_name {
        None
    } else {
        std::fs::read(path).ok()
    };
    bytes.is_none_or(|bytes| {
        let start = bytes.trim_ascii_start();
        start.is_empty()
            || start.starts_with(b"{") && !start.windows(7).take(4096).any(|w| w == b"\"asset\"")
    })
}

/// The keys that tell a `run.json` from a scene.
#[derive(Deserialize)]
#[allow(dead_code, reason = "their presence is what counts")]
struct RunText {
    program: String,
    version: String,
    scene: IgnoredAny,
}

/// A `run.json`, its scene checked.
#[derive(Deserialize)]
struct RunScene {
    scene: Scene,
}

/// The text of a scene or a run, and its scene with absolute paths.
fn anchored(path: &Path) -> Result<(String, Scene), Error> {
    let read = |source| Error::Read {
        path: path.to_owned(),
        source,
    };
    let text = std::fs::read_to_string(path).map_err(read)?;
    let mut scene = parse(&text, path)?;
    let folder = path.parent().unwrap_or(Path::new("")).join(".");
    scene.anchor(&folder.canonicalize().map_err(read)?);
    Ok((text, scene))
}

/// Parses a scene's `text`; `path` is for messages only. Defaults are filled in, relative paths
/// stay as they are.
///
/// # Errors
/// [`Error::Json`] or [`Error::UnknownKey`].
pub fn parse(text: &str, path: &Path) -> Result<Scene, Error> {
    let parsed = match serde_json::from_str::<RunText>(text) {
        Ok(_) => serde_json::from_str::<RunScene>(text).map(|run| run.scene),
        Err(_) => serde_json::from_str(text),
    };
    let mut scene =
        parsed.map_err(|error| json_error(&error, path, text, |message| mended(message, text)))?;
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
             Known here: $schema, dimension, domain, density, sites, sites_format, \
             drop_outside, cells, norm, order, method, coarse_to_fine, frames, output"
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
