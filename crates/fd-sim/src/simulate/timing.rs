//! How many integration steps a sample needs, and when a sampled controller acts.

use faer::Mat;
use fd_core::Limits;
use fd_model::{Continuous, SampleTime, StateSpace};

use super::{
    error::SimulateError,
    flat::{FIRST_STATE, Flat},
    linearize::{OperatingPoint, evaluate},
};
use crate::model::{Law, Model};

/// Largest `h |λ|`.
const LARGEST_STEP: f64 = 0.3;
/// Relative error of a ratio of two times that is meant to be whole.
const ROUNDING: f64 = 1e-9;

/// The grid of a simulation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing {
    pub ts: f64,
    /// Integration steps per sample.
    pub substeps: usize,
    /// Integration steps between two actions of a sampled controller; 0 without one.
    pub control_period: u64,
}

impl Timing {
    pub(super) fn choose(
        model: &Model,
        flat: &Flat,
        ts: SampleTime,
        limits: &Limits,
    ) -> Result<Self, SimulateError> {
        let ts = ts.seconds();
        let is_continuous = model.all_states().any(|state| matches!(state.law, Law::Derivative(_)));
        let step = match model.step {
            Some(step) => step,
            None if is_continuous => LARGEST_STEP / fastest(model, flat)?,
            None => f64::INFINITY,
        };
        let needed = (ts / step * (1.0 - ROUNDING)).ceil().max(1.0);
        let period = model.controller.as_ref().and_then(|controller| controller.sample_time);
        Self { ts, substeps: 1, control_period: 0 }.with(needed, period, limits.substeps)
    }

    /// At least `needed` steps per sample, such that the controller acts at the start of one.
    fn with(mut self, needed: f64, period: Option<f64>, most: u64) -> Result<Self, SimulateError> {
        let ts = self.ts;
        let per_sample = match period {
            None => 1.0,
            Some(period) => whole(ts / period)
                .or_else(|| whole(period / ts).map(|_| 1.0))
                .ok_or(SimulateError::ControllerRate { controller: period, ts })?,
        };
        let substeps = (needed / per_sample).ceil() * per_sample;
        if (most as f64) < substeps {
            return Err(SimulateError::TooStiff { substeps, ts, most });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole, checked above"
        )]
        {
            self.substeps = substeps as usize;
            self.control_period =
                period.map_or(0, |period| (period / ts * substeps).round() as u64);
        }
        Ok(self)
    }

    /// The same grid with each step divided into `factor`.
    pub(super) fn refined(self, factor: usize) -> Self {
        let factor = factor.max(1);
        Self {
            substeps: self.substeps * factor,
            control_period: self.control_period * factor as u64,
            ..self
        }
    }

    pub(super) fn h(self) -> f64 {
        self.ts / self.substeps as f64
    }
}

/// The whole number of at least 1 that this ratio is meant to be.
fn whole(ratio: f64) -> Option<f64> {
    let rounded = ratio.round();
    (1.0 <= rounded && (ratio - rounded).abs() <= ROUNDING * rounded).then_some(rounded)
}

/// Largest magnitude of an eigenvalue of the states with a derivative, in 1/s.
fn fastest(model: &Model, flat: &Flat) -> Result<f64, SimulateError> {
    let at = OperatingPoint::initial(model);
    let slopes = evaluate(flat, &flat.rates, flat.states, &at, model.sample_time)?;
    let is_moving: Vec<usize> = model
        .all_states()
        .enumerate()
        .filter_map(|(i, state)| matches!(state.law, Law::Derivative(_)).then_some(i))
        .collect();
    let n = is_moving.len();
    let a = Mat::from_fn(n, n, |i, j| slopes[is_moving[i] * flat.states + is_moving[j]]);
    for (row, state) in is_moving.iter().enumerate() {
        if (0..n).any(|col| !a[(row, col)].is_finite()) {
            let state = flat.scope.fast[FIRST_STATE + state].clone();
            return Err(SimulateError::NoStep { state });
        }
    }
    let linear =
        StateSpace::new(a, Mat::zeros(n, 0), Mat::zeros(0, n), Mat::zeros(0, 0), Continuous)?;
    Ok(linear.poles()?.into_iter().map(faer::c64::norm).fold(f64::MIN_POSITIVE, f64::max))
}
