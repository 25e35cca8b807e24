//! A line of G-code with some of its words replaced, and its checksum with them.

use std::ops::Range;

use crate::gcode::words::Command;

/// A line that is written anew.
#[derive(Debug)]
pub(crate) struct Rewrite<'a> {
    text: &'a [u8],
    command: Command,
    edits: Vec<(Range<usize>, String)>,
    /// Words that the line does not have.
    added: String,
}

impl<'a> Rewrite<'a> {
    /// Of the line `text`, whose command is `command`.
    pub(crate) fn new(text: &'a [u8], command: Command) -> Self {
        Self {
            text,
            command,
            edits: Vec::new(),
            added: String::new(),
        }
    }

    /// Writes `words` in the place of a word, which is there if its place is not empty.
    pub(crate) fn put(&mut self, place: Range<usize>, words: String) {
        if place.is_empty() {
            self.added.push(' ');
            self.added += &words;
        } else {
            self.edits.push((place, words));
        }
    }

    /// The whole line, checksum and comment too.
    pub(crate) fn whole(self) -> Vec<u8> {
        let (end, star) = extent(self.text);
        let mut line = self.edited(0..star.unwrap_or(end));
        if let Some(star) = star {
            let first = first_letter(&line);
            let sum = line[first..].iter().fold(0, |sum, byte| sum ^ byte);
            line.extend(format!("*{sum}").bytes());
            let digits = |byte: &&u8| byte.is_ascii_digit() || byte.is_ascii_whitespace();
            let after = star + 1 + self.text[star + 1..].iter().take_while(digits).count();
            line.extend(&self.text[after..]);
        } else {
            line.extend(&self.text[end..]);
        }
        line
    }

    /// The command alone: without number, checksum and comment.
    pub(crate) fn command(self) -> Vec<u8> {
        let (end, star) = extent(self.text);
        self.edited(self.command.name..star.unwrap_or(end))
    }

    fn edited(&self, range: Range<usize>) -> Vec<u8> {
        let mut edits: Vec<_> = self.edits.iter().collect();
        edits.sort_by_key(|(place, _)| place.start);
        let (mut line, mut at) = (Vec::new(), range.start);
        for (place, words) in edits {
            line.extend(&self.text[at..place.start]);
            line.extend(words.bytes());
            at = place.end;
        }
        line.extend(self.text[at..range.end.max(at)].trim_ascii_end());
        line.extend(self.added.bytes());
        line
    }
}

/// Where the code of a line ends, without blanks before its comment, and where its checksum begins.
fn extent(text: &[u8]) -> (usize, Option<usize>) {
    let mut at = 0;
    let mut star = None;
    while let Some(&byte) = text.get(at) {
        match byte {
            b';' => break,
            b'(' => {
                let close = text[at..].iter().position(|&byte| byte == b')');
                at = close.map_or(text.len() - 1, |length| at + length);
            }
            b'*' => star = Some(at),
            _ => {}
        }
        at += 1;
    }
    (text[..at].trim_ascii_end().len(), star)
}

/// Where the line's number or command begins: blanks before it do not count for the checksum.
fn first_letter(line: &[u8]) -> usize {
    let blank = |byte: &&u8| byte.is_ascii_whitespace();
    line.iter().take_while(blank).count()
}

/// How many digits follow the point of the number in a word.
pub(crate) fn decimals(word: &[u8]) -> usize {
    let point = word.iter().position(|&byte| byte == b'.');
    point.map_or(0, |point| word[point + 1..].trim_ascii_end().len())
}

/// `value` to so many decimals, and the shortest text for that.
pub(crate) fn rounded(value: f64, decimals: usize) -> (f64, String) {
    let text = format!("{value:.decimals$}");
    let text = if decimals > 0 {
        text.trim_end_matches('0').trim_end_matches('.')
    } else {
        &text[..]
    };
    let text = if matches!(text, "-0" | "") { "0" } else { text };
    (text.parse().unwrap_or(value), text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gcode::words::{Content, Words, content};

    fn rewrite(text: &str, e: &str) -> (String, String) {
        let Ok(Content::Command(command)) = content(text.as_bytes()) else {
            panic!("{text} is no command");
        };
        let mut words = Words::new();
        words.read(text.as_bytes(), &command).unwrap();
        let build = || {
            let mut rewrite = Rewrite::new(text.as_bytes(), command);
            rewrite.put(words.place(b'E'), format!("E{e}"));
            rewrite
        };
        let text = |line: Vec<u8>| String::from_utf8(line).unwrap();
        (text(build().whole()), text(build().command()))
    }

    #[test]
    fn words_change_and_all_else_stays() {
        for (line, whole, command) in [
            ("G1 X1 E2 ; E5", "G1 X1 E.5 ; E5", "G1 X1 E.5"),
            ("  G1X1E2F3", "  G1X1E.5F3", "G1X1E.5F3"),
            ("G1 X1", "G1 X1 E.5", "G1 X1 E.5"),
            ("G1 (E9) E 2.0 (x)", "G1 (E9) E.5 (x)", "G1 (E9) E.5 (x)"),
            ("G1 X1;c", "G1 X1 E.5;c", "G1 X1 E.5"),
            ("G1(a;b*)E2 ;c*1", "G1(a;b*)E.5 ;c*1", "G1(a;b*)E.5"),
        ] {
            let (e, expected) = (".5", (whole.to_owned(), command.to_owned()));
            assert_eq!(rewrite(line, e), expected, "{line}");
        }
    }

    #[test]
    fn checksums_follow() {
        let sum = |text: &str| text.bytes().fold(0, |sum, byte| sum ^ byte);
        for (line, code) in [("N7 G1 X1 E2", "N7 G1 X1 E.5"), ("G1 E2", "G1 E.5")] {
            let text = format!(" {line}*{} ; c", sum(line));
            let (whole, command) = rewrite(&text, ".5");
            assert_eq!(whole, format!(" {code}*{}; c", sum(code)));
            assert_eq!(command, code.trim_start_matches("N7 "));
            assert!(content(whole.as_bytes()).is_ok());
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!(rounded(1.500004, 5), (1.5, "1.5".into()));
        assert_eq!(rounded(-0.000004, 5), (0.0, "0".into()));
        assert_eq!(rounded(120.0, 3), (120.0, "120".into()));
        assert_eq!(rounded(100.0, 0), (100.0, "100".into()));
        assert_eq!(decimals(b"X-1.250"), 3);
        assert_eq!(decimals(b"X1"), 0);
    }
}
