//! Prints what relaxation makes of the same random sites with L2 cells and with L∞ cells, and how well L∞
//! cells are approximated by voxels: the README's answer to section 3.5 of Bukenberger & Lensch.
//!
//! `cargo run --release --example linf_study -- [counts=216,1000,10000] [from=1] [to=5] [voxels=64,128,256,512]`:
//! the sites of every seed in the unit cube; no voxels with `voxels=`. Figures are given of the sites' L2
//! cells and, after a slash, of their L∞ cells. CPU seconds are those of all threads, where the system
//! counts them (Linux).

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use chebloyd::scene::read;
use chebloyd::scene::run::{self, RunSpace, energy_spec};
use chebloyd::{Cuboid, Diagram, Method, Metrics, Norm, Relaxation, random_sites};
use nalgebra::{Point3, Vector3};
use rayon::prelude::*;

/// Clock ticks of Linux per second.
const TICKS: f64 = 100.0;

fn option(name: &str, default: &str) -> String {
    let prefix = format!("{name}=");
    let given = std::env::args().find_map(|one| one.strip_prefix(&prefix).map(str::to_owned));
    given.unwrap_or_else(|| default.to_owned())
}

fn numbers(name: &str, default: &str) -> Vec<usize> {
    let text = option(name, default);
    let parts = text.split(',').filter(|part| !part.is_empty());
    parts.map(|part| part.parse().expect("a number")).collect()
}

/// The CPU time that this process has taken; the time passed where it is not told (s).
fn cpu_seconds(began: Instant) -> f64 {
    let ticks = || {
        let text = std::fs::read_to_string("/proc/self/stat").ok()?;
        let rest = text.rsplit_once(')')?.1;
        let fields: Vec<f64> = rest
            .split_whitespace()
            .skip(11)
            .take(2)
            .map_while(|field| field.parse().ok())
            .collect();
        Some(fields.iter().sum::<f64>() / TICKS)
    };
    ticks().unwrap_or_else(|| began.elapsed().as_secs_f64())
}

/// The four relaxations: a name, the cells, and the method.
fn runs() -> [(&'static str, Norm, Method); 4] {
    [
        ("L2∣∞ Lloyd, 50 moves", Norm::L2, Method::lloyd(50)),
        ("L2 global objective", Norm::L2, Method::quasi_newton(50)),
        ("L∞ Lloyd, 50 moves", Norm::Linf, Method::lloyd(50)),
        ("L∞ quasi-Newton", Norm::Linf, Method::quasi_newton(50)),
    ]
}

fn relaxation(cells: Norm) -> Relaxation {
    Relaxation::new(Cuboid::unit()).cells(cells)
}

fn table(counts: &[usize], seeds: std::ops::RangeInclusive<u64>) -> Result<(), Box<dyn Error>> {
    println!(
        "| sites | seed | run | energy % | cubeness | six-facet | aligned | evaluations | CPU s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for &count in counts {
        for seed in seeds.clone() {
            let start = random_sites(&Cuboid::unit(), count, seed)?;
            let both = |sites: &[Point3<f64>]| -> Result<[Metrics; 2], Box<dyn Error>> {
                Ok([
                    relaxation(Norm::L2).measure(sites)?,
                    relaxation(Norm::Linf).measure(sites)?,
                ])
            };
            print_row(count, seed, "start", &both(&start)?, (0.0, 0.0));
            for (name, cells, method) in runs() {
                let (mut sites, began) = (start.clone(), Instant::now());
                let before = cpu_seconds(began);
                let outcome = relaxation(cells).method(method).run(&mut sites)?;
                let spent = cpu_seconds(began) - before;
                let evaluations = outcome
                    .records
                    .last()
                    .map_or(0.0, |record| record.evaluations);
                print_row(count, seed, name, &both(&sites)?, (evaluations, spent));
            }
        }
    }
    Ok(())
}

fn print_row(
    count: usize,
    seed: u64,
    name: &str,
    [l2, linf]: &[Metrics; 2],
    (evaluations, spent): (f64, f64),
) {
    println!(
        "| {count} | {seed} | {name} | {:.3} / {:.3} | {:.3} / {:.3} | {:.3} / {:.3} | {:.3} / {:.3} | {evaluations:.0} | {spent:.2} |",
        l2.energy_percent,
        linf.energy_percent,
        l2.cubeness,
        linf.cubeness,
        l2.six_facet_fraction,
        linf.six_facet_fraction,
        l2.axis_aligned_area,
        linf.axis_aligned_area,
    );
}

/// Volume, energy and where the mass center is, from the site, of a cell of labelled voxels.
#[derive(Clone, Copy, Default)]
struct VoxelCell {
    count: f64,
    energy: f64,
    arm: Vector3<f64>,
}

/// The sums over the voxels of every label.
fn voxel_cells(diagram: &Diagram<'_>, sites: &[Point3<f64>], side: usize) -> Vec<VoxelCell> {
    let at = |n: usize| (n as f64 + 0.5) / side as f64;
    let labels: Vec<u32> = (0..side.pow(3))
        .into_par_iter()
        .map(|n| {
            let point = [at(n % side), at(n / side % side), at(n / side / side)];
            diagram
                .locate_linf(point)
                .map_or(u32::MAX, |site| site as u32)
        })
        .collect();
    let mut cells = vec![VoxelCell::default(); sites.len()];
    for (n, &label) in labels.iter().enumerate() {
        let point = Point3::new(at(n % side), at(n / side % side), at(n / side / side));
        let arm = point - sites[label as usize];
        let cell = &mut cells[label as usize];
        cell.count += 1.0;
        cell.energy += arm.amax();
        cell.arm += arm;
    }
    cells
}

/// Errors of volume and energy (mean over the cells, relative to the mean cell) and of the mass center
/// (mean, in sides of the mean cell) of labelled voxels.
fn voxels(count: usize, sides: &[usize]) -> Result<(), Box<dyn Error>> {
    let text = format!(
        r#"{{ "cells": "linf", "sites": {{ "random": {{ "count": {count}, "seed": 1 }} }} }}"#
    );
    let scene = read::parse(&text, Path::new("study"))?;
    let space = run::space(&scene)?.0;
    let sites = space.place(&scene)?;
    let began = Instant::now();
    let before = cpu_seconds(began);
    let exact = RunSpace::<3>::cells(&space, &sites, energy_spec(&scene))?;
    println!(
        "\n| {count} sites as | volume | energy | center | CPU s | MB |\n|---|---|---|---|---|---|"
    );
    println!(
        "| exact cells | – | – | – | {:.3} | – |",
        cpu_seconds(began) - before
    );
    let cube = Cuboid::unit();
    let diagram = Diagram::new(&cube, &sites)?;
    for &side in sides {
        let before = cpu_seconds(began);
        let cells = voxel_cells(&diagram, &sites, side);
        let spent = cpu_seconds(began) - before;
        let voxel = 1.0 / (side as f64).powi(3);
        let mean = |error: &dyn Fn(usize) -> f64| (0..count).map(error).sum::<f64>() / count as f64;
        let mean_energy = mean(&|site| exact[site].energy);
        let volume =
            mean(&|site| (cells[site].count * voxel - exact[site].volume).abs() * count as f64);
        let energy =
            mean(&|site| (cells[site].energy * voxel - exact[site].energy).abs() / mean_energy);
        let center = mean(&|site| {
            let found = sites[site] + cells[site].arm / cells[site].count.max(1.0);
            (found - exact[site].centroid).norm() * (count as f64).cbrt()
        });
        let megabytes = (side.pow(3) * 4) as f64 / 1e6;
        println!(
            "| {side}³ voxels | {volume:.1e} | {energy:.1e} | {center:.1e} | {spent:.2} | {megabytes:.0} |"
        );
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let seeds = option("from", "1").parse()?..=option("to", "5").parse()?;
    let counts = numbers("counts", "216,1000,10000");
    table(&counts, seeds)?;
    let sides = numbers("voxels", "64,128,256,512");
    if !sides.is_empty() {
        voxels(1000, &sides)?;
    }
    Ok(())
}
