//! Relaxes sites in a solid that is given by arrays: here an octahedron, and sites beside its axes.
//!
//!     cargo run --release --example solid

use chebloyd::{Diagram, Relaxation, SurfaceSolid};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let vertices = [
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let triangles = [
        [0, 2, 4],
        [2, 1, 4],
        [1, 3, 4],
        [3, 0, 4],
        [2, 0, 5],
        [1, 2, 5],
        [3, 1, 5],
        [0, 3, 5],
    ];
    let solid = SurfaceSolid::from_arrays(&vertices, &triangles)?;
    let mut sites: Vec<[f64; 3]> = vertices
        .map(|vertex| vertex.map(|x| 0.3 * x + 0.01))
        .to_vec();
    Relaxation::new(solid.clone()).run(&mut sites)?;
    Diagram::new(&solid, &sites)?.check()?;
    for site in &sites {
        println!("{:8.5} {:8.5} {:8.5}", site[0], site[1], site[2]);
    }
    Ok(())
}
