//! A diagnosis that has learned what is normal, and the pipelines that it makes.

use fd_compensate::{
    DrivenRows, SampleRows,
    calibrate::CalibrationPlan,
    residual_compensation::{PreFitted, ResidualCompensator},
};
use fd_core::{
    DynPipeline, DynStages, Event, MissingSamples, Pipeline,
    stage::{Compensator, DecisionRule, Detector, Uncompensated},
};
use fd_ident::order::OrderTable;
use fd_model::{Discrete, Record, StateSpace};
use fd_residual::GeneratorDesign;

use super::{
    bias::LearnedBias,
    choose::Compared,
    error::TrainingError,
    fault_free::{FaultFree, Judged},
    pay::Payment,
    running::RunningBias,
    silent::Silent,
    structure::{DynIdentifier, stand_by},
    trace::Trace,
};
use crate::spec::{DetectorData, DetectorSpec, PipelineSpec, StartSpec};

/// A diagnosis that has learned what is normal.
#[derive(Debug)]
pub struct Trained {
    pub(super) spec: PipelineSpec,
    pub(super) nominal: StateSpace<Discrete>,
    pub(super) design: Box<dyn GeneratorDesign>,
    pub(super) bias: LearnedBias,
    pub(super) selection: Option<OrderTable>,
    pub(super) compared: Vec<Compared>,
    pub(super) payments: Vec<Payment>,
    /// Of the residuals that the bias was learned from, channel by channel.
    pub(super) means: Vec<f64>,
    pub(super) fit: PreFitted,
    pub(super) events: Vec<Event>,
    pub(super) healthy: FaultFree,
    /// How a diagnosis begins, started at many places of the same logs.
    pub(super) beginnings: FaultFree,
}

impl Trained {
    /// What was chosen.
    #[must_use]
    pub fn spec(&self) -> &PipelineSpec {
        &self.spec
    }

    /// The residual generator at design time.
    #[must_use]
    pub fn design(&self) -> &dyn GeneratorDesign {
        self.design.as_ref()
    }

    /// The frozen bias model.
    #[must_use]
    pub fn bias_model(&self) -> &LearnedBias {
        &self.bias
    }

    /// How all orders did, when they were to be chosen.
    #[must_use]
    pub fn order_selection(&self) -> Option<&OrderTable> {
        self.selection.as_ref()
    }

    /// The forms of the bias model that were compared, the simplest first, if it was chosen.
    #[must_use]
    pub fn compared(&self) -> &[Compared] {
        &self.compared
    }

    /// What the bias model is worth in each residual channel on the samples that it was calibrated on; none without
    /// such samples, or when the bias is learned on line first.
    #[must_use]
    pub fn payments(&self) -> &[Payment] {
        &self.payments
    }

    /// Means of the residuals that the bias was learned from, channel by channel: what a constant alone would subtract,
    /// and a detector that knows the mean of healthy runs leaves out by itself.
    #[must_use]
    pub fn means(&self) -> &[f64] {
        &self.means
    }

    /// Phases of a recursive training.
    #[must_use]
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Largest fault-free magnitudes of the primary and the compensated residual in the
    /// calibration data, all channels together.
    #[must_use]
    pub fn fault_free_maxima(&self) -> (f64, f64) {
        let peak = |values: &[f64]| values.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        (peak(&self.healthy.primary), peak(&self.healthy.compensated))
    }

    /// Fault-free samples of the primary and the compensated residual, row by row, next to
    /// [their inputs](Trained::calibration_inputs).
    #[must_use]
    pub fn calibration(&self) -> (&[f64], &[f64]) {
        (&self.healthy.primary, &self.healthy.compensated)
    }

    /// Inputs of the fault-free samples, row by row.
    #[must_use]
    pub fn calibration_inputs(&self) -> &[f64] {
        &self.healthy.inputs
    }

    /// A fresh pipeline that subtracts the learned bias, or, when the spec starts in training, learns it on
    /// line first, as [`Trained::learning`].
    ///
    /// # Errors
    ///
    /// Returns an error when there was no calibration data, or it does not fit the detector.
    pub fn compensated(&self) -> Result<DynPipeline, TrainingError> {
        self.pipeline(Box::new(self.compensator()?), Judged::Compensated)
    }

    /// A fresh pipeline that learns the bias on line from its first sample, whatever the spec says of the
    /// start. Its detector is calibrated as that of [`Trained::compensated`], and decides nothing before the
    /// switch is open.
    ///
    /// # Errors
    ///
    /// As [`Trained::compensated`].
    pub fn learning(&self) -> Result<DynPipeline, TrainingError> {
        let compensator = self.compensator_from(StartSpec::Training)?;
        self.pipeline(Box::new(compensator), Judged::Compensated)
    }

    /// A fresh pipeline without compensation, its detector calibrated in the same way. It waits as long as the one
    /// that compensates for the generator to settle.
    ///
    /// # Errors
    ///
    /// As [`Trained::compensated`].
    pub fn uncompensated(&self) -> Result<DynPipeline, TrainingError> {
        let compensator = Uncompensated::new(self.design.residual_len()).settling(self.fit.filling);
        self.pipeline(Box::new(compensator), Judged::Primary)
    }

    fn pipeline(
        &self,
        compensator: Box<dyn Compensator>,
        judged: Judged,
    ) -> Result<DynPipeline, TrainingError> {
        let healthy = self.healthy.residual(judged);
        let begun = Some(&self.beginnings).filter(|begun| !begun.is_empty());
        let beginnings = begun.map(|begun| begun.rows(begun.residual(judged))).transpose()?;
        let detector =
            self.detector_from(&self.spec.detector, healthy, beginnings, Some(&self.plan()))?;
        let PipelineSpec { isolation, rule, sizing, .. } = &self.spec;
        let rows = SampleRows::new(self.design.residual_len(), healthy)?;
        let rule = isolation.rule(*rule, sizing, self.design.as_ref(), rows)?;
        self.assemble(compensator, detector, rule)
    }

    /// The detector of the spec, calibrated on one of the two fault-free residuals.
    ///
    /// # Errors
    ///
    /// Returns an error when the residual does not fit the design, or is too short for the rate.
    pub fn detector(&self, healthy: &[f64]) -> Result<Box<dyn Detector>, TrainingError> {
        self.detector_from(&self.spec.detector, healthy, None, Some(&self.plan()))
    }

    fn plan(&self) -> CalibrationPlan {
        CalibrationPlan { debouncing: self.spec.rule, ..self.spec.calibration.clone() }
    }

    /// Another detector with the scales of fault-free residuals, its threshold not calibrated.
    ///
    /// # Errors
    ///
    /// Returns an error when the residual does not fit the design or the detector.
    pub fn scaled(
        &self,
        detector: &DetectorSpec,
        healthy: &[f64],
    ) -> Result<Box<dyn Detector>, TrainingError> {
        self.detector_from(detector, healthy, None, None)
    }

    fn detector_from(
        &self,
        detector: &DetectorSpec,
        healthy: &[f64],
        beginnings: Option<DrivenRows<'_>>,
        plan: Option<&CalibrationPlan>,
    ) -> Result<Box<dyn Detector>, TrainingError> {
        let data = DetectorData {
            healthy: self.healthy.rows(healthy)?,
            beginnings,
            plan,
            model: &self.nominal,
            design: self.design.as_ref(),
        };
        Ok(detector.calibrated(&data)?)
    }

    fn assemble(
        &self,
        compensator: Box<dyn Compensator>,
        detector: Box<dyn Detector>,
        rule: Box<dyn DecisionRule>,
    ) -> Result<DynPipeline, TrainingError> {
        let stages = DynStages { generator: self.design.build()?, compensator, detector, rule };
        let missing = match self.spec.hold_missing {
            0 => MissingSamples::Reject,
            at_most => MissingSamples::Hold { at_most },
        };
        Ok(Pipeline::new(stages)?.with_missing_samples(missing))
    }

    pub(super) fn compensator(
        &self,
    ) -> Result<ResidualCompensator<f64, DynIdentifier, RunningBias>, TrainingError> {
        self.compensator_from(self.spec.start)
    }

    fn compensator_from(
        &self,
        start: StartSpec,
    ) -> Result<ResidualCompensator<f64, DynIdentifier, RunningBias>, TrainingError> {
        let nu = self.design.io().nu;
        let identifier = stand_by(&self.bias, &self.spec.bias.learning, nu)?;
        let plan = &self.spec.compensation;
        let simulator = self.bias.freeze()?;
        Ok(match start {
            StartSpec::Fitted => {
                ResidualCompensator::pre_fitted(identifier, simulator, self.fit.clone(), plan)?
            }
            StartSpec::Training => {
                let settling = self.fit.filling;
                ResidualCompensator::new(identifier, simulator, plan)?.settling(settling)
            }
        })
    }

    /// Both residuals of a log, sample by sample, without anybody judging them.
    pub(super) fn watch(&self, record: &Record) -> Result<Trace, TrainingError> {
        Ok(Trace::of(&mut self.silent()?, record)?)
    }

    /// A pipeline that compensates and never alarms.
    ///
    /// # Errors
    ///
    /// Returns an error when the design cannot be built.
    pub fn silent(&self) -> Result<DynPipeline, TrainingError> {
        let judge = Box::new(Silent(self.design.residual_len()));
        self.assemble(Box::new(self.compensator()?), judge.clone(), judge)
    }
}
