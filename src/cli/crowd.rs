//! The sites that `chebloyd bench` times: even and uneven ones, with the box they live in.

use std::path::Path;

use clap::ValueEnum;
use nalgebra::Point3;

use chebloyd::domain::cuboid::Cuboid;
use chebloyd::domain::space::Domain;
use chebloyd::export::sites::write_csv;
use chebloyd::export::whole_file;
use chebloyd::geometry::bounds::Bounds;
use chebloyd::relax::relaxation_space::RelaxationSpace;
use chebloyd::relax::space::Space;
use chebloyd::scene::random::Uniform;
use chebloyd::scene::site_file::read;

use crate::cli::bench::QUESTION;
use crate::cli::failure::Failure;

/// The log-normal density is constant in so many parts along each axis.
const PARTS: usize = 16;

/// The standard deviation of the density's logarithm: the densest parts are a thousand times as
/// dense as the emptiest.
const LOG_DEVIATION: f64 = 1.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Kind {
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

/// Sites and where they live.
#[derive(Debug)]
pub(crate) struct Crowd {
    pub(crate) domain: Cuboid,
    pub(crate) sites: Vec<Point3<f64>>,
}

impl Crowd {
    /// Sites of a kind, about `count`, relaxed ones by so many moves.
    pub(crate) fn new(kind: Kind, count: usize, moves: usize) -> Result<Self, Failure> {
        let mut random = Uniform::new(1);
        let mut domain = Cuboid::unit();
        let mut sites: Vec<_> = match kind {
            Kind::Lattice => lattice(count),
            Kind::Lognormal => lognormal(count, &mut random),
            _ => (0..count).map(|_| random.point(&domain.bounds())).collect(),
        };
        match kind {
            Kind::Crowded => stretch(&mut sites, [0.1; 3], [0.3, 0.4, 0.5]),
            Kind::Planar => stretch(&mut sites, [1.0, 1.0, 0.0], [0.0, 0.0, 0.5]),
            Kind::Long => {
                stretch(&mut sites, [1000.0, 1.0, 1.0], [0.0; 3]);
                let bounds = Bounds {
                    min: Point3::origin(),
                    max: Point3::new(1000.0, 1.0, 1.0),
                };
                domain = Cuboid::new(bounds, [false; 3]).map_err(Failure::run)?;
            }
            Kind::Relaxed => {
                let space = Space::new(Box::new(domain));
                for _ in 0..moves {
                    let cells = space.assess(&sites, QUESTION).map_err(Failure::run)?;
                    sites = cells.iter().map(|cell| cell.target).collect();
                }
            }
            Kind::Random | Kind::Lattice | Kind::Lognormal => {}
        }
        Ok(Self { domain, sites })
    }

    /// The sites in a file, in the unit cube.
    pub(crate) fn read(file: &Path) -> Result<Self, Failure> {
        let domain = Cuboid::unit();
        let sites = read::sites(file).map_err(Failure::input)?;
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
        whole_file::write(file, |file| write_csv(&self.sites, file))
            .map_err(|error| Failure::run(format!("cannot write {}: {error}", file.display())))
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
fn lognormal(count: usize, random: &mut Uniform) -> Vec<Point3<f64>> {
    let unit = Cuboid::unit().bounds();
    let mut sum = 0.0;
    let sums: Vec<f64> = (0..PARTS.pow(3))
        .map(|_| {
            // Box and Muller; 1 − u is never 0.
            let (u, v) = (1.0 - random.number(), random.number());
            let normal = (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos();
            sum += (LOG_DEVIATION * normal).exp();
            sum
        })
        .collect();
    let one = |_| {
        let drawn = random.number() * sum;
        let part = sums
            .partition_point(|&sum| sum <= drawn)
            .min(sums.len() - 1);
        let corner = [part % PARTS, part / PARTS % PARTS, part / PARTS / PARTS];
        let inside = random.point(&unit);
        Point3::from([0, 1, 2].map(|axis| (corner[axis] as f64 + inside[axis]) / PARTS as f64))
    };
    (0..count).map(one).collect()
}
