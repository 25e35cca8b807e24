//! Whether this processor has what the program was built for.
//!
//! Without a look, an older one would end the program in the middle of its work.

use crate::cli::failure::Failure;

/// What `.cargo/config.toml` asks for, by the names of Linux, and what the compiler calls it.
const NEEDED: [(&str, bool); 3] = [
    ("avx2", cfg!(target_feature = "avx2")),
    ("bmi2", cfg!(target_feature = "bmi2")),
    ("fma", cfg!(target_feature = "fma")),
];

/// Refuses a processor that the program was not built for, where the system tells (Linux on x86).
pub(crate) fn check() -> Result<(), Failure> {
    let told = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    match missing(&told) {
        Some(feature) => Err(Failure::run(format!(
            "this program was built for processors with {feature}, which this one lacks; build it \
             anew with `RUSTFLAGS= cargo build --release`"
        ))),
        None => Ok(()),
    }
}

/// The first feature that is needed and not among the flags that the system tells.
fn missing(told: &str) -> Option<&'static str> {
    let flags = told.lines().find(|line| line.starts_with("flags"))?;
    let has = |feature: &str| flags.split_whitespace().any(|flag| flag == feature);
    let needed = NEEDED.iter().filter(|(_, is_needed)| *is_needed);
    needed
        .map(|(feature, _)| *feature)
        .find(|feature| !has(feature))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_processor_without_flags_is_told_what_it_lacks() {
        assert_eq!(missing("flags\t\t: fpu sse2 fma avx2 bmi2\n"), None);
        let lacks = missing("processor: 0\nflags\t\t: fpu sse2\n");
        assert_eq!(lacks.is_some(), cfg!(target_feature = "avx2"));
        assert_eq!(missing("Features: neon\n"), None);
    }
}
