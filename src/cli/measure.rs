//! `chebloyd measure`.

use clap::Args;

use chebloyd::relax::metrics::{CellFigures, Figures};
use chebloyd::scene::description::Scene;
use chebloyd::scene::overrides::Overrides;

use crate::cli::failure::Failure;
use crate::cli::ground::{Ground, plane, space};
use crate::cli::question::question;
use crate::cli::scene_options::SceneOptions;
use crate::cli::stdout;

/// Print what the tessellation of given sites is worth, as one JSON object
#[derive(Debug, Args)]
pub(crate) struct Options {
    #[command(flatten)]
    scene: SceneOptions,
    /// Print every cell too, in site order
    #[arg(long)]
    per_cell: bool,
}

pub(crate) fn run(options: &Options) -> Result<(), Failure> {
    let scene = options.scene.scene(Overrides::default())?;
    match scene.dimension {
        2 => print(&plane(&scene)?, &scene, options.per_cell),
        _ => print(&space(&scene)?, &scene, options.per_cell),
    }
}

fn print<const D: usize>(
    ground: &impl Ground<D>,
    scene: &Scene,
    per_cell: bool,
) -> Result<(), Failure> {
    let sites = ground.place(scene)?;
    let cells = ground
        .cells(&sites, question(scene))
        .map_err(Failure::input)?;
    let figures = Figures::of(ground.volume(), &cells);
    let text = object(&figures, per_cell.then_some(&cells)).map_err(Failure::run)?;
    stdout::print(text)
}

/// The figures as one JSON object; those of every cell too, one per line, where they are given.
fn object<const D: usize>(
    figures: &Figures,
    cells: Option<&Vec<CellFigures<D>>>,
) -> serde_json::Result<String> {
    let text = serde_json::to_string_pretty(figures)?;
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
