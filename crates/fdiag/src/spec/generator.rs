//! Which residual generator, as a line of a spec.

mod disturbance;

use faer::{Mat, c64};
use fd_model::{Discrete, Record, StateSpace};
use fd_residual::{
    DesignError, GeneratorDesign,
    decouple::DecoupledDesign,
    eigenstructure::EigenstructureDesign,
    observer::{ErrorPoles, ObserverDesign},
    parity::ParityDesign,
    simulation::SimulationDesign,
    unknown_input::UnknownInputObserver,
    weighted::WeightedDesign,
};
use serde::{Deserialize, Serialize};

pub use self::disturbance::DisturbanceSpec;

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
        let columns = rows.first().map_or(0, Vec::len);
        let weight =
            Mat::from_fn(rows.len(), columns, |i, j| rows[i].get(j).copied().unwrap_or(f64::NAN));
        Ok(Box::new(WeightedDesign::new(design, weight.as_ref())?))
    }

    /// Whether the residual has one channel per output of the model, in its order and unit.
    #[must_use]
    pub fn is_per_output(&self) -> bool {
        match self {
            Self::Simulation {}
            | Self::Observer { .. }
            | Self::Kalman { .. }
            | Self::UnknownInput { .. } => true,
            Self::Parity { .. } | Self::Decoupled { .. } | Self::Eigenstructure { .. } => false,
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
        })
    }
}
