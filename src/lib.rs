//! Chebyshev Lloyd relaxation: point sets whose Voronoi cells become near-cubic.
//!
//! The method is the L2∣∞ Lloyd relaxation of Bukenberger & Lensch \[BL\]: build the L2 Voronoi cell
//! of every site clipped to the domain, integrate the Chebyshev distance d∞ over it exactly, move the
//! site to the minimizer of that energy (its *center*), repeat.
//!
//! ```
//! use chebloyd::{Cuboid, Method, Relaxation, random_sites};
//!
//! let cube = Cuboid::unit();
//! let mut sites = random_sites(&cube, 100, 1)?;
//! let relaxation = Relaxation::new(cube).method(Method::quasi_newton(20));
//! let outcome = relaxation.run(&mut sites)?;
//! assert!(outcome.records[20].energy_percent < outcome.records[0].energy_percent);
//! assert!((relaxation.measure(&sites)?.volume_sum - 1.0).abs() < 1e-12);
//! # Ok::<(), chebloyd::RelaxError>(())
//! ```
//!
//! The root holds what most callers need: [`Relaxation`] and its [`Method`]s, domains, [`Diagram`] for
//! cells alone. [`mass`] weighs solids, [`integrals`] are the closed forms below, [`mesh`] validates
//! surfaces and tetrahedra. With the feature `files` meshes and sites are read and written, with `scene`
//! a whole run is one call (`scene::run::run`), with `cli` there is the command.
//!
//! # Layout
//!
//! ```text
//! floor 8   main.rs                             the program: one call of the command line
//! floor 7   cli/                                one file per subcommand (feature `cli`)
//! floor 6   scene/    export/   plot/  report/  input, files, pictures, pages (`scene`, `files`, `cli`)
//! floor 5   relax/        complex/  balance/    driver and moves │ cells as one mesh │ densities to measure
//! floor 4   voronoi/      energy/               cells of sites │ energies of cells
//! floor 3   domain/        gcode/      mass/    pieces of cells in solids │ prints │ mass properties
//! floor 2   mesh/         integrals/            surfaces and tetrahedra │ closed forms
//! floor 1   geometry/     minimize/             polyhedra and clipping │ Newton, L-BFGS-B
//! ```
//!
//! A file imports from floors below its own and only what `tests/architecture.rs` lists; no two files
//! import each other, directly or through others. `voronoi` builds cells and knows no energy, `energy`
//! takes a center and convex pieces and knows no diagram; `relax` is where they meet. `complex` makes one
//! mesh of the cells of a diagram, for `export` to write; its data, [`mesh`]'s `poly_mesh`, lies low, so that
//! readers of mesh files can make it too.
//!
//! `python/`, a workspace member of its own, is the package for Python: `scene::bindings` and `call` are what
//! it calls.
//!
//! # A site's way through an iteration
//!
//! ```text
//! scene::run         the scene's domain and sites
//!   relax::driver    which move comes next; one record per move
//!     relax::lloyd   every site to its own cell's center
//!       voronoi::diagram → cell → search → kd_tree      the cell: bisectors up to the security radius
//!         geometry::small_polyhedron_clip               each cut
//!       relax::evaluate_cell                            the cell's signed pieces in the domain
//!         domain::shape, density                        … clipped to a solid, weighted
//!         energy::preparation → evaluation → surface    the energy and its derivatives
//!         energy::center → minimize::newton             its minimizer: the site's target
//!     relax::ranked_sites … distributed: bricks, halos, exact sums (`chebloyd-mpi`)
//!     relax::linf      … with L∞ cells: voronoi::linf → energy::faceted → energy::center
//!     relax::record  energy and movement
//! export::run        log, checkpoint, sites (the command)
//! ```
//!
//! # Equations
//!
//! | source | what | function |
//! |---|---|---|
//! | \[BL\] eq. 1, 10 | mass of a tetrahedron of linear density | `integrals::reference::tetrahedron` |
//! | \[BL\] eq. 1-4 | moments of linear densities | [`integrals::mesh_moments::linear`], [`at_vertices`](integrals::mesh_moments::at_vertices) |
//! | \[BL\] eq. 6, 7 | energy of a cell and its derivatives | `energy::evaluation::energy`, `energy_jet` |
//! | … for p = 1 | | `energy::sums_linear` |
//! | … for any p | | `energy::sums_power` |
//! | … with a density | | `energy::sums_polynomial` |
//! | \[BL\] section 3.2 | densities that stand, least variance | `balance::stand`, `balance::solve` |
//! | … its clamped ramp | moments above planes, in layers | [`integrals::half_space`], [`mass::profile`] |
//! | … bodies that spin | | `balance::spin`, `balance::elements`, `balance::conditions` |
//! | \[BL\] eq. 5 | moments of the sine | `integrals::radial`, `integrals::sine_jet` |
//! | … fitted to an axis | | `balance::sine_fit` |
//! | \[BL\] section 3.4 | moments of a print's beads | `gcode::bead`, `gcode::weigh` |
//! | … infill of varying density | | `gcode::flow`, `gcode::modulate` |
//! | \[BL\] section 3.5 | Lloyd's move | `relax::lloyd` |
//! | … its future work | L∞ Voronoi cells | `voronoi::linf`, `relax::linf` |
//! | \[BL\] Fig. 10 | a cell of the plane and its fragments | `energy::planar`, `energy::planar_cell` |
//! | \[BL\] Fig. 12 | the six fragments | `energy::fragments` |
//! | \[BL\] Fig. 13 | energy and movement in percent | [`Record`] |
//! | \[BL\] Appendix B | tetrahedra cut by a plane | [`mass::split`], [`mass::cut`] |
//! | \[M\] eq. 18-27 | the ten integrals of a solid | [`integrals::mesh_moments::constant`] |
//! | \[M\] eq. 29-98 | the same by faces and their projections | [`integrals::reference::mirtich`] |
//! | \[M\] eq. 3, 5-17 | inertia, center of mass, transfer of axes | [`mass::body`] |
//! | \[CP\] eq. 3-15 | polynomials over surfaces and solids | [`integrals::reference::cattani_paoluzzi`] |
//! | … all monomials of a degree at once | | `integrals::monomials` |
//! | \[BL\] Table 3, Fig. 14, 15 | octrees and their errors | `mesh::octree`, `mass::octree_error` |
//! | \[RSL\] section 3 | security radius | `voronoi::search` |
//! | \[LL\] | the global objective and its gradient | `relax::objective`, `energy::facet_terms`, `energy::planar_cell` |
//! | \[B\] | L-BFGS-B | `minimize::lbfgsb` |
//!
//! - \[BL\] Bukenberger & Lensch, *Tetrahedra of Varying Density and their Applications*.
//! - \[M\] Mirtich, *Fast and Accurate Computation of Polyhedral Mass Properties*, 1996.
//! - \[CP\] Cattani & Paoluzzi, *Boundary Integration over Linear Polyhedra*, 1990, as restated in
//!   Paoluzzi, *Finite Domain Integration of Polynomials*, 2015.
//! - \[RSL\] Ray, Sokolov, Lefebvre & Lévy, *Meshless Voronoi on the GPU*, 2018.
//! - \[LL\] Lévy & Liu, *Lp Centroidal Voronoi Tessellation and its Applications*, 2010.
//! - \[B\] Byrd, Lu, Nocedal & Zhu, *A Limited Memory Algorithm for Bound Constrained Optimization*, 1995.
//!
//! # Conventions
//!
//! Lengths are in the unit of the input (L), volumes in L³ (L² in the plane), energies of order
//! p in L^(3+p). Positions are `nalgebra::Point` or arrays, displacements are vectors, all in `f64`.
//! Site indices count from zero. The library never prints and never panics on bad input; long work
//! reports to an observer, runs in the caller's rayon pool, and gives the same bits for any number of
//! threads. On x86-64 it is fastest where the whole program is built for AVX2
//! (`RUSTFLAGS="-C target-cpu=x86-64-v3"`).

#![cfg_attr(
    not(feature = "cli"),
    allow(
        dead_code,
        unreachable_pub,
        reason = "parts that only files, scenes or the command use"
    )
)]

pub mod integrals;
pub mod mass;
pub mod mesh;

#[cfg(feature = "files")]
pub mod export;
#[cfg(feature = "scene")]
pub mod scene;

mod arrays;
mod balance;
#[cfg(feature = "cli")]
mod cli;
mod complex;
mod domain;
mod energy;
#[cfg(feature = "files")]
mod gcode;
mod geometry;
mod minimize;
mod parallel;
#[cfg(feature = "cli")]
mod plot;
mod relax;
#[cfg(feature = "cli")]
mod report;
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
pub use crate::relax::method::Method;
pub use crate::relax::metrics::Metrics;
pub use crate::relax::record::Record;
pub use crate::relax::relaxation::{Checkpoint, Outcome, RelaxError, Relaxation, random_sites};
pub use crate::relax::relaxation_space::Norm;
pub use crate::voronoi::cell::{Cell, CellFacet};
pub use crate::voronoi::check::CheckError;
pub use crate::voronoi::diagram::{Diagram, DiagramError};

#[cfg(feature = "cli")]
pub use crate::cli::command::{command_line, command_line_of};
#[cfg(feature = "cli")]
pub use crate::cli::embedding::{CallOutcome, call};
#[cfg(feature = "cli")]
pub use crate::cli::over_ranks::command_line_over;
#[cfg(feature = "cli")]
pub use crate::relax::ranks::Ranks;

/// The README's code compiles and runs.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
