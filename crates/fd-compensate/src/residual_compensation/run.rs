//! The compensator: what it is made of, how it begins, what it can be asked.

use fd_core::{
    Scalar,
    stage::{BiasModel, Identifier},
};

use super::{
    convergence::ConvergenceTest,
    design::{CompensationPlan, Mode, PreFitted, Timeout},
    error::CompensationError,
    jump::JumpTest,
    operating_point::OperatingPointGuard,
    plant_watch::PlantWatch,
    trial::TrialRun,
};

/// Two-stage residual compensation over any identifier and bias model.
///
/// Two copies of the bias model run side by side. The *predictor* always remembers the measured
/// residual and supplies the innovation of the training. The *simulator* remembers a sample only
/// after it was found healthy, so that a hard fault in training never enters its history, and is
/// the one that computes `μ̂` once the switch is open. A bias model must show its parameters to
/// [`Stage::visit_state`](fd_core::stage::Stage::visit_state), as the contract of a stage says.
#[derive(Clone, Debug)]
pub struct ResidualCompensator<T, I, M> {
    pub(super) identifier: I,
    pub(super) predictor: M,
    pub(super) simulator: M,
    pub(super) mode: Mode,
    pub(super) longest: Option<u64>,
    pub(super) at_longest: Timeout,
    pub(super) least_input_span: T,
    pub(super) divergence: T,
    pub(super) start: Start<T>,
    pub(super) asks: bool,

    pub(super) activity: Activity,
    pub(super) convergence: ConvergenceTest<T>,
    pub(super) trial: TrialRun<T>,
    pub(super) jump: JumpTest<T>,
    pub(super) operating_point: OperatingPointGuard<T>,
    pub(super) plant_watch: PlantWatch<T>,
    /// The candidate or frozen parameters `θ*`.
    pub(super) frozen: Vec<T>,
    pub(super) mu_hat: Vec<T>,
    /// Largest `|r|` of the training.
    pub(super) peak: T,
    /// Samples since the present activity chain (training or filling) began.
    pub(super) age: u64,
    pub(super) guard_reported: bool,
    /// Whether it has asked to train again and still would.
    pub(super) has_asked: bool,
}

/// How a compensator begins and, on reset, begins again.
#[derive(Clone, Debug)]
pub(super) enum Start<T> {
    Training { settling: u64 },
    Compensating { fit: PreFitted, theta: Vec<T> },
}

/// What the compensator is doing; the phase and a little more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Activity {
    /// Learning the parameters.
    Learning,
    /// Learning on, while a candidate is simulated next to the residual.
    Trying,
    /// Waiting for a hard fault to go away.
    Paused,
    /// Waiting at the start, while the generator settles or the histories of a fitted model fill.
    Filling,
    /// The switch is open.
    Compensating,
}

impl Activity {
    pub(super) const ALL: [Self; 5] =
        [Self::Learning, Self::Trying, Self::Paused, Self::Filling, Self::Compensating];
}

impl<T, I, M> ResidualCompensator<T, I, M>
where
    T: Scalar,
    I: Identifier<T>,
    M: BiasModel<T> + Clone,
{
    /// A compensator that trains on line first.
    ///
    /// # Errors
    ///
    /// Returns an error when identifier and model differ in their sizes or a number of the plan is
    /// out of its range.
    ///
    /// # Examples
    ///
    /// ```
    /// # use fd_core::{StateVisitor, stage::{BiasModel, Stage}};
    /// # #[derive(Clone, Debug)] struct Gain(f64);
    /// # impl Stage for Gain {
    /// #     fn reset(&mut self) { self.0 = 0.0; }
    /// #     fn visit_state(&mut self, v: &mut dyn StateVisitor<f64>) {
    /// #         v.reals("gain", std::slice::from_mut(&mut self.0));
    /// #     }
    /// # }
    /// # impl BiasModel for Gain {
    /// #     fn nu(&self) -> usize { 1 }
    /// #     fn residual_len(&self) -> usize { 1 }
    /// #     fn theta_len(&self) -> usize { 1 }
    /// #     fn load(&mut self, theta: &[f64]) { self.0 = theta[0]; }
    /// #     fn observe(&mut self, _: &[f64], _: &[f64]) {}
    /// #     fn simulate(&mut self, u: &[f64], mu: &mut [f64]) { mu[0] = self.0 * u[0]; }
    /// #     fn predict(&mut self, u: &[f64], _: &[f64], mu: &mut [f64]) { self.simulate(u, mu); }
    /// # }
    /// use fd_compensate::residual_compensation::{
    ///     CompensationPlan, FixedParameters, ResidualCompensator,
    /// };
    /// use fd_core::stage::Compensator;
    ///
    /// let identifier = FixedParameters::new(1, 1, &[-0.3]);
    /// let plan = CompensationPlan::default();
    /// let compensator = ResidualCompensator::new(identifier, Gain(0.0), &plan)?;
    /// assert_eq!(compensator.nu(), Some(1));
    /// # Ok::<(), fd_compensate::residual_compensation::CompensationError>(())
    /// ```
    pub fn new(
        identifier: I,
        model: M,
        plan: &CompensationPlan,
    ) -> Result<Self, CompensationError> {
        plan.check()?;
        let (nu, residual_len, theta_len) = (model.nu(), model.residual_len(), model.theta_len());
        for (quantity, expected, found) in [
            ("inputs", nu, identifier.nu()),
            ("residual channels", residual_len, identifier.residual_len()),
            ("parameters", theta_len, identifier.theta().len()),
        ] {
            if expected != found {
                let part = "identifier";
                return Err(CompensationError::Size { part, quantity, expected, found });
            }
        }
        Ok(Self {
            identifier,
            predictor: model.clone(),
            simulator: model,
            mode: plan.mode,
            longest: plan.convergence.longest,
            at_longest: plan.convergence.at_longest,
            least_input_span: T::from_design(plan.convergence.least_input_span),
            divergence: T::from_design(plan.trial.divergence),
            start: Start::Training { settling: 0 },
            asks: plan.ask,
            activity: Activity::Learning,
            convergence: ConvergenceTest::new(&plan.convergence, theta_len, residual_len),
            trial: TrialRun::new(&plan.trial, residual_len),
            jump: JumpTest::new(&plan.hard_fault, residual_len),
            operating_point: OperatingPointGuard::new(&plan.operating_point, nu),
            plant_watch: PlantWatch::new(&plan.plant_change, nu, residual_len),
            frozen: vec![T::zero(); theta_len],
            mu_hat: vec![T::zero(); residual_len],
            peak: T::zero(),
            age: 0,
            guard_reported: false,
            has_asked: false,
        })
    }

    /// A compensator whose switch is open from the first sample, with parameters fitted beforehand.
    ///
    /// The identifier is needed only for re-training; [`FixedParameters`](super::FixedParameters)
    /// stands in where none is wanted.
    ///
    /// # Errors
    ///
    /// As [`ResidualCompensator::new`], and when the fit has other sizes than the model or is not
    /// finite.
    pub fn pre_fitted(
        identifier: I,
        model: M,
        fit: PreFitted,
        plan: &CompensationPlan,
    ) -> Result<Self, CompensationError> {
        fit.check(model.nu(), model.theta_len())?;
        let mut compensator = Self::new(identifier, model, plan)?;
        let theta = fit.theta.iter().map(|&v| T::from_design(v)).collect();
        compensator.start = Start::Compensating { fit, theta };
        compensator.begin();
        Ok(compensator)
    }

    /// Sets the samples at the start that a training on line does not learn from, while the residual
    /// generator forgets where it started (phase `Training`, `r* = r`). A fitted compensator has
    /// [`PreFitted::filling`] for that and stays as it is.
    #[must_use]
    pub fn settling(mut self, samples: u64) -> Self {
        if let Start::Training { settling } = &mut self.start {
            *settling = samples;
            self.begin();
        }
        self
    }

    /// The frozen parameters `θ*`, or the candidate that is being tried; `None` while there is none.
    #[must_use]
    pub fn theta(&self) -> Option<&[T]> {
        match self.activity {
            Activity::Learning | Activity::Paused => None,
            Activity::Filling if matches!(self.start, Start::Training { .. }) => None,
            Activity::Trying | Activity::Filling | Activity::Compensating => Some(&self.frozen),
        }
    }

    /// The newest `μ̂`: predicted while training, simulated by the candidate in its trial, and
    /// what was subtracted from the last residual once the switch is open.
    #[must_use]
    pub fn bias(&self) -> &[T] {
        &self.mu_hat
    }

    /// The identifier, for reports.
    pub fn identifier(&self) -> &I {
        &self.identifier
    }

    /// Trains again from the next sample, as when the operating condition has changed. The plant
    /// must be healthy.
    ///
    /// Parameters are forgotten, unless the identifier keeps what it learned under other
    /// conditions ([`Identifier::retrain`]); the trained range of the input then grows instead of
    /// starting anew.
    pub fn retrain(&mut self) {
        if self.identifier.retrain(&self.frozen) {
            self.forget_samples();
            self.operating_point.reopen();
        } else {
            self.forget();
        }
        self.activity = Activity::Learning;
    }
}
