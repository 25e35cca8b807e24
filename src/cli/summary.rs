//! What a run says at its end.

use std::path::Path;

use crate::cli::job::Description;

/// How `run.json` calls the end that Ctrl-C brings.
pub(crate) const INTERRUPTED: &str = "interrupted";

/// The run in a few lines, after `done` moves; nothing of a run that has not ended.
pub(crate) fn summary(run: &Description, done: u64, directory: &Path) -> String {
    let [Some(from), Some(to)] = [&run.initial, &run.last] else {
        return String::new();
    };
    let directory = directory.display();
    let last_line = match run.ended.as_deref() {
        Some(INTERRUPTED) => {
            format!("interrupted; go on with: chebloyd relax --resume --out {directory}")
        }
        _ => format!("log, sites and cells are in {directory}"),
    };
    format!(
        "{} sites, {done} iterations in {:.2} s\n\
         energy              {:8.2} % → {:.2} %\n\
         cubeness            {:8.3}   → {:.3}\n\
         six-facet cells     {:8.1} % → {:.1} %\n\
         axis-aligned area   {:8.3}   → {:.3}\n\
         {last_line}\n",
        to.sites,
        run.seconds,
        from.energy_percent,
        to.energy_percent,
        from.cubeness,
        to.cubeness,
        100.0 * from.six_facet_fraction,
        100.0 * to.six_facet_fraction,
        from.axis_aligned_area,
        to.axis_aligned_area,
    )
}
