//! The command line: one file per subcommand, thin.

pub(crate) mod arguments;
pub(crate) mod bench;
pub(crate) mod cell_files;
pub(crate) mod command;
pub(crate) mod completions;
pub(crate) mod crowd;
pub(crate) mod failure;
pub(crate) mod fragments;
pub(crate) mod ground;
pub(crate) mod ground_plane;
pub(crate) mod ground_space;
pub(crate) mod interrupt;
pub(crate) mod job;
pub(crate) mod man;
pub(crate) mod mass;
pub(crate) mod measure;
pub(crate) mod method_options;
pub(crate) mod plot;
pub(crate) mod progress;
mod question;
pub(crate) mod relax;
pub(crate) mod resident;
pub(crate) mod scene_options;
pub(crate) mod schema;
pub(crate) mod stdout;
pub(crate) mod summary;
pub(crate) mod watch;
