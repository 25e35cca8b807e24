//! The sites that every method leaves, to the last bit: the same with and without AVX2.

#[path = "../examples/golden.rs"]
#[allow(dead_code, reason = "the example's `main` is not called here")]
mod golden;

/// What `cargo run --example golden` printed on x86-64 Linux. Other systems have other mathematical
/// functions, and so other bits; there both builds are compared with each other alone.
#[cfg(all(target_arch = "x86_64", target_os = "linux"))]
const HASHES: [(&str, u64); 7] = [
    ("lloyd", 0x5e87_b915_9cc4_122a),
    ("accelerated", 0x1f31_cb77_5b14_97e3),
    ("l2", 0x6c2f_1b3f_618e_a0d0),
    ("order 3", 0xb288_a7eb_fd1f_88fd),
    ("quasi-newton", 0x18a3_d9d9_b4d5_bd7b),
    ("anneal", 0xdff1_0e7b_3a6e_e17e),
    ("cubes", 0x1e87_d7aa_8254_b38b),
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
