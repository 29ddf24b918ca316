//! The generators that are designed for a linear model.

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
};

use super::{DisturbanceSpec, FaultEntry, GeneratorSpec};

impl GeneratorSpec {
    /// The generator without weighting.
    pub(super) fn linear(
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
            Self::Zonotope(spec) => Box::new(spec.design(model)?),
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
            // Those of a nonlinear model or of none were told apart before.
            Self::Extended { .. }
            | Self::Unscented { .. }
            | Self::Particle { .. }
            | Self::Patched { .. }
            | Self::Pca { .. }
            | Self::Cva { .. }
            | Self::DataParity { .. } => {
                return Err(DesignError::Empty { what: "nonlinear model" });
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
