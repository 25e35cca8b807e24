//! Values that replace keys of a scene, written into its JSON before that is read again.
//!
//! So the scene's types alone state which keys there are, and a value that fits none of them is
//! refused by the reader that refuses it in a file.

use std::path::Path;

use serde_json::{Map, Value, json};

use crate::scene::description::Scene;
use crate::scene::error::{Error, UnknownKey, unknown_key};
use crate::scene::method::SceneMethod;

/// Keys of a scene with the values that replace those in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Keys of the scene itself. A name alone as `method` means that method with its defaults,
    /// unless the scene has it already.
    pub scene: Map<String, Value>,
    /// Keys of `sites`, of whatever kind these are.
    pub sites: Map<String, Value>,
    /// Keys of the method, whichever it is.
    pub method: Map<String, Value>,
    /// Keys of `output`.
    pub output: Map<String, Value>,
    /// Keys of a domain that is a mesh.
    pub domain: Map<String, Value>,
}

impl Overrides {
    /// Takes the sites from a file; its path is relative to the working folder.
    ///
    /// # Errors
    /// [`Error::Read`] for a file that is not there.
    pub fn set_site_file(&mut self, path: &Path) -> Result<(), Error> {
        let file = path.canonicalize().map_err(|source| Error::Read {
            path: path.to_owned(),
            source,
        })?;
        self.scene
            .insert("sites".to_owned(), json!({ "file": file }));
        Ok(())
    }

    /// Takes the method that makes cubes of the cells, in the plane squares.
    pub fn set_cubes(&mut self) {
        let method = json!(SceneMethod::cubes());
        self.scene.insert("method".to_owned(), method);
    }

    /// Takes the method that keeps the rows of a lattice and fits them to the walls.
    pub fn set_mesh(&mut self) {
        let method = json!(SceneMethod::mesh());
        self.scene.insert("method".to_owned(), method);
    }

    /// Changes `scene`.
    ///
    /// # Errors
    /// [`Error::Override`] for a key that the scene does not have there, or a value that is none.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        let mut value = match serde_json::to_value(&*scene) {
            Ok(Value::Object(value)) => value,
            _ => return Err(Error::value("scene", "a path in it is not text (UTF-8)")),
        };
        for (key, replacement) in &self.scene {
            match replacement {
                Value::String(name) if key == "method" => choose_method(&mut value, name),
                _ => drop(value.insert(key.clone(), replacement.clone())),
            }
        }
        for (part, keys) in [("sites", &self.sites), ("method", &self.method)] {
            let Some(first) = keys.keys().next() else {
                continue;
            };
            let options = value.get_mut(part).and_then(options_within);
            let options = options.ok_or_else(|| {
                refused(first, "the scene's sites are given and have no such key")
            })?;
            options.extend(keys.clone());
        }
        for (part, keys) in [("output", &self.output), ("domain", &self.domain)] {
            if let Some(options) = value.get_mut(part).and_then(Value::as_object_mut) {
                options.extend(keys.clone());
            }
        }
        *scene =
            serde_json::from_value(Value::Object(value)).map_err(|error| self.explain(&error))?;
        scene.fill_defaults();
        Ok(())
    }

    /// The refusal of the override at which the reader has stopped.
    fn explain(&self, error: &serde_json::Error) -> Error {
        let message = error.to_string();
        let mut all = self.maps().into_iter().flatten();
        let Some(UnknownKey {
            key,
            nearest,
            known,
        }) = unknown_key(&message)
        else {
            let keys: Vec<&str> = all.map(|(key, _)| key.as_str()).collect();
            return refused(&keys.join(", "), message);
        };
        let is_unknown = |(name, value): &(&String, &Value)| **name == key || **value == key;
        let option = all.find(is_unknown).map_or(&key, |(name, _)| name);
        let message = format!("unknown key `{key}`; did you mean `{nearest}`? Known here: {known}");
        refused(option, message)
    }

    fn maps(&self) -> [&Map<String, Value>; 5] {
        [
            &self.scene,
            &self.sites,
            &self.method,
            &self.output,
            &self.domain,
        ]
    }
}

/// The options of a method or of sites: the object that is the value of the only key.
fn options_within(part: &mut Value) -> Option<&mut Map<String, Value>> {
    part.as_object_mut()?.values_mut().next()?.as_object_mut()
}

fn choose_method(scene: &mut Map<String, Value>, name: &str) {
    let key = name.replace('-', "_");
    if scene
        .get("method")
        .is_none_or(|method| method.get(&key).is_none())
    {
        scene.insert("method".to_owned(), json!({ key: {} }));
    }
}

fn refused(key: &str, message: impl Into<String>) -> Error {
    Error::Override {
        option: format!("--{}", key.replace('_', "-")),
        message: message.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::relax::relaxation_space::Norm;
    use crate::scene::sites::Sites;

    fn keys(value: Value) -> Map<String, Value> {
        serde_json::from_value(value).expect("an object")
    }

    fn of_method(name: &str, options: Value) -> Overrides {
        Overrides {
            scene: keys(json!({ "method": name })),
            method: keys(options),
            ..Overrides::default()
        }
    }

    #[test]
    fn every_override_lands_where_it_belongs() {
        let mut scene = Scene::embedded();
        let overrides = Overrides {
            scene: keys(json!({ "norm": "l2", "method": "lloyd", "drop_outside": true })),
            sites: keys(json!({ "count": 7, "seed": 9 })),
            method: keys(json!({ "iterations": 3, "tolerance": 0.25 })),
            ..Overrides::default()
        };
        overrides.apply(&mut scene).expect("they fit");
        let text = serde_json::to_value(&scene).expect("a scene is JSON");
        assert_eq!(text["sites"]["random"], json!({ "count": 7, "seed": 9 }));
        assert_eq!(scene.norm, Norm::L2);
        assert!(scene.drop_outside);
        assert_eq!(text["method"]["lloyd"]["iterations"], 3);
        assert_eq!(text["method"]["lloyd"]["tolerance"], 0.25);
    }

    #[test]
    fn methods_are_chosen_by_name_and_keep_what_the_scene_says() {
        let mut scene = Scene::embedded();
        let options = json!({
            "warm_up": 2, "memory": 5, "gradient_tolerance": 1e-3, "rounds": 7, "noise": 0.25,
        });
        let overrides = of_method("anneal", options);
        overrides.apply(&mut scene).expect("annealing has them all");
        let SceneMethod::Anneal(keys) = &scene.method else {
            panic!("the method is the one named")
        };
        assert_eq!((keys.warm_up, keys.memory, keys.rounds), (2, Some(5), 7));
        assert!((keys.gradient_tolerance - 1e-3).abs() < 1e-18);
        assert!((keys.noise - 0.25).abs() < 1e-18);
        let before = scene.clone();
        of_method("anneal", json!({}))
            .apply(&mut scene)
            .expect("nothing to do");
        assert_eq!(scene, before);
        of_method("quasi-newton", json!({}))
            .apply(&mut scene)
            .expect("a method");
        assert!(matches!(scene.method, SceneMethod::QuasiNewton(_)));
    }

    #[test]
    fn given_sites_can_be_neither_counted_nor_seeded() {
        let mut scene = Scene::embedded();
        scene.sites = Sites::List(vec![vec![0.5; 3]]);
        for (key, option) in [("count", "--count"), ("seed", "--seed")] {
            let overrides = Overrides {
                sites: keys(json!({ key: 2 })),
                ..Overrides::default()
            };
            let error = overrides.apply(&mut scene).unwrap_err().to_string();
            assert!(
                error.starts_with(&format!("{option} does not fit")),
                "{error}"
            );
        }
    }

    #[test]
    fn options_of_other_methods_are_refused_by_name() {
        for (method, key, option) in [
            ("quasi-newton", "accelerate", "--accelerate"),
            ("anneal", "accelerate", "--accelerate"),
            ("quasi-newton", "rounds", "--rounds"),
            ("lloyd", "rounds", "--rounds"),
            ("lloyd", "gradient_tolerance", "--gradient-tolerance"),
        ] {
            let overrides = of_method(method, json!({ key: 3 }));
            let error = overrides
                .apply(&mut Scene::embedded())
                .unwrap_err()
                .to_string();
            assert!(
                error.starts_with(&format!("{option} does not fit")),
                "{error}"
            );
            assert!(
                error.contains("Known here: iterations, tolerance"),
                "{error}"
            );
        }
        let wrong = of_method("lloyd", json!({ "iterations": -3 }));
        let error = wrong.apply(&mut Scene::embedded()).unwrap_err().to_string();
        assert!(error.contains("-3"), "{error}");
    }
}
