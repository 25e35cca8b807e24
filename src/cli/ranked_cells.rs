//! The cells of a run over ranks: each rank writes those of its own sites, `cells_R.vtu`, and the first one the
//! list of these pieces, `cells.pvtu`, which readers of VTK files open.
//!
//! Source: VTK file formats, docs.vtk.org, `PUnstructuredGrid`: the arrays of the pieces by name and type, then the
//! pieces. A rank without sites writes none.

use std::io::Write;
use std::path::Path;

use crate::cli::failure::{Failure, write_file};
use crate::domain::shape::PieceScratch;
use crate::export::run::directory::{PIECES, RunDirectory};
use crate::export::vtu::{CellGeometry, VtuWriter};
use crate::geometry::shell::Shell;
use crate::relax::metrics::CellMetrics;
use crate::relax::ranked_sites::RankedSites;
use crate::relax::ranks::Ranks;
use crate::relax::space::shells;

/// Cells that are held at a time: some hundred megabytes.
const HELD: usize = 1 << 15;

/// The arrays of cells in a piece: type, name.
const ARRAYS: [(&str, &str); 5] = [
    ("Int64", "site"),
    ("Float64", "energy"),
    ("Float64", "volume"),
    ("Float64", "cubeness"),
    ("Int64", "facets"),
];

/// Writes the piece of this rank in the run's directory `out`; nothing where it has no sites. All ranks must call.
pub(crate) fn write_piece(
    out: &Path,
    sites: &mut RankedSites<'_>,
    cells: &[CellMetrics<3>],
) -> Result<(), Failure> {
    let domain = sites.space.domain();
    let path = out.join(RunDirectory::piece(sites.ranks.rank()));
    let mut file = (!cells.is_empty()).then(|| VtuWriter::new(&path));
    let mut written = Ok(());
    let numbers = sites.own.numbers.clone();
    let mut numbered = numbers.into_iter().zip(cells);
    let add = |shell: Shell| {
        let next = numbered.next().zip(file.as_mut());
        if let (Some(((number, cell), file)), Ok(())) = (next, &written) {
            written = file.push(&geometry(number as usize, shell, cell));
        }
    };
    let built = sites.stream_own(
        HELD,
        |scratch: &mut PieceScratch, cell| {
            let [shell, _] = shells(domain, cell, scratch, |_| false);
            shell
        },
        add,
    );
    built.map_err(Failure::run)?;
    written.map_err(Failure::run)?;
    file.map_or(Ok(0), VtuWriter::finish)
        .map_err(Failure::run)?;
    Ok(())
}

fn geometry(site: usize, shell: Shell, cell: &CellMetrics<3>) -> CellGeometry {
    CellGeometry {
        site,
        shell,
        energy: cell.energy,
        volume: cell.volume,
        cubeness: cell.cubeness,
        facet_count: cell.facets as usize,
    }
}

/// The ranks that have sites of their own; all must ask.
pub(crate) fn ranks_with_sites(ranks: &dyn Ranks, own: usize) -> Vec<usize> {
    let counts = ranks.share(vec![own as u64]);
    let all = counts.iter().enumerate();
    let some = all.filter(|(_, count)| count.iter().any(|&count| count > 0));
    some.map(|(rank, _)| rank).collect()
}

/// Writes the list of the pieces of these ranks.
pub(crate) fn write_list(directory: &RunDirectory, ranks: &[usize]) -> Result<(), Failure> {
    let text = list(ranks);
    let written = write_file(&directory.file(PIECES), |file| {
        file.write_all(text.as_bytes())
    });
    written.map_err(Failure::run)
}

fn list(ranks: &[usize]) -> String {
    let arrays =
        ARRAYS.map(|(kind, name)| format!("      <PDataArray type=\"{kind}\" Name=\"{name}\"/>\n"));
    let pieces = ranks.iter().map(|&rank| {
        let piece = RunDirectory::piece(rank);
        format!("    <Piece Source=\"{piece}\"/>\n")
    });
    format!(
        "<?xml version=\"1.0\"?>\n\
         <VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  \
           <PUnstructuredGrid GhostLevel=\"0\">\n    \
             <PPoints>\n      \
               <PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n    \
             </PPoints>\n    \
             <PCellData>\n{}    \
             </PCellData>\n{}  \
           </PUnstructuredGrid>\n\
         </VTKFile>\n",
        arrays.concat(),
        pieces.collect::<String>()
    )
}
