//! Mass properties of solids with varying density.
