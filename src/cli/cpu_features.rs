//! Check that this processor has the instructions that the program was built for.
//!
//! Without it, an older one would end the program in the middle of its work.

use std::fs::File;
use std::io::{BufRead, BufReader};

use crate::cli::failure::Failure;

/// The features that `.cargo/config.toml` enables, by their names in Linux, and whether this
/// build has them.
const NEEDED: [(&str, bool); 3] = [
    ("avx2", cfg!(target_feature = "avx2")),
    ("bmi2", cfg!(target_feature = "bmi2")),
    ("fma", cfg!(target_feature = "fma")),
];

/// Refuses a processor that the program was not built for, where the system lists its features (Linux on x86).
pub(crate) fn check() -> Result<(), Failure> {
    let listed = File::open("/proc/cpuinfo").ok().map(BufReader::new);
    match listed.and_then(missing) {
        Some(feature) => Err(Failure::run(format!(
            "this program was built for processors with {feature}, which this one lacks; build it \
             anew with `RUSTFLAGS= cargo build --release`"
        ))),
        None => Ok(()),
    }
}

/// The first feature that is needed and not among the flags of the first processor. Nothing is read after those: listing
/// many processors takes time.
fn missing(listed: impl BufRead) -> Option<&'static str> {
    let mut lines = listed.lines().map_while(Result::ok);
    let flags = lines.find(|line| line.starts_with("flags"))?;
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
    fn the_first_missing_feature_is_named() {
        assert_eq!(
            missing("flags\t\t: fpu sse2 fma avx2 bmi2\n".as_bytes()),
            None
        );
        let lacks = missing("processor: 0\nflags\t\t: fpu sse2\n".as_bytes());
        assert_eq!(lacks.is_some(), cfg!(target_feature = "avx2"));
        assert_eq!(missing("Features: neon\n".as_bytes()), None);
    }
}
