//! What the command line says instead of the scene.

use std::path::PathBuf;

use crate::scene::description::Scene;
use crate::scene::error::Error;
use crate::scene::method::{Method, MethodName};
use crate::scene::method_overrides::MethodOverrides;
use crate::scene::norm::Norm;
use crate::scene::sites::Sites;

/// Values that replace those of a scene; what is `None` stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// A site file instead of the scene's sites; relative to the working folder.
    pub sites: Option<PathBuf>,
    /// How many random sites.
    pub count: Option<usize>,
    /// The seed of random sites or of a grid's jitter.
    pub seed: Option<u64>,
    /// How many moves at most.
    pub iterations: Option<u64>,
    /// Leaves out sites outside the domain.
    pub drop_outside: bool,
    /// The distance to minimize.
    pub norm: Option<Norm>,
    /// The method's name, with its defaults unless the scene has it already.
    pub method: Option<MethodName>,
    /// Whether the method is to be the one that makes cubes.
    pub is_for_cubes: bool,
    /// How often to divide the number of sites by eight first.
    pub coarse_to_fine: Option<u32>,
    /// The movement in percent below which to stop.
    pub tolerance: Option<f64>,
    /// The order p of the Chebyshev energy.
    pub order: Option<u32>,
    /// What replaces the method's own keys.
    pub of_method: MethodOverrides,
}

impl Overrides {
    /// Changes `scene` as told.
    ///
    /// # Errors
    /// [`Error::Override`] for `count` or `seed` on sites that have none and for keys that the method
    /// does not have, [`Error::Read`] for a
    /// site file that is not there.
    pub fn apply(&self, scene: &mut Scene) -> Result<(), Error> {
        self.apply_to_sites(&mut scene.sites)?;
        scene.drop_outside |= self.drop_outside;
        if let Some(norm) = self.norm {
            scene.norm = norm;
        }
        if let Some(name) = self.method {
            scene.method.choose(name);
        }
        if self.is_for_cubes {
            scene.method = Method::cubes();
        }
        if self.coarse_to_fine.is_some() {
            scene.coarse_to_fine = self.coarse_to_fine;
        }
        if let Some(iterations) = self.iterations {
            scene.method.set_iterations(iterations);
        }
        if let Some(tolerance) = self.tolerance {
            scene.method.set_tolerance(tolerance);
        }
        if let Some(order) = self.order {
            scene.order = order;
        }
        self.of_method.apply(&mut scene.method)
    }

    fn apply_to_sites(&self, sites: &mut Sites) -> Result<(), Error> {
        if let Some(path) = &self.sites {
            let absolute = path.canonicalize().map_err(|source| Error::Read {
                path: path.clone(),
                source,
            })?;
            *sites = Sites::File(absolute);
        }
        if let Some(count) = self.count {
            set_count(sites, count)?;
        }
        if let Some(seed) = self.seed {
            set_seed(sites, seed)?;
        }
        Ok(())
    }
}

fn set_count(sites: &mut Sites, count: usize) -> Result<(), Error> {
    match sites {
        Sites::Random(random) => random.count = count,
        Sites::Grid(_) | Sites::List(_) | Sites::File(_) => {
            return Err(Error::Override {
                option: "--count",
                message: "only random sites can be of any number".to_owned(),
            });
        }
    }
    Ok(())
}

fn set_seed(sites: &mut Sites, seed: u64) -> Result<(), Error> {
    match sites {
        Sites::Random(random) => random.seed = seed,
        Sites::Grid(grid) => grid.seed = seed,
        Sites::List(_) | Sites::File(_) => {
            return Err(Error::Override {
                option: "--seed",
                message: "given sites have no seed".to_owned(),
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_override_lands_where_it_belongs() {
        let mut scene = Scene::embedded();
        let overrides = Overrides {
            count: Some(7),
            seed: Some(9),
            iterations: Some(3),
            norm: Some(Norm::L2),
            method: Some(MethodName::Lloyd),
            tolerance: Some(0.25),
            sites: None,
            drop_outside: true,
            ..Overrides::default()
        };
        overrides.apply(&mut scene).expect("they fit");
        let text = serde_json::to_value(&scene).expect("a scene is JSON");
        assert_eq!(text["sites"]["random"]["count"], 7);
        assert_eq!(text["sites"]["random"]["seed"], 9);
        assert_eq!(text["norm"], "l2");
        assert_eq!(text["drop_outside"], true);
        assert_eq!(text["method"]["lloyd"]["iterations"], 3);
        assert_eq!(text["method"]["lloyd"]["tolerance"], 0.25);
    }

    #[test]
    fn given_sites_can_be_neither_counted_nor_seeded() {
        let mut scene = Scene::embedded();
        scene.sites = Sites::List(vec![vec![0.5; 3]]);
        for overrides in [
            Overrides {
                count: Some(2),
                ..Overrides::default()
            },
            Overrides {
                seed: Some(2),
                ..Overrides::default()
            },
        ] {
            let error = overrides.apply(&mut scene).unwrap_err();
            assert!(error.to_string().contains("does not fit"), "{error}");
        }
    }
}
