//! The sites that every method leaves, to the last bit: the same with and without AVX2.

#[path = "../examples/golden.rs"]
#[allow(dead_code, reason = "the example's `main` is not called here")]
mod golden;

/// What `cargo run --example golden` printed on x86-64 Linux. Other systems have other mathematical
/// functions, and so other bits; there both builds are compared with each other alone.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
const HASHES: [(&str, u64); 7] = [
    ("lloyd", 0x04b9_d71b_e58e_c83c),
    ("accelerated", 0x342f_2e24_3415_0595),
    ("l2", 0x5681_44fb_c336_81fa),
    ("order 3", 0x0c39_3463_f0b1_a81a),
    ("quasi-newton", 0x8ceb_b38d_fe7b_779e),
    ("anneal", 0xcb7d_99ec_c48c_2a33),
    ("cubes", 0xc4c1_7524_0385_0573),
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
