//! meshless_voronoi: cells with volumes and centroids of the sites in a file, in the unit cube.
//! Prints CPU microseconds per site and the sum of the volumes.

use glam::DVec3;
use meshless_voronoi::{Dimensionality, Voronoi};

/// CPU time of this thread so far (s), as Linux tells it.
fn cpu_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").expect("Linux");
    let nanoseconds: f64 = text.split(' ').next().unwrap_or("").parse().expect("a number");
    nanoseconds * 1e-9
}

fn main() {
    let file = std::env::args().nth(1).expect("a file of sites");
    let text = std::fs::read_to_string(file).expect("a readable file");
    let site = |line: &str| {
        let mut numbers = line.split(',').map(|word| word.parse().expect("a number"));
        let mut next = || numbers.next().expect("three numbers");
        DVec3::new(next(), next(), next())
    };
    let sites: Vec<DVec3> = text.lines().skip(1).map(site).collect();
    let began = cpu_seconds();
    let diagram = Voronoi::build(
        &sites,
        DVec3::ZERO,
        DVec3::ONE,
        Dimensionality::ThreeD,
        false,
    );
    let seconds = cpu_seconds() - began;
    let volume: f64 = diagram.cells().iter().map(|cell| cell.volume()).sum();
    println!("{:.3} {volume:.15}", 1e6 * seconds / sites.len() as f64);
}
