//! The components of a surface: which belong together, which lie in which, which way they face.
//!
//! A component inside an odd number of others bounds a cavity. Inside is where the exact winding
//! number of the other component is not 0, at a point a few roundings within the one that is asked
//! about: there it makes no difference whether the two touch.

use std::collections::HashMap;

use nalgebra::Point3;

use crate::geometry::bounds::Bounds;
use crate::geometry::bvh::Bvh;
use crate::geometry::double_double::six_volume;
use crate::mesh::edges::EdgeTable;
use crate::mesh::orient::{EdgePlaces, Orientation, direction};
use crate::mesh::report::SurfaceReport;
use crate::mesh::surface::{SurfaceMesh, triangle_area};
use crate::mesh::winding::visit_turns;

/// The distance of a component's probe from its surface, in the greatest coordinate.
const STEP: f64 = 64.0 * f64::EPSILON;

/// Joins the components that are not closed by themselves at edges of more than two triangles.
pub(crate) fn join_open(triangles: &[[u32; 3]], edges: &EdgeTable, orientation: &mut Orientation) {
    let mut joined: Vec<u32> = (0..orientation.components as u32).collect();
    for edge in edges.iter().filter(|edge| edge.sides.len() > 2) {
        let mut sums: Vec<(u32, i32)> = Vec::new();
        for &side in edge.sides {
            let triangle = side as usize / 3;
            let component = root(&joined, orientation.component[triangle]);
            let turn = direction(triangles[triangle], edge.vertices);
            match sums.iter_mut().find(|(other, _)| *other == component) {
                Some((_, sum)) => *sum += turn,
                None => sums.push((component, turn)),
            }
        }
        let open: Vec<u32> = sums.iter().filter(|s| s.1 != 0).map(|s| s.0).collect();
        let first = open.iter().copied().min().unwrap_or_default();
        for component in open {
            joined[component as usize] = first;
        }
    }
    renumber(&joined, orientation);
}

/// Numbers the components that are joined from 0 up, in the order in which they occur.
fn renumber(joined: &[u32], orientation: &mut Orientation) {
    let mut numbers = HashMap::new();
    for component in &mut orientation.component {
        let count = numbers.len() as u32;
        *component = *numbers.entry(root(joined, *component)).or_insert(count);
    }
    orientation.components = numbers.len();
}

/// The component that stands for `component`: links lead to lower numbers.
fn root(joined: &[u32], mut component: u32) -> u32 {
    while joined[component as usize] != component {
        component = joined[component as usize];
    }
    component
}

/// Turns the components that contradicted themselves as read (`mixed`) outward, cavities inward;
/// then everything if the volume is negative. Reports how many components and cavities there are.
pub(crate) fn turn_outward(
    surface: &mut SurfaceMesh,
    places: &EdgePlaces<'_>,
    orientation: &Orientation,
    report: &mut SurfaceReport,
) {
    let mut volumes = volumes(surface, orientation);
    let mut turned = turned_by_nesting(surface, orientation, &volumes);
    let flip = |volumes: &mut [f64], turned: &[bool]| {
        let wrong = volumes.iter_mut().zip(turned).filter(|&(_, &turn)| turn);
        wrong.for_each(|(volume, _)| *volume = -*volume);
    };
    flip(&mut volumes, &turned);
    if volumes.iter().sum::<f64>() < 0.0 {
        turned.iter_mut().for_each(|turn| *turn = !*turn);
        volumes.iter_mut().for_each(|volume| *volume = -*volume);
    }
    report.components = orientation.components;
    report.cavities = volumes.iter().filter(|&&volume| volume < 0.0).count();
    let mut reported = vec![false; orientation.components];
    for (at, triangle) in surface.triangles.iter_mut().enumerate() {
        let component = orientation.component[at] as usize;
        if turned[component] {
            triangle.swap(1, 2);
            if !std::mem::replace(&mut reported[component], true) {
                report.inverted.add(places.numbers[at]);
            }
        }
    }
}

/// The components' signed volumes (L³).
fn volumes(surface: &SurfaceMesh, orientation: &Orientation) -> Vec<f64> {
    let apex = surface.bounds().center();
    let mut volumes = vec![0.0; orientation.components];
    for (corners, &number) in surface.all_corners().zip(&orientation.component) {
        volumes[number as usize] += six_volume(&apex, corners.each_ref()) / 6.0;
    }
    volumes
}

/// Which of the mixed components face the wrong way.
fn turned_by_nesting(
    surface: &SurfaceMesh,
    orientation: &Orientation,
    volumes: &[f64],
) -> Vec<bool> {
    let mut mixed = vec![false; orientation.components];
    for (&component, &turned) in orientation.component.iter().zip(&orientation.turned) {
        mixed[component as usize] |= turned;
    }
    if orientation.components == 1 || !mixed.contains(&true) {
        return vec![false; orientation.components];
    }
    let tree = Bvh::new(surface.all_corners().map(|corners| Bounds::of(&corners)));
    let probes = probes(surface, orientation, volumes);
    let is_wrong = |component: usize| {
        let mut windings = vec![0; orientation.components];
        visit_turns(surface, &tree, &probes[component], |triangle, turns| {
            windings[orientation.component[triangle as usize] as usize] += turns;
        });
        windings[component] = 0;
        let depth = windings.iter().filter(|&&winding| winding != 0).count();
        (volumes[component] < 0.0) != (depth % 2 == 1)
    };
    (0..mixed.len())
        .map(|component| mixed[component] && is_wrong(component))
        .collect()
}

/// For every component a point just within it, beside its greatest triangle.
fn probes(surface: &SurfaceMesh, orientation: &Orientation, volumes: &[f64]) -> Vec<Point3<f64>> {
    let Bounds { min, max } = surface.bounds();
    let step = STEP * min.coords.amax().max(max.coords.amax());
    let mut greatest = vec![(0.0, Point3::origin()); orientation.components];
    for (corners, &number) in surface.all_corners().zip(&orientation.component) {
        let area = triangle_area(&corners);
        let (most, probe) = &mut greatest[number as usize];
        if area > *most {
            let [a, b, c] = corners;
            let outward = (b - a).cross(&(c - a)).normalize() * volumes[number as usize].signum();
            let middle = Point3::from((a.coords + b.coords + c.coords) / 3.0);
            (*most, *probe) = (area, middle - outward * step);
        }
    }
    greatest.into_iter().map(|(_, probe)| probe).collect()
}
