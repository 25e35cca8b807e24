//! `chebloyd measure`: the figures of a tessellation, as JSON.

use clap::Args;

use crate::relax::metrics::{CellMetrics, Metrics};
use crate::scene::description::Scene;
use crate::scene::overrides::Overrides;
use crate::scene::run::{RunSpace, energy_spec, plane};

use crate::cli::cell_tables::TableOptions;
use crate::cli::failure::{Failure, print};
use crate::cli::options::{SceneOptions, print_notes, space};

/// Print the figures of the tessellation of given sites, as one JSON object
#[derive(Debug, Args)]
pub(crate) struct MeasureOptions {
    #[command(flatten)]
    scene: SceneOptions,
    /// Print every cell too, in site order
    #[arg(long)]
    per_cell: bool,
    #[command(flatten)]
    tables: TableOptions,
}

pub(crate) fn run(options: &MeasureOptions) -> Result<(), Failure> {
    let scene = options.scene.scene(Overrides::default())?;
    options
        .tables
        .check(&scene, &options.scene.inputs(&scene))?;
    match scene.dimension {
        2 => {
            let plane = plane(&scene).map_err(Failure::input)?;
            print_figures(&plane, &scene, options.per_cell)
        }
        _ => {
            let space = space(&scene)?;
            if options.tables.is_wanted() {
                let sites = space.place(&scene).map_err(Failure::input)?;
                let cells = space.metrics(&sites, energy_spec(&scene));
                let cells = cells.map_err(Failure::input)?;
                options.tables.write((&space, &scene), &sites, &cells)?;
            }
            print_figures(&space, &scene, options.per_cell)
        }
    }
}

fn print_figures<const D: usize>(
    space: &impl RunSpace<D>,
    scene: &Scene,
    per_cell: bool,
) -> Result<(), Failure> {
    let placed = space.placed(scene).map_err(Failure::input)?;
    print_notes(&placed.notes);
    let sites = placed.sites;
    let cells = space
        .cells(&sites, energy_spec(scene))
        .map_err(Failure::input)?;
    let figures = space.figures(&sites, &cells).map_err(Failure::input)?;
    let figures = figures.checked(0).map_err(Failure::input)?;
    let text = object(&figures, placed.dropped, per_cell.then_some(&cells));
    let text = text.map_err(Failure::run)?;
    print(text)
}

/// The figures as one JSON object; those of every cell too, one per line, where they are given.
fn object<const D: usize>(
    figures: &Metrics,
    dropped: usize,
    cells: Option<&Vec<CellMetrics<D>>>,
) -> serde_json::Result<String> {
    let mut text = serde_json::to_string_pretty(figures)?;
    if dropped > 0 {
        let head = text.strip_suffix("\n}").unwrap_or(&text);
        text = format!("{head},\n  \"dropped_outside\": {dropped}\n}}");
    }
    let Some(cells) = cells else {
        return Ok(text + "\n");
    };
    let lines = cells.iter().map(serde_json::to_string);
    let lines = lines
        .collect::<serde_json::Result<Vec<_>>>()?
        .join(",\n    ");
    let head = text.strip_suffix("\n}").unwrap_or(&text);
    Ok(format!("{head},\n  \"cells\": [\n    {lines}\n  ]\n}}\n"))
}
