//! The k-d tree over the sites, and the candidate neighbors gathered from it.
//!
//! [`tree`] holds the sites in leaves, into which [`sort`] brings them; [`candidates`] holds what may cut a
//! cell, [`neighborhood`] gathers candidates once for all sites of a small subtree and orders them by distance
//! for each.

pub(crate) mod candidates;
pub(crate) mod neighborhood;
pub(crate) mod sort;
pub(crate) mod tree;
