//! The loops that move sites, and the records they leave.

pub mod record;
pub mod tessellation;
