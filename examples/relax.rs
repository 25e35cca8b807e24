//! Relaxes random sites in a box and prints the convergence.
//!
//!     cargo run --release --example relax

use std::ops::ControlFlow;

use chebloyd::{Bounds, Cuboid, Method, Relaxation, random_sites};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bounds = Bounds::from_corners([0.0, 0.0, 0.0], [2.0, 1.0, 1.0]);
    let periodic = [true, false, false];
    let cuboid = Cuboid::new(bounds, periodic)?;
    let mut sites = random_sites(&cuboid, 2000, 1)?;
    let method = Method::quasi_newton(30);
    let relaxation = Relaxation::new(cuboid).method(method);
    let outcome = relaxation.run_with(&mut sites, |record, _| {
        println!("{:3} {:8.4} %", record.iteration, record.energy_percent);
        ControlFlow::Continue(())
    })?;
    let metrics = relaxation.measure(&sites)?;
    println!("{:?}: cubeness {:.3}", outcome.ended, metrics.cubeness);
    Ok(())
}
