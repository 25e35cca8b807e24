//! Tests of the crate's parts against second opinions: quadrature, rational arithmetic, brute force.

mod acceleration;
mod cell_check;
mod complex;
mod cubes;
mod density;
mod energy;
mod export;
mod fragments;
mod frames;
mod gcode;
mod gcode_rewrite;
mod geometry;
mod integrals;
mod levels;
mod linf;
mod linf_relax;
mod mass;
mod memory;
mod mesh;
mod minimize;
#[path = "../../tests/common/models.rs"]
mod models;
mod objective;
mod pictures;
mod plane;
mod plane_methods;
mod plot;
mod properties;
pub(crate) mod quadrature;
mod relax;
mod sites;
mod solids;
mod voronoi;
