//! Writers of sites, cells and run directories.

pub mod atomic_write;
pub mod run;
pub mod sites;
pub mod vtu;
