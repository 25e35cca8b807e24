//! Files of a run: sites, cells, records, checkpoints and descriptions.

#[cfg(feature = "scene")]
pub mod log;
#[cfg(feature = "scene")]
pub mod run;
pub mod sites;
mod spool;
pub mod vtu;
pub mod whole_file;
