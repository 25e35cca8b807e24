//! Chebyshev Lloyd relaxation: point sets whose Voronoi cells become near-cubic.
//!
//! The method is the L2∣∞ Lloyd relaxation of Bukenberger & Lensch, *Tetrahedra of Varying
//! Density and their Applications* \[BL\]: build the L2 Voronoi cell of every site clipped to
//! the domain, integrate the Chebyshev distance d∞ over it exactly, move the site to the
//! minimizer of that energy (its *center*), repeat.
//!
//! # The house
//!
//! ```text
//! floor 8   main.rs                             the program: one call of the command line
//! floor 7   cli/                                one file per subcommand (feature `cli`)
//! floor 6   scene/        export/      plot/    what comes in, what goes out
//! floor 5   relax/                              the loops and their records
//! floor 4   voronoi/      energy/               where a cell comes from │ what a cell is worth
//! floor 3   domain/                    mass/    which pieces overlap a cell │ mass properties
//! floor 2   mesh/         integrals/            meshes read from files │ closed forms
//! floor 1   geometry/     minimize/             half-spaces, polyhedra, clip │ projected Newton
//! ```
//!
//! Data goes up once: scene → diagram → fragments → energy → new sites → record → files. A
//! module imports only from the floors below it, and only what `tests/architecture.rs` lists.
//! Two wings stand on one ground: `voronoi` builds cells, `energy` says what they are worth
//! (it takes a center and convex pieces and never sees a diagram), `relax` is where they meet.
//!
//! # Conventions
//!
//! Lengths are in the unit of the input (L), volumes in L³ (L² in the plane), energies of order
//! p in L^(3+p). Positions are `nalgebra::Point`, displacements are vectors, all in `f64`.
//! Site indices count from zero. The library never prints and never panics on bad input; long
//! work reports to an observer.

#![cfg_attr(
    not(feature = "cli"),
    allow(dead_code, reason = "parts that only files, scenes or the command use")
)]

pub mod integrals;
pub mod mass;
pub mod mesh;

#[cfg(feature = "files")]
pub mod export;
#[cfg(feature = "scene")]
pub mod scene;

#[cfg(feature = "cli")]
mod cli;
mod domain;
mod energy;
mod geometry;
mod minimize;
#[cfg(feature = "cli")]
mod plot;
mod relax;
mod voronoi;

#[cfg(test)]
mod tests;

pub use crate::domain::convex::ConvexPolyhedron;
pub use crate::domain::cuboid::Cuboid;
pub use crate::domain::domain::{Domain, WeightedDomain};
pub use crate::domain::error::DomainError;
pub use crate::domain::facet_kind::FacetKind;
pub use crate::domain::shape::DomainShape;
pub use crate::domain::tet_mesh::TetSolid;
pub use crate::domain::tri_surface::solid::SurfaceSolid;
pub use crate::geometry::bounds::Bounds;
pub use crate::geometry::half_space::HalfSpace;
pub use crate::geometry::moments::Moments;
pub use crate::integrals::polynomial::Polynomial;
pub use crate::relax::driver::RunEnd;
pub use crate::relax::frames::Frames;
pub use crate::relax::metrics::Metrics;
pub use crate::relax::record::Record;
pub use crate::relax::relaxation::{
    Checkpoint, Method, Outcome, RelaxError, Relaxation, random_sites,
};
pub use crate::relax::relaxation_space::Norm;
pub use crate::voronoi::cell::{Cell, CellFacet};
pub use crate::voronoi::check::CheckError;
pub use crate::voronoi::diagram::{Diagram, DiagramError};

#[cfg(feature = "cli")]
pub use crate::cli::command::command_line;

/// The README's code compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
