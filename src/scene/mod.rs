//! Scenes: a run's description in JSON, the sites it names, and the run itself.
//!
//! A scene is a JSON object ([`description`]) whose larger parts have a file each: [`domain`] with
//! [`mesh_domain`], [`density`], [`sites`], [`method`], [`frames`]; every part validates its own
//! numbers, the scene what they exclude together. [`read`] turns text into a scene or
//! into an [`error`] with file, line, column and the nearest known key; [`overrides`] replace keys.
//! A scene that passed is *resolved*: every default is filled in and every path absolute, so that it
//! can be written into a run's description and read again.
//!
//! [`place`] makes the sites and refuses those that have no diagram: from seeds or
//! from files ([`site_file`], [`npy`], `xyz`), unless `memory` has no room for them. [`run`] carries a
//! scene out; [`bindings`] are its calls for other languages.

pub(crate) mod background;
pub mod bindings;
pub mod density;
pub mod description;
pub mod domain;
pub mod error;
pub(crate) mod field;
pub(crate) mod field_file;
pub(crate) mod field_text;
pub mod frames;
pub(crate) mod memory;
pub mod mesh_domain;
pub mod method;
pub mod npy;
pub(crate) mod number_text;
pub(crate) mod numbers;
pub mod overrides;
pub mod place;
pub mod read;
pub mod run;
pub mod site_file;
pub(crate) mod site_table;
pub mod sites;
mod turned_lattice;
pub(crate) mod xyz;
