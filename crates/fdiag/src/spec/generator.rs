//! Which residual generator, as a line of a spec.

mod bounds;
mod component;
mod data;
mod design;
mod deviations;
mod disturbance;
mod error;
#[cfg(feature = "testing")]
mod every;
mod fault;
mod filter;
mod linear;
mod model_source;
mod parameter;
mod tracked;

use std::{collections::BTreeMap, path::Path};

use serde::{Deserialize, Serialize};

#[cfg(feature = "testing")]
pub(super) use self::every::EVERY;
pub use self::{
    bounds::{ModelBoundSpec, ZonotopeSpec},
    component::{ComponentSpec, PartSpec},
    deviations::DeviationSpec,
    disturbance::DisturbanceSpec,
    error::GeneratorSpecError,
    fault::{FaultEntry, SignatureSpec},
    model_source::ModelSource,
    parameter::{ParameterSpec, ShiftSpec},
};

/// A residual generator and its settings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum GeneratorSpec {
    /// Measured minus simulated output, without any correction.
    Simulation {},
    /// A Luenberger observer with all poles of its error at one place.
    Observer {
        /// Rate at which the error dies out, in 1/s: all poles at `exp(−rate·Ts)`.
        rate: f64,
    },
    /// The steady-state Kalman filter.
    Kalman {
        /// Variance of the noise on each state per sample, in the (scaled) unit of the state.
        process_noise: f64,
        /// Variance of the noise on each output, in the (scaled) unit of the output.
        output_noise: f64,
    },
    /// An observer of all states that bounds allow; the residual is within ±1 as long as they hold.
    Zonotope(ZonotopeSpec),
    /// All exact parity relations over `order + 1` samples.
    Parity {
        /// Window length minus one.
        order: usize,
    },
    /// An observer of all states that an unknown input does not reach.
    UnknownInput {
        /// The unknown input.
        disturbance: DisturbanceSpec,
        /// Least rate at which the error dies out, in 1/s.
        rate: f64,
    },
    /// All residuals that an unknown input does not reach, of least order.
    Decoupled {
        /// The unknown input.
        disturbance: DisturbanceSpec,
        /// Least rate at which the error dies out, in 1/s.
        rate: f64,
    },
    /// An observer whose residual rows are left eigenvectors that the unknown input is
    /// orthogonal to.
    Eigenstructure {
        /// The unknown input.
        disturbance: DisturbanceSpec,
        /// Rate at which the error dies out, in 1/s; none makes it dead beat.
        #[serde(default)]
        rate: Option<f64>,
    },
    /// The residual with the widest gap between faults and noise at every frequency.
    Optimal {
        /// Faults that have to stay visible; without any, all sensors.
        #[serde(default)]
        faults: Vec<FaultEntry>,
        /// Variance of the noise on each state per sample, in the (scaled) unit of the state.
        process_noise: f64,
        /// Variance of the noise on each output, in the (scaled) unit of the output.
        output_noise: f64,
        /// A disturbance that must not show at all.
        #[serde(default)]
        decoupled: Option<DisturbanceSpec>,
        /// A disturbance that counts as further noise, as large as its columns are long.
        #[serde(default)]
        attenuated: Option<DisturbanceSpec>,
        /// Rate in 1/s of residuals that no noise reaches.
        #[serde(default = "unit_rate")]
        rate: f64,
    },
    /// A bank with a wanted structure matrix.
    Structured {
        /// Faults, in the order of the columns.
        faults: Vec<FaultEntry>,
        /// Which residual reacts to which fault.
        structure: SignatureSpec,
        /// A disturbance that no residual shows.
        #[serde(default)]
        disturbance: Option<DisturbanceSpec>,
        /// Least rate of the filters in 1/s; none takes parity relations of least order.
        #[serde(default)]
        rate: Option<f64>,
    },
    /// The Beard filter: each fault keeps the residual in a direction of its own.
    Directional {
        /// Columns along which faults enter the states; without any, every direction is kept,
        /// which needs as many independent outputs as states.
        #[serde(default)]
        events: Vec<Vec<f64>>,
        /// Rate at which the error dies out, in 1/s.
        rate: f64,
    },
    /// An observer that re-identifies parameters of the plant.
    Adaptive {
        /// What may change.
        parameters: ParameterSpec,
        /// Variance of the noise on each state over that on each output, which sets the gain.
        process_noise: f64,
        /// Variance of the noise on each output, in the (scaled) unit of the output.
        output_noise: f64,
        /// Standard deviation of each parameter before the first sample.
        #[serde(default = "default_prior")]
        prior: f64,
        /// Variance of the step that each parameter takes per sample.
        #[serde(default)]
        drift: f64,
        /// Largest magnitude of a parameter.
        #[serde(default = "unit_rate")]
        bound: f64,
    },
    /// Estimates of faults in place of residuals, in their own units.
    FaultEstimate {
        /// The faults, no more than outputs.
        faults: Vec<FaultEntry>,
        /// Variance of the noise on each state per sample, in the (scaled) unit of the state.
        process_noise: f64,
        /// Variance of the noise on each output, in the (scaled) unit of the output.
        output_noise: f64,
        /// Variance of the step that each fault takes per sample.
        drift: f64,
    },
    // What three filters have in common stands three times: a flattened struct would not refuse unknown keys.
    /// The extended Kalman filter of a nonlinear model.
    Extended {
        /// The model file.
        model: ModelSource,
        /// Standard deviation of the noise that drives each state, per root of a second.
        process_noise: DeviationSpec,
        /// Standard deviation of the noise of each output; without it that of the model file.
        #[serde(default)]
        output_noise: Option<DeviationSpec>,
        /// Standard deviation of each state at the start; without it that of the model file.
        #[serde(default)]
        initial: Option<DeviationSpec>,
        /// Samples over which the slopes of the model are renewed in turns; 0 or 1 means all at every sample.
        #[serde(default)]
        linearised_over: u32,
    },
    /// The unscented Kalman filter of a nonlinear model.
    Unscented {
        /// The model file.
        model: ModelSource,
        /// Standard deviation of the noise that drives each state, per root of a second.
        process_noise: DeviationSpec,
        /// Standard deviation of the noise of each output; without it that of the model file.
        #[serde(default)]
        output_noise: Option<DeviationSpec>,
        /// Standard deviation of each state at the start; without it that of the model file.
        #[serde(default)]
        initial: Option<DeviationSpec>,
        /// How far out the points lie; none takes what suits the number of states.
        #[serde(default)]
        kappa: Option<f64>,
    },
    /// The bootstrap particle filter of a nonlinear model.
    Particle {
        /// The model file.
        model: ModelSource,
        /// Standard deviation of the noise that drives each state, per root of a second.
        process_noise: DeviationSpec,
        /// Standard deviation of the noise of each output; without it that of the model file.
        #[serde(default)]
        output_noise: Option<DeviationSpec>,
        /// Standard deviation of each state at the start; without it that of the model file.
        #[serde(default)]
        initial: Option<DeviationSpec>,
        /// How many particles.
        #[serde(default = "default_particles")]
        particles: usize,
        /// Seed of the random numbers.
        #[serde(default)]
        seed: u64,
    },
    /// Measured minus simulated output of a model with a known cause in it, whose strength is tracked.
    Patched {
        /// The model file, as `fdiag gap` writes it.
        model: ModelSource,
        /// Parameters that wear: standard deviation of how far each walks, per root of a second, in its unit.
        #[serde(default)]
        track: BTreeMap<String, f64>,
        /// A fault is suspected, and nothing followed, when the smoothed residual is so many times what the
        /// healthy logs showed.
        #[serde(default = "default_suspicion")]
        suspicion: f64,
        /// Time in s over which the residual is smoothed for that.
        #[serde(default = "default_memory")]
        memory_s: f64,
        /// Time in s at the start of each healthy log that is not learned from for that.
        #[serde(default)]
        settle_s: f64,
        /// Rate in 1/s at which an observer of the pipeline's linear model forgets what the simulation leaves, as that
        /// of `observer`; without it nothing corrects the simulation.
        #[serde(default)]
        observer_rate: Option<f64>,
    },
    /// Principal components of the healthy logs.
    Pca {
        /// Past samples beside the present one.
        #[serde(default)]
        lags: usize,
        /// How many components.
        #[serde(default)]
        components: ComponentSpec,
        /// What of them is the residual.
        #[serde(default)]
        part: PartSpec,
    },
    /// Canonical variates of past and future in the healthy logs.
    Cva {
        /// Samples of the past, the present one included.
        past: usize,
        /// Samples of the future.
        future: usize,
        /// How many variates are states; none asks Akaike's criterion.
        #[serde(default)]
        states: Option<usize>,
        /// What of them is the residual.
        #[serde(default)]
        part: PartSpec,
    },
    /// Parity relations of the healthy logs.
    DataParity {
        /// Window length minus one.
        order: usize,
        /// States of the plant; none counts them.
        #[serde(default)]
        states: Option<usize>,
    },
}

fn unit_rate() -> f64 {
    1.0
}

fn default_prior() -> f64 {
    0.3
}

fn default_particles() -> usize {
    1000
}

fn default_suspicion() -> f64 {
    1.5
}

fn default_memory() -> f64 {
    5.0
}

impl GeneratorSpec {
    /// Whether the residual has one channel per output of the model, in its order and unit.
    #[must_use]
    pub fn is_per_output(&self) -> bool {
        match self {
            Self::Simulation {}
            | Self::Observer { .. }
            | Self::Kalman { .. }
            | Self::UnknownInput { .. }
            | Self::Directional { .. }
            | Self::Adaptive { .. }
            | Self::Extended { .. }
            | Self::Unscented { .. }
            | Self::Particle { .. }
            | Self::Patched { .. } => true,
            Self::Zonotope(_)
            | Self::Parity { .. }
            | Self::Decoupled { .. }
            | Self::Eigenstructure { .. }
            | Self::Optimal { .. }
            | Self::Structured { .. }
            | Self::FaultEstimate { .. }
            | Self::Pca { .. }
            | Self::Cva { .. }
            | Self::DataParity { .. } => false,
        }
    }

    /// Lets the path of a model file begin in the folder of the spec.
    pub fn begin_in(&mut self, folder: &Path) {
        match self {
            Self::Extended { model, .. }
            | Self::Unscented { model, .. }
            | Self::Particle { model, .. }
            | Self::Patched { model, .. } => model.begin_in(folder),
            _ => {}
        }
    }

    /// The file of the nonlinear model, if there is one.
    #[must_use]
    pub fn model_file(&self) -> Option<&Path> {
        match self {
            Self::Extended { model, .. }
            | Self::Unscented { model, .. }
            | Self::Particle { model, .. }
            | Self::Patched { model, .. } => model.file(),
            _ => None,
        }
    }
}
