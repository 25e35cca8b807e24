//! A run's directory: log, checkpoint and description, and the resumption of interrupted runs.
//!
//! [`directory`] takes the directory for one process at a time and refuses to overwrite a run.
//! [`log`] appends a record per iteration. [`checkpoint`] keeps the sites and the record of some
//! iteration, from which everything later follows again bit by bit, with a [`checksum`]: a resumed run
//! drops the records after its checkpoint and recomputes them. [`directory::Description`] is `run.json`.
//!
//! The order of writing makes every moment safe to be killed in: the record of iteration k is in
//! the log, synced, before the checkpoint of k replaces an older one.

pub mod checkpoint;
pub mod checksum;
pub mod directory;
pub mod error;
pub mod log;
