//! Component faults: the health of a running engine as parameters that can be moved.

use fd_model::fault::Parameters;

use super::{
    discretise::{PerUnit, Sampled},
    extended::ExtendedEngine,
    health::HealthParameter,
    rhs::Engine17,
};

/// The parameters are those of [`Health`](super::Health), by the names of its fields.
impl Parameters for Engine17<f64> {
    fn parameter_names(&self) -> Vec<String> {
        HealthParameter::ALL.iter().map(|parameter| parameter.name().to_owned()).collect()
    }

    fn parameter(&self, index: usize) -> f64 {
        self.health().get(HealthParameter::ALL[index])
    }

    fn set_parameter(&mut self, index: usize, value: f64) {
        let mut health = *self.health();
        health.set(HealthParameter::ALL[index], value);
        self.set_health(health);
    }
}

/// Hands the parameters of the engine inside on.
macro_rules! parameters_of_inner {
    ([$($generics:tt)*] $plant:ty, $inner:ident, $inner_mut:ident) => {
        impl<$($generics)*> Parameters for $plant {
            fn parameter_names(&self) -> Vec<String> {
                self.$inner().parameter_names()
            }

            fn parameter(&self, index: usize) -> f64 {
                self.$inner().parameter(index)
            }

            fn set_parameter(&mut self, index: usize, value: f64) {
                self.$inner_mut().set_parameter(index, value);
            }
        }
    };
}

parameters_of_inner!([] ExtendedEngine<f64>, engine, engine_mut);
parameters_of_inner!([E: Parameters, const N: usize] Sampled<E, N>, engine, engine_mut);
parameters_of_inner!([E: Parameters, const N: usize] PerUnit<E, N>, plant, plant_mut);
