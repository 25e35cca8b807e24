//! `run.json`: what was run, on what, and how it ended.

use serde::{Deserialize, Serialize};

/// What `run.json` says. It is there from the first moment of a run, with `ended` empty.
///
/// `S` is the scene and `M` the measures of a tessellation, as they read and write themselves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Description<S, M> {
    /// The program's name.
    pub program: String,
    /// The program's version.
    pub version: String,
    /// The scene with every default filled in.
    pub scene: S,
    /// How many sites there are.
    pub sites: usize,
    /// The domain's volume (L^D).
    pub domain_volume: f64,
    /// The p = 1 Chebyshev energy of a cube of the mean volume (L^(D+1)).
    pub optimal_energy: f64,
    /// The tessellation that the run began with.
    pub initial: Option<M>,
    /// The tessellation that the run ended with.
    #[serde(rename = "final")]
    pub last: Option<M>,
    /// Why the run ended; nothing while it goes on, or when it was killed.
    pub ended: Option<String>,
    /// Wall time since the start (s), earlier parts of a resumed run included.
    pub seconds: f64,
    /// How many threads computed.
    pub threads: usize,
}
