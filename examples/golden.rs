//! Prints a hash of the bits of the sites that every method leaves: the same with and without AVX2.
//!
//!     cargo run --release --example golden
//!     RUSTFLAGS= cargo run --release --example golden

use chebloyd::{Cuboid, Method, Norm, RelaxError, Relaxation, random_sites};

/// FNV-1a over the bits of all coordinates.
fn hash(sites: &[[f64; 3]]) -> u64 {
    let bytes = sites
        .iter()
        .flatten()
        .flat_map(|x| x.to_bits().to_le_bytes());
    bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

/// Every method's name and hash.
pub(crate) fn hashes() -> Result<Vec<(&'static str, u64)>, RelaxError> {
    let methods = [
        ("lloyd", Method::lloyd(20)),
        ("accelerated", Method::lloyd(20).accelerated()),
        ("l2", Method::lloyd(20).norm(Norm::L2)),
        ("order 3", Method::lloyd(10).order(3)),
        ("quasi-newton", Method::quasi_newton(20)),
        ("anneal", Method::anneal().iterations(200)),
        ("cubes", Method::cubes(500).iterations(60)),
    ];
    let mut hashes = Vec::new();
    for (name, method) in methods {
        let sites = random_sites(&Cuboid::unit(), 500, 1)?;
        let mut sites: Vec<[f64; 3]> = sites.into_iter().map(Into::into).collect();
        Relaxation::new(Cuboid::unit())
            .method(method)
            .run(&mut sites)?;
        hashes.push((name, hash(&sites)));
    }
    Ok(hashes)
}

fn main() -> Result<(), RelaxError> {
    for (name, hash) in hashes()? {
        println!("{name:13} {hash:016x}");
    }
    Ok(())
}
