//! The bench: the nominal engine, its model, and everything that is drawn for one seed.

use fd_core::{Heap, Limits};
use fd_jetengine::{
    EngineModel, PerturbedEngine,
    engine17::{Engine17, Health, HealthParameter, Parameters},
};
use fd_model::{
    Channel, ChannelScale, Continuous, Discrete, Inputs, Record, SampleTime, Scaling, Simulation,
    SimulationError, StateSpace,
    fault::FaultSpec,
    reduce,
    signal::{SignalSpec, WhiteNoise},
};
use fdiag::spec::NominalPlant;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{
    config::{CONFIG_VERSION, EngineChoice, EngineConfig, PlantConfig, ReductionConfig},
    error::EngineStudyError,
    reality::Reality,
};

/// What does not depend on the seed.
#[derive(Clone, Debug)]
pub struct Benchmark {
    config: EngineConfig,
    ts: SampleTime,
    nominal: EngineModel,
    /// The nonlinear engine behind it, if there is one.
    engine: Option<Engine17<f64>>,
    readings: Vec<(Channel, f64)>,
}

/// One perturbed engine with the model that is to watch it.
pub(crate) struct Case {
    /// The engine where the bias is learned.
    pub training: Reality,
    /// The same engine where the test runs take place.
    pub moved: Reality,
    /// The engine itself, when it is nonlinear.
    engine: Option<Engine17<f64>>,
    /// The perturbed plant, when it is linear.
    pub(super) plant: Option<StateSpace<Discrete>>,
    pub model: StateSpace<Discrete>,
    /// What its signals are in physical units, where they are deviations from its own equilibrium.
    pub(super) scaling: Option<Scaling>,
    pub(super) redraws: usize,
    pub(super) rng: Xoshiro256PlusPlus,
}

impl Case {
    /// The model that is to watch it, and what its signals are in physical units.
    pub(crate) fn plant(&self) -> NominalPlant<'_> {
        let plant = NominalPlant::from(&self.model);
        self.scaling.iter().fold(plant, |plant, scaling| plant.in_units(scaling.clone()))
    }
}

/// What is random in a run, so that it can be repeated with a fault.
#[derive(Clone)]
pub(crate) struct Draw {
    pub(super) inputs: Inputs,
    pub(super) output_noise: Vec<SignalSpec>,
}

/// Where a run without faults stands before a sample.
pub(crate) struct Fork {
    at: usize,
    state: Vec<f64>,
}

impl Benchmark {
    /// Prepares the nominal engine of a configuration.
    ///
    /// ```
    /// use fd_lab::engine::{Benchmark, EngineConfig};
    ///
    /// let benchmark = Benchmark::new(EngineConfig::default())?;
    /// assert_eq!(benchmark.readings().len(), 5);
    /// # Ok::<(), fd_lab::engine::EngineStudyError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of its range or the engine has no such operating
    /// point.
    pub fn new(config: EngineConfig) -> Result<Self, EngineStudyError> {
        if config.version != CONFIG_VERSION {
            let (expected, found) = (CONFIG_VERSION, config.version);
            return Err(EngineStudyError::Version { expected, found });
        }
        for (setting, found) in
            [("plant.noise", config.plant.noise), ("faults.size", config.faults.size)]
        {
            if !(found >= 0.0 && found.is_finite()) {
                return Err(EngineStudyError::Setting { setting, found });
            }
        }
        let ts = SampleTime::new(config.sample_time_s)?;
        config.check_limits(&Limits::default())?;
        let (nominal, readings, engine) = nominal_engine(&config)?;
        Ok(Self { config, ts, nominal, engine, readings })
    }

    /// The configuration.
    #[must_use]
    pub fn config(&self) -> &EngineConfig {
        &self.config
    }

    /// Output channels in physical units, each with the value that one per unit stands for.
    #[must_use]
    pub fn readings(&self) -> &[(Channel, f64)] {
        &self.readings
    }

    /// Name of the engine.
    #[must_use]
    pub fn engine_name(&self) -> &str {
        &self.nominal.name
    }

    pub(super) fn inputs(&self) -> &[Channel] {
        &self.nominal.inputs
    }

    pub(crate) fn ts(&self) -> SampleTime {
        self.ts
    }

    /// Output channels of the scaled engine.
    pub(crate) fn outputs(&self) -> Vec<Channel> {
        self.nominal.outputs.clone()
    }

    /// Index of the sensors that the faults are on.
    pub(super) fn fault_channels(&self) -> Result<Vec<usize>, EngineStudyError> {
        let names = || self.nominal.outputs.iter().map(|c| c.name.clone()).collect();
        self.config
            .faults
            .sensors
            .iter()
            .map(|name| {
                self.nominal.outputs.iter().position(|c| c.name == *name).ok_or_else(|| {
                    EngineStudyError::UnknownSensor { found: name.clone(), known: names() }
                })
            })
            .collect()
    }

    /// Draws everything for one seed.
    pub(crate) fn case(&self, seed: u64) -> Result<Case, EngineStudyError> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let draw = self.perturbed(rng.next_u64())?;
        let drawn = &draw.model.model;
        let rejected = draw.rejected;
        if let (
            Some(engine),
            EngineChoice::Engine17Nonlinear {
                fuel_kg_s,
                moved_to_kg_s,
                health_scatter,
                unmodelled,
            },
        ) = (&self.engine, &self.config.plant.engine)
        {
            let mut health = Health::default();
            for parameter in HealthParameter::MODULES {
                let delta = health_scatter * rng.random_range(-1.0..1.0);
                health = health.shifted(parameter, delta);
            }
            let engine = engine.clone().with_health(health);
            let about = |fuel| Reality::nonlinear(&engine, &engine, *unmodelled, fuel, self.ts);
            let rest = engine.trim(*fuel_kg_s)?.outputs();
            let per_unit = |value: &f64| ChannelScale::per_unit(*value, *value);
            let (inputs, outputs) =
                (vec![per_unit(fuel_kg_s)], rest.iter().map(per_unit).collect());
            return Ok(Case {
                scaling: Some(Scaling { inputs, outputs }),
                training: about(*fuel_kg_s)?,
                moved: about(moved_to_kg_s.unwrap_or(*fuel_kg_s))?,
                engine: Some(engine.clone()),
                plant: None,
                // The engine is what it is; it is the model that is wrong.
                model: self.observer_model(drawn)?,
                redraws: rejected,
                rng,
            });
        }
        let plant = drawn.sample_zoh(self.ts)?;
        let running = plant.freeze::<f64, Heap>()?;
        Ok(Case {
            scaling: None,
            training: Reality::Linear(running.clone()),
            moved: Reality::Linear(running),
            engine: None,
            plant: Some(plant),
            model: self.observer_model(&self.nominal.model)?,
            redraws: rejected,
            rng,
        })
    }

    /// A linear engine of the type, perturbed.
    pub(super) fn perturbed(&self, seed: u64) -> Result<PerturbedEngine, EngineStudyError> {
        let PlantConfig { engine: choice, perturbation, .. } = &self.config.plant;
        Ok(match (&self.engine, choice) {
            (Some(engine), EngineChoice::Engine17 { fuel_kg_s }) => {
                perturbation.draw_engine17(engine, *fuel_kg_s, seed)?
            }
            _ => perturbation.draw(&self.nominal, seed)?,
        })
    }

    /// Whether the engine is nonlinear, so that its components can wear.
    pub(crate) fn is_nonlinear(&self) -> bool {
        matches!(self.config.plant.engine, EngineChoice::Engine17Nonlinear { .. })
    }

    /// The engine of a case with a health parameter shifted: where the bias is learned, and where
    /// the test runs take place. `None` for a linear engine, which has no such parameters.
    pub(crate) fn worn(
        &self,
        case: &Case,
        parameter: HealthParameter,
        shift: f64,
    ) -> Result<Option<(Reality, Reality)>, EngineStudyError> {
        let (
            Some(new),
            &EngineChoice::Engine17Nonlinear { fuel_kg_s, moved_to_kg_s, unmodelled, .. },
        ) = (&case.engine, &self.config.plant.engine)
        else {
            return Ok(None);
        };
        let worn = new.clone().with_health(new.health().shifted(parameter, shift));
        let about = |fuel| Reality::nonlinear(new, &worn, unmodelled, fuel, self.ts);
        Ok(Some((about(fuel_kg_s)?, about(moved_to_kg_s.unwrap_or(fuel_kg_s))?)))
    }

    /// The discrete model of the residual generator.
    fn observer_model(
        &self,
        full: &StateSpace<Continuous>,
    ) -> Result<StateSpace<Discrete>, EngineStudyError> {
        let reduced = match self.config.reduction {
            ReductionConfig::MeasuredStates {} => {
                reduce::residualise_onto(full, &measured_states(full)?)?
            }
            ReductionConfig::BalancedTruncation { order } => {
                reduce::balanced_truncation(full, order)?.model
            }
            ReductionConfig::BalancedResidualisation { order } => {
                reduce::balanced_residualisation(full, order)?.model
            }
            ReductionConfig::None {} => full.clone(),
        };
        Ok(reduced.sample_zoh(self.ts)?)
    }

    /// The training input with noise.
    pub(crate) fn draw_training(&self, case: &mut Case) -> Result<Draw, EngineStudyError> {
        let inputs = self.config.training.inputs(&self.nominal.inputs, self.ts)?;
        Ok(Draw { inputs, output_noise: self.noise(&mut case.rng) })
    }

    /// A fresh input with noise.
    pub(crate) fn draw_fresh(&self, case: &mut Case) -> Result<Draw, EngineStudyError> {
        let inputs = self.config.fresh.inputs(&self.nominal.inputs, self.ts, &mut case.rng)?;
        Ok(Draw { inputs, output_noise: self.noise(&mut case.rng) })
    }

    /// One run of a plant.
    pub(crate) fn run(
        &self,
        plant: &Reality,
        draw: &Draw,
        faults: &[FaultSpec],
    ) -> Result<Record, EngineStudyError> {
        let output_noise = draw.output_noise.clone();
        let simulation =
            Simulation { output_noise, faults: faults.to_vec(), ..Simulation::default() };
        Ok(plant.run(simulation, &draw.inputs, self.nominal.outputs.clone())?)
    }

    /// Where a run without faults stands before sample `at`, for [`Benchmark::run_on`].
    pub(crate) fn fork(plant: &Reality, draw: &Draw, at: usize) -> Fork {
        let at = at.min(draw.inputs.len());
        Fork { at, state: plant.state_at(&draw.inputs, at) }
    }

    /// The same run as [`Benchmark::run`] makes of all faults together, from a run without the last one, which
    /// sets in at the fork: only what comes after it is simulated. `faults`, those that `healthy` has too, are
    /// on sensors. Times count from the fork, so a growing fault may differ by rounding.
    pub(crate) fn run_on(
        &self,
        plant: &Reality,
        (draw, healthy): (&Draw, &Record),
        fork: &Fork,
        (faults, last): (&[FaultSpec], FaultSpec),
    ) -> Result<Record, EngineStudyError> {
        let (inputs, at) = (&draw.inputs, fork.at);
        let rest = inputs.values()[at * inputs.channels().len()..].to_vec();
        let after = Inputs::new(inputs.channels().to_vec(), rest, inputs.len() - at, inputs.ts())?
            .starting_at(inputs.time(at));
        let simulation =
            Simulation { x0: fork.state.clone(), faults: vec![last], ..Simulation::default() };
        let mut tail = plant.run(simulation, &after, self.nominal.outputs.clone())?;
        // The noise goes on where it was at the fork.
        for (i, noise) in draw.output_noise.iter().enumerate() {
            let values = noise.values(inputs.len(), inputs.ts()).map_err(SimulationError::from)?;
            for (k, noise) in values[at..].iter().enumerate() {
                tail.y_mut(k)[i] += noise;
            }
        }
        for fault in faults {
            fault.apply_to_record(&mut tail).map_err(SimulationError::from)?;
        }
        let mut whole = healthy.clone();
        for k in 0..tail.len() {
            whole.y_mut(at + k).copy_from_slice(tail.y(k));
        }
        Ok(whole)
    }

    pub(super) fn noise(&self, rng: &mut Xoshiro256PlusPlus) -> Vec<SignalSpec> {
        let sigma = self.config.plant.noise;
        let outputs = if sigma > 0.0 { self.nominal.outputs.len() } else { 0 };
        (0..outputs).map(|_| WhiteNoise::new(sigma, rng.next_u64()).into()).collect()
    }
}

type Readings = Vec<(Channel, f64)>;

fn nominal_engine(
    config: &EngineConfig,
) -> Result<(EngineModel, Readings, Option<Engine17<f64>>), EngineStudyError> {
    let with_readings = |physical: &EngineModel, scale: Vec<f64>| -> Readings {
        physical.outputs.iter().cloned().zip(scale).collect()
    };
    match config.plant.engine {
        EngineChoice::Engine17 { fuel_kg_s }
        | EngineChoice::Engine17Nonlinear { fuel_kg_s, .. } => {
            let engine = Engine17::<f64>::new(&Parameters::default())?;
            let physical = engine.linearise(&engine.trim(fuel_kg_s)?)?;
            let per_unit = physical.per_unit()?;
            let scale = physical.operating_point.as_ref().map_or_else(Vec::new, |p| p.y.clone());
            Ok((per_unit, with_readings(&physical, scale), Some(engine)))
        }
        EngineChoice::F100 {} => {
            let physical = fd_jetengine::f100()?;
            let (scaled, scaling) = physical.equilibrated()?;
            let readings = with_readings(&physical, scaling.y);
            Ok((scaled, readings, None))
        }
        EngineChoice::ChenPattonZhang {} => {
            let per_unit = fd_jetengine::chen_patton_zhang()?;
            let readings = per_unit.outputs.iter().map(|c| (c.clone(), 1.0)).collect();
            Ok((per_unit, readings, None))
        }
    }
}

/// For each output, the state that it measures.
fn measured_states(model: &StateSpace<Continuous>) -> Result<Vec<usize>, EngineStudyError> {
    let c = model.c();
    let mut states = Vec::new();
    for row in 0..c.nrows() {
        let mut columns = (0..c.ncols()).filter(|&j| c[(row, j)].abs() > 0.0);
        match (columns.next(), columns.next()) {
            (Some(state), None) => {
                if !states.contains(&state) {
                    states.push(state);
                }
            }
            _ => return Err(EngineStudyError::NotAState { output: row }),
        }
    }
    Ok(states)
}
