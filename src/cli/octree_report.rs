//! Tables of octrees' errors beside those of \[BL\] Table 3.

use std::fmt::Display;

use serde::Serialize;

use crate::mass::body::Body;
use crate::mass::octree_error::OctreeError;
use crate::mesh::octree::Octree;
use crate::mesh::surface::SurfaceMesh;
use crate::plot::octrees::ErrorCurves;

/// What \[BL\] Table 3 says of a model at one depth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
struct PaperRow {
    nodes: u32,
    center_error_percent: f64,
    mass_error_percent: f64,
}

/// Of a model: its name, vertices and faces, and the trees of depths 4 and 8.
type PaperModel = (&'static str, [usize; 2], [(u32, f64, f64); 2]);

#[rustfmt::skip]
const TABLE_3: [PaperModel; 8] = [
    ("buddha", [99_370, 198_736], [(2047, 0.4362, 0.8117), (730_647, 0.0027, 0.0432)]),
    ("casting", [5096, 10_224], [(1719, 4.1531, 12.1164), (911_551, 0.7120, 0.9831)]),
    ("fandisk", [2877, 5750], [(1505, 1.0598, 0.5505), (433_740, 0.0329, 0.0872)]),
    ("fertility", [241_607, 483_226], [(1854, 0.3387, 1.3620), (695_297, 0.0118, 0.1219)]),
    ("maxplanck", [49_132, 98_260], [(1759, 0.1952, 0.0457), (561_597, 0.0225, 0.0765)]),
    ("nefertiti", [1_009_118, 2_018_232], [(1677, 0.4852, 0.6365), (570_914, 0.0010, 0.0085)]),
    ("rockerarm", [10_044, 20_088], [(2148, 0.4042, 3.1069), (818_778, 0.0728, 0.1308)]),
    ("trefoil", [10_240, 20_480], [(2221, 0.0952, 0.4600), (825_107, 0.0008, 0.1352)]),
];

/// What is printed.
#[derive(Debug, Serialize)]
pub(crate) struct OctreesReport {
    pub(crate) models: Vec<ModelReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct ModelReport {
    name: String,
    vertices: usize,
    triangles: usize,
    mass: f64,
    center_of_mass: [f64; 3],
    seconds: f64,
    /// Vertices and faces of the paper's mesh of that name.
    #[serde(skip_serializing_if = "Option::is_none")]
    paper_mesh: Option<[usize; 2]>,
    trees: Vec<TreeReport>,
}

#[derive(Debug, Serialize)]
pub(crate) struct TreeReport {
    depth: u32,
    nodes: usize,
    leaves: usize,
    center_error_percent: f64,
    mass_error_percent: f64,
    inertia_error_percent: f64,
    seconds: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    paper: Option<PaperRow>,
}

impl TreeReport {
    pub(crate) fn new(tree: &Octree, error: &OctreeError, seconds: f64) -> Self {
        Self {
            depth: tree.depth,
            nodes: tree.nodes,
            leaves: tree.leaves.len(),
            center_error_percent: 100.0 * error.center,
            mass_error_percent: 100.0 * error.mass,
            inertia_error_percent: 100.0 * error.inertia,
            seconds,
            paper: None,
        }
    }
}

/// The names of the columns.
const HEADER: &str = "  depth       nodes (paper)         ε_C % (paper)         ε_M % (paper)      ε_Θ %    seconds  times exact\n";

impl ModelReport {
    pub(crate) fn new(name: &str, surface: &SurfaceMesh, exact: &Body, seconds: f64) -> Self {
        Self {
            name: name.to_owned(),
            vertices: surface.vertices.len(),
            triangles: surface.triangles.len(),
            mass: exact.mass,
            center_of_mass: exact.center_of_mass().into(),
            seconds,
            paper_mesh: paper_model(name).map(|(_, mesh, _)| *mesh),
            trees: Vec::new(),
        }
    }

    /// Adds a tree, with what the paper says of it.
    pub(crate) fn push(&mut self, mut tree: TreeReport) {
        let rows = paper_model(&self.name).map(|(_, _, rows)| rows);
        let row = rows.and_then(|[fourth, eighth]| match tree.depth {
            4 => Some(fourth),
            8 => Some(eighth),
            _ => None,
        });
        tree.paper = row.map(|&(nodes, center, mass)| PaperRow {
            nodes,
            center_error_percent: center,
            mass_error_percent: mass,
        });
        self.trees.push(tree);
    }

    fn table(&self) -> String {
        let [x, y, z] = self.center_of_mass;
        let mut text = format!(
            "{}: {} vertices, {} triangles{}\n  exact: mass {:.9}, center {x:.9} {y:.9} {z:.9}, in {:.2} ms\n",
            self.name,
            self.vertices,
            self.triangles,
            self.mesh_remark(),
            self.mass,
            1e3 * self.seconds
        );
        text += HEADER;
        for tree in &self.trees {
            text += &tree.line(self.seconds);
        }
        text
    }

    fn mesh_remark(&self) -> String {
        match self.paper_mesh {
            Some([vertices, faces]) if [self.vertices, self.triangles] != [vertices, faces] => {
                format!(" (the paper's mesh of this name has {vertices} and {faces})")
            }
            Some(_) => " (the paper's mesh)".to_owned(),
            None => String::new(),
        }
    }
}

/// A figure, with the paper's in brackets.
fn beside(own: impl Display, paper: Option<impl Display>) -> String {
    match paper {
        Some(paper) => format!("{own} ({paper})"),
        None => own.to_string(),
    }
}

impl TreeReport {
    fn line(&self, exact: f64) -> String {
        let paper = self.paper.as_ref();
        let nodes = beside(self.nodes, paper.map(|row| row.nodes));
        let percent = |error: f64| format!("{error:.4}");
        let center = beside(
            percent(self.center_error_percent),
            paper.map(|row| percent(row.center_error_percent)),
        );
        let mass = beside(
            percent(self.mass_error_percent),
            paper.map(|row| percent(row.mass_error_percent)),
        );
        format!(
            "  {:>5}{nodes:>20}{center:>22}{mass:>22}{:>11.4}{:>11.4}{:>13.0}\n",
            self.depth,
            self.inertia_error_percent,
            self.seconds,
            self.seconds / exact
        )
    }
}

impl OctreesReport {
    pub(crate) fn table(&self) -> String {
        let tables = self.models.iter().map(ModelReport::table);
        tables.collect::<Vec<_>>().join("\n")
    }

    /// The curves of all models.
    pub(crate) fn curves(&self) -> Vec<ErrorCurves> {
        let curves = self.models.iter().map(|model| ErrorCurves {
            name: model.name.clone(),
            nodes: model.trees.iter().map(|tree| tree.nodes as f64).collect(),
            errors: model.trees.iter().map(TreeReport::errors).collect(),
            seconds: model.trees.iter().map(|tree| tree.seconds).collect(),
            exact_seconds: model.seconds,
        });
        curves.collect()
    }
}

impl TreeReport {
    fn errors(&self) -> [f64; 3] {
        [
            self.center_error_percent,
            self.mass_error_percent,
            self.inertia_error_percent,
        ]
    }
}

/// The paper's row of a model, by its name without hyphens and case.
fn paper_model(name: &str) -> Option<&'static PaperModel> {
    let letters = name.chars().filter(|letter| letter.is_alphanumeric());
    let plain = letters.collect::<String>().to_lowercase();
    TABLE_3.iter().find(|(known, _, _)| *known == plain)
}
