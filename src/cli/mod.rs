//! The command line: one file per subcommand, and what several of them share.

pub(crate) mod bench;
pub(crate) mod bench_sites;
pub(crate) mod cell_files;
pub(crate) mod command;
pub(crate) mod cpu_features;
pub(crate) mod describe;
pub(crate) mod failure;
pub(crate) mod fragments;
pub(crate) mod identity;
pub(crate) mod integrate;
pub(crate) mod integrate_report;
pub(crate) mod interrupt;
pub(crate) mod mass;
pub(crate) mod mass_gcode;
pub(crate) mod mass_notes;
pub(crate) mod mass_report;
pub(crate) mod measure;
pub(crate) mod mesh;
pub(crate) mod mesh_report;
pub(crate) mod options;
pub(crate) mod output;
pub(crate) mod plot;
pub(crate) mod relax;
pub(crate) mod run;
pub(crate) mod stopwatch;
