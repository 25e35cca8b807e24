//! Memory that so many sites need, estimated before anything grows, against what the machine has left.
//!
//! On Linux that is the smaller of `MemAvailable` (proc(5)) and the limit of the process's control group
//! (`memory.max`, in version 1 `memory.limit_in_bytes`). Elsewhere nothing is known, and only the
//! numbering of sites sets a limit.

use std::fs;
use std::path::{Path, PathBuf};

use crate::scene::error::Error;

/// Bytes per site of a tessellation with its figures: measured between 100 000 and 200 000 sites.
const TESSELLATION: u64 = 200;

/// Bytes of a position or a gradient.
const VECTOR: u64 = 24;

/// Vectors per site of a descent besides its memory of steps: point, gradient, trial, work arrays.
const OF_DESCENT: u64 = 8;

/// Sites are numbered by `u32`, of which one number means none.
pub(crate) const MOST_SITES: u64 = u32::MAX as u64 - 1;

/// Refuses more sites than a tessellation has room for.
///
/// # Errors
/// [`Error::TooManySites`].
pub(crate) fn check(count: u64) -> Result<(), Error> {
    compare(count, TESSELLATION, available())
}

/// Refuses more sites than a descent that remembers so many steps has room for: it keeps two vectors per
/// site and step, and the numbers of a checkpoint hold them once more.
///
/// # Errors
/// [`Error::TooManySites`].
pub(crate) fn check_descent(count: u64, steps: u64) -> Result<(), Error> {
    let vectors = steps.saturating_mul(4).saturating_add(OF_DESCENT);
    let per_site = vectors.saturating_mul(VECTOR).saturating_add(TESSELLATION);
    compare(count, per_site, available())
}

/// Refuses more sites than there is room for where each of several processes on this machine holds `1 / parts` of
/// them: `[processes, parts]`. A descent without steps to remember is none.
///
/// # Errors
/// [`Error::TooManySites`].
pub(crate) fn check_share(
    count: u64,
    steps: u64,
    [processes, parts]: [u64; 2],
) -> Result<(), Error> {
    let of_steps = if steps == 0 {
        0
    } else {
        steps.saturating_mul(4).saturating_add(OF_DESCENT)
    };
    let per_site = of_steps.saturating_mul(VECTOR).saturating_add(TESSELLATION);
    let per_site = per_site.saturating_mul(processes).div_ceil(parts.max(1));
    compare(count, per_site, available())
}

/// Refuses a file that is larger than the memory that is left.
///
/// # Errors
/// [`Error::File`].
pub(crate) fn check_file(path: &Path) -> Result<(), Error> {
    let length = fs::metadata(path).map_or(0, |file| file.len());
    match available() {
        Some(available) if length > available => {
            let (length, available) = (shown(length), shown(available));
            Err(Error::File {
                path: path.to_owned(),
                message: format!("holds {length}, and {available} of memory are available"),
            })
        }
        _ => Ok(()),
    }
}

fn compare(count: u64, per_site: u64, available: Option<u64>) -> Result<(), Error> {
    let needed = count.saturating_mul(per_site);
    if count <= MOST_SITES && available.is_none_or(|available| needed <= available) {
        return Ok(());
    }
    let available = available.map_or_else(
        || format!("at most {MOST_SITES} sites can be numbered"),
        |available| {
            let most = MOST_SITES.min(available / per_site.max(1));
            format!(
                "{} are available, enough for {most} sites",
                shown(available)
            )
        },
    );
    Err(Error::TooManySites {
        count,
        needed: shown(needed),
        available,
    })
}

/// A number of bytes in decimal units.
fn shown(bytes: u64) -> String {
    const UNITS: [&str; 7] = ["B", "kB", "MB", "GB", "TB", "PB", "EB"];
    let mut number = bytes as f64;
    let mut unit = 0;
    while number >= 1000.0 && unit + 1 < UNITS.len() {
        number /= 1000.0;
        unit += 1;
    }
    let digits = usize::from(number < 10.0 && unit > 0);
    format!("{number:.digits$} {}", UNITS[unit])
}

/// The bytes of memory that are left to this process, where the system tells.
fn available() -> Option<u64> {
    let whole = fs::read_to_string("/proc/meminfo").ok();
    let whole = whole.as_deref().and_then(of_meminfo);
    let groups = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let limits = limit_files(&groups).into_iter().filter_map(|file| {
        let text = fs::read_to_string(file).ok()?;
        text.trim().parse::<u64>().ok()
    });
    limits.chain(whole).min()
}

/// `MemAvailable` of `/proc/meminfo`, which counts in kibibytes.
fn of_meminfo(text: &str) -> Option<u64> {
    let line = text
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let number = line.split_whitespace().next()?.parse::<u64>().ok()?;
    number.checked_mul(1024)
}

/// The files that may hold a limit of the groups in `/proc/self/cgroup`, own ones and all above.
fn limit_files(groups: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':');
        let (Some(_), Some(controllers), Some(path)) = (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        let (root, name) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            _ if controllers.split(',').any(|one| one == "memory") => {
                ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")
            }
            _ => continue,
        };
        let own = Path::new(root).join(path.trim_start_matches('/'));
        let is_below = |folder: &&Path| folder.starts_with(root);
        let folders = own.ancestors().take_while(is_below);
        files.extend(folders.map(|folder| folder.join(name)));
    }
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_refusal_names_count_estimate_and_what_is_there() {
        let message = compare(1_000_000_000_000, TESSELLATION, Some(32_000_000_000));
        assert_eq!(
            message.expect_err("too many").to_string(),
            "1000000000000 sites need about 200 TB of memory: 32 GB are available, enough for \
             160000000 sites; take fewer"
        );
        let message = compare(u64::MAX, TESSELLATION, None).expect_err("too many");
        assert!(message.to_string().contains("4294967294"), "{message}");
        assert!(compare(160_000_000, TESSELLATION, Some(32_000_000_000)).is_ok());
        assert!(compare(MOST_SITES, 1, None).is_ok() && compare(MOST_SITES + 1, 0, None).is_err());
    }

    #[test]
    fn the_system_tells_by_these_files() {
        let text = "MemTotal: 99 kB\nMemAvailable:   2048 kB\n";
        assert_eq!(of_meminfo(text), Some(2 << 20));
        let files = limit_files("0::/a/b\n5:cpu,memory:/c\n6:cpu:/d\n");
        let expected = [
            "/sys/fs/cgroup/a/b/memory.max",
            "/sys/fs/cgroup/a/memory.max",
            "/sys/fs/cgroup/memory.max",
            "/sys/fs/cgroup/memory/c/memory.limit_in_bytes",
            "/sys/fs/cgroup/memory/memory.limit_in_bytes",
        ];
        assert_eq!(files, expected.map(PathBuf::from));
    }
}
