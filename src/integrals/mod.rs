//! Closed forms: exact integrals of polynomials over simplices and polyhedra.
