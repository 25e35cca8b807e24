//! Cells as arrays and cells of chosen sites: identities, agreement with cells one by one, thin halos, stops.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use nalgebra::{Point2, Point3, Vector3};

use crate::domain::cuboid::Cuboid;
use crate::domain::domain::Domain;
use crate::domain::facet_kind::FacetKind;
use crate::domain::planar::PlaneDomain;
use crate::geometry::bounds::Bounds;
use crate::relax::relaxation::random_sites;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::{Space, SpaceError};
use crate::voronoi::cell_arrays::{CellArrays, CellQuery};
use crate::voronoi::diagram::{Diagram, DiagramError};

const ALL: CellQuery<'_> = CellQuery {
    chosen: None,
    shapes: true,
    known: None,
};

fn periodic_box() -> Cuboid {
    let bounds = Bounds::from_corners([-1.0, 0.0, 2.0], [1.0, 1.0, 2.5]);
    Cuboid::new(bounds, [true, false, true]).expect("a box")
}

fn sites(domain: &dyn Domain, count: usize) -> Vec<Point3<f64>> {
    random_sites(domain, count, 7).expect("a box has room")
}

/// Label, area, normal, corners.
type LabeledFacet = (i64, f64, Vector3<f64>, Vec<Point3<f64>>);

/// The facets of cell `cell`.
fn facets(arrays: &CellArrays, cell: usize) -> Vec<LabeledFacet> {
    let range = arrays.facet_offsets[cell] as usize..arrays.facet_offsets[cell + 1] as usize;
    let corner = |&number: &i64| Point3::from_slice(&arrays.vertices[3 * number as usize..][..3]);
    range
        .map(|facet| {
            let ends = [0, 1].map(|k| arrays.corner_offsets[facet + k] as usize);
            let corners = arrays.corners[ends[0]..ends[1]]
                .iter()
                .map(corner)
                .collect();
            let normal = Vector3::from_column_slice(&arrays.normals[3 * facet..][..3]);
            (
                arrays.neighbors[facet],
                arrays.areas[facet],
                normal,
                corners,
            )
        })
        .collect()
}

#[test]
fn arrays_hold_what_cells_say_one_by_one() {
    let domain = periodic_box();
    let mut sites = sites(&domain, 300);
    // A lattice's corner among them: eight sites on one sphere.
    sites.extend((0..8).map(|k| {
        Point3::from([0, 1, 2].map(|axis| 0.25 * f64::from(k >> axis & 1)))
            + Vector3::new(0.1, 0.3, 2.1)
    }));
    let diagram = Diagram::new(&domain, &sites).expect("sites");
    let arrays = CellArrays::in_space(&diagram, &ALL).expect("cells");
    let cells =
        diagram.map_cells(|cell| (cell.facets(), cell.moments(), cell.reach(), cell.position));
    for (number, (expected, moments, reach, position)) in
        cells.expect("cells").into_iter().enumerate()
    {
        assert!((arrays.volumes[number] - moments.mass).abs() < 1e-15);
        let centroid = position + moments.center();
        assert!(
            (Point3::from_slice(&arrays.centroids[3 * number..][..3]) - centroid).norm() < 1e-14
        );
        assert_eq!(arrays.radii[number].to_bits(), reach.to_bits());
        let found = facets(&arrays, number);
        assert_eq!(found.len(), expected.len());
        for ((behind, area, normal, corners), facet) in found.iter().zip(&expected) {
            let expected_behind = match facet.kind {
                FacetKind::Neighbor { site, .. } => i64::from(site),
                FacetKind::Wall(wall) => -1 - i64::from(wall),
                FacetKind::Inner => i64::MIN,
            };
            assert_eq!(*behind, expected_behind);
            assert!((area - facet.area).abs() < 1e-14 && (normal - facet.normal).norm() < 1e-14);
            assert!(corners.len() >= 3 && corners.len() <= facet.vertices.len());
        }
    }
    assert!((arrays.volumes.iter().sum::<f64>() - 1.0).abs() < 1e-13);
    let bare = CellArrays::in_space(
        &diagram,
        &CellQuery {
            shapes: false,
            ..ALL
        },
    )
    .expect("cells");
    assert!(bare.vertices.is_empty() && bare.areas == arrays.areas && bare.images == arrays.images);
}

#[test]
fn chosen_cells_have_the_bits_of_all_cells() {
    let domain = periodic_box();
    let sites = sites(&domain, 2000);
    let diagram = Diagram::new(&domain, &sites).expect("sites");
    let all = CellArrays::in_space(&diagram, &ALL).expect("cells");
    let chosen: Vec<usize> = (0..2000).rev().step_by(3).chain([5, 5]).collect();
    let some = CellArrays::in_space(
        &diagram,
        &CellQuery {
            chosen: Some(&chosen),
            ..ALL
        },
    )
    .expect("cells");
    for (number, &site) in chosen.iter().enumerate() {
        assert_eq!(some.volumes[number].to_bits(), all.volumes[site].to_bits());
        assert_eq!(facets(&some, number), facets(&all, site));
    }
    let no_such = DiagramError::NoSuchSite {
        site: 2000,
        count: 2000,
    };
    assert_eq!(diagram.map_cells_of(&[3, 2000], |_| ()), Err(no_such));
}

/// Own sites and a halo of growing width: a cell that its halo certifies is the true one.
#[test]
fn a_thin_halo_is_noticed() {
    for periodic in [[false; 3], [true; 3]] {
        let domain =
            Cuboid::new(Bounds::from_corners([0.0; 3], [1.0; 3]), periodic).expect("a box");
        let sites = sites(&domain, 3000);
        let is_own = |site: &Point3<f64>| site.x < 0.5;
        let truth =
            Diagram::new(&domain, &sites).and_then(|all| all.map_cells(|cell| cell.volume()));
        let own = sites
            .iter()
            .zip(truth.expect("cells"))
            .filter(|(site, _)| is_own(site));
        let truth: Vec<f64> = own.map(|(_, volume)| volume).collect();
        let mut shares = Vec::new();
        for width in [0.02, 0.1, 0.3] {
            let low = if periodic[0] { -width } else { 0.0 };
            let known = Bounds::from_corners([low, 0.0, 0.0], [0.5 + width, 1.0, 1.0]);
            let is_near = |x: f64| x <= 0.5 + width || periodic[0] && x - 1.0 >= low;
            let near: Vec<_> = sites
                .iter()
                .copied()
                .filter(|site| is_near(site.x))
                .collect();
            let chosen: Vec<usize> = (0..near.len())
                .filter(|&site| is_own(&near[site]))
                .collect();
            let diagram = Diagram::new(&domain, &near).expect("sites");
            let cells =
                diagram.map_cells_of(&chosen, |cell| (cell.volume(), cell.is_certified(&known)));
            let cells = cells.expect("cells");
            let is_right: Vec<bool> = cells
                .iter()
                .zip(&truth)
                .map(|((v, _), t)| (v - t).abs() < 1e-15)
                .collect();
            assert!(
                cells
                    .iter()
                    .zip(&is_right)
                    .all(|((_, is_certified), right)| *right || !is_certified)
            );
            let certified = cells
                .iter()
                .filter(|(_, is_certified)| *is_certified)
                .count();
            let right = is_right.iter().filter(|right| **right).count();
            shares.push((
                right as f64 / truth.len() as f64,
                certified as f64 / truth.len() as f64,
            ));
        }
        assert!(shares[0].0 < 0.999 && shares[0].1 < 0.95, "{shares:?}");
        assert!(shares[1].1 > shares[0].1, "{shares:?}");
        assert!(shares[2].0 >= 1.0 && shares[2].1 >= 1.0, "{shares:?}");
    }
}

#[test]
fn cells_of_the_plane_fill_it() {
    let ring = [
        vec![[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]],
        vec![[1.0, 1.0], [3.0, 1.0], [3.0, 3.0], [1.0, 3.0]],
    ];
    let loops: Vec<Vec<Point2<f64>>> = ring
        .iter()
        .map(|corners| corners.iter().copied().map(Point2::from).collect())
        .collect();
    let domain = PlaneDomain::from_loops(&loops).expect("a ring");
    let grid =
        (0..64).map(|k| Point2::new(f64::from(k % 8) * 0.5 + 0.3, f64::from(k / 8) * 0.5 + 0.2));
    let sites: Vec<_> = grid.filter(|site| domain.contains(site)).collect();
    let cells = CellArrays::in_plane(&domain, &sites, &ALL).expect("cells");
    assert!((cells.volumes.iter().sum::<f64>() - 12.0).abs() < 1e-12);
    for cell in 0..sites.len() {
        let range = cells.facet_offsets[cell] as usize..cells.facet_offsets[cell + 1] as usize;
        assert!(
            cells.neighbors[range]
                .iter()
                .all(|&behind| behind > i64::MIN)
        );
    }
    let some = CellQuery {
        chosen: Some(&[4, 2]),
        ..ALL
    };
    let some = CellArrays::in_plane(&domain, &sites, &some).expect("cells");
    assert_eq!(some.volumes, [cells.volumes[4], cells.volumes[2]]);
}

/// The flag is raised before the index, at a cell, and after the last cell, while results are put in order.
#[test]
fn a_raised_flag_stops_every_phase() {
    let cube = Cuboid::unit();
    let sites = sites(&cube, 8000);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a thread");
    for after in [0, 1000, sites.len()] {
        let (flag, visited) = (Arc::new(AtomicBool::new(after == 0)), AtomicUsize::new(0));
        let diagram = Diagram::new(&cube, &sites).expect("sites").stop_by(&flag);
        let count = || {
            if visited.fetch_add(1, Ordering::Relaxed) + 1 == after {
                flag.store(true, Ordering::Relaxed);
            }
        };
        let ended = pool.install(|| diagram.map_cells(|_| count()));
        assert_eq!(ended, Err(DiagramError::Stopped));
        assert_eq!(visited.load(Ordering::Relaxed), after);
        assert_eq!(
            diagram.map_cells_of(&[1], |_| ()),
            Err(DiagramError::Stopped)
        );
        assert!(after > 0 || diagram.locate([0.5; 3]).is_none());
    }
    let flag = Arc::new(AtomicBool::new(true));
    let spec = EnergySpec {
        norm: Norm::Linf,
        order: 1,
        minimizer: Minimizer::Newton,
    };
    for cells in [Norm::L2, Norm::Linf] {
        let space = Space::new(Box::new(Cuboid::unit()))
            .with_cells(cells)
            .stop_by(&flag);
        let stopped = space.assess(&sites[..10], spec).map(|_| ());
        assert_eq!(stopped, Err(SpaceError::Diagram(DiagramError::Stopped)));
    }
}
