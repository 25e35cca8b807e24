//! Slicers' totals of a print, corrected for what is printed now: lengths, volumes, weights
//! and costs of filament, and times.

use crate::gcode::comments::after;

/// How much the print has changed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Change {
    /// What each tool deposited and deposits (mm³), by its number.
    pub(crate) tools: Vec<(u32, [f64; 2])>,
    /// Seconds added.
    pub(crate) seconds: f64,
}

/// Lines about filament, one value for each tool or one for all; those of PrusaSlicer, OrcaSlicer,
/// Bambu Studio and Cura.
const FILAMENT: [&str; 6] = [
    "filament used [",
    "total filament ",
    "filament cost",
    "Filament used:",
    "filament_used",
    "total filament used",
];

/// Lines about times.
const TIMES: [&str; 4] = [
    "estimated printing time",
    "model printing time",
    "total estimated time",
    "TIME:",
];

/// Lines about times that are only marked: how much is of the first layer is not counted.
const MARKED_TIMES: [&str; 2] = ["estimated first layer printing time", "Build time:"];

/// Lines of Simplify3D, which are only marked.
const MARKED: [&str; 4] = [
    "Filament length:",
    "Plastic volume:",
    "Plastic weight:",
    "Material cost:",
];

/// What is added to lines that are not corrected.
const MARK: &str = " (as sliced, before chebloyd print)";

impl Change {
    /// Adds to what tool `tool` deposited and deposits.
    pub(crate) fn add(&mut self, tool: u32, volumes: [f64; 2]) {
        match self.tools.iter_mut().find(|(number, _)| *number == tool) {
            Some((_, sums)) => {
                sums[0] += volumes[0];
                sums[1] += volumes[1];
            }
            None => self.tools.push((tool, volumes)),
        }
    }

    /// By what the filament of the tool in a place of a list is multiplied; of a list of one, all.
    fn ratio(&self, place: usize, count: usize) -> f64 {
        let chosen = self
            .tools
            .iter()
            .filter(|(tool, _)| count == 1 || *tool as usize == place);
        let [before, after] = chosen.fold([0.0; 2], |sum, (_, volumes)| {
            [sum[0] + volumes[0], sum[1] + volumes[1]]
        });
        if before > 0.0 { after / before } else { 1.0 }
    }

    /// Whether times have changed.
    fn is_slower(&self) -> bool {
        self.seconds.abs() >= 1e-6
    }

    /// Whether anything is stale.
    fn is_none(&self) -> bool {
        let same = |(_, [before, after]): &(u32, [f64; 2])| (before - after).abs() <= 1e-9 * before;
        self.tools.iter().all(same) && !self.is_slower()
    }

    /// The comment `comment`, given without its semicolon, if it is stale; `so_far` are the seconds added
    /// before it.
    pub(crate) fn corrected(&self, comment: &[u8], so_far: f64) -> Option<String> {
        let text = std::str::from_utf8(comment).ok()?;
        let body = text.trim_start();
        let begins = |name: &str| body.starts_with(name);
        if self.is_none() {
            return None;
        }
        let corrected = if FILAMENT.iter().any(|name| begins(name)) {
            self.filament(text)?
        } else if after(body.as_bytes(), "TIME_ELAPSED:").is_some() {
            with_seconds(text, so_far)?
        } else if TIMES.iter().any(|name| begins(name)) {
            with_seconds(text, self.seconds)?
        } else if MARKED.iter().any(|name| begins(name))
            || self.is_slower() && MARKED_TIMES.iter().any(|name| begins(name))
        {
            format!("{}{MARK}", text.trim_end())
        } else {
            return None;
        };
        (corrected != text).then_some(corrected)
    }

    /// The values behind `=` or `:`, each times the ratio of its tool.
    fn filament(&self, text: &str) -> Option<String> {
        let at = text.find(['=', ':'])? + 1;
        let (name, values) = text.split_at(at);
        let values: Vec<_> = values.split(',').collect();
        let scaled = values.iter().enumerate().map(|(place, value)| {
            let Some((range, number, decimals)) = number_in(value) else {
                return (*value).to_owned();
            };
            let number = number * self.ratio(place, values.len());
            let (before, behind) = (&value[..range.start], &value[range.end..]);
            format!("{before}{number:.decimals$}{behind}")
        });
        Some(name.to_owned() + &scaled.collect::<Vec<_>>().join(","))
    }
}

/// The first number in a text: where it stands, its value, its decimals.
fn number_in(text: &str) -> Option<(std::ops::Range<usize>, f64, usize)> {
    let from = text.find(|sign: char| sign.is_ascii_digit())?;
    let rest = &text[from..];
    let end = rest.find(|sign: char| !sign.is_ascii_digit() && sign != '.');
    let word = &rest[..end.unwrap_or(rest.len())];
    let decimals = word.find('.').map_or(0, |point| word.len() - point - 1);
    Some((from..from + word.len(), word.parse().ok()?, decimals))
}

/// The text with `added` seconds on each of its durations: `30m 2s`, or plain seconds behind `TIME`.
fn with_seconds(text: &str, added: f64) -> Option<String> {
    if added.abs() < 1e-6 {
        return None;
    }
    if text.trim_start().starts_with("TIME") {
        let (range, number, decimals) = number_in(text)?;
        let seconds = (number + added).max(0.0);
        return Some(format!(
            "{}{seconds:.decimals$}{}",
            &text[..range.start],
            &text[range.end..]
        ));
    }
    let parts: Vec<_> = text
        .split(';')
        .map(|part| with_duration(part, added))
        .collect();
    Some(parts.join(";"))
}

/// The text with `added` seconds on the duration behind its `=` or `:`.
fn with_duration(text: &str, added: f64) -> String {
    let Some(at) = text.find(['=', ':']) else {
        return text.to_owned();
    };
    let (name, duration) = text.split_at(at + 1);
    let mut seconds = 0.0;
    for word in duration.split_whitespace() {
        let (number, unit) = word.split_at(word.len().saturating_sub(1));
        let unit = match unit {
            "d" => 86400.0,
            "h" => 3600.0,
            "m" => 60.0,
            "s" => 1.0,
            _ => return text.to_owned(),
        };
        match number.parse::<f64>() {
            Ok(number) => seconds += number * unit,
            Err(_) => return text.to_owned(),
        }
    }
    format!("{name} {}", duration_text(seconds + added))
}

fn duration_text(seconds: f64) -> String {
    let mut left = seconds.max(0.0).round() as u64;
    let mut words = Vec::new();
    for (unit, name) in [(86400, 'd'), (3600, 'h'), (60, 'm')] {
        if left >= unit || !words.is_empty() {
            words.push(format!("{}{name}", left / unit));
            left %= unit;
        }
    }
    words.push(format!("{left}s"));
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn change() -> Change {
        let mut change = Change::default();
        change.add(0, [60.0, 40.0]);
        change.add(0, [40.0, 10.0]);
        change.add(1, [100.0, 100.0]);
        change.seconds = 70.4;
        change
    }

    #[test]
    fn totals_are_corrected_as_each_slicer_writes_them() {
        for (line, corrected) in [
            (
                " filament used [mm] = 2645.53",
                Some(" filament used [mm] = 1984.15"),
            ),
            (
                " filament used [mm] = 100.00, 50.00",
                Some(" filament used [mm] = 50.00, 50.00"),
            ),
            (" total filament used [g] = 0.00", None),
            (" filament_used = no number", None),
            (
                " total filament length [mm] : 10.0",
                Some(" total filament length [mm] : 7.5"),
            ),
            ("Filament used: 2m", Some("Filament used: 2m")),
            ("Filament used: 2.50m", Some("Filament used: 1.88m")),
            ("TIME:6666", Some("TIME:6736")),
            ("TIME_ELAPSED:14.425326", Some("TIME_ELAPSED:24.425326")),
            (
                " estimated printing time (normal mode) = 30m 2s",
                Some(" estimated printing time (normal mode) = 31m 12s"),
            ),
            (
                " model printing time: 59m 0s; total estimated time: 1d 0h 59m 30s",
                Some(" model printing time: 1h 0m 10s; total estimated time: 1d 1h 0m 40s"),
            ),
            (
                "   Build time: 1 hour 4 minutes",
                Some("   Build time: 1 hour 4 minutes (as sliced, before chebloyd print)"),
            ),
            ("TYPE:FILL", None),
        ] {
            let got = change().corrected(line.as_bytes(), 10.0);
            let expected = corrected.filter(|text| *text != line);
            assert_eq!(got.as_deref(), expected, "{line}");
        }
    }

    #[test]
    fn without_change_nothing_is_stale() {
        let mut change = Change::default();
        change.add(0, [60.0, 60.0]);
        assert_eq!(
            change.corrected(b" filament used [mm] = 2645.53", 0.0),
            None
        );
        assert_eq!(change.corrected(b"Build time: 3", 0.0), None);
    }
}
