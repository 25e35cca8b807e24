//! The loops that move sites, and the records they leave.
//!
//! A loop ([`lloyd`], its moves perhaps made longer by [`over_relaxation`]) works on any
//! [`tessellation`]: [`space`] is the one of solids, [`plane`] that of planar domains. It shows an
//! observer one [`record`] per move.
//!
//! In space there is more than one loop. [`objective`] is the energy of all cells as a function of
//! all sites; [`travel`] carries out a [`plan`]: it descends along that objective ([`descent`]) or
//! by Lloyd's moves, gets out of local minima (`kick`: `noise`, `exchange`), and goes from few
//! sites to many ([`levels`]). Its [`stand`] is all that a later process needs to go on. [`frames`]
//! turn the axes along which distances are measured, as [`boundary_frames`] say or otherwise;
//! [`outline`] is what files and pictures show of a cell.

pub mod boundary_frames;
pub mod cell_memory;
pub mod descent;
pub mod figures;
pub mod frames;
pub mod levels;
pub mod lloyd;
pub mod objective;
pub mod outline;
pub mod over_relaxation;
pub mod plan;
pub mod plane;
pub mod record;
pub mod space;
pub mod stand;
pub mod tessellation;
pub mod travel;

mod exchange;
mod kick;
mod noise;
mod plane_figures;
mod reach;
mod shape;
