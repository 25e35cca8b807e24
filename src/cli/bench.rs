//! `chebloyd bench`: the stages of an iteration, timed.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use nalgebra::{Point3, Vector3};
use rayon::ThreadPoolBuilder;

use crate::cli::bench_sites::{BenchSites, ENERGY, SiteKind};
use crate::cli::failure::{Failure, print};
use crate::cli::output::OutputRule;
use crate::cli::stopwatch::{Stopwatch, peak_memory, reset_peak_memory};
use crate::domain::domain::Domain;
use crate::relax::evaluate_cell::CellMemory;
use crate::relax::linf::LinfCells;
use crate::relax::relaxation_space::RelaxationSpace;
use crate::relax::space::Space;
use crate::voronoi::diagram::Diagram;

/// What is timed; the order is that of the columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum BenchStage {
    /// Building the index
    Index,
    /// Building the cells
    Cells,
    /// Preparing the cells for integrals
    Prepare,
    /// One energy with gradient and Hessian
    Energy,
    /// A whole iteration, with the minimizer
    Iteration,
    /// The global objective with its gradient
    Global,
    /// The global objective of L∞ cells with its gradient
    Linf,
    /// A whole iteration of L∞ cells, with the minimizer
    LinfMove,
}

const STAGES: [BenchStage; 8] = [
    BenchStage::Index,
    BenchStage::Cells,
    BenchStage::Prepare,
    BenchStage::Energy,
    BenchStage::Iteration,
    BenchStage::Global,
    BenchStage::Linf,
    BenchStage::LinfMove,
];

/// Time the stages of an iteration on this machine, per site
///
/// Each stage includes the ones to its left: building the index, building the cells, preparing
/// them for integrals, one energy with gradient and Hessian, and the whole iteration with the
/// minimizer. "global" is the objective of all sites together with its gradient, what a step of
/// quasi-newton takes; "linf" is the same with L∞ cells, "linfmove" a whole iteration with them. "evaluations"
/// counts those of an iteration, per site. "MB" is the most memory that was resident meanwhile, sites
/// included, where the system counts it (Linux).
#[derive(Debug, Args)]
pub(crate) struct BenchOptions {
    /// How many sites
    #[arg(long, value_name = "N", value_delimiter = ',', default_values_t = [10_000, 100_000])]
    count: Vec<usize>,
    /// Which sites
    #[arg(long, value_name = "KIND", value_delimiter = ',', value_enum,
          default_values_t = [SiteKind::Random, SiteKind::Lattice, SiteKind::Relaxed])]
    sites: Vec<SiteKind>,
    /// Time the sites in this file, in the unit cube, instead
    #[arg(long, value_name = "FILE", conflicts_with_all = ["count", "sites"])]
    points: Option<PathBuf>,
    /// Write the (last) sites to this file, as comma-separated text, and time nothing
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
    /// Replace the file that --save names
    #[arg(long, requires = "save")]
    force: bool,
    /// What to time
    #[arg(long, value_name = "STAGE", value_delimiter = ',', value_enum, default_values_t = STAGES)]
    stages: Vec<BenchStage>,
    /// How many Lloyd iterations make relaxed sites
    #[arg(long, value_name = "M", default_value_t = 50)]
    moves: usize,
    /// Print the CPU time of all threads together instead of the time passed, where the system
    /// counts it (Linux): it depends less on what else the machine does
    #[arg(long)]
    cpu: bool,
    /// How often each stage is timed; the shortest time counts
    #[arg(long, value_name = "R", default_value_t = 3)]
    repeat: u32,
}

/// Why sites cannot be timed.
type BenchError = Box<dyn std::error::Error + Send + Sync>;

pub(crate) fn run(options: &BenchOptions, threads: Option<u32>) -> Result<(), Failure> {
    if let Some(file) = &options.save {
        return save(file, options);
    }
    let mut table = format!("{:<18} {:>7}", "µs per site", "threads");
    for stage in STAGES {
        let _ = write!(table, " {:>9}", name(stage));
    }
    let _ = writeln!(table, " {:>11} {:>6}", "evaluations", "MB");
    if let Some(file) = &options.points {
        let sites = BenchSites::read(file)?;
        add_rows("file", &sites, options, threads, &mut table)?;
        return print(table);
    }
    for &count in &options.count {
        for &kind in &options.sites {
            let sites = BenchSites::new(kind, count, options.moves)?;
            add_rows(&name(kind), &sites, options, threads, &mut table)?;
        }
    }
    print(table)
}

/// Writes the last of the sites.
fn save(file: &Path, options: &BenchOptions) -> Result<(), Failure> {
    let inputs: Vec<PathBuf> = options.points.iter().cloned().collect();
    let rule = OutputRule {
        inputs: &inputs,
        force: options.force,
        option: "--save",
    };
    rule.check(&[file.to_owned()])?;
    match (&options.points, options.sites.last(), options.count.last()) {
        (Some(points), ..) => BenchSites::read(points)?.save(file),
        (None, Some(&kind), Some(&count)) => {
            BenchSites::new(kind, count, options.moves)?.save(file)
        }
        _ => Ok(()),
    }
}

/// The name of a kind or a stage.
fn name(value: impl std::fmt::Debug) -> String {
    format!("{value:?}").to_lowercase()
}

/// Adds the rows of some sites: with one thread, and with all.
fn add_rows(
    name: &str,
    sites: &BenchSites,
    options: &BenchOptions,
    threads: Option<u32>,
    table: &mut String,
) -> Result<(), Failure> {
    let all = threads.map_or_else(rayon::current_num_threads, |threads| threads as usize);
    let threads = if all > 1 { vec![1, all] } else { vec![1] };
    for threads in threads {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.map_err(Failure::run)?;
        reset_peak_memory();
        let row = pool.install(|| time(sites, options));
        let row = row.map_err(Failure::run)?;
        let name = format!("{name} {}", sites.sites.len());
        let _ = write!(table, "{name:<18} {threads:>7}");
        for time in row.microseconds {
            let _ = write!(table, " {:>9}", shown(time, 2));
        }
        let _ = write!(table, " {:>11}", shown(row.evaluations, 2));
        let megabytes = peak_memory().map(|bytes| bytes as f64 / 1e6);
        let _ = writeln!(table, " {:>6}", shown(megabytes, 0));
    }
    Ok(())
}

fn shown(number: Option<f64>, digits: usize) -> String {
    number.map_or_else(|| "-".to_owned(), |number| format!("{number:.digits$}"))
}

#[derive(Debug, Default)]
struct Row {
    microseconds: [Option<f64>; STAGES.len()],
    evaluations: Option<f64>,
}

/// Times the stages in turn, `repeat` times over, so that a slow moment hits all of them.
fn time(sites: &BenchSites, options: &BenchOptions) -> Result<Row, BenchError> {
    let (sites, space) = (&sites.sites, Space::new(Box::new(sites.domain)));
    let count = sites.len() as f64;
    let mut row = Row::default();
    for _ in 0..options.repeat.max(1) {
        for (stage, shortest) in STAGES.into_iter().zip(&mut row.microseconds) {
            if !options.stages.contains(&stage) {
                continue;
            }
            let stopwatch = Stopwatch::start(options.cpu);
            let evaluations = run_stage(stage, &space, sites)?;
            let spent = stopwatch.seconds() * 1e6 / count;
            *shortest = Some(shortest.map_or(spent, |shortest| shortest.min(spent)));
            if stage == BenchStage::Iteration {
                row.evaluations = Some(evaluations as f64 / count);
            }
        }
    }
    Ok(row)
}

/// Does the work up to a stage and returns how many energies the minimizer evaluated.
fn run_stage(stage: BenchStage, space: &Space, sites: &[Point3<f64>]) -> Result<u64, BenchError> {
    let domain = space.domain();
    match stage {
        BenchStage::Iteration => {
            let cells = space.assess(sites, ENERGY)?;
            return Ok(cells.iter().map(|cell| u64::from(cell.evaluations)).sum());
        }
        BenchStage::Global => drop(space.objective(sites, ENERGY.order)?),
        BenchStage::Linf => drop(LinfCells::new(domain, sites).objective(ENERGY.order)?),
        BenchStage::LinfMove => drop(LinfCells::new(domain, sites).assess(ENERGY)?),
        _ => run_part(stage, domain, &Diagram::borrowed(domain, sites)?)?,
    }
    Ok(0)
}

/// Does the work of a stage that has no minimizer.
fn run_part(
    stage: BenchStage,
    domain: &dyn Domain,
    diagram: &Diagram<'_>,
) -> Result<(), BenchError> {
    match stage {
        BenchStage::Index => diagram.sort_sites(),
        BenchStage::Cells => {
            diagram.map(|(): &mut (), cell| cell.half_spaces().len())?;
        }
        BenchStage::Prepare => {
            diagram.map(|memory: &mut CellMemory, cell| memory.load(domain, &cell))?;
        }
        _ => {
            diagram.map(|memory: &mut CellMemory, cell| {
                memory.load(domain, &cell);
                memory.evaluate(&Vector3::zeros(), 1).value
            })?;
        }
    }
    Ok(())
}
