//! What a detector is made from, and why it cannot be.

use fd_compensate::{
    DrivenRows, RowsError,
    calibrate::{CalibrationError, CalibrationPlan, FalseAlarms, calibrate_with_beginnings},
    detect::{DetectorError, Spread, Standardizer},
};
use fd_core::stage::Detector;
use fd_model::{Discrete, ModelError, StateSpace};
use fd_residual::{DesignError, GeneratorDesign};
use thiserror::Error;

/// What a detector is made from.
#[derive(Clone, Copy, Debug)]
pub struct DetectorData<'a> {
    /// Fault-free residuals with their inputs.
    pub healthy: DrivenRows<'a>,
    /// How runs begin, each a run of its own, where they begin otherwise than they go on.
    pub beginnings: Option<DrivenRows<'a>>,
    /// How a threshold is found for a rate of false alarms; without it the detector is scaled but
    /// its threshold stays at 1 and is set by the caller.
    pub plan: Option<&'a CalibrationPlan>,
    /// The nominal model.
    pub model: &'a StateSpace<Discrete>,
    /// What makes the residual.
    pub design: &'a dyn GeneratorDesign,
}

/// A detector cannot be made from these fault-free residuals.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum DetectorSpecError {
    /// Its settings or its scales.
    #[error(transparent)]
    Detector(#[from] DetectorError),
    /// The fault-free samples.
    #[error(transparent)]
    Rows(#[from] RowsError),
    /// Its threshold.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The residual generator does not allow what it needs to know of faults or uncertainty.
    #[error(transparent)]
    Generator(#[from] DesignError),
    /// The model does not.
    #[error(transparent)]
    Model(#[from] ModelError),
}

impl DetectorData<'_> {
    /// A detector with the threshold that keeps the wanted rate, set by `with`.
    pub(super) fn calibrated<D: Detector + 'static>(
        &self,
        mut detector: D,
        wanted: FalseAlarms,
        with: impl FnOnce(D, f64) -> Result<D, DetectorError>,
    ) -> Result<Box<dyn Detector>, DetectorSpecError> {
        let Some(plan) = self.plan else { return Ok(Box::new(detector)) };
        let Self { healthy, beginnings, .. } = *self;
        let found = calibrate_with_beginnings(&mut detector, healthy, beginnings, wanted, plan)?;
        Ok(Box::new(with(detector, found.threshold)?))
    }

    pub(super) fn standard(&self) -> Result<Standardizer<f64>, DetectorError> {
        Standardizer::from_fault_free(self.healthy.residuals(), Spread::StandardDeviation)
    }
}
