//! Written files: an independent reader gets back the values written.

use std::collections::BTreeMap;
use std::fs;

use crate::export::run::log::{LogError, read_log};
use crate::export::vtu::{CellGeometry, VtuWriter, write_cells};
use crate::geometry::brep::Piece;
use crate::geometry::shell::Shell;
use crate::tests::sites::{cell, grid_sites, random_sites};
use nalgebra::{Point2, Point3};

const LINE: &str = r#"{"iteration":0,"energy_mean":1.0,"energy_max":2.0,"energy_percent":126.4,"movement_mean":0.0,"movement_max":0.0,"movement_percent":0.0,"evaluations":1.0,"seconds":0.1,"temperature":0.5}"#;

/// A folder with one file `log.jsonl` of this content.
fn log(content: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("log.jsonl"), content).expect("written");
    folder
}

#[test]
fn a_log_reads_back_without_its_torn_last_line() {
    let whole = log(&format!("{LINE}\n{LINE}\n\n{LINE}"));
    let records = read_log(&whole.path().join("log.jsonl")).expect("reads");
    assert_eq!(records.len(), 3);
    assert!((records[2].energy_percent - 126.4).abs() < 1e-15);
    let torn = log(&format!("{LINE}\n{}", &LINE[..LINE.len() / 2]));
    assert_eq!(
        read_log(&torn.path().join("log.jsonl"))
            .expect("reads")
            .len(),
        1
    );
    let empty = log("");
    assert!(
        read_log(&empty.path().join("log.jsonl"))
            .expect("reads")
            .is_empty()
    );
}

#[test]
fn a_bad_line_is_named() {
    let folder = log(&format!("{LINE}\n{{\"iteration\": 1}}\n{LINE}\n"));
    let path = folder.path().join("log.jsonl");
    let error = read_log(&path).expect_err("refused");
    assert!(matches!(error, LogError::Line { line: 2, .. }));
    let message = error.to_string();
    assert!(
        message.contains("log.jsonl, line 2") && message.contains("energy_mean"),
        "{message}"
    );
    let message = read_log(&folder.path().join("none"))
        .expect_err("refused")
        .to_string();
    assert!(message.contains("none"), "{message}");
}

fn geometry(site: usize, shell: Shell) -> CellGeometry {
    CellGeometry {
        site,
        volume: shell.volume(),
        facet_count: shell.facet_count(),
        shell,
        energy: 100.0 + site as f64,
        cubeness: 1.0 / (1.0 + site as f64),
    }
}

/// A `.vtu` file as a reader sees it: the head's text and the arrays' bytes by name.
struct Vtu {
    head: String,
    arrays: BTreeMap<String, Vec<u8>>,
}

impl Vtu {
    fn parse(bytes: &[u8]) -> Self {
        let mark = b"<AppendedData encoding=\"raw\">\n_";
        let place = bytes.windows(mark.len()).position(|window| window == mark);
        let start = place.expect("appended data") + mark.len();
        let head = String::from_utf8(bytes[..start].to_vec()).expect("text");
        let mut arrays = BTreeMap::new();
        let mut end = start;
        for line in head.lines().filter(|line| line.starts_with("<DataArray")) {
            let offset: usize = attribute(line, "offset").parse().expect("a number");
            // No gap and no overlap between the arrays.
            assert_eq!(start + offset, end);
            let size = bytes[end..end + 8].try_into().expect("eight bytes");
            let first = end + 8;
            end = first + u64::from_le_bytes(size) as usize;
            let bytes = bytes[first..end].to_vec();
            arrays.insert(attribute(line, "Name").to_owned(), bytes);
        }
        assert_eq!(&bytes[end..], b"\n</AppendedData>\n</VTKFile>\n");
        Self { head, arrays }
    }

    fn count(&self, name: &str) -> usize {
        attribute(&self.head, name).parse().expect("a number")
    }

    fn reals(&self, name: &str) -> Vec<f64> {
        let eight = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().expect("eight"));
        self.arrays[name].chunks(8).map(eight).collect()
    }

    fn integers(&self, name: &str) -> Vec<usize> {
        let eight = |bytes: &[u8]| i64::from_le_bytes(bytes.try_into().expect("eight"));
        let number = |bytes| usize::try_from(eight(bytes)).expect("no negative number");
        self.arrays[name].chunks(8).map(number).collect()
    }

    /// The cells' volumes from points and faces alone, after checking that cells use only their
    /// own points and that their faces close.
    fn volumes(&self) -> Vec<f64> {
        let points: Vec<Point3<f64>> = self
            .reals("Points")
            .chunks(3)
            .map(Point3::from_slice)
            .collect();
        let (connectivity, faces) = (self.integers("connectivity"), self.integers("faces"));
        let (mut first, mut place) = (0, 0);
        let ends = self
            .integers("offsets")
            .into_iter()
            .zip(self.integers("faceoffsets"));
        let volumes = ends.map(|(end, faces_end)| {
            let own = &connectivity[first..end];
            first = end;
            let mut edges = BTreeMap::new();
            let mut volume = 0.0;
            let count = faces[place];
            place += 1;
            for _ in 0..count {
                let corners = &faces[place + 1..place + 1 + faces[place]];
                place += 1 + faces[place];
                assert!(corners.len() >= 3 && corners.iter().all(|c| own.contains(c)));
                for (from, to) in corners.iter().zip(corners.iter().cycle().skip(1)) {
                    *edges.entry((from.min(to), from.max(to))).or_insert(0) +=
                        if from < to { 1 } else { -1 };
                }
                for k in 2..corners.len() {
                    let [a, b, c] = [0, k - 1, k].map(|k| points[corners[k]].coords);
                    volume += a.dot(&b.cross(&c)) / 6.0;
                }
            }
            assert_eq!(place, faces_end);
            assert!(
                edges.values().all(|balance| *balance == 0),
                "an open surface"
            );
            volume
        });
        volumes.collect()
    }
}

/// The value of the attribute's first occurrence in `text`.
fn attribute<'a>(text: &'a str, name: &str) -> &'a str {
    let (_, rest) = text
        .split_once(&format!("{name}=\""))
        .expect("the attribute");
    rest.split('"').next().expect("its value")
}

fn written(cells: impl IntoIterator<Item = CellGeometry>) -> Vtu {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("cells.vtu");
    write_cells(&path, cells).expect("written");
    assert_eq!(
        fs::read_dir(folder.path()).expect("a folder").count(),
        1,
        "scratch left"
    );
    Vtu::parse(&fs::read(path).expect("read"))
}

#[test]
fn cells_fill_the_cube_in_the_file_too() {
    let sites = random_sites(300, 7);
    let cells =
        (0..300).map(|site| geometry(site, Shell::from(Piece::Convex(&cell(&sites, site)))));
    let file = written(cells.clone());
    let (points, count) = (file.count("NumberOfPoints"), file.count("NumberOfCells"));
    assert_eq!(count, 300);
    assert_eq!(file.arrays["types"], vec![42; 300]);
    assert_eq!(file.reals("Points").len(), 3 * points);
    assert_eq!(
        file.integers("connectivity"),
        (0..points).collect::<Vec<_>>()
    );
    assert_eq!(file.integers("site"), (0..300).collect::<Vec<_>>());
    let facets: Vec<usize> = cells.clone().map(|cell| cell.facet_count).collect();
    assert_eq!(file.integers("facets"), facets);
    let bits = |values: Vec<f64>| values.into_iter().map(f64::to_bits).collect::<Vec<_>>();
    assert_eq!(
        bits(file.reals("energy")),
        bits(cells.clone().map(|cell| cell.energy).collect())
    );
    assert_eq!(
        bits(file.reals("cubeness")),
        bits(cells.map(|cell| cell.cubeness).collect())
    );
    let volumes = file.volumes();
    assert!((volumes.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    for (written, counted) in file.reals("volume").iter().zip(&volumes) {
        assert!((written - counted).abs() < 1e-12);
    }
}

#[test]
fn lattice_cells_are_clean_cubes_in_the_file() {
    let sites = grid_sites(4);
    let file = written(
        (0..64).map(|site| geometry(site, Shell::from(Piece::Convex(&cell(&sites, site))))),
    );
    assert_eq!(file.count("NumberOfPoints"), 64 * 8);
    // Per cell: the number of faces, then six times a count and four corners.
    assert_eq!(file.integers("faces").len(), 64 * 31);
    assert!(
        file.volumes()
            .iter()
            .all(|volume| (volume - 1.0 / 64.0).abs() < 1e-14)
    );
}

#[test]
fn cells_of_the_plane_are_polygons() {
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(Point2::from);
    let file = written([0, 1].map(|site| geometry(site, Shell::polygon(&corners))));
    assert_eq!(file.arrays["types"], vec![7, 7]);
    assert_eq!(file.integers("offsets"), [3, 6]);
    assert_eq!(file.integers("connectivity"), [0, 1, 2, 3, 4, 5]);
    assert!(!file.arrays.contains_key("faces"));
}

#[test]
fn many_cells_pass_through_scratch_files() {
    // More than the MiB that an array may hold in memory.
    let cube = Shell::from(Piece::Convex(&cell(&grid_sites(1), 0)));
    let file = written((0..20_000).map(|site| geometry(site, cube.clone())));
    assert_eq!(file.count("NumberOfCells"), 20_000);
    assert!((file.volumes().iter().sum::<f64>() - 20_000.0).abs() < 1e-9);
}

#[test]
fn no_cells_and_vanished_cells_are_files_too() {
    assert_eq!(written([]).count("NumberOfCells"), 0);
    assert_eq!(
        written([geometry(0, Shell::default())]).arrays["types"],
        [0]
    );
}

#[test]
fn an_unwritable_file_is_named_and_nothing_is_left() {
    let folder = tempfile::tempdir().expect("a folder");
    let error = write_cells(&folder.path().join("none/cells.vtu"), []).expect_err("refused");
    assert!(error.to_string().contains("none/cells.vtu"), "{error}");
    let path = folder.path().join("cells.vtu");
    fs::write(&path, "old").expect("written");
    let mut writer = VtuWriter::new(&path);
    writer.push(&geometry(0, Shell::default())).expect("pushed");
    drop(writer);
    assert_eq!(fs::read(&path).expect("read"), b"old");
    assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 1);
}
