//! The first sites of a run over ranks: an array in a file is read in parts, all others are placed by the first rank.

use std::path::Path;

use nalgebra::Point3;

use crate::cli::agreement::together;
use crate::cli::failure::Failure;
use crate::cli::identity::{of_parts, of_sites};
use crate::cli::options::print_notes;
use crate::mesh::formats::unpack::extension_of;
use crate::relax::ranked_sites::RankedSites;
use crate::relax::ranks::{Ranks, SomeSites, any};
use crate::relax::space::Space;
use crate::scene::description::Scene;
use crate::scene::npy::{NpyPart, read_part};
use crate::scene::place::{check_part, twins};
use crate::scene::run::RunSpace;
use crate::scene::site_file::SiteFormat;
use crate::scene::sites::Sites;

/// What a rank has of the sites before they are distributed.
#[derive(Default)]
pub(crate) struct PlacedPart {
    sites: SomeSites,
    dropped: usize,
    /// The part of the run's identity that tells sites apart; the first rank has it.
    sum: String,
    /// Whether two sites in one place would be a news.
    is_of_parts: bool,
}

/// How many sites there are, how many were left out, and the part of the run's identity that tells them apart.
pub(crate) struct Counted {
    pub(crate) sites: usize,
    pub(crate) dropped: usize,
    pub(crate) sum: String,
}

/// The sites of a scene.
pub(crate) fn place(
    ranks: &dyn Ranks,
    space: &Space,
    scene: &Scene,
) -> Result<PlacedPart, Failure> {
    if let Some(path) = read_in_parts(scene) {
        let share = [ranks.rank(), ranks.size()].map(|number| number as u64);
        let part = read_part(path, share);
        let part = together(ranks, part.map_err(Failure::input))?;
        let is_whole = any(ranks, part.is_none());
        if let (Some(part), false) = (part, is_whole) {
            return PlacedPart::of_rows(ranks, space, part);
        }
    }
    place_at_first(ranks, space, scene)
}

/// The sites of a scene, all of the first rank.
fn place_at_first(ranks: &dyn Ranks, space: &Space, scene: &Scene) -> Result<PlacedPart, Failure> {
    let placed = (ranks.rank() == 0).then(|| space.placed(scene).map_err(Failure::input));
    let Some(placed) = together(ranks, placed.transpose())? else {
        return Ok(PlacedPart::default());
    };
    print_notes(&placed.notes);
    Ok(PlacedPart {
        dropped: placed.dropped,
        ..PlacedPart::of_first(placed.sites)
    })
}

/// The file of the scene's sites, if it is an array.
fn read_in_parts(scene: &Scene) -> Option<&Path> {
    let Sites::File(path) = &scene.sites else {
        return None;
    };
    let is_array = match scene.sites_format {
        Some(format) => format == SiteFormat::Npy,
        None => extension_of(path) == "npy",
    };
    (is_array && !scene.drop_outside).then_some(path)
}

impl PlacedPart {
    /// All sites, of the first rank.
    pub(crate) fn of_first(sites: Vec<Point3<f64>>) -> Self {
        Self {
            sum: of_sites(&sites),
            sites: SomeSites::following(0, sites),
            ..Self::default()
        }
    }

    /// Some rows of an array.
    fn of_rows(ranks: &dyn Ranks, space: &Space, part: NpyPart) -> Result<Self, Failure> {
        let checked = check_part(&part.rows, part.first as usize, &space.region());
        together(ranks, checked.map_err(Failure::input))?;
        let mut count = [part.rows.len() as i64];
        ranks.add(&mut count);
        Ok(Self {
            sum: of_parts(ranks, count[0] as usize, &part.rows),
            sites: SomeSites::following(part.first, part.rows),
            is_of_parts: true,
            ..Self::default()
        })
    }

    /// The sites, each with the rank in whose brick it lies.
    pub(crate) fn distributed<'a>(
        self,
        ranks: &'a dyn Ranks,
        space: &'a Space,
    ) -> Result<(RankedSites<'a>, Counted), Failure> {
        let sites = RankedSites::new(ranks, space, self.sites);
        let pair = self.is_of_parts.then(|| sites.twins()).flatten();
        let refused = pair.map(|(numbers, place)| Failure::input(twins(numbers, &place)));
        together(ranks, refused.map_or(Ok(()), Err))?;
        let counted = Counted {
            sites: sites.count,
            dropped: self.dropped,
            sum: self.sum,
        };
        Ok((sites, counted))
    }
}
