//! The sites that `chebloyd bench` times, even and uneven, with the box that holds them.

use std::path::Path;

use clap::ValueEnum;
use nalgebra::Point3;

use crate::domain::cuboid::Cuboid;
use crate::domain::shape::DomainShape;
use crate::export::sites::write_csv;
use crate::geometry::bounds::Bounds;
use crate::geometry::random::Random;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::scene::memory::check;
use crate::scene::site_file;

use crate::cli::failure::{Failure, write_file};

/// What is evaluated in every cell.
pub(crate) const ENERGY: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

/// The log-normal density is constant in so many parts along each axis.
const PARTS: usize = 16;

/// The standard deviation of the density's logarithm: the densest parts are a thousand times as
/// dense as the emptiest.
const LOG_DEVIATION: f64 = 1.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SiteKind {
    /// Uniform random sites
    Random,
    /// An exact cubic lattice of about as many sites
    Lattice,
    /// Random sites after some Lloyd iterations
    Relaxed,
    /// Random sites in a thousandth of the volume
    Crowded,
    /// Random sites on a plane
    Planar,
    /// Random sites whose density is log-normal
    Lognormal,
    /// Uniform random sites in a box of 1000 : 1 : 1
    Long,
}

/// Sites and the box that holds them.
#[derive(Debug)]
pub(crate) struct BenchSites {
    pub(crate) domain: Cuboid,
    pub(crate) sites: Vec<Point3<f64>>,
}

impl BenchSites {
    /// Sites of a kind, about `count`, relaxed ones by so many moves.
    pub(crate) fn new(kind: SiteKind, count: usize, moves: usize) -> Result<Self, Failure> {
        check(count as u64).map_err(Failure::input)?;
        let mut random = Random::new(1);
        let mut domain = Cuboid::unit();
        let mut sites: Vec<_> = match kind {
            SiteKind::Lattice => lattice(count),
            SiteKind::Lognormal => lognormal(count, &mut random),
            _ => (0..count).map(|_| random.point(&domain.bounds())).collect(),
        };
        match kind {
            SiteKind::Crowded => stretch(&mut sites, [0.1; 3], [0.3, 0.4, 0.5]),
            SiteKind::Planar => stretch(&mut sites, [1.0, 1.0, 0.0], [0.0, 0.0, 0.5]),
            SiteKind::Long => {
                stretch(&mut sites, [1000.0, 1.0, 1.0], [0.0; 3]);
                let bounds = Bounds {
                    min: Point3::origin(),
                    max: Point3::new(1000.0, 1.0, 1.0),
                };
                domain = Cuboid::new(bounds, [false; 3]).map_err(Failure::run)?;
            }
            SiteKind::Relaxed => {
                let space = Space::new(Box::new(domain));
                for _ in 0..moves {
                    let cells = space.assess(&sites, ENERGY).map_err(Failure::run)?;
                    sites = cells.iter().map(|cell| cell.target).collect();
                }
            }
            SiteKind::Random | SiteKind::Lattice | SiteKind::Lognormal => {}
        }
        Ok(Self { domain, sites })
    }

    /// The sites in a file, in the unit cube.
    pub(crate) fn read(file: &Path) -> Result<Self, Failure> {
        let domain = Cuboid::unit();
        let sites = site_file::read(file).map_err(Failure::input)?;
        if let Some(site) = sites.iter().position(|site| !domain.contains(site)) {
            let place = file.display();
            return Err(Failure::input(format!(
                "site {site} of {place} lies outside the unit cube"
            )));
        }
        Ok(Self { domain, sites })
    }

    /// Writes the sites as comma-separated text.
    pub(crate) fn save(&self, file: &Path) -> Result<(), Failure> {
        write_file(file, |file| write_csv(&self.sites, file)).map_err(Failure::run)
    }
}

fn stretch(sites: &mut [Point3<f64>], factors: [f64; 3], origin: [f64; 3]) {
    for site in sites {
        for axis in 0..3 {
            site[axis] = origin[axis] + factors[axis] * site[axis];
        }
    }
}

fn lattice(count: usize) -> Vec<Point3<f64>> {
    let side = (count as f64).cbrt().round().max(1.0) as usize;
    let at = |n: usize| (n as f64 + 0.5) / side as f64;
    (0..side.pow(3))
        .map(|n| Point3::new(at(n % side), at(n / side % side), at(n / side / side)))
        .collect()
}

/// Sites in parts of the cube drawn by weight.
fn lognormal(count: usize, random: &mut Random) -> Vec<Point3<f64>> {
    let unit = Cuboid::unit().bounds();
    let mut sum = 0.0;
    let sums: Vec<f64> = (0..PARTS.pow(3))
        .map(|_| {
            // Box and Muller; 1 − u is never 0.
            let (u, v) = (1.0 - random.uniform(), random.uniform());
            let normal = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
            sum += (LOG_DEVIATION * normal).exp();
            sum
        })
        .collect();
    let one = |_| {
        let drawn = random.uniform() * sum;
        let part = sums.partition_point(|&sum| sum <= drawn);
        let part = part.min(sums.len() - 1);
        let corner = [part % PARTS, part / PARTS % PARTS, part / PARTS / PARTS];
        let inside = random.point(&unit);
        Point3::from([0, 1, 2].map(|axis| (corner[axis] as f64 + inside[axis]) / PARTS as f64))
    };
    (0..count).map(one).collect()
}
