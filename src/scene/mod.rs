//! What a run is asked to do: scenes and the sites they name.
//!
//! A scene is a JSON object ([`description`]) whose parts each have a file of their own:
//! [`domain`], [`sites`], [`norm`], [`method`], [`frames`], [`output`]. [`read`] turns text into a
//! scene or into an error that names file, line, column and the nearest known key; [`overrides`]
//! applies what the command line says instead; [`validate`] judges the numbers. A scene that passed
//! is *resolved*: every default is filled in and every path absolute, so that it can be written into
//! a run's description and read again.
//!
//! [`plan`] says what a scene's method means for the loops, [`place`] makes the sites: [`random`]
//! and [`grid`] from seeds, [`site_file`] from disk; [`check`] refuses the ones that have no
//! diagram. Both see the domain only as a [`region`].

pub mod check;
pub mod density;
pub mod description;
pub mod domain;
pub mod domain_keys;
pub mod error;
pub mod frames;
pub mod grid;
pub mod mesh_domain;
pub mod method;
pub mod method_keys;
pub mod method_overrides;
pub mod norm;
pub mod output;
pub mod overrides;
pub mod place;
pub mod plan;
pub mod random;
pub mod read;
pub mod region;
pub mod schema;
pub mod site_file;
pub mod sites;
pub mod validate;
