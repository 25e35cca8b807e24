//! What the command line says instead of the keys of a method.

use crate::scene::error::Error;
use crate::scene::method::Method;

/// Values that replace those of a scene's method; what is `None` stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MethodOverrides {
    /// Lengthens Lloyd's moves where that ends lower.
    pub accelerate: bool,
    /// How many of Lloyd's moves come first.
    pub warm_up: Option<u64>,
    /// How many steps the model of the curvature remembers.
    pub memory: Option<usize>,
    /// The projected gradient at which a descent ends.
    pub gradient_tolerance: Option<f64>,
    /// How many rounds.
    pub rounds: Option<u64>,
    /// The greatest noise, in sides of the mean cell.
    pub noise: Option<f64>,
}

impl MethodOverrides {
    /// Changes `method` as told.
    ///
    /// # Errors
    /// [`Error::Override`] for what the method does not know.
    pub fn apply(&self, method: &mut Method) -> Result<(), Error> {
        match method {
            Method::Lloyd(lloyd) => {
                self.refuse_for_descents(method_name("lloyd"))?;
                self.refuse_for_rounds(method_name("lloyd"))?;
                lloyd.accelerate |= self.accelerate;
            }
            Method::QuasiNewton(descent) => {
                self.refuse_acceleration()?;
                self.refuse_for_rounds(method_name("quasi-newton"))?;
                set(&mut descent.warm_up, self.warm_up);
                set(&mut descent.memory, self.memory);
                set(&mut descent.gradient_tolerance, self.gradient_tolerance);
            }
            Method::Anneal(anneal) => {
                self.refuse_acceleration()?;
                set(&mut anneal.warm_up, self.warm_up);
                set(&mut anneal.memory, self.memory);
                set(&mut anneal.gradient_tolerance, self.gradient_tolerance);
                set(&mut anneal.rounds, self.rounds);
                set(&mut anneal.noise, self.noise);
            }
        }
        Ok(())
    }

    fn refuse_acceleration(&self) -> Result<(), Error> {
        refuse(
            &[("--accelerate", self.accelerate)],
            "only \"lloyd\" knows it",
        )
    }

    fn refuse_for_descents(&self, name: String) -> Result<(), Error> {
        let given = [
            ("--warm-up", self.warm_up.is_some()),
            ("--memory", self.memory.is_some()),
            ("--gradient-tolerance", self.gradient_tolerance.is_some()),
        ];
        refuse(
            &given,
            &format!("{name}; \"quasi-newton\" and \"anneal\" do"),
        )
    }

    fn refuse_for_rounds(&self, name: String) -> Result<(), Error> {
        let given = [
            ("--rounds", self.rounds.is_some()),
            ("--noise", self.noise.is_some()),
        ];
        refuse(&given, &format!("{name}; \"anneal\" does"))
    }
}

fn method_name(name: &str) -> String {
    format!("the method \"{name}\" does not know it")
}

fn set<T: Copy>(value: &mut T, told: Option<T>) {
    if let Some(told) = told {
        *value = told;
    }
}

fn refuse(given: &[(&'static str, bool)], message: &str) -> Result<(), Error> {
    match given.iter().find(|(_, is_given)| *is_given) {
        Some(&(option, _)) => Err(Error::Override {
            option,
            message: message.to_owned(),
        }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::method::MethodName;

    fn method(name: MethodName) -> Method {
        let mut method = Method::default();
        method.choose(name);
        method
    }

    #[test]
    fn every_option_lands_where_it_belongs() {
        let told = MethodOverrides {
            warm_up: Some(2),
            memory: Some(5),
            gradient_tolerance: Some(1e-3),
            rounds: Some(7),
            noise: Some(0.25),
            ..MethodOverrides::default()
        };
        let mut anneal = method(MethodName::Anneal);
        told.apply(&mut anneal).expect("annealing knows them all");
        let Method::Anneal(keys) = anneal else {
            panic!("the method stays what it is")
        };
        assert_eq!((keys.warm_up, keys.memory, keys.rounds), (2, 5, 7));
        assert!((keys.gradient_tolerance - 1e-3).abs() < 1e-18);
        assert!((keys.noise - 0.25).abs() < 1e-18);
    }

    #[test]
    fn options_of_other_methods_are_refused_by_name() {
        let accelerate = MethodOverrides {
            accelerate: true,
            ..MethodOverrides::default()
        };
        let rounds = MethodOverrides {
            rounds: Some(3),
            ..MethodOverrides::default()
        };
        let memory = MethodOverrides {
            memory: Some(3),
            ..MethodOverrides::default()
        };
        for (told, name, option) in [
            (&accelerate, MethodName::QuasiNewton, "--accelerate"),
            (&accelerate, MethodName::Anneal, "--accelerate"),
            (&rounds, MethodName::QuasiNewton, "--rounds"),
            (&rounds, MethodName::Lloyd, "--rounds"),
            (&memory, MethodName::Lloyd, "--memory"),
        ] {
            let error = told.apply(&mut method(name)).unwrap_err().to_string();
            assert!(error.contains(option), "{error}");
        }
    }
}
