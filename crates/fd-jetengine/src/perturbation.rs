//! How the engine that is watched differs from the model that watches it.

use fd_model::{Continuous, StateSpace, uncertainty::MatrixPerturbation};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use crate::{
    engine17::{Engine17, Health, HealthParameter},
    error::EngineError,
    model::{EngineModel, Scaling},
};

/// A random difference between engines of one type.
///
/// The paper speaks of 10 % perturbation of the model matrices and does not say how; the
/// default is 10 % entry by entry.
///
/// ```
/// use fd_jetengine::{Perturbation, chen_patton_zhang};
///
/// let nominal = chen_patton_zhang()?;
/// let plant = Perturbation::default().draw(&nominal, 1)?;
/// assert!(plant.model.model.is_stable()?);
/// # Ok::<(), fd_jetengine::EngineError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Perturbation {
    /// No difference.
    None {},
    /// Perturbed matrices of the scaled linear model, entry by entry or within a norm.
    Matrices(MatrixPerturbation),
    /// Perturbed volumes, inertias, ducts and map shapes; see
    /// [`Parameters::scattered`](crate::engine17::Parameters::scattered). For engine17 only.
    Physical {
        /// Largest relative change of a parameter.
        fraction: f64,
    },
    /// Perturbed efficiencies and flow capacities of the four turbomachines. For engine17 only.
    Health {
        /// Largest relative change of a parameter.
        fraction: f64,
    },
}

impl Default for Perturbation {
    fn default() -> Self {
        Self::Matrices(MatrixPerturbation::default())
    }
}

/// One engine of many.
#[derive(Clone, Debug)]
pub struct PerturbedEngine {
    /// Its linear model, in the units of the nominal one; all modes are stable.
    pub model: EngineModel,
    /// Unstable draws that were thrown away before it.
    pub rejected: usize,
}

/// Draws of physical parameters or health before giving up.
const DRAWS: u64 = 100;

impl Perturbation {
    /// Another engine next to a linear one. The same seed gives the same engine.
    ///
    /// # Errors
    ///
    /// Returns an error for the kinds that need a nonlinear engine, when the nominal model is
    /// unstable, and when no stable engine is found.
    pub fn draw(&self, nominal: &EngineModel, seed: u64) -> Result<PerturbedEngine, EngineError> {
        match self {
            Self::None {} => Ok(PerturbedEngine { model: nominal.clone(), rejected: 0 }),
            Self::Matrices(perturbation) => {
                let draw = perturbation.draw(&nominal.model, seed)?;
                Ok(PerturbedEngine {
                    model: with_model(nominal, draw.model),
                    rejected: draw.rejected,
                })
            }
            Self::Physical { .. } | Self::Health { .. } => Err(EngineError::NotPhysical),
        }
    }

    /// Another engine of the type of `engine`, trimmed at the same fuel flow (kg/s), linearised
    /// and expressed per unit of the *nominal* operating point.
    ///
    /// # Errors
    ///
    /// Returns an error when an engine cannot be trimmed, or no stable one is found.
    pub fn draw_engine17(
        &self,
        engine: &Engine17,
        fuel: f64,
        seed: u64,
    ) -> Result<PerturbedEngine, EngineError> {
        let nominal = engine.linearise(&engine.trim(fuel)?)?;
        let Some(point) = &nominal.operating_point else {
            return Err(EngineError::NoOperatingPoint);
        };
        let units = Scaling { x: point.x.clone(), u: point.u.clone(), y: point.y.clone() };
        if matches!(self, Self::None {} | Self::Matrices(_)) {
            return self.draw(&nominal.scaled(&units)?, seed);
        }
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut rejected = 0;
        for _ in 0..DRAWS {
            let other = self.another(engine, rng.random())?;
            let model = other.linearise(&other.trim(fuel)?)?.scaled(&units)?;
            if model.model.is_stable()? {
                return Ok(PerturbedEngine { model, rejected });
            }
            rejected += 1;
        }
        Err(EngineError::NoStableEngine { draws: rejected })
    }

    /// The nonlinear engine itself with other parameters or another health; the same engine for
    /// the kinds that perturb matrices.
    ///
    /// # Errors
    ///
    /// Returns an error when the size of the perturbation is out of its range.
    pub fn another(&self, engine: &Engine17, seed: u64) -> Result<Engine17, EngineError> {
        match *self {
            Self::None {} | Self::Matrices(_) => Ok(engine.clone()),
            Self::Physical { fraction } => {
                let other = Engine17::new(&engine.parameters().scattered(fraction, seed)?)?;
                Ok(other.at(*engine.environment()).with_health(*engine.health()))
            }
            Self::Health { fraction } => {
                let (low, high) = (0.0, 0.1);
                if !(low..=high).contains(&fraction) {
                    let quantity = "relative scatter of health";
                    let value = fraction;
                    return Err(EngineError::OutOfRange { quantity, value, low, high, unit: "1" });
                }
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
                let mut health: Health = *engine.health();
                for parameter in HealthParameter::MODULES {
                    let factor = 1.0 + fraction * rng.random_range(-1.0..=1.0);
                    health.set(parameter, health.get(parameter) * factor);
                }
                Ok(engine.clone().with_health(health))
            }
        }
    }
}

fn with_model(nominal: &EngineModel, model: StateSpace<Continuous>) -> EngineModel {
    EngineModel { model, ..nominal.clone() }
}
