//! Writers of sites, cells and run directories.

pub mod atomic_write;
#[cfg(feature = "scene")]
pub mod run;
pub mod sites;
pub mod vtu;
