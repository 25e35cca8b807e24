//! What a run leaves behind: sites, cells and run descriptions as files.

pub mod log;
