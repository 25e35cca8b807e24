//! What surfaces and tetrahedra enclose more than once, against a count of unit cubes.

use nalgebra::{Matrix3, Point3, Rotation3, Vector3};
use proptest::prelude::*;

use crate::geometry::bounds::Bounds;
use crate::mesh::repair::{Triangles, weld};
use crate::mesh::report::Refusal;
use crate::mesh::shapes;
use crate::mesh::surface::SurfaceMesh;
use crate::mesh::tets::TetMesh;
use crate::mesh::validate::{validate_surface, validate_tets};

/// Boxes with whole corners in [0, 4]³, each inward or outward.
type Boxes = Vec<([i32; 3], [i32; 3], bool)>;

/// Where a box begins and ends along an axis.
type Range = (i32, i32);

fn boxes() -> impl Strategy<Value = Boxes> {
    let axis = || (0..3_i32).prop_flat_map(|low| (Just(low), low + 1..=4));
    let one = (axis(), axis(), axis(), prop::bool::weighted(0.8));
    let of_axes = |(x, y, z, outward): (Range, Range, Range, bool)| {
        ([x.0, y.0, z.0], [x.1, y.1, z.1], outward)
    };
    prop::collection::vec(one.prop_map(of_axes), 1..5)
}

/// Σ f(w) over the unit cubes, w the boxes' winding number times `sign`.
fn count(boxes: &Boxes, sign: i32, f: fn(i32) -> i32) -> i32 {
    let winding = |cube: [i32; 3]| -> i32 {
        let holds = |low: &[i32; 3], high: &[i32; 3]| {
            (0..3).all(|axis| low[axis] <= cube[axis] && cube[axis] < high[axis])
        };
        let turns = |(low, high, outward): &([i32; 3], [i32; 3], bool)| {
            let sign = if *outward { 1 } else { -1 };
            if holds(low, high) { sign } else { 0 }
        };
        boxes.iter().map(turns).sum()
    };
    let cubes = (0..64).map(|k| [k % 4, k / 4 % 4, k / 16]);
    cubes.map(|cube| f(sign * winding(cube))).sum()
}

fn cuboid(low: [i32; 3], high: [i32; 3]) -> SurfaceMesh {
    shapes::cuboid(&Bounds {
        min: low.map(f64::from).into(),
        max: high.map(f64::from).into(),
    })
}

fn surface(boxes: &Boxes, map: &Matrix3<f64>, shift: &Vector3<f64>) -> SurfaceMesh {
    let mut all = SurfaceMesh::default();
    for &(low, high, outward) in boxes {
        let part = cuboid(low, high);
        let base = all.vertices.len() as u32;
        let place = |point: &Point3<f64>| map * point + shift;
        all.vertices.extend(part.vertices.iter().map(place));
        all.triangles
            .extend(part.triangles.iter().map(|&[a, b, c]| {
                let [b, c] = if outward { [b, c] } else { [c, b] };
                [a + base, b + base, c + base]
            }));
    }
    all
}

/// Compares volume, repeated and negative volume with the count.
fn compare(boxes: &Boxes, mesh: &SurfaceMesh, unit: f64) -> Result<(), TestCaseError> {
    let sum = count(boxes, 1, |w| w);
    let checked = validate_surface(mesh);
    if sum == 0 {
        prop_assert_eq!(checked.unwrap_err(), Refusal::Flat);
        return Ok(());
    }
    let (valid, report) = checked.unwrap();
    for (found, expected) in [
        (valid.mesh().volume(), count(boxes, sum.signum(), |w| w)),
        (
            report.repeated.map_or(0.0, |o| o.volume),
            count(boxes, sum.signum(), |w| (w - 1).max(0)),
        ),
        (
            report.negative.map_or(0.0, |o| o.volume),
            count(boxes, sum.signum(), |w| (-w).max(0)),
        ),
    ] {
        let expected = f64::from(expected) * unit;
        prop_assert!(
            (found - expected).abs() < 1e-10 * unit,
            "{} {}",
            found,
            expected
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Boxes with walls, edges and corners in common, nested, overlapping, some inside out: every
    /// volume is the number of unit cubes.
    #[test]
    fn boxes_overlap_in_unit_cubes(boxes in boxes()) {
        compare(&boxes, &surface(&boxes, &Matrix3::identity(), &Vector3::zeros()), 1.0)?;
    }

    /// The same turned and moved, so that common walls differ by rounding.
    #[test]
    fn turned_boxes_overlap_alike(boxes in boxes(), turn in prop::array::uniform3(-3.0..3.0), far in 0..3_i32) {
        let map = Rotation3::new(Vector3::from(turn)).into_inner() * 0.37;
        let shift = Vector3::new(0.3, -0.7, 0.2) * 10_f64.powi(far);
        compare(&boxes, &surface(&boxes, &map, &shift), 0.37_f64.powi(3))?;
    }

    /// With vertices in common, edges of many triangles and twins: what is left is the union.
    #[test]
    fn welded_boxes_have_the_same_union(mut boxes in boxes()) {
        boxes.iter_mut().for_each(|part| part.2 = true);
        let SurfaceMesh { mut vertices, triangles } = surface(&boxes, &Matrix3::identity(), &Vector3::zeros());
        let mut triangles = Triangles::of(&triangles);
        weld(&mut vertices, &mut triangles, 0.0);
        let (valid, report) = validate_surface(&SurfaceMesh { vertices, triangles: triangles.corners }).unwrap();
        let union = valid.mesh().volume() - report.repeated.map_or(0.0, |o| o.volume);
        prop_assert!((union - f64::from(count(&boxes, 1, |w| w.min(1)))).abs() < 1e-12);
        prop_assert_eq!(report.negative, None);
    }

    /// Boxes of five tetrahedra each, every box with its own vertices.
    #[test]
    fn tetrahedra_overlap_in_unit_cubes(boxes in boxes()) {
        let mut mesh = TetMesh::default();
        for (low, high, _) in &boxes {
            let base = mesh.vertices.len() as u32;
            let five = shapes::unit_cube_five_tets();
            let place = |p: &Point3<f64>| Point3::from([0, 1, 2].map(|k| {
                f64::from(low[k]) + p[k] * f64::from(high[k] - low[k])
            }));
            mesh.vertices.extend(five.vertices.iter().map(place));
            mesh.tets.extend(five.tets.iter().map(|tet| tet.map(|vertex| vertex + base)));
        }
        let outward: Boxes = boxes.iter().map(|&(low, high, _)| (low, high, true)).collect();
        let (valid, report) = validate_tets(&mesh).unwrap();
        let repeated = report.repeated.map_or(0.0, |o| o.volume);
        let union = valid.mesh().volume() - repeated;
        prop_assert!((union - f64::from(count(&outward, 1, |w| w.min(1)))).abs() < 1e-12);
        if report.duplicates.count == 0 {
            let expected = f64::from(count(&outward, 1, |w| (w - 1).max(0)));
            prop_assert!((repeated - expected).abs() < 1e-12);
        }
    }
}

/// A double pyramid whose middle is a side of the cube: no triangle crosses another, the overlap is
/// the lower pyramid.
#[test]
fn parts_that_cross_along_edges_only_are_found() {
    let mut mesh = cuboid([0; 3], [2; 3]);
    let base = mesh.vertices.len() as u32;
    let ring = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
    let corners = ring.map(|[x, y]| Point3::new(x, y, 2.0));
    mesh.vertices.extend(corners);
    mesh.vertices.push(Point3::new(1.0, 1.0, 4.0));
    mesh.vertices.push(Point3::new(1.0, 1.0, 0.5));
    for k in 0..4 {
        let (from, to) = (base + k, base + (k + 1) % 4);
        mesh.triangles.push([from, to, base + 4]);
        mesh.triangles.push([to, from, base + 5]);
    }
    let (valid, report) = validate_surface(&mesh).unwrap();
    assert!((valid.mesh().volume() - (8.0 + 4.0 * 3.5 / 3.0)).abs() < 1e-14);
    let overlap = report.repeated.unwrap();
    assert!((overlap.volume - 2.0).abs() < 1e-14, "{overlap}");
    assert!(overlap.place.z < 2.0 && overlap.place.z > 0.5);
}

/// Two tetrahedra on one side of a facet.
#[test]
fn tetrahedra_on_one_side_of_a_facet_are_refused() {
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.2, 0.2, 0.7],
    ];
    let mesh = TetMesh {
        vertices: corners.map(Point3::from).to_vec(),
        tets: vec![[0, 1, 2, 3], [0, 1, 2, 4]],
        vertex_data: Vec::new(),
    };
    let refusal = validate_tets(&mesh).unwrap_err();
    assert_eq!(refusal, Refusal::Overlap { count: 1, first: 0 });
}

/// Long triangles along a diagonal, whose boxes along the axes all overlap, and their end caps: few
/// pairs are looked at, whatever their number.
#[test]
fn long_diagonal_triangles_are_told_apart_in_linear_time() {
    let pairs = |sides: u32| {
        let mesh = rod(sides);
        let mut all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let tree = crate::mesh::triangle_tree::TriangleTree::new(&mesh, &mut all);
        let found = tree.pairs(1e-12, &|one, other| Some([one.min(other), one.max(other)]));
        let report = validate_surface(&mesh).unwrap().1;
        assert_eq!(report.notes(), Vec::<String>::new());
        found.len()
    };
    let (few, many) = (pairs(125), pairs(1000));
    assert!(
        many < 12 * few,
        "{few} pairs of 500 triangles, {many} of 4000"
    );
    assert!(many < 60 * 4000, "{many}");
}

/// A round rod of 4 · `sides` triangles.
fn rod(sides: u32) -> SurfaceMesh {
    let axis = Vector3::new(1.0, 2.0, 3.3).normalize();
    let one = axis.cross(&Vector3::z()).normalize();
    let other = axis.cross(&one);
    let rim = |k: u32, along: f64| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / f64::from(sides)).sin_cos();
        Point3::from((one * cos + other * sin) * 0.5 + axis * along)
    };
    let lower = (0..sides).map(|k| rim(k, 0.0));
    let upper = (0..sides).map(|k| rim(k, 200.0));
    let ends = [Point3::origin(), Point3::from(axis * 200.0)];
    let around = (0..sides).flat_map(|k| {
        let next = (k + 1) % sides;
        [
            [k, next, sides + next],
            [k, sides + next, sides + k],
            [2 * sides, next, k],
            [2 * sides + 1, sides + k, sides + next],
        ]
    });
    SurfaceMesh {
        vertices: lower.chain(upper).chain(ends).collect(),
        triangles: around.collect(),
    }
}
