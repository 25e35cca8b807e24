//! The loops that move sites, and the records they leave.

pub mod measure_plane;
pub mod plane;
pub mod lloyd;
pub mod record;
pub mod space;
pub mod tessellation;
