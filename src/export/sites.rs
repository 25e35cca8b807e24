//! Sites as comma-separated text.

use std::io::{self, Write};

use nalgebra::Point;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Writes a header and one site per line in site order, every coordinate as the shortest decimal
/// that reads back to the same number.
///
/// # Errors
/// What `file` says.
pub fn write_csv<const D: usize>(sites: &[Point<f64, D>], file: &mut impl Write) -> io::Result<()> {
    write_csv_header::<D>(file)?;
    write_csv_rows(sites, file)
}

/// The first line.
pub(crate) fn write_csv_header<const D: usize>(file: &mut impl Write) -> io::Result<()> {
    writeln!(file, "{}", AXES[..D].join(","))
}

/// The lines of some sites.
pub(crate) fn write_csv_rows<const D: usize>(
    sites: &[Point<f64, D>],
    file: &mut impl Write,
) -> io::Result<()> {
    for site in sites {
        for (axis, value) in site.iter().enumerate() {
            let comma = if axis == 0 { "" } else { "," };
            write!(file, "{comma}{value:?}")?;
        }
        writeln!(file)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_read_back_to_the_bit(bits in prop::array::uniform3(any::<u64>())) {
            let site = bits.map(f64::from_bits);
            prop_assume!(site.iter().all(|value| value.is_finite()));
            let mut text = Vec::new();
            write_csv(&[Point::from(site)], &mut text).expect("memory takes all");
            let text = String::from_utf8(text).expect("numbers are text");
            let (header, row) = text.trim_end().split_once('\n').expect("two lines");
            prop_assert_eq!(header, "x,y,z");
            let again: Vec<u64> = row
                .split(',')
                .map(|number| number.parse::<f64>().expect("a number").to_bits())
                .collect();
            prop_assert_eq!(again, bits);
        }
    }

    #[test]
    fn the_plane_has_two_columns() {
        let mut text = Vec::new();
        write_csv(&[Point::from([0.5, 1e-7])], &mut text).expect("memory takes all");
        assert_eq!(text, b"x,y\n0.5,1e-7\n");
    }
}
