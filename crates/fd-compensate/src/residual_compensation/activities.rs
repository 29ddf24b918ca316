//! What the compensator does with one sample in each of its activities.

use fd_core::{
    EventKind, Events, Frame, Scalar, StateVisitor,
    stage::{BiasModel, Compensation, Compensator, Identifier, Phase, Stage},
};

use super::{
    design::{Mode, Timeout},
    run::{Activity, ResidualCompensator, Start},
    trial::TrialOutcome,
};

impl<T, I, M> ResidualCompensator<T, I, M>
where
    T: Scalar,
    I: Identifier<T>,
    M: BiasModel<T> + Clone,
{
    pub(super) fn forget(&mut self) {
        self.identifier.reset();
        self.forget_samples();
        self.operating_point.reset();
        self.frozen.fill(T::zero());
        self.peak = T::zero();
    }

    /// Forgets all samples, but neither parameters nor the range that they hold for.
    pub(super) fn forget_samples(&mut self) {
        self.predictor.reset();
        self.simulator.reset();
        self.convergence.reset();
        self.trial.reset();
        self.jump.reset();
        self.plant_watch.reset();
        self.mu_hat.fill(T::zero());
        self.age = 0;
        self.guard_reported = false;
        self.has_asked = false;
    }

    /// Enters the first activity of a compensator that has no memory.
    pub(super) fn begin(&mut self) {
        self.activity = match &self.start {
            Start::Training { settling: 0 } => Activity::Learning,
            Start::Training { .. } => Activity::Filling,
            Start::Compensating { fit, theta } => {
                self.frozen.copy_from_slice(theta);
                self.operating_point.set_range(&fit.input_low, &fit.input_high);
                self.peak = T::from_design(fit.residual_peak);
                self.predictor.load(theta);
                self.simulator.load(theta);
                if fit.filling > 0 { Activity::Filling } else { Activity::Compensating }
            }
        };
    }

    fn training(&self) -> Phase {
        Phase::Training { samples: self.convergence.learned() }
    }

    /// Fills the histories of the models; `μ̂ = 0`.
    fn fill(&mut self, u: &[T], r: &[T]) -> Phase {
        self.predictor.observe(u, r);
        self.simulator.observe(u, r);
        self.age += 1;
        match &self.start {
            Start::Compensating { fit, .. } if self.age >= fit.filling => {
                self.activity = Activity::Compensating;
            }
            Start::Training { settling } if self.age >= *settling => {
                self.activity = Activity::Learning;
                self.age = 0;
            }
            _ => {}
        }
        Phase::Training { samples: 0 }
    }

    /// Learns one sample and writes the innovation.
    fn train(&mut self, u: &[T], r: &[T], r_star: &mut [T], events: &mut Events) -> Phase {
        if self.age == 0 {
            events.push(EventKind::TrainingStarted);
        }
        self.age += 1;
        self.predictor.load(self.identifier.theta());
        self.predictor.predict(u, r, &mut self.mu_hat);
        subtract(r, &self.mu_hat, r_star);
        if self.operating_point.is_new(u) {
            self.jump.warm_up();
        }
        if self.jump.jumps(r_star, self.peak) {
            events.push(EventKind::HardFaultWhileTraining);
            self.pause(u, r, r_star);
            return self.training();
        }
        self.peak = r.iter().fold(self.peak, |peak, v| peak.max(v.abs()));
        self.operating_point.learn(u);
        let converged = self.convergence.learn(&mut self.identifier, u, r, r_star);
        if !self.guard_reported && self.identifier.guard().acted() {
            self.guard_reported = true;
            events.push(EventKind::WindUpGuard);
        }
        let phase = self.training();
        if self.activity == Activity::Trying {
            self.try_candidate(u, r, events);
        } else {
            self.simulator.observe(u, r);
            if converged && self.operating_point.span() > self.least_input_span {
                self.nominate(events);
            }
        }
        self.mind_the_time(events);
        phase
    }

    /// Makes the present parameters the candidate `θ*`.
    fn nominate(&mut self, events: &mut Events) {
        self.frozen.copy_from_slice(self.identifier.theta());
        self.simulator.load(&self.frozen);
        if self.trial.is_wanted() {
            self.trial.reset();
            self.activity = Activity::Trying;
        } else {
            self.open_switch(events);
        }
    }

    fn try_candidate(&mut self, u: &[T], r: &[T], events: &mut Events) {
        self.simulator.simulate(u, &mut self.mu_hat);
        match self.trial.add(r, &self.mu_hat) {
            TrialOutcome::Ongoing => {}
            TrialOutcome::Accepted => self.open_switch(events),
            TrialOutcome::Rejected => {
                events.push(EventKind::BiasModelRejected);
                self.convergence.doubt();
                // Its history is its own; the samples of the next streak fill in a measured one.
                self.simulator.reset();
                self.activity = Activity::Learning;
            }
        }
    }

    fn open_switch(&mut self, events: &mut Events) {
        self.predictor.load(&self.frozen);
        self.activity = Activity::Compensating;
        events.push(EventKind::Frozen);
    }

    /// Ends a training that takes too long.
    fn mind_the_time(&mut self, events: &mut Events) {
        let is_late = self.longest.is_some_and(|longest| self.age >= longest);
        if !is_late || self.activity == Activity::Compensating {
            return;
        }
        events.push(EventKind::TrainingInconclusive);
        match self.at_longest {
            Timeout::TrainAgain => self.retrain(),
            Timeout::FreezeAnyway => {
                if self.activity == Activity::Learning {
                    self.frozen.copy_from_slice(self.identifier.theta());
                    self.simulator.load(&self.frozen);
                }
                self.open_switch(events);
            }
        }
    }

    /// Goes on from the last healthy sample by simulation, so that the fault is not learned.
    fn pause(&mut self, u: &[T], r: &[T], r_star: &mut [T]) {
        if self.activity == Activity::Learning {
            self.frozen.copy_from_slice(self.identifier.theta());
            self.simulator.load(&self.frozen);
        }
        self.activity = Activity::Paused;
        self.simulator.simulate(u, &mut self.mu_hat);
        subtract(r, &self.mu_hat, r_star);
    }

    /// Goes on simulating until the fault has gone or the time is up.
    fn wait(&mut self, u: &[T], r: &[T], r_star: &mut [T], events: &mut Events) -> Phase {
        self.age += 1;
        self.simulator.simulate(u, &mut self.mu_hat);
        subtract(r, &self.mu_hat, r_star);
        let phase = self.training();
        if self.jump.has_recovered(r_star) {
            // The samples of the pause are missing in the regressors of the identifier, so that
            // it cannot go on from where it was.
            self.retrain();
        } else {
            self.mind_the_time(events);
        }
        phase
    }

    /// Subtracts the bias; the switch is open.
    fn compensate(&mut self, u: &[T], r: &[T], r_star: &mut [T], events: &mut Events) -> Phase {
        match self.mode {
            Mode::Simulation => self.simulator.simulate(u, &mut self.mu_hat),
            Mode::OneStep => self.predictor.predict(u, r, &mut self.mu_hat),
        }
        let limit = self.divergence * self.peak;
        // Written so that a NaN counts as diverged.
        if !self.mu_hat.iter().all(|mu| mu.abs() <= limit) {
            events.push(EventKind::BiasModelRejected);
            self.retrain();
            r_star.copy_from_slice(r);
            return Phase::Training { samples: 0 };
        }
        subtract(r, &self.mu_hat, r_star);
        // Both watch every sample, whatever the other says.
        let has_moved = self.operating_point.watch(u, events);
        let is_wanted = self.plant_watch.watch(u, r_star, self.peak, events) || has_moved;
        if self.asks {
            self.ask(is_wanted, events);
        } else if is_wanted {
            self.retrain();
        }
        Phase::Compensating
    }

    /// Asks once to train again, and takes it back when there is no reason any more.
    fn ask(&mut self, is_wanted: bool, events: &mut Events) {
        if is_wanted && !self.has_asked {
            self.has_asked = true;
            events.push(EventKind::RetrainingWanted);
        } else if self.has_asked
            && !self.operating_point.is_outside()
            && !self.plant_watch.is_changed()
        {
            self.has_asked = false;
            events.push(EventKind::RetrainingWithdrawn);
        }
    }
}

impl<T, I, M> Compensator<T> for ResidualCompensator<T, I, M>
where
    T: Scalar,
    I: Identifier<T>,
    M: BiasModel<T> + Clone,
{
    fn nu(&self) -> Option<usize> {
        Some(self.simulator.nu())
    }

    fn residual_len(&self) -> usize {
        self.simulator.residual_len()
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &[T], r_star: &mut [T]) -> Compensation {
        let u = frame.u();
        let mut events = Events::none();
        let phase = match self.activity {
            Activity::Learning | Activity::Trying => self.train(u, r, r_star, &mut events),
            Activity::Paused => self.wait(u, r, r_star, &mut events),
            Activity::Filling => {
                r_star.copy_from_slice(r);
                self.fill(u, r)
            }
            Activity::Compensating => self.compensate(u, r, r_star, &mut events),
        };
        Compensation { phase, events }
    }

    fn retrain(&mut self) -> bool {
        Self::retrain(self);
        true
    }
}

impl<T, I, M> Stage<T> for ResidualCompensator<T, I, M>
where
    T: Scalar,
    I: Identifier<T>,
    M: BiasModel<T> + Clone,
{
    fn reset(&mut self) {
        self.forget();
        self.begin();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        let activity = Activity::ALL.iter().position(|&a| a == self.activity).unwrap_or(0);
        let (reported, asked) = (u64::from(self.guard_reported), u64::from(self.has_asked));
        let mut counts = [activity as u64, self.age, reported, asked];
        visitor.counts("compensator activity, age, guard reported, asked", &mut counts);
        let activity = usize::try_from(counts[0]).ok().and_then(|i| Activity::ALL.get(i));
        self.activity = activity.copied().unwrap_or(Activity::Learning);
        self.age = counts[1];
        self.guard_reported = counts[2] != 0;
        self.has_asked = counts[3] != 0;

        visitor.reals("compensator parameters", &mut self.frozen);
        visitor.reals("compensator bias", &mut self.mu_hat);
        visitor.reals("compensator residual peak", std::slice::from_mut(&mut self.peak));
        self.convergence.visit_state(visitor);
        self.trial.visit_state(visitor);
        self.jump.visit_state(visitor);
        self.operating_point.visit_state(visitor);
        self.plant_watch.visit_state(visitor);
        self.identifier.visit_state(visitor);
        self.predictor.visit_state(visitor);
        self.simulator.visit_state(visitor);
    }
}

fn subtract<T: Scalar>(r: &[T], mu_hat: &[T], r_star: &mut [T]) {
    for ((star, &r), &mu) in r_star.iter_mut().zip(r).zip(mu_hat) {
        *star = r - mu;
    }
}
