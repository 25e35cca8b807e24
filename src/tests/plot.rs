//! Pictures: well-formed files that contain every element, for any data.

use crate::geometry::bounds::Bounds;
use crate::geometry::brep::Piece;
use crate::geometry::half_space::HalfSpace;
use crate::geometry::section::section;
use crate::geometry::shell::Shell;
use crate::plot::color::ColorScale;
use crate::plot::convergence::{Run, convergence};
use crate::plot::cutaway::{CutawayPicture, Removed};
use crate::plot::exploded::{Fragment, FragmentedCell, exploded};
use crate::plot::patches::{Patch, PlaneCut, picture};
use crate::plot::png::png;
use crate::plot::svg::svg;
use crate::relax::record::Record;
use crate::tests::sites::{cell, grid_sites, random_sites};
use nalgebra::{Point2, Point3, Vector3};

/// A made-up run whose movement falls from 12.8 % and energy from 126.4 % to `floor`.
fn run(count: u64, floor: f64) -> Vec<Record> {
    let share = |k: u64| 1.0 / (1.0 + k as f64).powf(1.5);
    (0..count)
        .map(|k| Record {
            iteration: k,
            energy_mean: 1.0,
            energy_max: 2.0,
            energy_percent: floor + (126.4 - floor) * share(k),
            movement_mean: 0.0,
            movement_max: 0.0,
            movement_percent: if k == 0 { 0.0 } else { 36.0 * share(k) },
            evaluations: 1.0,
            seconds: 0.0,
            energy_reference: None,
            stage: Default::default(),
        })
        .collect()
}

/// The document's tag names in order, after checking that tags nest and attributes are quoted.
fn tags(document: &str) -> Vec<String> {
    let mut open = Vec::new();
    let mut all = Vec::new();
    for chunk in document.split('<').skip(1) {
        let (tag, text) = chunk.split_once('>').expect("every tag ends");
        assert!(!text.contains('&') || text.contains(';'), "raw & in {text}");
        assert_eq!(
            tag.matches('"').count() % 2,
            0,
            "unbalanced quotes in {tag}"
        );
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
        } else {
            let name = tag.split([' ', '/']).next().expect("a name").to_owned();
            all.push(name.clone());
            if !tag.ends_with('/') {
                open.push(name);
            }
        }
    }
    assert!(open.is_empty(), "unclosed {open:?}");
    all
}

/// Width and height of a PNG that decodes without error.
fn decoded_size(bytes: &[u8]) -> (u32, u32) {
    assert_eq!(&bytes[..8], b"\x89PNG\r\n\x1a\n");
    let sheet = tiny_skia::Pixmap::decode_png(bytes).expect("the picture decodes");
    (sheet.width(), sheet.height())
}

#[test]
fn a_convergence_figure_has_both_panels_and_every_run() {
    let (linf, l2) = (run(51, 102.5), run(51, 104.4));
    let runs = [("linf", &linf), ("l2 <control> & more", &l2)];
    let runs = runs.map(|(name, records)| Run { name, records });
    let document = svg(&convergence(&runs));
    assert_eq!(tags(&document)[0], "svg");
    for text in [
        "Movement",
        "Energy",
        "iteration",
        "linf",
        "l2 &lt;control&gt; &amp; more",
    ] {
        assert!(document.contains(&format!(">{text}<")), "{text} is missing");
    }
    // One curve in each panel, and each color again in the legend.
    for color in ["#0072b2", "#d55e00"] {
        assert_eq!(document.matches(color).count(), 3, "{color}");
    }
}

#[test]
fn a_convergence_figure_as_png_decodes() {
    let records = run(51, 102.5);
    let figure = convergence(&[Run {
        name: "linf",
        records: &records,
    }]);
    let bytes = png(&figure, 2.0).expect("encodes");
    let expected = [figure.width, figure.height].map(|length| (2.0 * length).ceil() as u32);
    assert_eq!(decoded_size(&bytes), (expected[0], expected[1]));
}

#[test]
fn odd_logs_still_give_a_figure() {
    let single = run(1, 102.5);
    let mut still = run(20, 100.0);
    still.iter_mut().for_each(|record| {
        record.energy_percent = 100.0;
        record.movement_percent = 0.0;
    });
    let mut broken = run(5, 101.0);
    broken[2].energy_percent = f64::NAN;
    broken[3].movement_percent = f64::INFINITY;
    let mut vanishing = run(400, 100.0);
    for record in &mut vanishing {
        record.movement_percent *= 0.5_f64.powi(record.iteration as i32);
    }
    let many = vec![
        Run {
            name: "many",
            records: &vanishing
        };
        40
    ];
    let long = "a-folder-with-a-name-that-no-one-wants-to-read/".repeat(20);
    for runs in [
        vec![],
        vec![Run {
            name: "empty",
            records: &[],
        }],
        vec![Run {
            name: "single",
            records: &single,
        }],
        vec![Run {
            name: &long,
            records: &still,
        }],
        vec![Run {
            name: "",
            records: &broken,
        }],
        many,
    ] {
        let figure = convergence(&runs);
        let document = svg(&figure);
        tags(&document);
        assert!(!document.contains("NaN"));
        assert!(!document.contains(&long));
        decoded_size(&png(&figure, 1.0).expect("encodes"));
    }
}

#[test]
fn a_long_log_stays_a_small_picture() {
    let records = run(200_000, 102.5);
    let document = svg(&convergence(&[Run {
        name: "long",
        records: &records,
    }]));
    assert!(document.len() < 100_000, "{} bytes", document.len());
}

#[test]
fn a_picture_without_pixels_is_refused() {
    let figure = convergence(&[]);
    assert!(png(&figure, 0.0).is_err());
    assert!(png(&figure, 1e9).is_err());
    assert!(png(&figure, f64::NAN).is_err());
}

fn shells(sites: &[Point3<f64>]) -> Vec<Shell> {
    let numbers = 0..sites.len();
    numbers
        .map(|site| Shell::from(Piece::Convex(&cell(sites, site))))
        .collect()
}

/// Signed area in the plane of `normal`, positive for loops counter-clockwise about it.
fn area(contour: &[Point3<f64>], normal: &Vector3<f64>) -> f64 {
    let pairs = contour.iter().zip(contour.iter().cycle().skip(1));
    let sum: Vector3<f64> = pairs.map(|(a, b)| a.coords.cross(&b.coords)).sum();
    0.5 * sum.dot(&normal.normalize())
}

fn section_area(cells: &[Shell], plane: &HalfSpace) -> f64 {
    let contours = cells.iter().flat_map(|shell| section(shell, plane));
    contours.map(|contour| area(&contour, &plane.normal)).sum()
}

#[test]
fn sections_of_a_diagram_fill_the_section_of_the_cube() {
    // On the lattice these planes run through facets, edges and vertices.
    for cells in [
        shells(&grid_sites(4)),
        shells(&grid_sites(3)),
        shells(&random_sites(200, 5)),
    ] {
        for height in [0.1, 0.25, 1.0 / 3.0, 0.5, 2.0 / 3.0, 0.75, 1.0] {
            for axis in 0..3 {
                let mut normal = Vector3::zeros();
                normal[axis] = 2.0;
                let plane = HalfSpace {
                    normal,
                    offset: 2.0 * height,
                };
                let area = section_area(&cells, &plane);
                assert!(
                    (area - 1.0).abs() < 1e-12,
                    "axis {axis} at {height}: {area}"
                );
            }
        }
        // The plane x = y through two edges of the cube, and the hexagon x + y + z = 3/2.
        let normal = Vector3::new(1.0, -1.0, 0.0);
        let diagonal = section_area(
            &cells,
            &HalfSpace {
                normal,
                offset: 0.0,
            },
        );
        assert!((diagonal - 2.0_f64.sqrt()).abs() < 1e-12, "{diagonal}");
        let normal = Vector3::new(1.0, 1.0, 1.0);
        let hexagon = section_area(
            &cells,
            &HalfSpace {
                normal,
                offset: 1.5,
            },
        );
        assert!((hexagon - 0.75 * 3.0_f64.sqrt()).abs() < 1e-12, "{hexagon}");
    }
}

#[test]
fn a_plane_beside_a_cell_cuts_nothing() {
    let cube = Shell::from(Piece::Convex(&cell(&grid_sites(1), 0)));
    let across = |offset| HalfSpace {
        normal: Vector3::z(),
        offset,
    };
    assert!(section(&cube, &across(1.1)).is_empty());
    assert!(section(&cube, &across(-0.1)).is_empty());
    // Touched from above only: the facet counts for the cell below the plane.
    assert!(section(&cube, &across(0.0)).is_empty());
    let nowhere = HalfSpace {
        normal: Vector3::zeros(),
        offset: 0.0,
    };
    assert!(section(&cube, &nowhere).is_empty());
}

#[test]
fn a_cell_that_is_not_convex_has_several_contours() {
    // A U-shaped prism: two towers on a base, front and back facet not convex.
    let front = [
        [0., 0.],
        [3., 0.],
        [3., 2.],
        [2., 2.],
        [2., 1.],
        [1., 1.],
        [1., 2.],
        [0., 2.],
    ];
    let vertices: Vec<Point3<f64>> = [0.0, 1.0]
        .iter()
        .flat_map(|y| front.map(|[x, z]| Point3::new(x, *y, z)))
        .collect();
    let sides = (0..8).map(|k| vec![(k + 1) % 8, k, k + 8, (k + 1) % 8 + 8]);
    let ends = [(0..8).collect::<Vec<u32>>(), (8..16).rev().collect()];
    let shell = Shell::new(&vertices, sides.chain(ends)).expect("valid numbers");
    assert!((shell.volume() - 5.0).abs() < 1e-14);
    let plane = HalfSpace {
        normal: Vector3::z(),
        offset: 1.5,
    };
    let contours = section(&shell, &plane);
    assert_eq!(contours.len(), 2);
    for contour in contours {
        assert!((area(&contour, &plane.normal) - 1.0).abs() < 1e-14);
    }
}

fn names() -> [String; 2] {
    ["x", "y"].map(str::to_owned)
}

fn scale() -> ColorScale {
    ColorScale::fitting("energy (%)", [100.0, 110.0])
}

#[test]
fn a_cut_is_a_picture_of_its_cells() {
    let cells = shells(&grid_sites(4));
    let cut = PlaneCut::horizontal(0.6);
    let patches: Vec<Patch> = cells
        .iter()
        .filter_map(|shell| cut.patch(shell, 104.0))
        .collect();
    assert_eq!(patches.len(), 16);
    let figure = picture(&patches, &scale(), "Cut z = 0.6", &names());
    let document = svg(&figure);
    tags(&document);
    let fill = format!("fill=\"#{}\" stroke", hex(scale().color(104.0).rgb));
    assert_eq!(document.matches(&fill).count(), 16);
    assert!(document.contains(">Cut z = 0.6<") && document.contains(">energy (%)<"));
    decoded_size(&png(&figure, 1.0).expect("encodes"));
}

fn hex(rgb: [u8; 3]) -> String {
    rgb.iter().map(|part| format!("{part:02x}")).collect()
}

#[test]
fn ten_thousand_cells_of_the_plane_are_a_small_picture() {
    let corner = |k: usize| Point2::new((k % 100) as f64, (k / 100) as f64);
    let hexagon = [
        [0.3, 0.0],
        [0.97, 0.1],
        [1.13, 0.6],
        [0.7, 1.0],
        [0.03, 0.9],
        [-0.13, 0.4],
    ];
    let patches: Vec<Patch> = (0..10_000)
        .map(|k| Patch {
            rims: None,
            contours: vec![
                hexagon
                    .map(|[x, y]| corner(k) + nalgebra::Vector2::new(x, y))
                    .to_vec(),
            ],
            value: 100.0 + (k % 17) as f64,
            site: Some(corner(k) + nalgebra::Vector2::new(0.5, 0.5)),
        })
        .collect();
    let document = svg(&picture(&patches, &scale(), "plane", &names()));
    assert!(document.len() < 3_000_000, "{} bytes", document.len());
    assert_eq!(document.matches("<circle").count(), 10_000);
}

#[test]
fn odd_patches_still_give_a_picture() {
    let point = Patch {
        rims: None,
        contours: vec![vec![Point2::new(1.0, 1.0); 3]],
        value: f64::NAN,
        site: None,
    };
    for patches in [vec![], vec![point]] {
        let figure = picture(&patches, &scale(), "", &names());
        tags(&svg(&figure));
        decoded_size(&png(&figure, 1.0).expect("encodes"));
    }
}

/// The share of pixels that are not white.
fn inked(bytes: &[u8]) -> f64 {
    let sheet = tiny_skia::Pixmap::decode_png(bytes).expect("the picture decodes");
    let white = |pixel: &tiny_skia::PremultipliedColorU8| {
        pixel.red() == 255 && pixel.green() == 255 && pixel.blue() == 255
    };
    let pixels = sheet.pixels();
    pixels.iter().filter(|pixel| !white(pixel)).count() as f64 / pixels.len() as f64
}

#[test]
fn a_cutaway_hides_what_it_removes() {
    let sites = grid_sites(4);
    let cells = shells(&sites);
    let unit = Bounds {
        min: Point3::origin(),
        max: Point3::new(1.0, 1.0, 1.0),
    };
    let shown = |removed: Removed| {
        let mut view = CutawayPicture::new(&unit, removed, scale(), "64 cells").expect("a size");
        let count = sites.iter().filter(|site| view.shows(site)).count();
        for (site, shell) in sites.iter().zip(&cells) {
            view.push(shell, site, 104.0);
        }
        (count, inked(&view.finish().expect("encodes")))
    };
    let [octant, half] = [Removed::Octant, Removed::Half].map(shown);
    assert_eq!([octant.0, half.0], [56, 32]);
    // The octant's hole lies inside the cube's outline, the removed half does not.
    assert!(half.1 < 0.8 * octant.1, "{octant:?} {half:?}");
}

#[test]
fn an_exploded_cell_shows_all_its_fragments() {
    // The pyramids over the facets of a cube.
    let cube = Shell::from(Piece::Convex(&cell(&grid_sites(1), 0)));
    let center = Point3::new(0.5, 0.5, 0.5);
    let fragments = cube.loops().map(|facet| {
        let base: Vec<Point3<f64>> = facet.collect();
        let middle = base
            .iter()
            .map(|corner| corner - center)
            .sum::<Vector3<f64>>()
            / 4.0;
        let mut vertices = base;
        vertices.push(center);
        let sides = (0..4).map(|k| vec![(k + 1) % 4, k, 4]);
        let facets = sides.chain([vec![0, 1, 2, 3]]);
        Fragment {
            axis: middle.iamax(),
            positive: middle.sum() > 0.0,
            shell: Shell::new(&vertices, facets).expect("valid numbers"),
        }
    });
    let cell = FragmentedCell {
        caption: "cube".into(),
        center,
        fragments: fragments.collect(),
    };
    assert!(
        cell.fragments
            .iter()
            .all(|f| (f.shell.volume() - 1.0 / 6.0).abs() < 1e-15)
    );
    let one = exploded(std::slice::from_ref(&cell)).expect("encodes");
    let two = exploded(&[cell.clone(), cell]).expect("encodes");
    assert!(decoded_size(&two).0 > decoded_size(&one).0);
    assert!(inked(&one) > 0.3);
    assert!(exploded(&[]).is_err());
}
