//! Sites as lines of a table: separated by commas, semicolons, tabs or white space.
//!
//! A table may begin with a header; if it does, the columns named x, y and z (in any case, a unit
//! behind: `x [mm]`; also ParaView's `Points:0`) are read, in any order of columns. Without one every line
//! has exactly one number per axis, or a number of the site before them. Blank lines and what follows
//! `#` are skipped. Lines end with LF, CR LF or CR.

use std::collections::HashSet;

use nalgebra::Point;

use crate::mesh::formats::words::lines;
use crate::scene::number_text::{AXES, number};

/// A one-based line and what is wrong there.
type Fault = (usize, String);

/// Sites as a file gives them, and what there is to say about it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SiteFile<const D: usize> {
    pub(crate) sites: Vec<Point<f64, D>>,
    /// One sentence each.
    pub(crate) notes: Vec<String>,
}

/// The sign between columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Separator {
    Blank,
    Sign(char),
}

impl Separator {
    /// The one of a line: a tab, a semicolon, a comma, or white space.
    pub(crate) fn of(line: &str) -> Self {
        let has_words = line.split_whitespace().nth(1).is_some();
        match ['\t', ';', ',']
            .into_iter()
            .find(|sign| line.contains(*sign))
        {
            Some(sign) => Self::Sign(sign),
            None if has_words => Self::Blank,
            None => Self::Sign(','),
        }
    }

    pub(crate) fn fields(self, line: &str) -> Vec<String> {
        match self {
            Self::Blank => line.split_whitespace().map(str::to_owned).collect(),
            Self::Sign(sign) => line
                .split(sign)
                .map(|field| field.trim().trim_matches('"').to_owned())
                .collect(),
        }
    }
}

/// The first line that is neither blank nor a comment.
pub(crate) fn first_line(text: &str) -> Option<&str> {
    let mut contents = lines(text.trim_start_matches('\u{feff}')).map(content);
    contents.find(|content| !content.is_empty())
}

fn content(line: &str) -> &str {
    line.split('#').next().unwrap_or("").trim()
}

/// Whether the fields of a header name the first two axes at least.
pub(crate) fn names_columns(header: &[String]) -> bool {
    AXES[..2]
        .iter()
        .all(|axis| header.iter().any(|name| is_axis(name, axis)))
}

/// Parses a table with this separator, or with that of its first line.
pub(crate) fn parse<const D: usize>(
    text: &str,
    separator: Option<Separator>,
) -> Result<SiteFile<D>, Fault> {
    let separator = separator.or_else(|| first_line(text).map(Separator::of));
    let separator = separator.unwrap_or(Separator::Blank);
    let mut columns: Option<Columns<D>> = None;
    let mut sites = Vec::new();
    for (line, content) in (1..).zip(lines(text.trim_start_matches('\u{feff}')).map(content)) {
        if content.is_empty() {
            continue;
        }
        let fields = separator.fields(content);
        let at = |message| (line, message);
        if columns.is_none() && fields.iter().any(|field| is_word(field)) {
            columns = Some(Columns::named(&fields).map_err(at)?);
            continue;
        }
        let columns = columns.get_or_insert_with(|| Columns::plain(&fields));
        sites.push(columns.point(&fields).map_err(at)?);
    }
    let numbered = columns.is_some_and(|columns| columns.numbers.is_some());
    let notes = numbered.then(|| {
        format!(
            "the first of {} columns numbers the sites and is passed over",
            D + 1
        )
    });
    Ok(SiteFile {
        sites,
        notes: notes.into_iter().collect(),
    })
}

/// The columns of the coordinates in a line.
struct Columns<const D: usize> {
    at: [usize; D],
    width: usize,
    /// The numbers of the sites so far, where the first column holds them.
    numbers: Option<HashSet<u64>>,
}

impl<const D: usize> Columns<D> {
    /// Those of a table without a header, by its first line. In the plane three columns may be points
    /// of space, so their numbers begin with 0 or 1.
    fn plain(first: &[String]) -> Self {
        let number = first[0].parse::<u64>();
        let begins = number.is_ok_and(|number| D == 3 || number <= 1);
        let is_numbered = first.len() == D + 1 && begins;
        let shift = usize::from(is_numbered);
        Self {
            at: std::array::from_fn(|axis| axis + shift),
            width: D + shift,
            numbers: is_numbered.then(HashSet::new),
        }
    }

    fn named(header: &[String]) -> Result<Self, String> {
        let mut at = [0; D];
        for (column, axis) in at.iter_mut().zip(AXES) {
            let found = header.iter().position(|name| is_axis(name, axis));
            *column = found.ok_or_else(|| {
                format!(
                    "the header names no column {axis}; expected {}",
                    AXES[..D].join(",")
                )
            })?;
        }
        let (width, numbers) = (header.len(), None);
        Ok(Self { at, width, numbers })
    }

    fn point(&mut self, fields: &[String]) -> Result<Point<f64, D>, String> {
        if fields.len() != self.width {
            return Err(wrong_width::<D>(fields, self.width));
        }
        self.check_number(fields)?;
        let mut point = Point::origin();
        for (axis, &column) in self.at.iter().enumerate() {
            point[axis] = number(&fields[column], AXES[axis])
                .map_err(|message| message + decimal_comma(&fields[column]))?;
        }
        Ok(point)
    }

    /// Refuses a first column that does not number the sites, as that of the first line did.
    fn check_number(&mut self, fields: &[String]) -> Result<(), String> {
        let Some(numbers) = &mut self.numbers else {
            return Ok(());
        };
        let number = fields[0].parse::<u64>().ok();
        // In the plane the numbers follow one another.
        let follows = |number: &u64| {
            let before = number.checked_sub(1);
            D == 3 || numbers.is_empty() || before.is_some_and(|before| numbers.contains(&before))
        };
        let is_new = number
            .filter(follows)
            .is_some_and(|number| numbers.insert(number));
        match is_new {
            true => Ok(()),
            false => Err(format!(
                "{}; the first does not number the sites: it is `{}`",
                wrong_width::<D>(fields, D),
                fields[0]
            )),
        }
    }
}

/// Whether a column's name is that of an axis, in any case, perhaps with a unit, or as ParaView says it.
fn is_axis(name: &str, axis: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let bare = name.split(['[', '(']).next().unwrap_or_default().trim();
    let number = AXES.iter().position(|known| *known == axis);
    let of_paraview =
        number.is_some_and(|k| [format!("points:{k}"), format!("points_{k}")].contains(&name));
    bare == axis || of_paraview
}

/// Whether a field is neither a number nor one that went wrong: a header's word.
fn is_word(field: &str) -> bool {
    field.parse::<f64>().is_err() && field.starts_with(|first: char| first.is_alphabetic())
}

fn wrong_width<const D: usize>(fields: &[String], expected: usize) -> String {
    let found = fields.len();
    let mend = match found {
        2 | 3 if expected == D => format!("; a scene with \"dimension\": {found} takes these"),
        _ if found == 2 * expected => {
            "; where decimals have commas, write points instead, or semicolons between columns and points"
                .to_owned()
        }
        _ => String::new(),
    };
    format!("{found} columns where {expected} are expected{mend}")
}

/// The mend for a number with a decimal comma.
fn decimal_comma(field: &str) -> &'static str {
    let is_number =
        field.matches(',').count() == 1 && field.replace(',', ".").parse::<f64>().is_ok();
    if is_number {
        "; write decimals with a point (sed 's/,/./g')"
    } else {
        ""
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(text: &str) -> Result<SiteFile<3>, Fault> {
        parse(text, None)
    }

    #[test]
    fn columns_are_parted_by_any_sign() {
        let expected = [Point::from([0.5, 1.0, -2.0]), Point::from([1.0, 2.0, 3.0])];
        for text in [
            "0.5,1,-2\n1,2,3\n",
            "0.5; 1; -2\n1;2;3\n",
            "0.5\t1\t-2\r\n1\t2\t3\r\n",
            "0.5 1 -2\n1   2\t3\n",
            "x;y;z\n0.5;1;-2\n1;2;3\n",
            "X [mm]\tY [mm]\tZ [mm]\n0.5\t1\t-2\n1\t2\t3\n",
            "\"rho\",\"Points:0\",\"Points:1\",\"Points:2\"\n7,0.5,1,-2\n7,1,2,3\n",
            "id x y z\n9 0.5 1 -2\n3 1 2 3\n",
        ] {
            let file = table(text).unwrap();
            assert_eq!(
                (&file.sites[..], file.notes.len()),
                (&expected[..], 0),
                "{text}"
            );
        }
    }

    #[test]
    fn a_first_column_of_numbers_is_told() {
        for text in [
            "1 0 0 0\n2 1 2 3\n",
            "7,0,0,0\n3,1,2,3\n",
            "0\t0\t0\t0\n1\t1\t2\t3\n",
        ] {
            let file = table(text).unwrap();
            assert_eq!(file.sites[1], Point::from([1.0, 2.0, 3.0]), "{text}");
            assert!(file.notes[0].starts_with("the first of 4 columns numbers"));
        }
        let (line, message) = table("1 0 0 0\n1 1 2 3\n").unwrap_err();
        assert!(
            line == 2 && message.contains("does not number the sites: it is `1`"),
            "{message}"
        );
        assert!(
            table("0.5 0 0 0\n")
                .unwrap_err()
                .1
                .starts_with("4 columns where 3")
        );
        let plane = parse::<2>("1 0.5 0.5\n2 0.25 0.5\n", None).unwrap();
        assert_eq!((plane.sites.len(), plane.notes.len()), (2, 1));
        let (_, message) = parse::<2>("1 0.5 0.5\n3 0.25 0.5\n", None).unwrap_err();
        assert!(message.contains("\"dimension\": 3"), "{message}");
        assert!(parse::<2>("5 0.5 0.5\n", None).is_err());
    }

    #[test]
    fn decimal_commas_are_refused_with_the_mend() {
        for text in ["0,5;0,25;1\n", "0,5\t0,25\t1\n"] {
            let (_, message) = table(text).unwrap_err();
            assert!(
                message.contains("x is `0,5`") && message.contains("with a point"),
                "{message}"
            );
        }
        let (_, message) = table("0,5,0,25,1,0\n").unwrap_err();
        assert!(message.contains("decimals have commas"), "{message}");
    }
}
