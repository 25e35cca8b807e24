//! Prints what every method makes of the same random sites: the tables of the README.
//!
//! `cargo run --release --example methods -- [count=1000] [from=1] [to=1] [extent=1] [periodic=0]
//! [scene=FILE] [surface=FILE] [only=NAME,…]`: `count` sites of every seed `from` … `to`, in a box of
//! the lengths `extent`, 1, 1, in the domain of a scene, or in a surface fitted into the unit cube.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use chebloyd::scene::read;
use chebloyd::{Bounds, Cuboid, Domain, Method, Relaxation, random_sites};

fn option(name: &str) -> Option<String> {
    let prefix = format!("{name}=");
    std::env::args().find_map(|argument| argument.strip_prefix(&prefix).map(str::to_owned))
}

fn number(name: &str, default: f64) -> f64 {
    option(name).map_or(default, |value| value.parse().expect("a number"))
}

/// The methods of the tables.
fn methods(count: usize) -> Vec<(&'static str, Method)> {
    vec![
        ("lloyd-50", Method::lloyd(50)),
        ("lloyd-150", Method::lloyd(150)),
        ("lloyd-400", Method::lloyd(400)),
        ("accelerated-50", Method::lloyd(50).accelerated()),
        ("accelerated-150", Method::lloyd(150).accelerated()),
        ("quasi-newton-24", Method::quasi_newton(24)),
        ("quasi-newton-175", Method::quasi_newton(175)),
        ("anneal", Method::anneal()),
        ("cubes", Method::cubes(count)),
    ]
}

fn domain() -> Result<Box<dyn Domain>, Box<dyn Error>> {
    if let Some(path) = option("scene") {
        return Ok(read::scene(Path::new(&path))?.solid()?.0);
    }
    if let Some(path) = option("surface") {
        let path = Path::new(&path).canonicalize()?;
        let domain = serde_json::json!({ "surface": path, "scale_to": "unit_cube" });
        let text = serde_json::json!({ "domain": domain, "sites": { "random": { "count": 1 } } });
        return Ok(read::parse(&text.to_string(), Path::new("surface"))?
            .solid()?
            .0);
    }
    let bounds = Bounds::from_corners([0.0; 3], [number("extent", 1.0), 1.0, 1.0]);
    let is_periodic = number("periodic", 0.0) > 0.0;
    Ok(Box::new(Cuboid::new(bounds, [is_periodic; 3])?))
}

fn main() -> Result<(), Box<dyn Error>> {
    let count = number("count", 1000.0) as usize;
    let only = option("only");
    let is_wanted = |name: &str| {
        let names = only.as_ref().map(|only| only.split(','));
        names.is_none_or(|mut names| names.any(|only| only == name))
    };
    println!(
        "| method | sites | seed | energy % | cubeness | six-facet | aligned | evaluations | s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for seed in number("from", 1.0) as u64..=number("to", 1.0) as u64 {
        let start = random_sites(domain()?.as_ref(), count, seed)?;
        for (name, method) in methods(count) {
            if !is_wanted(name) {
                continue;
            }
            let relaxation = Relaxation::boxed(domain()?).method(method);
            let (mut sites, began) = (start.clone(), Instant::now());
            let outcome = relaxation.run(&mut sites)?;
            let seconds = began.elapsed().as_secs_f64();
            let evaluations = outcome
                .records
                .last()
                .map_or(0.0, |record| record.evaluations);
            let metrics = relaxation.measure(&sites)?;
            println!(
                "| {name} | {} | {seed} | {:.4} | {:.4} | {:.3} | {:.4} | {evaluations:.0} | {seconds:.2} |",
                sites.len(),
                metrics.energy_percent,
                metrics.cubeness,
                metrics.six_facet_fraction,
                metrics.axis_aligned_area,
            );
        }
    }
    Ok(())
}
