//! The page: one text of HTML with style, program and data in it.

use std::io::{self, Write};

use serde_json::{Value, json};

use crate::plot::camera::TOWARD;
use crate::plot::color::{Color, TOO_DARK, viridis};
use crate::plot::convergence::COLORS;
use crate::report::run::ReportedRun;

const PAGE: &str = include_str!("page/page.html");
const STYLE: &str = include_str!("page/style.css");

/// The program, in the order in which its parts build on each other.
const PROGRAM: [&str; 14] = [
    include_str!("page/base.js"),
    include_str!("page/inflate.js"),
    include_str!("page/unpack.js"),
    include_str!("page/color.js"),
    include_str!("page/triangulate.js"),
    include_str!("page/surface.js"),
    include_str!("page/camera.js"),
    include_str!("page/space.js"),
    include_str!("page/plane.js"),
    include_str!("page/bar.js"),
    include_str!("page/viewer.js"),
    include_str!("page/curves.js"),
    include_str!("page/figures.js"),
    include_str!("page/main.js"),
];

/// How many colors of a palette are in the page, from one end to the other.
const STOPS: u32 = 17;

/// Writes the page of `runs` under `title`.
///
/// # Errors
/// Those of `file`.
pub(crate) fn write(file: &mut impl Write, title: &str, runs: &[ReportedRun]) -> io::Result<()> {
    let mut rest = PAGE;
    for part in ["title", "style", "heading", "data", "program"] {
        let mark = format!("{{{{{part}}}}}");
        let (before, after) = rest.split_once(&mark).unwrap_or((rest, ""));
        file.write_all(before.as_bytes())?;
        match part {
            "title" | "heading" => file.write_all(escaped(title).as_bytes())?,
            "style" => file.write_all(STYLE.as_bytes())?,
            "data" => write_data(file, title, runs)?,
            _ => PROGRAM
                .iter()
                .try_for_each(|part| file.write_all(part.as_bytes()))?,
        }
        rest = after;
    }
    file.write_all(rest.as_bytes())
}

/// The data as JSON, and the numbers of cells.
fn write_data(file: &mut impl Write, title: &str, runs: &[ReportedRun]) -> io::Result<()> {
    // No text in the data can end the element.
    let data = data(title, runs).to_string().replace('<', "\\u003c");
    writeln!(
        file,
        "<script type=\"application/json\" id=\"data\">{data}</script>"
    )?;
    let cells = runs.iter().map(|run| run.cells.as_ref()).enumerate();
    for (number, cells) in cells.filter_map(|(number, cells)| Some((number, cells?))) {
        let numbers = &cells.numbers;
        writeln!(
            file,
            "<script type=\"text/plain\" id=\"cells-{number}\">{numbers}</script>"
        )?;
    }
    Ok(())
}

fn data(title: &str, runs: &[ReportedRun]) -> Value {
    let stops = (0..STOPS).map(|stop| viridis(f64::from(stop) / f64::from(STOPS - 1)));
    json!({
        "program": env!("CARGO_PKG_NAME"),
        "version": env!("CARGO_PKG_VERSION"),
        "title": title,
        "palette": { "stops": stops.map(web).collect::<Vec<_>>(), "dark": TOO_DARK },
        "curves": COLORS.map(web),
        "toward": TOWARD.as_slice(),
        "runs": runs.iter().map(ReportedRun::to_json).collect::<Vec<_>>(),
    })
}

fn web(color: Color) -> String {
    let [red, green, blue] = color.rgb;
    format!("#{red:02x}{green:02x}{blue:02x}")
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}
