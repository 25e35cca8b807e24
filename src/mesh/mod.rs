//! Meshes read from files.
