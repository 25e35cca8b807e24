//! Voronoi cells without any relaxation: volumes, facets, neighbors, and which cell holds a point.
//!
//!     cargo run --release --example cells

use chebloyd::{Cuboid, Diagram, FacetKind, random_sites};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let cube = Cuboid::unit();
    let sites = random_sites(&Cuboid::unit(), 100, 1)?;
    let diagram = Diagram::new(&cube, &sites)?;
    let cells = diagram.map_cells(|cell| (cell.volume(), cell.facets()))?;
    for (site, (volume, facets)) in cells.iter().enumerate().take(5) {
        let walls = facets
            .iter()
            .filter(|facet| matches!(facet.kind, FacetKind::Wall(_)));
        let walls = walls.count();
        println!(
            "cell {site}: volume {volume:.6}, {} facets, {walls} walls",
            facets.len()
        );
    }
    println!(
        "the center lies in the cell of site {:?}",
        diagram.locate([0.5; 3])
    );
    diagram.check()?;
    Ok(())
}
