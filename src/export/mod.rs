//! What a run leaves behind: sites, cells and run descriptions as files.

pub mod log;
pub mod run;
pub mod sites;
mod spool;
pub mod vtu;
pub mod whole_file;
