//! Reports of mesh validation: counts, first places, sentences, refusals.

use std::fmt;

use nalgebra::Point3;
use thiserror::Error;

/// The count of a finding, and its first place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tally<T> {
    /// How many.
    pub count: usize,
    /// The first of them.
    pub first: Option<T>,
}

impl<T> Default for Tally<T> {
    fn default() -> Self {
        let (count, first) = (0, None);
        Self { count, first }
    }
}

impl<T> Tally<T> {
    /// Counts one more.
    pub fn add(&mut self, place: T) {
        self.count += 1;
        self.first.get_or_insert(place);
    }
}

impl<T> FromIterator<T> for Tally<T> {
    fn from_iter<I: IntoIterator<Item = T>>(places: I) -> Self {
        let mut tally = Self::default();
        for place in places {
            tally.add(place);
        }
        tally
    }
}

/// An edge and one of its triangles, zero-based as read (polygons counted by their triangles).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgePlace {
    /// The edge's vertices.
    pub vertices: [u32; 2],
    /// A triangle at the edge.
    pub triangle: u32,
}

impl fmt::Display for EdgePlace {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = self.vertices;
        write!(
            out,
            "between vertices {from} and {to} (triangle {})",
            self.triangle
        )
    }
}

/// What was found in, and done to, a surface that was accepted. Triangle and vertex numbers are
/// zero-based and those of the mesh as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceReport {
    /// What the file's reader has to say: units, elements read in part.
    pub file: Vec<String>,
    /// Connected components (across edges).
    pub components: usize,
    /// Components that bound a cavity.
    pub cavities: usize,
    /// The sum of the components' genera (handles): V − E + F = 2 · components − 2 · genus.
    pub genus: i64,
    /// Coincident vertices that were merged because the surface was open without.
    pub welded: usize,
    /// The greatest distance between merged vertices (L); 0 where all were equal.
    pub welded_apart: f64,
    /// Triangles that lie on others of opposite winding: both were dropped, they cancel.
    pub cancelled: Tally<u32>,
    /// Triangles with a repeated vertex, dropped.
    pub collapsed: Tally<u32>,
    /// Triangles on the same three vertices as another, dropped.
    pub duplicates: Tally<u32>,
    /// Triangles turned to agree with their neighbors.
    pub reoriented: Tally<u32>,
    /// Components turned inside out, each by a triangle of it.
    pub inverted: Tally<u32>,
    /// Triangles without area, kept: they are harmless.
    pub flat: Tally<u32>,
    /// Edges of four or more triangles, evenly traversed, kept: components or handles that touch.
    pub touching: Tally<EdgePlace>,
    /// Vertices no triangle uses, dropped.
    pub isolated: Tally<u32>,
    /// What is enclosed more than once: parts that overlap, cross or lie in others. It counts as
    /// often as it is enclosed.
    pub repeated: Option<Overlap>,
    /// What is subtracted where nothing is: parts inside out, cavities that reach outside.
    pub negative: Option<Overlap>,
}

/// A volume that a mesh counts wrongly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The volume (L³); what is enclosed three times counts twice here.
    pub volume: f64,
    /// A point of it.
    pub place: Point3<f64>,
    /// The triangle or tetrahedron beside this point, as read.
    pub element: u32,
}

impl fmt::Display for Overlap {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let volume = brief(self.volume);
        let [x, y, z] = [self.place.x, self.place.y, self.place.z].map(brief);
        let element = self.element;
        write!(
            out,
            "a volume of {volume} around ({x}, {y}, {z}) beside element {element}"
        )
    }
}

/// A number with six digits.
pub(crate) fn brief(number: f64) -> String {
    let rounded = format!("{number:.5e}").parse::<f64>().unwrap_or(number);
    if rounded != 0.0 && !(1e-4..1e7).contains(&rounded.abs()) {
        format!("{rounded:e}")
    } else {
        format!("{}", rounded + 0.0)
    }
}

impl SurfaceReport {
    /// One sentence for each thing that a user should know; none for a flawless surface.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let collapsed = "triangles with a repeated vertex were dropped";
        let reoriented = "triangles were turned to agree with their neighbors";
        let cancelled = "triangles that lie on each other in opposite directions were dropped";
        let notes = [
            self.welded_note(),
            note(self.collapsed, collapsed),
            note(self.duplicates, "duplicate triangles were dropped"),
            note(self.cancelled, cancelled),
            note(self.reoriented, reoriented),
            note(self.inverted, "components were turned inside out"),
            note(self.flat, "triangles have no area; kept"),
            unused_note(self.isolated),
            self.touching_note(),
            repeated_note(self.repeated),
            self.negative_note(),
        ];
        let file = self.file.iter().cloned();
        file.chain(notes.into_iter().flatten()).collect()
    }

    fn welded_note(&self) -> Option<String> {
        let merged = merged_note(self.welded, self.welded_apart)?;
        Some(format!("{merged} to close the surface"))
    }

    fn touching_note(&self) -> Option<String> {
        let Tally { count, first } = self.touching;
        Some(format!(
            "{count} edges belong to more than two triangles, the first {}; kept, the solid touches itself there",
            first?
        ))
    }

    fn negative_note(&self) -> Option<String> {
        let negative = self.negative?;
        Some(format!(
            "a part is inside out or a cavity reaches outside: where nothing else is, {negative} is subtracted; turn or move that part"
        ))
    }

    /// Why the surface is no domain although it has a volume.
    pub(crate) fn no_domain(&self) -> Option<String> {
        let repeated = self.repeated.map(|overlap| {
            format!(
                "crosses itself or its parts overlap: it encloses {overlap} more than once; unite the parts with a Boolean union, in Blender or MeshLab"
            )
        });
        repeated.or_else(|| self.negative_note())
    }
}

/// What was found in, and done to, a tetrahedral mesh that was accepted. Numbers are zero-based
/// and those of the mesh as read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TetReport {
    /// What the file's reader has to say: elements read in part.
    pub file: Vec<String>,
    /// Coincident vertices of different elements that were merged.
    pub welded: usize,
    /// The greatest distance between merged vertices (L); 0 where all were equal.
    pub welded_apart: f64,
    /// Tetrahedra of negative volume, turned.
    pub inverted: Tally<u32>,
    /// Tetrahedra without volume, dropped.
    pub flat: Tally<u32>,
    /// Tetrahedra on the same four corners as another, dropped.
    pub duplicates: Tally<u32>,
    /// Vertices no tetrahedron uses, dropped.
    pub isolated: Tally<u32>,
    /// What tetrahedra fill more than once.
    pub repeated: Option<Overlap>,
}

impl TetReport {
    /// One sentence for each thing that a user should know; none for a flawless mesh.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let welded = merged_note(self.welded, self.welded_apart);
        let notes = [
            welded.map(|merged| format!("{merged}: the elements at them are neighbors")),
            note(self.inverted, "inverted tetrahedra were turned"),
            note(self.flat, "tetrahedra without volume were dropped"),
            note(self.duplicates, "duplicate tetrahedra were dropped"),
            unused_note(self.isolated),
            repeated_note(self.repeated),
        ];
        let file = self.file.iter().cloned();
        file.chain(notes.into_iter().flatten()).collect()
    }
}

fn merged_note(count: usize, apart: f64) -> Option<String> {
    let what = if apart > 0.0 {
        format!("vertices up to {} apart", brief(apart))
    } else {
        "coincident vertices".to_owned()
    };
    (count > 0).then(|| format!("{count} {what} were merged"))
}

fn repeated_note(repeated: Option<Overlap>) -> Option<String> {
    Some(format!(
        "parts cross or overlap: what is enclosed more than once is counted as often, {}; unite the parts with a Boolean union",
        repeated?
    ))
}

fn note(tally: Tally<u32>, what: &str) -> Option<String> {
    let first = tally.first?;
    Some(format!(
        "{} {what}, the first at element {first}",
        tally.count
    ))
}

fn unused_note(tally: Tally<u32>) -> Option<String> {
    let first = tally.first?;
    Some(format!(
        "{} vertices belong to no element and were dropped, the first is vertex {first}",
        tally.count
    ))
}

/// The reason why a mesh bounds or fills no solid, with the remedy. The sentence continues a file's name.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum Refusal {
    /// No elements.
    #[error("has no {0}; export the mesh again")]
    Empty(&'static str),
    /// A coordinate or value is NaN or infinite.
    #[error(
        "has a coordinate or value at vertex {0} that is not finite; repair or export the mesh again"
    )]
    NotFinite(usize),
    /// A coordinate so great that volumes overflow.
    #[error(
        "has a coordinate beyond 1e98 at vertex {0} (zero-based), where volumes overflow; scale the mesh down"
    )]
    TooFar(u32),
    /// An element refers to a vertex that is not there.
    #[error(
        "element {element} refers to vertex {vertex} of {vertices} (zero-based); export the mesh again"
    )]
    OutOfRange {
        /// The element.
        element: usize,
        /// The vertex it refers to.
        vertex: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// Edges with one triangle.
    #[error(
        "is not closed: {count} boundary edges, the first {first}; close it, small gaps by --weld L, holes by a mesh repair tool such as MeshLab's 'Close Holes' or PyMeshFix"
    )]
    Open {
        /// The number of boundary edges.
        count: usize,
        /// The first of them.
        first: EdgePlace,
    },
    /// Edges whose triangles enclose no solid consistently.
    #[error(
        "is not the boundary of a solid: {count} edges belong to more than two triangles, the first {first}; remove inner walls and doubled faces, for example with MeshLab's 'Repair non Manifold Edges'"
    )]
    NonManifold {
        /// The number of such edges.
        count: usize,
        /// The first of them.
        first: EdgePlace,
    },
    /// A one-sided component.
    #[error(
        "has a one-sided component (such as a Klein bottle): its triangles cannot be oriented, the first contradiction stands {first}; cut it open there"
    )]
    OneSided {
        /// An edge at which the orientations contradict each other.
        first: EdgePlace,
    },
    /// A sheet in a plane, open.
    #[error(
        "is a flat sheet, not a solid: all vertices lie in one plane and {count} edges are open; give it thickness (extrude it), or, for a run in the plane, write a scene with \"dimension\": 2 and the outline as \"polygon\""
    )]
    Sheet {
        /// The number of boundary edges.
        count: usize,
    },
    /// No inside.
    #[error("encloses no volume; give it thickness")]
    Flat,
    /// Facets with more than two tetrahedra.
    #[error(
        "{count} facets belong to more than two tetrahedra, the first to tetrahedron {first}; remove the overlapping tetrahedra"
    )]
    Overlap {
        /// The number of such facets.
        count: usize,
        /// A tetrahedron at the first of them.
        first: u32,
    },
}
