//! What a reader of pictures relies on: labels within the canvas, marked ends, axes, no idle space.

use nalgebra::{Point2, Point3, Vector2};

use crate::energy::planar::visit;
use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::clip::{ClipScratch, clip};
use crate::geometry::half_space::HalfSpace;
use crate::geometry::polygon::ConvexPolygon;
use crate::geometry::polyhedron::Polyhedron;
use crate::geometry::shell::Shell;
use crate::plot::color::{Color, ColorScale};
use crate::plot::convergence::{EnergyAxis, Run, convergence, convergence_of};
use crate::plot::cutaway::{CutawayPicture, Removed};
use crate::plot::exploded::{Fragment, FragmentedCell};
use crate::plot::exploded_lines::exploded_figure;
use crate::plot::figure::{Anchor, Figure, Shape};
use crate::plot::font;
use crate::plot::patches::{Patch, picture};
use crate::plot::planar_fragments::{FlatCell, FlatTriangle, fragments_figure};
use crate::plot::series::{Overlay, RunGroup};
use crate::plot::svg::svg;
use crate::relax::record::Record;

const LABEL: &str = "energy (% of a cube of the cell’s volume)";

/// A log with these energies, each move half as long as the last.
fn log(energies: &[f64]) -> Vec<Record> {
    let records = energies.iter().enumerate();
    let record = |(k, &energy_percent): (usize, &f64)| Record {
        iteration: k as u64,
        energy_mean: 1.0,
        energy_max: 1.0,
        energy_percent,
        movement_mean: 0.0,
        movement_max: 0.0,
        movement_percent: if k == 0 {
            0.0
        } else {
            10.0 * 0.5_f64.powi(k as i32)
        },
        evaluations: 1.0,
        seconds: 0.0,
        energy_reference: None,
        stage: Default::default(),
    };
    records.map(record).collect()
}

fn texts(figure: &Figure) -> Vec<&str> {
    let texts = figure.shapes.iter().filter_map(|shape| match shape {
        Shape::Text(text) => Some(text.content.as_str()),
        _ => None,
    });
    texts.collect()
}

/// All places of texts and shapes.
fn extents(figure: &Figure) -> Vec<(String, Bounds<2>)> {
    let places = figure.shapes.iter().map(|shape| match shape {
        Shape::Path { contours, .. } => ("path".to_owned(), Bounds::of(contours.iter().flatten())),
        Shape::Disc { center, radius, .. } => {
            let arm = Vector2::repeat(*radius);
            (
                "disc".to_owned(),
                Bounds::from_corners(center - arm, center + arm),
            )
        }
        Shape::Text(text) => {
            let length = font::width(&text.content, text.size);
            let before = match text.anchor {
                Anchor::Start => 0.0,
                Anchor::Middle => 0.5 * length,
                Anchor::End => length,
            };
            let along = [-before, length - before];
            // Ascenders and descenders of DejaVu Sans.
            let across = [-0.78 * text.size, 0.24 * text.size];
            let corners = [0, 1].map(|k| {
                let arm = if text.upward {
                    Vector2::new(across[k], -along[k])
                } else {
                    Vector2::new(along[k], across[k])
                };
                text.position + arm
            });
            (text.content.clone(), Bounds::of(&corners))
        }
    });
    places.collect()
}

fn assert_on_canvas(figure: &Figure) {
    let canvas = Bounds::from_corners([0.0; 2], [figure.width, figure.height]);
    for (name, bounds) in extents(figure) {
        let is_inside = canvas.contains(&bounds.min) && canvas.contains(&bounds.max);
        assert!(is_inside, "`{name}` at {bounds:?} leaves {canvas:?}");
    }
}

/// Squares in `columns` and `rows`, of values 100, 101, …
fn squares(columns: u32, rows: u32) -> Vec<Patch> {
    let square = |k: u32| {
        let corner = Point2::new(f64::from(k % columns), f64::from(k / columns));
        let bounds = Bounds::from_corners(corner, corner + Vector2::repeat(1.0));
        Patch {
            contours: vec![
                ConvexPolygon::rectangle(&bounds, [0; 4])
                    .vertices()
                    .to_vec(),
            ],
            rims: None,
            value: 100.0 + f64::from(k),
            site: None,
        }
    };
    (0..columns * rows).map(square).collect()
}

fn scale(min: f64, max: f64) -> ColorScale {
    ColorScale {
        label: LABEL.to_owned(),
        min,
        max,
    }
}

fn drawn(columns: u32, rows: u32, scale: &ColorScale) -> Figure {
    let names = ["x", "y"].map(str::to_owned);
    picture(
        &squares(columns, rows),
        scale,
        "Cells cut at z = 0.5250",
        &names,
    )
}

#[test]
fn labels_are_whole_and_lie_within_the_canvas() {
    for (columns, rows) in [(8, 2), (40, 1), (2, 9), (1, 60), (5, 5), (7, 3)] {
        let figure = drawn(columns, rows, &scale(100.0, 140.0));
        assert_on_canvas(&figure);
        let words = texts(&figure).join(" ");
        assert!(!words.contains('…'), "{columns} by {rows}: {words}");
        for word in LABEL.split(' ') {
            assert!(words.contains(word), "{columns} by {rows} lacks {word}");
        }
    }
}

#[test]
fn curves_and_fragments_lie_within_the_canvas() {
    let records = log(&[126.0, 113.0, 105.0, 102.5]);
    let long = "a-folder/with-a-name/that-is-much-longer-than-any-legend-could-ever-hold";
    let runs = [long, "short", long].map(|name| Run {
        name,
        records: &records,
    });
    for count in 1..=3 {
        let figure = convergence(&runs[..count]);
        assert_on_canvas(&figure);
    }
    assert_on_canvas(&fragments_figure(&flat_cell()));
    assert_on_canvas(&exploded_figure(&fragmented_cell()));
}

/// Triangles with a rim of three corners beside the bar.
fn arrows(figure: &Figure) -> usize {
    let is_arrow = |shape: &&Shape| {
        matches!(shape, Shape::Path { contours, fill: Some(_), stroke: Some(_), .. }
            if contours.len() == 1 && contours[0].len() == 3)
    };
    figure.shapes.iter().filter(is_arrow).count()
}

#[test]
fn clipped_color_bars_end_in_arrows_on_the_side_that_is_clipped() {
    for (columns, rows) in [(4, 4), (16, 1)] {
        // Values are 100 to 115.
        for (ends, count) in [
            ([100.0, 115.0], 0),
            ([101.0, 115.0], 1),
            ([100.0, 110.0], 1),
            ([101.0, 110.0], 2),
        ] {
            let figure = drawn(columns, rows, &scale(ends[0], ends[1]));
            assert_eq!(arrows(&figure), count, "{columns} by {rows}, {ends:?}");
            assert_on_canvas(&figure);
        }
    }
}

#[test]
fn flat_pictures_have_axes_with_names_and_ticks_of_one_scale() {
    let figure = drawn(8, 4, &scale(100.0, 140.0));
    let texts = texts(&figure);
    for text in ["x", "y", "0", "2", "4", "6", "8"] {
        assert!(texts.contains(&text), "{text} is missing in {texts:?}");
    }
}

/// The part of the canvas that the picture proper fills.
fn filled(figure: &Figure) -> f64 {
    let cells = figure.shapes.iter().take(4);
    let contours = cells.filter_map(|shape| match shape {
        Shape::Path { contours, .. } => Some(contours.iter().flatten()),
        _ => None,
    });
    let bounds = Bounds::of(contours.flatten());
    bounds.volume() / (figure.width * figure.height)
}

#[test]
fn flat_canvases_are_filled() {
    for (columns, rows, least) in [(2, 2, 0.58), (4, 1, 0.38), (1, 4, 0.33)] {
        let figure = drawn(columns, rows, &scale(100.0, 104.0));
        assert!(
            filled(&figure) > least,
            "{columns} by {rows}: {}",
            filled(&figure)
        );
    }
}

#[test]
fn cutaway_canvases_have_the_shape_of_what_they_show() {
    let bounds = Bounds::from_corners([0.0; 3], [6.0, 1.0, 1.0]);
    let title = Removed::Half.title();
    let picture = CutawayPicture::new(&bounds, Removed::Half, scale(0.0, 1.0), title);
    let bytes = picture.expect("pixels").finish().expect("a picture");
    let sheet = tiny_skia::Pixmap::decode_png(&bytes).expect("it decodes");
    let ratio = f64::from(sheet.width()) / f64::from(sheet.height());
    assert!((1.3..3.0).contains(&ratio), "{ratio}");
}

#[test]
fn one_curve_has_no_legend_and_its_canvas_ends_below_the_axis() {
    let records = log(&[126.0, 113.0, 105.0, 102.5]);
    let run = Run {
        name: "a name for the legend",
        records: &records,
    };
    let alone = convergence(&[run]);
    assert!(!texts(&alone).contains(&run.name));
    let both = convergence(&[run, run]);
    assert_eq!(
        texts(&both)
            .iter()
            .filter(|text| **text == run.name)
            .count(),
        2
    );
    assert!(alone.height < both.height);
}

/// The curve of the right panel.
fn energy_curve(figure: &Figure) -> Vec<Point2<f64>> {
    let mut curves = figure.shapes.iter().filter_map(|shape| match shape {
        Shape::Path {
            contours,
            closed: false,
            stroke: Some(stroke),
            ..
        } if stroke.color == Color::hex(0x00_72_b2) => Some(contours[0].clone()),
        _ => None,
    });
    curves.next_back().expect("a curve")
}

#[test]
fn the_energy_axis_is_spent_where_the_curve_is() {
    let fall = |to: f64| -> Vec<f64> {
        let share = |k: i32| 0.8_f64.powi(k);
        (0..50).map(|k| to + (126.0 - to) * share(k)).collect()
    };
    for (energies, middle) in [(fall(102.5), 0.03), (fall(100.0), 0.3), (fall(125.0), 0.0)] {
        let records = log(&energies);
        let curve = energy_curve(&convergence(&[Run {
            name: "",
            records: &records,
        }]));
        // The frame is from 36 to 330.
        let share = |point: &Point2<f64>| (330.0 - point.y) / 294.0;
        let bounds = Bounds::of(&curve);
        assert!((bounds.max.y - bounds.min.y) / 294.0 > 0.8, "{bounds:?}");
        let at_middle = share(&curve[curve.len() / 2]);
        assert!(at_middle > middle, "{at_middle}");
    }
}

#[test]
fn a_range_on_request_holds_and_clips() {
    let records = log(&[126.0, 113.0, 105.0, 102.5, 101.0]);
    let group = RunGroup {
        name: "run".to_owned(),
        logs: vec![&records],
    };
    let axis = EnergyAxis {
        range: Some([102.0, 110.0]),
        is_linear: false,
    };
    let figure = convergence_of(&[group], &[], axis);
    let bounds = Bounds::of(&energy_curve(&figure));
    assert!((bounds.min.y - 36.0).abs() < 1e-9 && (bounds.max.y - 330.0).abs() < 1e-9);
    let texts = texts(&figure);
    assert!(texts.contains(&"102") && texts.contains(&"110") && !texts.contains(&"112"));
}

#[test]
fn several_seeds_become_a_mean_within_a_band() {
    let logs = [[120.0, 110.0, 104.0], [130.0, 112.0, 106.0]].map(|energies| log(&energies));
    let short = log(&[125.0, 105.0]);
    let group = RunGroup {
        name: "runs".to_owned(),
        logs: vec![&logs[0], &logs[1], &short],
    };
    let energy = group.energy();
    assert_eq!(energy.mean, [(0.0, 125.0), (1.0, 109.0), (2.0, 105.0)]);
    let [low, high] = energy.extremes.clone().expect("several runs");
    assert_eq!(low, [(0.0, 120.0), (1.0, 105.0), (2.0, 104.0)]);
    assert_eq!(high, [(0.0, 130.0), (1.0, 112.0), (2.0, 106.0)]);
    // The run that has ended moves no more and does not count.
    assert_eq!(group.movement().mean, [(1.0, 5.0), (2.0, 2.5)]);
    let figure = convergence_of(&[group], &[], EnergyAxis::default());
    let is_band = |shape: &&Shape| {
        let pale = Color::hex(0x00_72_b2).mix(Color::WHITE, 0.72);
        matches!(shape, Shape::Path { fill: Some(fill), stroke: None, .. } if *fill == pale)
    };
    assert_eq!(figure.shapes.iter().filter(is_band).count(), 2);
    assert_on_canvas(&figure);
}

#[test]
fn overlays_are_circles_up_to_the_last_iteration() {
    let records = log(&[126.0, 113.0, 105.0, 102.5]);
    let group = RunGroup {
        name: "run".to_owned(),
        logs: vec![&records],
    };
    let overlay = Overlay {
        name: "reference".to_owned(),
        movement: vec![(1.0, 12.8), (50.0, 0.3)],
        energy: vec![(0.0, 126.4), (1.0, 113.0), (3.0, 102.5), (400.0, 101.0)],
    };
    let figure = convergence_of(&[group], &[overlay], EnergyAxis::default());
    let is_circle =
        |shape: &&Shape| matches!(shape, Shape::Path { contours, .. } if contours[0].len() == 24);
    // One of them in the legend.
    assert_eq!(figure.shapes.iter().filter(is_circle).count(), 5);
    assert!(texts(&figure).contains(&"reference"));
    assert_on_canvas(&figure);
}

fn flat_cell() -> FlatCell {
    let corners = [[-0.4, -0.5], [0.6, -0.4], [0.5, 0.5], [-0.3, 0.4]].map(Point2::from);
    let polygon = ConvexPolygon::from_corners(corners, [0; 4]);
    let mut triangles = Vec::new();
    visit(&polygon, &Point2::origin(), |triangle| {
        triangles.push(FlatTriangle {
            axis: triangle.axis,
            sign: triangle.sign,
            ends: [triangle.start, triangle.end],
        });
    });
    FlatCell {
        caption: "site 0: energy 1.234567e-1".to_owned(),
        sum: "the sum over 8 triangles".to_owned(),
        area: polygon.area(),
        pieces: vec![polygon],
        triangles,
    }
}

#[test]
fn a_cell_of_the_plane_stands_beside_its_four_fragments() {
    let cell = flat_cell();
    let areas = cell
        .triangles
        .iter()
        .map(|it| 0.5 * it.ends[0].perp(&it.ends[1]));
    assert!((areas.sum::<f64>() - cell.area).abs() < 1e-15);
    for (axis, sign) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let is_of = |it: &&FlatTriangle| it.axis == axis && it.sign * sign > 0.0;
        assert!(cell.triangles.iter().any(|it| is_of(&it)));
    }
    let figure = fragments_figure(&cell);
    let words = texts(&figure).join("\n");
    for text in [
        "The cell and its distances",
        "Its four fragments",
        "square of its area",
    ] {
        assert!(words.contains(text), "{text}");
    }
    // Every triangle has a rim, and the square is dashed.
    let is_rim = |shape: &&Shape| {
        matches!(shape, Shape::Path { contours, fill: None, stroke: Some(stroke), closed: true }
            if contours[0].len() == 3 && stroke.dash.is_none())
    };
    assert_eq!(
        figure.shapes.iter().filter(is_rim).count(),
        cell.triangles.len()
    );
    let document = svg(&figure);
    assert!(document.contains("stroke-dasharray") && document.len() < 400_000);
}

fn fragmented_cell() -> FragmentedCell {
    let around = Bounds::from_corners([-0.5; 3], [0.5; 3]);
    let cube = Polyhedron::cuboid(&around, [0; 6]);
    let fragment = |number: usize| {
        let (axis, positive) = (number / 2, number % 2 == 1);
        let mut polyhedron = cube.clone();
        let mut scratch = ClipScratch::default();
        for side in 0..4 {
            let mut normal = nalgebra::Vector3::zeros();
            normal[axis] = if positive { -1.0 } else { 1.0 };
            normal[(axis + 1 + side / 2) % 3] = if side % 2 == 0 { 1.0 } else { -1.0 };
            let plane = HalfSpace {
                normal,
                offset: 0.0,
            };
            clip(&mut polyhedron, &plane, 0, &mut scratch);
        }
        let shell = Shell::from(Piece::Convex(&polyhedron));
        Fragment {
            axis,
            positive,
            shell,
        }
    };
    FragmentedCell {
        caption: "Fragments of the cell of site 0".to_owned(),
        center: Point3::origin(),
        fragments: (0..6).map(fragment).collect(),
    }
}

#[test]
fn a_cell_in_space_is_taken_apart_as_polygons() {
    let figure = exploded_figure(&fragmented_cell());
    let document = svg(&figure);
    for text in [">x<", ">y<", ">z<", ">Fragments of the cell of site 0<"] {
        assert!(document.contains(text), "{text}");
    }
    // Pyramids: of each one the base or some of its four sides face the viewer.
    let is_rim = |shape: &&Shape| {
        matches!(
            shape,
            Shape::Path {
                fill: None,
                stroke: Some(_),
                closed: true,
                ..
            }
        )
    };
    let rims = figure.shapes.iter().filter(is_rim).count();
    assert!((9..=21).contains(&rims), "{rims}");
    assert!(document.len() < 200_000, "{}", document.len());
}
