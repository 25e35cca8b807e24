//! Cells that are small where a density is high: ρ = 1 + 80 x⁴ in the unit cube.
//!
//!     cargo run --release --example graded

use chebloyd::{Cuboid, Diagram, Polynomial, Relaxation, WeightedDomain, random_sites};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let density = Polynomial::from_terms([([0, 0, 0], 1.0), ([4, 0, 0], 80.0)]);
    let cube = Box::new(Cuboid::unit());
    let domain = WeightedDomain::new(cube, density)?;
    let mut sites = random_sites(&Cuboid::unit(), 300, 1)?;
    Relaxation::new(domain).run(&mut sites)?;
    let cube = Cuboid::unit();
    let volumes =
        Diagram::new(&cube, &sites)?.map_cells(|cell| (cell.position.x, cell.volume()))?;
    let mean = |low: f64, high: f64| {
        let inside = volumes.iter().filter(|(x, _)| (low..high).contains(x));
        let (count, sum) = inside.fold((0, 0.0), |(count, sum), (_, v)| (count + 1, sum + v));
        sum / f64::from(count)
    };
    println!(
        "mean volume for x < 0.5: {:.5}, for x > 0.5: {:.5}",
        mean(0.0, 0.5),
        mean(0.5, 1.0)
    );
    Ok(())
}
