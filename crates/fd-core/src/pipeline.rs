//! The stages joined into one diagnosis that runs sample by sample.

use crate::{
    error::{BuildError, FrameError},
    event::{EventKind, Events},
    frame::Frame,
    scalar::Scalar,
    sink::Sink,
    snapshot::StateVisitor,
    stage::{
        Compensation, Compensator, Decision, DecisionRule, Detector, Evidence, Phase,
        ResidualGenerator, Stage, Verdict,
    },
};

/// The parts of a [`Pipeline`], named so that a pipeline reads top to bottom.
#[derive(Clone, Debug)]
pub struct Stages<G, C, D, J> {
    /// Samples to primary residuals.
    pub generator: G,
    /// Primary to compensated residuals.
    pub compensator: C,
    /// Compensated residuals to test statistics.
    pub detector: D,
    /// Test statistics to decisions.
    pub rule: J,
}

/// Stages chosen at run time.
pub type DynStages<T = f64> = Stages<
    Box<dyn ResidualGenerator<T>>,
    Box<dyn Compensator<T>>,
    Box<dyn Detector<T>>,
    Box<dyn DecisionRule<T>>,
>;

/// What to do with a sample that has a NaN or an infinity in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MissingSamples {
    /// Refuse it with an error; the pipeline stays as it was.
    #[default]
    Reject,
    /// Replace each missing channel by its last good value, for at most so many samples in a
    /// row; then refuse.
    Hold {
        /// Most consecutive samples to replace.
        at_most: u64,
    },
}

/// A running diagnosis.
#[derive(Clone, Debug)]
pub struct Pipeline<T, S> {
    stages: S,
    missing: MissingSamples,
    u: Vec<T>,
    y: Vec<T>,
    residual: Vec<T>,
    compensated: Vec<T>,
    k: u64,
    held: u64,
    alarmed: bool,
}

/// A [`Pipeline`] whose stages were chosen at run time.
pub type DynPipeline<T = f64> = Pipeline<T, DynStages<T>>;

/// Everything that one sample produced, borrowed from the pipeline.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, T> {
    /// Sample index.
    pub k: u64,
    /// Primary residual `r`.
    pub residual: &'a [T],
    /// Compensated residual `r* = r − μ̂`.
    pub compensated: &'a [T],
    /// Whether the bias is being learned or subtracted.
    pub phase: Phase,
    /// Test statistic of the compensated residual.
    pub verdict: Verdict<T>,
    /// Outcome.
    pub decision: Decision<T>,
    /// What happened at this sample.
    pub events: Events,
}

impl<T, G, C, D, J> Pipeline<T, Stages<G, C, D, J>>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    C: Compensator<T>,
    D: Detector<T>,
    J: DecisionRule<T>,
{
    /// Joins the stages; missing samples are rejected.
    ///
    /// # Errors
    ///
    /// Returns the first stage that expects other numbers of channels than the generator has.
    pub fn new(stages: Stages<G, C, D, J>) -> Result<Self, BuildError> {
        let io = stages.generator.io();
        let found = stages.generator.residual_len();
        let drivers =
            [("compensator", stages.compensator.nu()), ("detector", stages.detector.nu())];
        for (stage, nu) in drivers {
            if let Some(expected) = nu.filter(|&nu| nu != io.nu) {
                return Err(BuildError { stage, signal: "input", expected, found: io.nu });
            }
        }
        let consumers = [
            ("compensator", stages.compensator.residual_len()),
            ("detector", stages.detector.residual_len()),
            ("decision rule", stages.rule.residual_len()),
        ];
        for (stage, expected) in consumers {
            if expected != found {
                return Err(BuildError { stage, signal: "residual", expected, found });
            }
        }
        Ok(Self {
            stages,
            missing: MissingSamples::Reject,
            u: vec![T::zero(); io.nu],
            y: vec![T::zero(); io.ny],
            residual: vec![T::zero(); found],
            compensated: vec![T::zero(); found],
            k: 0,
            held: 0,
            alarmed: false,
        })
    }

    /// Sets what to do with samples that have a NaN or an infinity in them.
    #[must_use]
    pub fn with_missing_samples(mut self, policy: MissingSamples) -> Self {
        self.missing = policy;
        self
    }

    /// The stages, for reports.
    pub fn stages(&self) -> &Stages<G, C, D, J> {
        &self.stages
    }

    /// Processes one sample. This is the whole data flow.
    ///
    /// # Errors
    ///
    /// Returns an error when the sample has the wrong channels, or is not finite and the policy
    /// for missing samples does not cover it; the pipeline is then unchanged.
    pub fn step(&mut self, u: &[T], y: &[T]) -> Result<Step<'_, T>, FrameError> {
        let io = self.stages.generator.io();
        let mut events = Events::none();
        let frame = match (Frame::new(io, self.k, u, y), self.missing) {
            (Ok(frame), _) => {
                self.held = 0;
                self.u.copy_from_slice(u);
                self.y.copy_from_slice(y);
                frame
            }
            (Err(FrameError::NonFinite { .. }), MissingSamples::Hold { at_most })
                if self.k > 0 && self.held < at_most =>
            {
                hold(&mut self.u, u);
                hold(&mut self.y, y);
                // Another sample than the one that was refused, and a restored memory may be anything.
                let held = Frame::new(io, self.k, &self.u, &self.y)?;
                self.held += 1;
                events.push(EventKind::SampleHeld);
                held
            }
            (Err(error), _) => return Err(error),
        };
        self.k += 1;

        let Stages { generator, compensator, detector, rule } = &mut self.stages;
        generator.step(frame, &mut self.residual);
        let Compensation { phase, events: happened } =
            compensator.step(frame, &self.residual, &mut self.compensated);
        let verdict = detector.update(frame.u(), &self.compensated);
        let k = frame.k();
        let decision = rule.decide(Evidence { k, phase, verdict, r_star: &self.compensated });

        happened.iter().for_each(|kind| events.push(kind));
        if decision.is_fault() != self.alarmed {
            self.alarmed = decision.is_fault();
            let kind = if self.alarmed { EventKind::AlarmRaised } else { EventKind::AlarmCleared };
            events.push(kind);
        }
        Ok(Step {
            k,
            residual: &self.residual,
            compensated: &self.compensated,
            phase,
            verdict,
            decision,
            events,
        })
    }

    /// Processes many samples and hands each outcome to `sink`.
    ///
    /// # Errors
    ///
    /// Stops at the first bad sample.
    pub fn run<'s>(
        &mut self,
        samples: impl IntoIterator<Item = (&'s [T], &'s [T])>,
        sink: &mut impl Sink<T>,
    ) -> Result<(), FrameError>
    where
        T: 's,
    {
        for (u, y) in samples {
            sink.record(self.step(u, y)?);
        }
        Ok(())
    }
}

/// A pipeline is itself a stage: it can be restarted, saved and restored as a whole.
impl<T, G, C, D, J> Stage<T> for Pipeline<T, Stages<G, C, D, J>>
where
    T: Scalar,
    G: ResidualGenerator<T>,
    C: Compensator<T>,
    D: Detector<T>,
    J: DecisionRule<T>,
{
    fn reset(&mut self) {
        self.stages.generator.reset();
        self.stages.compensator.reset();
        self.stages.detector.reset();
        self.stages.rule.reset();
        self.u.fill(T::zero());
        self.y.fill(T::zero());
        self.residual.fill(T::zero());
        self.compensated.fill(T::zero());
        self.k = 0;
        self.held = 0;
        self.alarmed = false;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("pipeline u", &mut self.u);
        visitor.reals("pipeline y", &mut self.y);
        let mut counts = [self.k, self.held, u64::from(self.alarmed)];
        visitor.counts("pipeline k, held, alarmed", &mut counts);
        [self.k, self.held] = [counts[0], counts[1]];
        self.alarmed = counts[2] != 0;
        self.stages.generator.visit_state(visitor);
        self.stages.compensator.visit_state(visitor);
        self.stages.detector.visit_state(visitor);
        self.stages.rule.visit_state(visitor);
    }
}

/// Overwrites the kept values by the new ones where these are finite.
fn hold<T: Scalar>(kept: &mut [T], new: &[T]) {
    for (kept, &new) in kept.iter_mut().zip(new) {
        if new.is_finite() {
            *kept = new;
        }
    }
}
