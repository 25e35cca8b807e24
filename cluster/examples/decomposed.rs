//! Cells within a decomposition that is somebody else's.
//!
//! `mpirun -n R decomposed [COUNT [WIDTH [FILE.csv]]]`: the box is cut into slabs along x, as another program may
//! have done it; every rank owns the sites of its slab and is sent ghosts from up to WIDTH beyond it. It asks for
//! the cells of its own sites alone. Every cell says how far it asks for others and whether the halo certifies it,
//! so that a thin halo is noticed: then it is widened by what was asked for. Sites have 64-bit numbers of the
//! program's own; volumes and neighbors are the same, to the bit, for any number of ranks.

use std::error::Error;
use std::fmt::Write;

use chebloyd::{Bounds, Cuboid, Diagram, FacetKind, Ranks, random_sites};
use chebloyd_mpi::World;
use mpi::Threading;

/// The numbers of the program's sites begin somewhere beyond 32 bits.
const FIRST_NUMBER: u64 = 7 << 40;

/// A site with its number, coordinates as bits.
type Site = [u64; 4];

/// What is asked of a cell.
struct Answer {
    volume: f64,
    /// The sum of its neighbors' numbers, which tells sets of them apart.
    neighbors: u64,
    /// How wide the halo would have to be (L).
    needed: f64,
    is_certified: bool,
}

fn position([_, x, y, z]: &Site) -> [f64; 3] {
    [x, y, z].map(|bits| f64::from_bits(*bits))
}

/// The slab of a rank of the unit cube, `width` wider on both sides where there is anything.
fn slab(rank: usize, width: f64) -> Bounds<3> {
    let size = World.size() as f64;
    let (low, high) = (rank as f64 / size, (rank + 1) as f64 / size);
    let ends = [(low - width).max(0.0), (high + width).min(1.0)];
    Bounds::from_corners([ends[0], 0.0, 0.0], [ends[1], 1.0, 1.0])
}

/// The own sites and the ghosts that the others send, by number.
fn with_ghosts(own: &[Site], width: f64) -> Vec<Site> {
    let part = |rank: usize| {
        let wanted = slab(rank, width);
        let sent = own
            .iter()
            .filter(|site| wanted.contains(&position(site).into()));
        sent.flatten().copied().collect::<Vec<u64>>()
    };
    let came = World.exchange((0..World.size()).map(part).collect());
    let mut all: Vec<Site> = came
        .iter()
        .flat_map(|part| part.as_chunks::<4>().0)
        .copied()
        .collect();
    // Local indices in the order of the numbers: then equally distant sites fall as in one process.
    all.sort_unstable();
    all.dedup();
    all
}

/// The cells of the own sites among those known.
fn cells(domain: &Cuboid, own: &[Site], width: f64) -> Result<Vec<Answer>, Box<dyn Error>> {
    let all = with_ghosts(own, width);
    let known = slab(World.rank(), width);
    let inner = slab(World.rank(), 0.0);
    let positions: Vec<[f64; 3]> = all.iter().map(position).collect();
    let place = |site: &Site| all.binary_search(site);
    let chosen = own.iter().map(place).collect::<Result<Vec<usize>, _>>();
    let chosen = chosen.map_err(|_| "a site of this rank is not in its slab")?;
    if chosen.is_empty() {
        return Ok(Vec::new());
    }
    let diagram = Diagram::new(domain, &positions)?;
    let answers = diagram.map_cells_of(&chosen, |cell| {
        let facets = cell.facets();
        let neighbors = facets.iter().map(|facet| match facet.kind {
            FacetKind::Neighbor { site, .. } => all[site as usize][0],
            _ => 0,
        });
        let x = cell.position.x;
        let to_side = (x - inner.min.x).min(inner.max.x - x);
        Answer {
            volume: cell.volume(),
            neighbors: neighbors.fold(0, u64::wrapping_add),
            needed: cell.reach() - to_side,
            is_certified: cell.is_certified(&known),
        }
    })?;
    Ok(answers)
}

fn run(count: usize, mut width: f64, file: Option<&str>) -> Result<(), Box<dyn Error>> {
    let domain = Cuboid::unit();
    let mine = slab(World.rank(), 0.0);
    let numbered = random_sites(&domain, count, 1)?
        .into_iter()
        .zip(FIRST_NUMBER..);
    let is_mine = |x: f64| mine.min.x <= x && (x < mine.max.x || mine.max.x >= 1.0);
    let own = numbered.filter(|(site, _)| is_mine(site.x));
    let own: Vec<Site> = own
        .map(|(site, number)| [number, site.x.to_bits(), site.y.to_bits(), site.z.to_bits()])
        .collect();
    let answers = loop {
        let answers = cells(&domain, &own, width)?;
        let doubtful = answers.iter().filter(|answer| !answer.is_certified).count();
        let needed = answers.iter().filter(|answer| !answer.is_certified);
        let mut largest = [needed.map(|answer| answer.needed).fold(0.0, f64::max)];
        World.largest(&mut largest);
        if largest[0] <= 0.0 {
            break answers;
        }
        let (rank, own) = (World.rank(), own.len());
        eprintln!(
            "rank {rank}: {doubtful} of {own} cells are not certified by a halo of {width:.3}"
        );
        width = 1.001 * largest[0];
    };
    let words = own.iter().zip(&answers);
    let words =
        words.flat_map(|(site, answer)| [site[0], answer.volume.to_bits(), answer.neighbors]);
    let came = World.share(words.collect());
    if World.rank() > 0 {
        return Ok(());
    }
    let mut rows: Vec<[u64; 3]> = came
        .iter()
        .flat_map(|part| part.as_chunks::<3>().0)
        .copied()
        .collect();
    rows.sort_unstable();
    let volume: f64 = rows.iter().map(|row| f64::from_bits(row[1])).sum();
    println!("{} cells, volume {volume:.12}, halo {width:.3}", rows.len());
    let Some(file) = file else { return Ok(()) };
    let mut text = "number,volume,neighbors\n".to_owned();
    for [number, volume, neighbors] in rows {
        writeln!(text, "{number},{:?},{neighbors}", f64::from_bits(volume))?;
    }
    Ok(std::fs::write(file, text)?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let _universe =
        mpi::initialize_with_threading(Threading::Funneled).ok_or("MPI is initialized already")?;
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let argument = |place: usize| arguments.get(place).map(String::as_str);
    let count: usize = argument(0).map_or(Ok(2000), str::parse)?;
    // About half of what random sites need: noticed, then widened.
    let width: f64 = argument(1).map_or(Ok(1.5 / (count as f64).cbrt()), str::parse)?;
    run(count, width, argument(2))
}
