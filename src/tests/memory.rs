//! Memory of a run per site, beyond the sites themselves, and of weighing a print.
//!
//! Peaks of the heap are compared between two numbers of sites, so that what every thread and every
//! file takes once cancels.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::ControlFlow;
use std::path::Path;
use std::process::Command;

use crate::domain::cuboid::Cuboid;
use crate::domain::shape::PieceScratch;
use crate::export::run::directory::RunDirectory;
use crate::export::sites::write_csv;
use crate::export::vtu::{CellGeometry, VtuWriter};
use crate::gcode::settings::Filament;
use crate::gcode::weigh::weigh;
use crate::geometry::shell::Shell;
use crate::relax::driver::drive;
use crate::relax::metrics::Metrics;
use crate::relax::plan::Plan;
use crate::relax::record::Record;
use crate::relax::relaxation_space::{EnergySpec, Minimizer, Norm, RelaxationSpace};
use crate::relax::space::Space;
use crate::relax::space::shell;
use crate::relax::state::RunState;
use crate::voronoi::cell::Cell;
use crate::voronoi::diagram::{Diagram, DiagramError};
use nalgebra::Point3;
use peak_alloc::PeakAlloc;
use rayon::ThreadPoolBuilder;

use crate::tests::sites::random_sites;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Tells the test's own process, started anew, to do the work: the heap of a process is one for all
/// tests that run in it.
const IS_CHILD: &str = "CHEBLOYD_MEMORY_TEST";

/// Cubes along an edge of the smaller and of the larger number of sites.
const FEW: usize = 16;
const MANY: usize = 22;

/// Bytes per site that a run may take.
const MOST_PER_SITE: f64 = 300.0;

const QUESTION: EnergySpec = EnergySpec {
    norm: Norm::Linf,
    order: 1,
    minimizer: Minimizer::Newton,
};

/// The peak of the heap while `work` is done (bytes), beyond what is there before.
fn peak(work: impl FnOnce()) -> usize {
    let before = HEAP.current_usage();
    HEAP.reset_peak_usage();
    work();
    HEAP.peak_usage() - before
}

/// How much more each further site takes (bytes).
fn per_site(work: impl Fn(usize) -> usize + Sync) -> f64 {
    let pool = ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let [few, many] = [FEW, MANY].map(|side| pool.install(|| work(side)) as f64);
    (many - few) / (MANY.pow(3) - FEW.pow(3)) as f64
}

/// Relaxes the sites as the command does, with the files that it leaves at a run's start, during it
/// and at its end.
fn relax(space: &Space, sites: &mut Vec<Point3<f64>>, options: &Plan, folder: &Path) {
    let mut directory = RunDirectory::create(folder, "a run", &"a run").unwrap();
    directory.describe(&metrics(space, sites)).unwrap();
    let mut keep = |record: &Record, sites: &[Point3<f64>], state: &RunState<3>| {
        directory
            .record(record, sites, state.numbers(), None)
            .unwrap();
        directory.keep(record, sites, state.numbers()).unwrap();
        ControlFlow::Continue(())
    };
    let mut state = RunState::new(sites.len(), 0);
    drive(space, options, sites, &mut state, None, &mut keep).unwrap();
    crate::export::atomic_write::write(&folder.join("sites.csv"), |file| write_csv(sites, file))
        .unwrap();
    write_cells(space, sites, &folder.join("cells.vtu"));
    directory.describe(&metrics(space, sites)).unwrap();
}

fn metrics(space: &Space, sites: &[Point3<f64>]) -> Metrics {
    let cells = space.metrics(sites, QUESTION).unwrap();
    Metrics::of(space.volume(), &space.optimum(), &cells)
}

/// Writes the cells while the figures of all are held.
fn write_cells(space: &Space, sites: &[Point3<f64>], path: &Path) {
    let cells = space.metrics(sites, QUESTION).unwrap();
    let diagram = Diagram::new(space.domain(), sites).unwrap();
    let mut file = VtuWriter::new(path);
    let outline =
        |scratch: &mut PieceScratch, cell: Cell<'_>| shell(space.domain(), &cell, scratch);
    let push = |site: usize, shell: Shell| {
        let cell = &cells[site];
        let geometry = CellGeometry {
            site,
            shell,
            energy: cell.energy,
            volume: cell.volume,
            cubeness: cell.cubeness,
            facet_count: cell.facets as usize,
        };
        file.push(&geometry).unwrap();
        Ok::<(), DiagramError>(())
    };
    diagram.stream(outline, push).unwrap();
    assert_eq!(file.finish().unwrap(), sites.len() as u64);
}

/// The peak of a run of so many moves from `sites`.
fn run(mut sites: Vec<Point3<f64>>, iterations: u64, is_accelerated: bool) -> usize {
    let space = Space::new(Box::new(Cuboid::unit()));
    let options = Plan {
        is_accelerated,
        ..Plan::lloyd(QUESTION, iterations)
    };
    let folder = tempfile::tempdir().unwrap();
    peak(|| relax(&space, &mut sites, &options, folder.path()))
}

/// Does `work` in a process of its own, which runs only the test `name`.
fn alone(name: &str, work: impl FnOnce()) {
    if std::env::var_os(IS_CHILD).is_some() {
        return work();
    }
    let program = std::env::current_exe().expect("a test has a program");
    let child = Command::new(program)
        .args([&format!("tests::memory::{name}"), "--exact", "--nocapture"])
        .env(IS_CHILD, "1")
        .output()
        .expect("the test's program starts");
    let report = String::from_utf8_lossy(&child.stdout).into_owned();
    assert!(
        child.status.success() && report.contains("1 passed"),
        "{report}"
    );
}

#[test]
fn a_run_takes_little_memory_per_site() {
    alone("a_run_takes_little_memory_per_site", || {
        for is_accelerated in [false, true] {
            let bytes = per_site(|side| run(random_sites(side.pow(3), 1), 2, is_accelerated));
            assert!(bytes <= MOST_PER_SITE, "{bytes} bytes per site");
        }
    });
}

/// A text that begins again and again.
struct Repeated {
    text: &'static [u8],
    times: u64,
    at: u64,
}

impl Read for Repeated {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.text.len() as u64;
        if self.at == self.times * length {
            return Ok(0);
        }
        let rest = &self.text[(self.at % length) as usize..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for Repeated {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let SeekFrom::Start(at) = to else {
            return Err(io::ErrorKind::Unsupported.into());
        };
        self.at = at;
        Ok(at)
    }
}

#[test]
fn weighing_a_print_takes_no_memory_per_line() {
    let weigh_copies = |times| {
        let text = include_bytes!("../../tests/cases/gcode/bar-cura.gcode");
        let at = 0;
        let mut print = Repeated { text, times, at };
        peak(|| drop(weigh(&mut print, Filament::default()).unwrap()))
    };
    alone("weighing_a_print_takes_no_memory_per_line", || {
        let (once, often) = (weigh_copies(1), weigh_copies(20));
        // Beside what the test harness takes meanwhile; the text is 224 kB.
        assert!(often < once + 10_000, "{once} and {often} bytes");
        assert!(once < 1_000_000, "{once} bytes");
    });
}
