//! Reader of sites from chemistry's XYZ: a line with the number of atoms, a line of remarks, and a
//! line for every atom, `symbol x y z` with any columns behind.
//!
//! The symbol is a word or an atomic number, or is left out; in the plane a line holds two
//! coordinates and nothing behind. In extended XYZ the remarks say `Properties=species:S:1:pos:R:3:…`,
//! name, type and number of the columns, and `pos` are the coordinates wherever they stand. A file is
//! one frame.

use nalgebra::Point;

use crate::mesh::formats::words::lines;
use crate::scene::number_text::{AXES, number};

/// A one-based line and what is wrong there.
pub(crate) type Fault = (usize, String);

/// The atoms' positions; `None` if the first line is not one whole number.
pub(crate) fn parse<const D: usize>(bytes: &[u8]) -> Option<Result<Vec<Point<f64, D>>, Fault>> {
    // Remarks may be in any encoding.
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let count = lines(text).next()?.trim().parse::<usize>().ok()?;
    Some(frame(text, count))
}

fn frame<const D: usize>(text: &str, count: usize) -> Result<Vec<Point<f64, D>>, Fault> {
    let mut all = (1..).zip(lines(text).map(str::trim)).skip(1);
    let column = match all.next() {
        Some((line, remarks)) => position_column::<D>(remarks).map_err(|fault| (line, fault))?,
        None => None,
    };
    let mut sites = Vec::new();
    let mut last = 2;
    for (line, content) in all.by_ref().take(count) {
        let fields: Vec<&str> = content.split_whitespace().collect();
        if fields.is_empty() {
            break;
        }
        sites.push(atom(&fields, column).map_err(|fault| (line, fault))?);
        last = line;
    }
    if sites.len() < count {
        let found = sites.len();
        let message = format!("{count} atoms are announced, {found} are there; correct line 1");
        return Err((last, message));
    }
    match all.find(|(_, content)| !content.is_empty()) {
        Some((line, _)) => Err((
            line,
            format!("text after the {count} atoms announced; correct line 1, or keep one frame"),
        )),
        None => Ok(sites),
    }
}

/// The first column of the coordinates, where the remarks of extended XYZ say it.
fn position_column<const D: usize>(remarks: &str) -> Result<Option<usize>, String> {
    const KEY: &str = "properties=";
    let Some(start) = remarks.to_ascii_lowercase().find(KEY) else {
        return Ok(None);
    };
    let list = remarks[start + KEY.len()..].trim_start_matches('"');
    let list = list.split(|sign: char| sign == '"' || sign.is_whitespace());
    let list: Vec<&str> = list.take(1).flat_map(|list| list.split(':')).collect();
    let mut column = 0_usize;
    for property in list.chunks(3) {
        let width = width_of(property)?;
        if property[0].eq_ignore_ascii_case("pos") {
            if width != D {
                return Err(format!("`pos` has {width} columns where {D} are expected"));
            }
            return Ok(Some(column));
        }
        column = column.saturating_add(width);
    }
    Err("`Properties` names no `pos`".to_owned())
}

/// The number of columns of a property of extended XYZ.
fn width_of(property: &[&str]) -> Result<usize, String> {
    let width = property.get(2).and_then(|width| width.parse().ok());
    width.ok_or_else(|| "`Properties` is not a list of name:type:columns".to_owned())
}

/// The coordinates in an atom's line, in the given column or after the symbol.
fn atom<const D: usize>(fields: &[&str], column: Option<usize>) -> Result<Point<f64, D>, String> {
    let column = match column {
        Some(column) => column,
        None if fields.len() == D => 0,
        None => symbol(fields[0])?,
    };
    let coordinates = fields.get(column..column.saturating_add(D));
    let coordinates = coordinates.filter(|_| D == 3 || fields.len() <= 1 + D);
    let Some(coordinates) = coordinates else {
        let found = fields.len();
        return Err(format!(
            "{found} columns where a symbol and {D} coordinates are expected"
        ));
    };
    let mut point = Point::origin();
    for axis in 0..D {
        point[axis] = number(coordinates[axis], AXES[axis])?;
    }
    Ok(point)
}

/// One column for a word or an atomic number.
fn symbol(field: &str) -> Result<usize, String> {
    let is_symbol = field.parse::<u32>().is_ok() || field.parse::<f64>().is_err();
    is_symbol
        .then_some(1)
        .ok_or_else(|| format!("`{field}` is no element, and the columns are not just coordinates"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point2, Point3};

    fn sites(text: &str) -> Vec<Point3<f64>> {
        parse(text.as_bytes()).expect("a count").expect("atoms")
    }

    fn fault(text: &str) -> Fault {
        parse::<3>(text.as_bytes()).expect("a count").unwrap_err()
    }

    #[test]
    fn atoms_are_sites_with_symbols_numbers_or_neither() {
        let expected = [Point3::new(0.1, 0.2, 0.3), Point3::new(0.4, 0.5, 1e-3)];
        for text in [
            "2\nwater # 7\nO 0.1 0.2 0.3\nh 0.4 0.5 1e-3\n",
            " 2 \r\n\r\nCl\t.1 0.2 0.3 -1.5 nan\r\n6 0.4 0.5 0.001 x\r\n\r\n",
            "2\rold Mac\r0.1 0.2 0.3\r0.4 0.5 1E-3",
            "2\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3:forces:R:3 pbc=\"T T T\"\nNa 0.1 0.2 0.3 0 0 0\nCL 0.4 0.5 1e-3 0 0 0\n",
            "2\nproperties=\"id:I:1:Z:R:1:pos:R:3\"\n1 2.5 0.1 0.2 0.3\n2 2.5 0.4 0.5 1e-3\n",
        ] {
            assert_eq!(sites(text), expected, "{text}");
        }
        let plane: Vec<Point2<f64>> = parse(b"1\n\nC 0.5 0.25\n").unwrap().unwrap();
        assert_eq!(plane, [Point2::new(0.5, 0.25)]);
        assert!(parse::<2>(b"1\n\nC 0.5 0.25 0.125\n").unwrap().is_err());
    }

    #[test]
    fn what_is_no_atom_is_named_by_line() {
        assert!(parse::<3>(b"0.1 0.2 0.3\n").is_none() && parse::<3>(b"").is_none());
        assert!(
            fault("3\n\nC 0 0 0\nC 0 0 1\n")
                .1
                .starts_with("3 atoms are announced, 2")
        );
        assert!(fault("2").1.starts_with("2 atoms are announced, 0"));
        assert_eq!(fault("1\n\nC 0 0 0\n1\n\nC 0 0 1\n").0, 4);
        assert_eq!(
            fault("1\n\nC 0 nan 0\n").1,
            "y is nan; sites need finite coordinates"
        );
        assert_eq!(fault("1\n\nC 0 0\n").0, 3);
        assert!(fault("1\n\n0.5 0.5 0.5 0.5\n").1.contains("no element"));
        assert_eq!(fault("1\nProperties=species:S:1:pos:R:2\nC 0 0\n").0, 2);
        assert_eq!(fault("1\nProperties=species\nC 0 0 0\n").0, 2);
        assert_eq!(fault("1\nProperties=species:S:1\nC 0 0 0\n").0, 2);
    }
}
