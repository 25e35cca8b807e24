//! Convergence curves and pictures of cells.
