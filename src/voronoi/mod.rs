//! Where a cell comes from: L2 Voronoi cells clipped to a domain.
