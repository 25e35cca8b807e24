//! The program `chebloyd`: output, files, refusals. One binary, which takes a tenth of the time that one for
//! each file takes to build.

#[path = "../common/models.rs"]
mod models;

mod bad_input;
mod browser;
mod comfort;
mod command_line;
mod dialects;
mod fragments;
mod frames;
mod gcode;
mod integrate;
mod linf;
mod mass;
mod mass_parts;
mod mesh;
mod outputs;
mod plane;
mod print;
mod readme;
mod report;
mod resume;
mod scenes;
mod site_files;
mod solids;
mod spin;
mod stand;
mod test_dir;
mod touching_parts;
