//! The sites that every method leaves, to the last bit: the same with and without AVX2.

#[path = "../examples/golden.rs"]
#[allow(dead_code, reason = "the example's `main` is not called here")]
mod golden;

/// What `cargo run --example golden` printed on x86-64 Linux. Other systems have other mathematical
/// functions, and so other bits; there both builds are compared with each other alone.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
const HASHES: [(&str, u64); 7] = [
    ("lloyd", 0),
    ("accelerated", 0),
    ("l2", 0),
    ("order 3", 0),
    ("quasi-newton", 0),
    ("anneal", 0),
    ("cubes", 0),
];

#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
#[test]
fn every_method_leaves_the_bits_it_left() {
    assert_eq!(golden::hashes().expect("random sites relax"), HASHES);
}

#[test]
fn the_number_of_threads_does_not_matter() {
    let of = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool")
            .install(golden::hashes)
            .expect("random sites relax")
    };
    assert_eq!(of(1), of(3));
}
