//! The stages joined into one diagnosis that runs sample by sample.

mod parts;

pub use self::parts::{DynStages, MissingSamples, Stages, Step};
use crate::{
    error::{BuildError, FrameError},
    event::{EventKind, Events},
    frame::Frame,
    scalar::Scalar,
    sink::Sink,
    stage::{
        Compensation, Compensator, DecisionRule, Detector, Evidence, Phase, ResidualGenerator,
        Stage,
    },
    visitor::StateVisitor,
};

/// A running diagnosis: the four stages, the buffers between them, and a policy for missing samples.
///
/// [`step`](Self::step) is the only place in the workspace where stages meet, and it reads like the
/// picture of the method: check the sample, make the residual, compensate it, test it, decide. Data
/// flow forward only. No stage calls a later one, none keeps another's output, and what one sample
/// produced leaves as a single borrowed [`Step`].
///
/// # The contract
///
/// *Building* can fail: [`new`](Self::new) compares the numbers of channels that the stages were
/// built for and names the first that does not fit. *Stepping* can fail in one way only, by a sample
/// that is no good, and then the pipeline is as it was before the call.
///
/// A step allocates nothing and takes about the same time in every phase, so a pipeline may run in the
/// loop of a controller. It contains no thread, no clock and no random number: the same samples give
/// the same decisions to the bit, today, on a restored copy, and in a replay of the log.
///
/// # Samples and their index
///
/// `k` starts at 0 and counts the samples that were accepted. A rejected sample gets no index, and the
/// stages never learn that it was there: for them the next good one follows the last good one. That is
/// fine for a value lost now and then. After a long gap call [`reset`](Stage::reset), because the
/// states of observers and the histories of bias models are then those of another time.
///
/// [`MissingSamples`] decides what counts as good. `Reject` hands every NaN back to the caller, who
/// alone knows whether the sensor or the recorder failed. `Hold` repeats the last good value of the
/// missing channels for a stated number of samples in a row and says so by the event `SampleHeld`. A
/// sample with the wrong number of channels is an error under either policy.
///
/// # Static or dynamic
///
/// The type parameter is the struct of stages. With concrete types the compiler sees through the whole
/// pipeline, and with [`Fixed`](crate::Fixed) sizes in the stages nothing is on the heap but the
/// buffers between them. With [`DynStages`] each stage is a box, chosen at run time by a spec or a
/// command line. [`DynPipeline`] is no second implementation: it is `Pipeline` with other type
/// arguments. The two kinds may be mixed, stage by stage.
///
/// # When judging begins
///
/// While a compensator settles or trains, its `r*` is not what a threshold was set on. The rule is silent then, and
/// the detector begins anew with the first sample of [`Phase::Compensating`](crate::stage::Phase), so that no window
/// or sum carries samples of the training into the verdicts after it. It begins anew, too, after a sample whose
/// residual is not finite: no window remembers that a model had no answer.
///
/// # Stopping and going on
///
/// A pipeline is a [`Stage`], so [`Snapshot::of`](crate::Snapshot::of) saves all of it, wherever it
/// is: in the middle of a training, during an alarm, between two held samples. Restore the snapshot
/// into a pipeline that was built from the same design.
///
/// # What to do elsewhere
///
/// * Acting on a decision: in a [`Sink`], or in the loop around `step`.
/// * Resampling, scaling, units: before, when the record is made.
/// * Many units at once: a pipeline each, or `fdiag::fleet`, which computes side by side.
/// * A bank of generators: one generator to the pipeline, `fd_residual::bank`.
///
/// # Example
///
/// The smallest whole diagnosis. Two sensors of the same temperature must agree; their difference is
/// the residual, a constant threshold tests it, and every alarm is a fault.
///
/// ```
/// use fd_core::{
///     DynStages, EventKind, Frame, IoDims, MissingSamples, Pipeline, Snapshot, Stages, StateVisitor,
///     stage::{
///         Decision, DecisionRule, Detector, Evidence, Fault, ResidualGenerator, Stage, Uncompensated,
///         Verdict,
///     },
/// };
///
/// #[derive(Debug)]
/// struct Difference;
/// #[derive(Debug)]
/// struct AtMost(f64);
/// #[derive(Debug)]
/// struct AlarmIsFault;
///
/// impl ResidualGenerator for Difference {
///     fn io(&self) -> IoDims { IoDims { nu: 0, ny: 2 } }
///     fn residual_len(&self) -> usize { 1 }
///     fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
///         r[0] = frame.y()[0] - frame.y()[1];
///     }
/// }
///
/// impl Detector for AtMost {
///     fn residual_len(&self) -> usize { 1 }
///     fn update(&mut self, _u: &[f64], r: &[f64]) -> Verdict<f64> {
///         Verdict { statistic: r[0].abs(), threshold: self.0 }
///     }
/// }
///
/// impl DecisionRule for AlarmIsFault {
///     fn residual_len(&self) -> usize { 1 }
///     fn decide(&mut self, evidence: Evidence<'_, f64>) -> Decision<f64> {
///         if evidence.verdict.alarm() {
///             Decision::Fault(Fault::since(evidence.k))
///         } else {
///             Decision::Nominal
///         }
///     }
/// }
///
/// // None of the three has a memory, so `reset` and `visit_state` of their `Stage` are empty.
/// # macro_rules! without_memory { ($($stage:ty)*) => { $(
/// # impl Stage for $stage {
/// #     fn reset(&mut self) {}
/// #     fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
/// # }
/// # )* } }
/// # without_memory!(Difference AtMost AlarmIsFault);
///
/// let mut pipeline = Pipeline::new(Stages {
///     generator: Difference,
///     compensator: Uncompensated::new(1),
///     detector: AtMost(0.5),
///     rule: AlarmIsFault,
/// })?
/// .with_missing_samples(MissingSamples::Hold { at_most: 1 });
///
/// let log = [[20.0, 20.1], [20.2, 20.2], [20.3, f64::NAN], [20.4, 21.7]];
/// let mut story = Vec::new();
/// for y in &log {
///     let step = pipeline.step(&[], y)?;
///     story.extend(step.events.iter().map(|kind| (step.k, kind)));
/// }
/// assert_eq!(story, [(2, EventKind::SampleHeld), (3, EventKind::AlarmRaised)]);
///
/// // The same with stages chosen at run time; it takes over where the other one was saved.
/// let stages: DynStages = Stages {
///     generator: Box::new(Difference),
///     compensator: Box::new(Uncompensated::new(1)),
///     detector: Box::new(AtMost(0.5)),
///     rule: Box::new(AlarmIsFault),
/// };
/// let mut other = Pipeline::new(stages)?;
/// Snapshot::of(&mut pipeline).restore(&mut other)?;
/// let step = other.step(&[], &[20.5, 20.5])?;
/// assert_eq!(step.k, 4);
/// assert!(step.events.iter().eq([EventKind::AlarmCleared]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    void: bool,
    /// Whether the last sample was compensated, so that the detector remembers samples like the next.
    judged: bool,
}

/// A [`Pipeline`] whose stages were chosen at run time.
pub type DynPipeline<T = f64> = Pipeline<T, DynStages<T>>;

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
            void: false,
            judged: false,
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

    /// Whether, at the last sample, the threshold was said to be void: while compensating, and where the
    /// [detector](Detector::is_void) says so.
    pub fn is_void(&self) -> bool {
        self.void
    }

    /// Lets the compensator train again from the next sample; false where there is nothing to train.
    pub fn retrain(&mut self) -> bool {
        self.stages.compensator.retrain()
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
        // The `r*` of the settling and of the training is no fault-free residual: a window that still held some
        // of it would alarm when the switch opens. Thresholds are calibrated on detectors that begin there too.
        let judged = phase == Phase::Compensating;
        if judged && !self.judged {
            detector.reset();
        }
        self.judged = judged;
        let verdict = detector.update(frame.u(), &self.compensated);
        let k = frame.k();
        let decision = rule.decide(Evidence { k, phase, verdict, r_star: &self.compensated });

        happened.iter().for_each(|kind| events.push(kind));
        // While the bias is learned no threshold applies.
        let void = judged && detector.is_void();
        if void != self.void {
            self.void = void;
            events.push(if void { EventKind::ThresholdVoid } else { EventKind::ThresholdValid });
        }
        if decision.is_fault() != self.alarmed {
            self.alarmed = decision.is_fault();
            let kind = if self.alarmed { EventKind::AlarmRaised } else { EventKind::AlarmCleared };
            events.push(kind);
        }
        // A model without an answer begins anew with the next sample; what it left must not stay in windows and sums.
        if !self.compensated.iter().all(nalgebra::ComplexField::is_finite) {
            detector.reset();
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
        self.void = false;
        self.judged = false;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("pipeline u", &mut self.u);
        visitor.reals("pipeline y", &mut self.y);
        // Flags in one count: snapshots keep the layout that they had before the second and the third.
        let flags =
            u64::from(self.alarmed) | u64::from(self.void) << 1 | u64::from(self.judged) << 2;
        let mut counts = [self.k, self.held, flags];
        visitor.counts("pipeline k, held, alarmed", &mut counts);
        [self.k, self.held] = [counts[0], counts[1]];
        self.alarmed = counts[2] & 1 != 0;
        self.void = counts[2] & 2 != 0;
        self.judged = counts[2] & 4 != 0;
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
