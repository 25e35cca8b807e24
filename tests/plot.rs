//! What pictures must hold: well-formed files that show everything, whatever the data.

use chebloyd::plot::convergence::{Run, convergence};
use chebloyd::plot::png::png;
use chebloyd::plot::svg::svg;
use chebloyd::relax::record::Record;

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
    let long = "a-folder-with-a-name-that-nobody-wants-to-read/".repeat(20);
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
