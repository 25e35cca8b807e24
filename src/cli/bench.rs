//! `chebloyd bench`.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use nalgebra::{Point3, Vector3};
use rayon::ThreadPoolBuilder;

use chebloyd::domain::space::Domain;
use chebloyd::relax::cell_memory::CellMemory;
use chebloyd::relax::space::Space;
use chebloyd::relax::tessellation::{Minimizer, Norm, Question, Tessellation};
use chebloyd::voronoi::diagram::{Diagram, DiagramError};

use crate::cli::crowd::{Crowd, Kind};
use crate::cli::failure::Failure;
use crate::cli::stdout;
use crate::cli::watch::Watch;

/// The stages are index, cells, preparation, energy and the whole iteration.
const LAST_STAGE: usize = 4;

pub(crate) const QUESTION: Question = Question {
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
    /// How many sites
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [10_000, 100_000])]
    count: Vec<usize>,
    /// Which sites
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_enum,
          default_values_t = [Kind::Random, Kind::Lattice, Kind::Relaxed])]
    sites: Vec<Kind>,
    /// Time the sites in this file, in the unit cube, instead
    #[arg(long, value_name = "FILE", conflicts_with_all = ["count", "sites"])]
    points: Option<PathBuf>,
    /// Write the (last) sites to this file, as comma-separated text, and time nothing
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// How many Lloyd iterations make relaxed sites
    #[arg(long, value_name = "M", default_value_t = 10)]
    moves: usize,
    /// Print the CPU time of all threads together instead of the time passed, where the system
    /// tells it (Linux): it depends less on what else the machine does
    #[arg(long)]
    cpu: bool,
    /// How often each stage is timed; the shortest time counts
    #[arg(long, value_name = "R", default_value_t = 3)]
    repeat: u32,
}

pub(crate) fn run(options: &Options, threads: Option<u32>) -> Result<(), Failure> {
    let mut table = String::from(
        "µs per site        threads    index    cells  prepare   energy  iteration  evaluations\n",
    );
    if let Some(file) = &options.points {
        let crowd = Crowd::read(file)?;
        add_rows("file", &crowd, options, threads, &mut table)?;
        return stdout::print(table);
    }
    for &count in &options.count {
        for &kind in &options.sites {
            let crowd = Crowd::new(kind, count, options.moves)?;
            if let Some(file) = &options.save {
                crowd.save(file)?;
            } else {
                let name = format!("{kind:?}").to_lowercase();
                add_rows(&name, &crowd, options, threads, &mut table)?;
            }
        }
    }
    if options.save.is_some() {
        return Ok(());
    }
    stdout::print(table)
}

/// Adds the rows of one crowd: with one thread, and with all.
fn add_rows(
    name: &str,
    crowd: &Crowd,
    options: &Options,
    threads: Option<u32>,
    table: &mut String,
) -> Result<(), Failure> {
    let all = threads.map_or_else(rayon::current_num_threads, |threads| threads as usize);
    let threads = if all > 1 { vec![1, all] } else { vec![1] };
    for threads in threads {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(Failure::run)?;
        let row = pool.install(|| time(crowd, options));
        let row = row.map_err(Failure::run)?;
        let name = format!("{name} {}", crowd.sites.len());
        let _ = write!(table, "{name:<18} {threads:>7}");
        for time in row.microseconds {
            let _ = write!(table, " {time:>8.2}");
        }
        let _ = writeln!(table, "   {:>10.2}", row.evaluations);
    }
    Ok(())
}

struct Row {
    microseconds: [f64; LAST_STAGE + 1],
    evaluations: f64,
}

/// Times the stages in turn, `repeat` times over, so that a slow moment hits all of them.
fn time(crowd: &Crowd, options: &Options) -> Result<Row, DiagramError> {
    let (sites, space) = (&crowd.sites, Space::new(Box::new(crowd.domain)));
    let domain = space.domain();
    let mut row = Row {
        microseconds: [f64::INFINITY; LAST_STAGE + 1],
        evaluations: 0.0,
    };
    for _ in 0..options.repeat.max(1) {
        for stage in 0..row.microseconds.len() {
            let watch = Watch::start(options.cpu);
            let evaluations = run_stage(stage, &space, domain, sites)?;
            let spent = watch.seconds() * 1e6 / sites.len() as f64;
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
