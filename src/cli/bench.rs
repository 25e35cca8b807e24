//! `chebloyd bench`.

use std::fmt::Write as _;
use std::time::Instant;

use clap::{Args, ValueEnum};
use nalgebra::{Point3, Vector3};
use rayon::ThreadPoolBuilder;

use chebloyd::domain::cuboid::Cuboid;
use chebloyd::domain::space::Domain;
use chebloyd::relax::cell_memory::CellMemory;
use chebloyd::relax::space::Space;
use chebloyd::relax::tessellation::{Minimizer, Norm, Question, Tessellation};
use chebloyd::scene::place::place;
use chebloyd::scene::region::Region;
use chebloyd::scene::sites::{Random, Sites};
use chebloyd::voronoi::diagram::{Diagram, DiagramError};

use crate::cli::failure::Failure;
use crate::cli::stdout;

/// Moves that make relaxed sites out of random ones.
const RELAXATION: usize = 10;

/// The stages are index, cells, preparation, energy and the whole iteration.
const LAST_STAGE: usize = 4;

const QUESTION: Question = Question {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

/// Time the stages of an iteration on this machine, per site
///
/// Each stage includes the ones to its left: building the index, building the cells, preparing
/// them for integrals, one energy with gradient and Hessian, and the whole iteration with the
/// minimizer.
#[derive(Debug, Args)]
pub(crate) struct Options {
    /// How many sites in the unit cube
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [10_000, 100_000])]
    count: Vec<usize>,
    /// Which sites
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_enum,
          default_values_t = [Kind::Random, Kind::Lattice, Kind::Relaxed])]
    sites: Vec<Kind>,
    /// How often each stage is timed; the shortest time counts
    #[arg(long, value_name = "R", default_value_t = 3)]
    repeat: u32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// Uniform random sites
    Random,
    /// An exact cubic lattice of about as many sites
    Lattice,
    /// Random sites after ten Lloyd iterations
    Relaxed,
}

pub(crate) fn run(options: &Options, threads: Option<u32>) -> Result<(), Failure> {
    let all = threads.map_or_else(rayon::current_num_threads, |threads| threads as usize);
    let mut table = String::from(
        "µs per site        threads    index    cells  prepare   energy  iteration  evaluations\n",
    );
    let threads = if all > 1 { vec![1, all] } else { vec![1] };
    for &count in &options.count {
        for &kind in &options.sites {
            let sites = sites(kind, count)?;
            for &threads in &threads {
                let pool = ThreadPoolBuilder::new().num_threads(threads).build();
                let pool = pool.map_err(Failure::run)?;
                let row = pool.install(|| time(&sites, options.repeat));
                let row = row.map_err(Failure::run)?;
                let name = format!("{kind:?} {}", sites.len()).to_lowercase();
                let _ = write!(table, "{name:<18} {threads:>7}");
                for time in row.microseconds {
                    let _ = write!(table, " {time:>8.2}");
                }
                let _ = writeln!(table, "   {:>10.2}", row.evaluations);
            }
        }
    }
    stdout::print(table)
}

fn sites(kind: Kind, count: usize) -> Result<Vec<Point3<f64>>, Failure> {
    let domain = Cuboid::unit();
    let side = (count as f64).cbrt().round().max(1.0) as usize;
    if let Kind::Lattice = kind {
        let at = |n: usize| (n as f64 + 0.5) / side as f64;
        let lattice =
            |n: usize| Point3::new(at(n % side), at(n / side % side), at(n / side / side));
        return Ok((0..side.pow(3)).map(lattice).collect());
    }
    let random = Sites::Random(Random { count, seed: 1 });
    let region = Region::<3>::of_solid(&domain);
    let mut sites = place(&random, &region, false).map_err(Failure::input)?;
    if let Kind::Relaxed = kind {
        let space = Space::new(Box::new(domain));
        for _ in 0..RELAXATION {
            let cells = space.assess(&sites, QUESTION).map_err(Failure::run)?;
            sites = cells.iter().map(|cell| cell.target).collect();
        }
    }
    Ok(sites)
}

struct Row {
    microseconds: [f64; LAST_STAGE + 1],
    evaluations: f64,
}

/// Times the stages in turn, `repeat` times over, so that a slow moment hits all of them.
fn time(sites: &[Point3<f64>], repeat: u32) -> Result<Row, DiagramError> {
    let space = Space::new(Box::new(Cuboid::unit()));
    let domain = space.domain();
    let mut row = Row {
        microseconds: [f64::INFINITY; LAST_STAGE + 1],
        evaluations: 0.0,
    };
    for _ in 0..repeat.max(1) {
        for stage in 0..row.microseconds.len() {
            let began = Instant::now();
            let evaluations = run_stage(stage, &space, domain, sites)?;
            let spent = began.elapsed().as_secs_f64() * 1e6 / sites.len() as f64;
            row.microseconds[stage] = row.microseconds[stage].min(spent);
            row.evaluations = evaluations as f64 / sites.len() as f64;
        }
    }
    Ok(row)
}

/// Does the work up to a stage and returns how many energies were evaluated.
fn run_stage(
    stage: usize,
    space: &Space,
    domain: &dyn Domain,
    sites: &[Point3<f64>],
) -> Result<u64, DiagramError> {
    if stage == LAST_STAGE {
        let cells = space.assess(sites, QUESTION)?;
        return Ok(cells.iter().map(|cell| u64::from(cell.evaluations)).sum());
    }
    let diagram = Diagram::new(domain, sites)?;
    match stage {
        0 => {}
        1 => {
            diagram.map(|(): &mut (), cell| cell.polyhedron.vertex_count())?;
        }
        2 => {
            diagram.map(|memory: &mut CellMemory, cell| memory.load(domain, &cell))?;
        }
        _ => {
            diagram.map(|memory: &mut CellMemory, cell| {
                memory.load(domain, &cell);
                memory.evaluate(&Vector3::zeros(), 1).value
            })?;
        }
    }
    Ok(0)
}
