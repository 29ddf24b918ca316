//! Which residual generator, as a line of a spec.

mod disturbance;
mod fault;
mod parameter;

use faer::{Mat, c64};
use fd_model::{Discrete, Record, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign,
    adaptive::{AdaptiveDesign, ParameterNoise},
    analysis::UnknownInputs,
    decouple::DecoupledDesign,
    directional::BeardDesign,
    eigenstructure::EigenstructureDesign,
    estimation::{FaultEstimatorDesign, FaultNoise},
    observer::{ErrorPoles, ObserverDesign},
    optimal::{Exposure, OptimalDesign},
    parity::ParityDesign,
    simulation::SimulationDesign,
    structured::{RowMethod, StructuredDesign},
    unknown_input::UnknownInputObserver,
    weighted::WeightedDesign,
};
use serde::{Deserialize, Serialize};

use self::parameter::dense;
pub use self::{
    disturbance::DisturbanceSpec,
    fault::{FaultEntry, SignatureSpec},
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
}

/// Lines of specs, at least one of each kind, for a model of one input, two states and two outputs.
#[cfg(feature = "testing")]
pub(super) const EVERY: [&str; 17] = [
    r#"kind = "simulation""#,
    r#"kind = "observer", rate = 2.0"#,
    r#"kind = "kalman", process_noise = 0.1, output_noise = 1.0"#,
    r#"kind = "parity", order = 2"#,
    r#"kind = "unknown-input", disturbance = { kind = "learned", rank = 1 }, rate = 2.0"#,
    r#"kind = "unknown-input", disturbance = { kind = "directions", columns = [[1.0, 0.5]] }, rate = 2.0"#,
    r#"kind = "decoupled", disturbance = { kind = "learned", rank = 1, duration_s = 2.0 }, rate = 2.0"#,
    r#"kind = "eigenstructure", disturbance = { kind = "directions", columns = [[1.0, 0.5]] }"#,
    r#"kind = "eigenstructure", disturbance = { kind = "learned", rank = 1 }, rate = 3.0"#,
    r#"kind = "unknown-input", disturbance = { kind = "perturbed", rank = 1, models = 20, perturbation = { fraction = 0.03 } }, rate = 2.0"#,
    r#"kind = "unknown-input", disturbance = { kind = "models", rank = 1, shifts = [{ a = [[0.02, -0.01], [0.01, 0.02]], b = [[-0.01], [0.01]] }] }, rate = 2.0"#,
    r#"kind = "optimal", process_noise = 0.01, output_noise = 1.0, attenuated = { kind = "learned", rank = 1 }"#,
    r#"kind = "structured", faults = [{ sensor = 1 }, { sensor = 2 }], structure = { kind = "dedicated" }"#,
    r#"kind = "structured", faults = [{ sensor = 1 }, { sensor = 2 }], structure = { kind = "rows", rows = ["10", "11"] }, rate = 2.0"#,
    r#"kind = "directional", rate = 2.0"#,
    r#"kind = "adaptive", parameters = { kind = "state-rates" }, process_noise = 0.1, output_noise = 1e-4"#,
    r#"kind = "fault-estimate", faults = [{ actuator = 1 }, { sensor = 2 }], process_noise = 1e-4, output_noise = 1e-2, drift = 1e-4"#,
];

fn unit_rate() -> f64 {
    1.0
}

fn default_prior() -> f64 {
    0.3
}

impl GeneratorSpec {
    /// Designs the generator for `model`, followed by the weighting if there is one.
    ///
    /// `healthy` holds the logs of the healthy plant that a learned disturbance is learned from,
    /// in the units of the model; other kinds do not look at them.
    ///
    /// # Errors
    ///
    /// Returns why no such generator exists for this model.
    ///
    /// ```
    /// use faer::mat;
    /// use fdiag::{model::{Discrete, SampleTime, StateSpace}, spec::GeneratorSpec};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let model = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let design = GeneratorSpec::Observer { rate: 2.0 }.design(&model, None, &[])?;
    /// assert_eq!(design.residual_len(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn design(
        &self,
        model: &StateSpace<Discrete>,
        weighting: Option<&[Vec<f64>]>,
        healthy: &[Record],
    ) -> Result<Box<dyn GeneratorDesign>, DesignError> {
        let design = self.unweighted(model, healthy)?;
        let Some(rows) = weighting else { return Ok(design) };
        Ok(Box::new(WeightedDesign::new(design, dense(rows).as_ref())?))
    }

    /// Whether the residual has one channel per output of the model, in its order and unit.
    #[must_use]
    pub fn is_per_output(&self) -> bool {
        match self {
            Self::Simulation {}
            | Self::Observer { .. }
            | Self::Kalman { .. }
            | Self::UnknownInput { .. }
            | Self::Directional { .. }
            | Self::Adaptive { .. } => true,
            Self::Parity { .. }
            | Self::Decoupled { .. }
            | Self::Eigenstructure { .. }
            | Self::Optimal { .. }
            | Self::Structured { .. }
            | Self::FaultEstimate { .. } => false,
        }
    }

    fn unweighted(
        &self,
        model: &StateSpace<Discrete>,
        healthy: &[Record],
    ) -> Result<Box<dyn GeneratorDesign>, DesignError> {
        Ok(match self {
            Self::Simulation {} => Box::new(SimulationDesign::new(model)?),
            Self::Observer { rate } => {
                let pole = c64::new((-rate * model.domain().ts.seconds()).exp(), 0.0);
                Box::new(ObserverDesign::place(model, &vec![pole; model.nx()])?)
            }
            Self::Kalman { process_noise, output_noise } => {
                Box::new(ObserverDesign::kalman(model, *process_noise, *output_noise)?)
            }
            Self::Parity { order } => Box::new(ParityDesign::all(model, *order)?),
            Self::UnknownInput { disturbance, rate } => {
                let e = disturbance.columns(model, healthy)?;
                let poles = ErrorPoles::Rate(*rate);
                Box::new(UnknownInputObserver::place(model, e.as_ref(), &poles)?)
            }
            Self::Decoupled { disturbance, rate } => {
                let unknown = disturbance.unknown(model, healthy)?;
                Box::new(DecoupledDesign::new(model, &unknown, &ErrorPoles::Rate(*rate))?)
            }
            Self::Eigenstructure { disturbance, rate } => {
                let e = disturbance.columns(model, healthy)?;
                let poles = rate.map_or(ErrorPoles::DeadBeat, ErrorPoles::Rate);
                Box::new(EigenstructureDesign::new(model, e.as_ref(), &poles)?)
            }
            Self::Optimal { faults, process_noise, output_noise, decoupled, attenuated, rate } => {
                let faults = match faults.as_slice() {
                    [] => (0..model.ny()).map(|i| FaultEntry::Sensor(i + 1)).collect(),
                    given => given.to_vec(),
                };
                let mut noise = independent_noises(model, *process_noise, *output_noise)?;
                if let Some(more) = attenuated {
                    noise = noise.and(&more.unknown(model, healthy)?)?;
                }
                let exposure = Exposure {
                    faults: &FaultEntry::unknown(&faults, model)?,
                    disturbances: &unknown(decoupled.as_ref(), model, healthy)?,
                    noise: &noise,
                };
                Box::new(OptimalDesign::new(model, &exposure, *rate)?)
            }
            Self::Structured { faults, structure, disturbance, rate } => {
                let faults = FaultEntry::unknown(faults, model)?;
                let unknown = unknown(disturbance.as_ref(), model, healthy)?;
                // No residual needs a longer window than that.
                let longest = model.nx() + faults.len() + unknown.len();
                let method =
                    rate.map_or(RowMethod::Parity { longest }, |rate| RowMethod::Filter { rate });
                let structure = structure.structure();
                Box::new(StructuredDesign::new(model, &faults, &unknown, &structure, method)?)
            }
            Self::Directional { events, rate } if events.is_empty() => {
                Box::new(BeardDesign::full_state(model, *rate)?)
            }
            Self::Directional { events, rate } => {
                let given = DisturbanceSpec::Directions { columns: events.clone() };
                let e = given.columns(model, healthy)?;
                Box::new(BeardDesign::for_events(model, e.as_ref(), *rate)?)
            }
            Self::Adaptive { parameters, process_noise, output_noise, prior, drift, bound } => {
                let observer = ObserverDesign::kalman(model, *process_noise, 1.0)?;
                let (prior, drift, output, bound) = (*prior, *drift, *output_noise, *bound);
                let noise = ParameterNoise { prior, drift, output, bound };
                Box::new(AdaptiveDesign::new(observer, parameters.shifts(model)?, noise)?)
            }
            Self::FaultEstimate { faults, process_noise, output_noise, drift } => {
                let faults = FaultEntry::unknown(faults, model)?;
                let (process, output, drift) = (*process_noise, *output_noise, *drift);
                let noise = FaultNoise { process, output, drift };
                Box::new(FaultEstimatorDesign::new(model, &faults, &noise)?)
            }
        })
    }
}

/// White noise on all states and outputs, of unit intensity.
fn independent_noises(
    model: &StateSpace<Discrete>,
    process: f64,
    output: f64,
) -> Result<UnknownInputs, DesignError> {
    let (n, ny) = (model.nx(), model.ny());
    let on = |rows: usize, from: usize, variance: f64| {
        let deviation = variance.sqrt();
        Mat::from_fn(rows, n + ny, |i, j| if i + from == j { deviation } else { 0.0 })
    };
    UnknownInputs::new("noise", on(n, 0, process), on(ny, n, output))
}

fn unknown(
    disturbance: Option<&DisturbanceSpec>,
    model: &StateSpace<Discrete>,
    healthy: &[Record],
) -> Result<UnknownInputs, DesignError> {
    disturbance.map_or_else(|| Ok(UnknownInputs::none(model)), |d| d.unknown(model, healthy))
}
