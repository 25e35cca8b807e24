//! The native half of the Python package `chebloyd`: arrays and JSON text in, arrays and JSON text out.
//!
//! Names, defaults and the classes that users meet are in `python/chebloyd/*.py`. Everything here runs in
//! [`work::detached`]: on threads of its own, without Python's lock, while the calling thread listens for
//! signals.

mod arrays;
mod calls;
mod errors;
mod work;

use pyo3::prelude::*;

/// Whether this processor has what `-C target-cpu=x86-64-v3` builds for.
#[pyfunction]
fn has_v3() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        // The features of x86-64-v3 that Rust can name; osxsave comes with avx.
        std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("bmi1")
            && std::arch::is_x86_feature_detected!("bmi2")
            && std::arch::is_x86_feature_detected!("fma")
            && std::arch::is_x86_feature_detected!("f16c")
            && std::arch::is_x86_feature_detected!("lzcnt")
            && std::arch::is_x86_feature_detected!("movbe")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        false
    }
}

/// Whether this module was built for x86-64-v3.
#[pyfunction]
const fn is_v3() -> bool {
    cfg!(all(target_arch = "x86_64", target_feature = "avx2"))
}

#[pymodule]
mod _chebloyd {
    #[pymodule_export]
    use super::calls::{call, cells, cubes, energy, measure, program, relax};
    #[pymodule_export]
    use super::{has_v3, is_v3};
}
