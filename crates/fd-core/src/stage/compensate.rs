//! From primary to compensated residuals.

use crate::{event::Events, frame::Frame, scalar::Scalar, stage::Stage, visitor::StateVisitor};

/// Removes the estimated bias from the residual, `r* = r − μ̂`.
///
/// A real plant never equals its model, so the primary residual of a healthy plant is not zero. A threshold
/// above that bias would hide small faults. The compensator estimates the bias `μ̂` and leaves the *compensated
/// residual* `r*`, which reveals a slow fault of a thousandth (Patton and Chen 1992, section 3).
///
/// # The contract
///
/// [`step`](Self::step) takes the frame of one sample and its primary residual, writes all channels
/// of `r*`, and says in which [`Phase`] it treated the sample:
///
/// * [`Phase::Training`]: the plant is assumed to be healthy and the bias is being learned. `r*` is then the
///   best available indication of a sudden fault (usually the innovation of the estimator), but it is not
///   comparable with the `r*` of the other phase. Decision rules stay silent.
/// * [`Phase::Compensating`]: what is subtracted no longer learns from the residual. Thresholds
///   hold.
///
/// One rule makes the method safe: **while compensating, `μ̂` may depend only on `u` and on the residual of the
/// past training.** A compensator that keeps adapting to `r` learns an incipient fault as fast as it grows, and
/// reveals nothing.
///
/// Changes of phase are [`Events`]: `TrainingStarted`, `Frozen`, `TrainingInconclusive`,
/// `BiasModelRejected`, `OperatingPointLeft` and so on. Push an event at the sample at which it
/// happens, once. The sample that carries `Frozen` still belongs to the training.
///
/// # Who calls it, and when
///
/// [`Pipeline::step`](crate::Pipeline::step), once per sample, between the generator and the
/// detector. The first sample it ever sees is the first one of the run, so a compensator that trains
/// on line starts in training; one whose parameters were fitted beforehand may compensate at once.
///
/// [`nu`](Self::nu) and [`residual_len`](Self::residual_len) are called when the pipeline is built. Return
/// `None` from `nu` if the input is not used.
///
/// # What an implementor must do
///
/// * *Say `Training` when in doubt.* A pause, a trial of a candidate, a history that is still being filled: a
///   threshold for `r*` applies to none of them.
/// * *Monitor the trained range.* A bias learned at one operating point is not the bias at another. Leaving the
///   range is at least an event; the plan of `fd-compensate` can also retrain.
/// * *Recover from trouble.* A diverged bias model is rejected and reported, `r*` falls back to `r`, and the
///   next sample is treated as usual. There is no failed state that needs a human.
/// * *Show all memory*, the phase and its counters included, in [`visit_state`](super::Stage::visit_state). A
///   compensator that is restored in the middle of its training opens the switch at the same sample as one that
///   was never interrupted.
/// * *Neither allocate nor fail*, in any phase. The sample at which the switch opens is no exception.
///
/// Missing samples are not its concern: a frame is complete. It learns from held samples like from any others,
/// which is one more reason to hold few.
///
/// # How it composes
///
/// As a type in [`Stages`](crate::Stages), as `Box<dyn Compensator>`, or by the tables `[bias]` and
/// `[compensation]` of a spec. [`Uncompensated`] is the same pipeline without compensation, the baseline for
/// every result.
///
/// # When not to implement it
///
/// Nearly always. The two-stage method with its convergence tests, trial, hard-fault test and guard
/// of the operating point is `fd_compensate::residual_compensation`, and it takes any
/// [`Identifier`](super::Identifier) with any [`BiasModel`](super::BiasModel): a new way of learning
/// or a new kind of bias needs one of these, not a new compensator.
///
/// # Example
///
/// The simplest bias is a constant: the offset of a sensor. Average it over the first samples, then subtract
/// it:
///
/// ```
/// use fd_core::{
///     EventKind, Events, Frame, IoDims, StateVisitor,
///     stage::{Compensation, Compensator, Phase, Stage},
/// };
///
/// #[derive(Debug)]
/// struct Tare {
///     samples: u64,
///     learned: u64,
///     mean: f64,
/// }
///
/// impl Stage for Tare {
///     fn reset(&mut self) {
///         (self.learned, self.mean) = (0, 0.0);
///     }
///
///     fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
///         visitor.counts("samples learned", std::slice::from_mut(&mut self.learned));
///         visitor.reals("tare", std::slice::from_mut(&mut self.mean));
///     }
/// }
///
/// impl Compensator for Tare {
///     fn nu(&self) -> Option<usize> {
///         None
///     }
///
///     fn residual_len(&self) -> usize {
///         1
///     }
///
///     fn step(&mut self, _: Frame<'_, f64>, r: &[f64], r_star: &mut [f64]) -> Compensation {
///         let mut events = Events::none();
///         r_star[0] = r[0] - self.mean;
///         if self.learned == self.samples {
///             return Compensation { phase: Phase::Compensating, events };
///         }
///         if self.learned == 0 {
///             events.push(EventKind::TrainingStarted);
///         }
///         self.learned += 1;
///         self.mean += r_star[0] / self.learned as f64;
///         if self.learned == self.samples {
///             events.push(EventKind::Frozen);
///         }
///         Compensation { phase: Phase::Training { samples: self.learned }, events }
///     }
/// }
///
/// let mut tare = Tare { samples: 4, learned: 0, mean: 0.0 };
/// let (io, mut r_star) = (IoDims { nu: 0, ny: 1 }, [0.0]);
/// let mut story = Vec::new();
/// for (k, r) in [0.4, 0.6, 0.4, 0.6, 0.5, 0.7].into_iter().enumerate() {
///     let r = [r];
///     let outcome = tare.step(Frame::new(io, k as u64, &[], &r)?, &r, &mut r_star);
///     story.extend(outcome.events.iter().map(|kind| (k, kind)));
/// }
/// assert_eq!(story, [(0, EventKind::TrainingStarted), (3, EventKind::Frozen)]);
/// // The last sample is 0.2 above the tare of 0.5, and the tare has not followed it.
/// assert!((r_star[0] - 0.2).abs() < 1e-15 && (tare.mean - 0.5).abs() < 1e-15);
/// # Ok::<(), fd_core::FrameError>(())
/// ```
pub trait Compensator<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`, or `None` if any number will do.
    fn nu(&self) -> Option<usize>;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Consumes one sample with its primary residual and writes the compensated residual.
    fn step(&mut self, frame: Frame<'_, T>, r: &[T], r_star: &mut [T]) -> Compensation;

    /// Retrains from the next sample on, on request. False if there is nothing to train.
    fn retrain(&mut self) -> bool {
        false
    }
}

/// What a compensator did with one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compensation {
    /// Phase in which the sample was treated.
    pub phase: Phase,
    /// What happened.
    pub events: Events,
}

/// The two stages of Patton & Chen (1992), section 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The switch is closed: the plant is assumed to be healthy and the bias is being learned.
    Training {
        /// Samples learned from in this phase.
        samples: u64,
    },
    /// The switch is open: parameters are frozen and the bias is subtracted.
    Compensating,
}

/// The compensator that subtracts nothing, `r* = r`: the baseline that others are compared with, and all that is
/// needed where no bias is learned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uncompensated {
    residual_len: usize,
    settling: u64,
    settled: u64,
}

impl Uncompensated {
    /// A compensator for `residual_len` channels.
    ///
    /// ```
    /// # use fd_core::stage::{Compensator, Uncompensated};
    /// assert_eq!(Compensator::<f64>::residual_len(&Uncompensated::new(2)), 2);
    /// ```
    #[must_use]
    pub const fn new(residual_len: usize) -> Self {
        Self { residual_len, settling: 0, settled: 0 }
    }

    /// Sets the samples at the start that are not judged (phase `Training`), while the residual generator forgets
    /// where it started.
    ///
    /// ```
    /// # use fd_core::{Frame, IoDims, stage::{Compensator, Phase, Uncompensated}};
    /// let mut plain = Uncompensated::new(1).settling(1);
    /// let frame = Frame::new(IoDims { nu: 0, ny: 1 }, 0, &[], &[3.0])?;
    /// let mut phase = |r: &[f64]| plain.step(frame, r, &mut [0.0]).phase;
    /// assert_eq!(phase(&[3.0]), Phase::Training { samples: 0 });
    /// assert_eq!(phase(&[3.0]), Phase::Compensating);
    /// # Ok::<(), fd_core::FrameError>(())
    /// ```
    #[must_use]
    pub const fn settling(self, samples: u64) -> Self {
        Self { settling: samples, ..self }
    }
}

impl<T: Scalar> Stage<T> for Uncompensated {
    fn reset(&mut self) {
        self.settled = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        // What settles at once has no state.
        if 0 < self.settling {
            visitor.counts("samples settled", std::slice::from_mut(&mut self.settled));
        }
    }
}

impl<T: Scalar> Compensator<T> for Uncompensated {
    fn nu(&self) -> Option<usize> {
        None
    }

    fn residual_len(&self) -> usize {
        self.residual_len
    }

    fn step(&mut self, _frame: Frame<'_, T>, r: &[T], r_star: &mut [T]) -> Compensation {
        r_star.copy_from_slice(r);
        let settles = self.settled < self.settling;
        self.settled += u64::from(settles);
        let phase = if settles { Phase::Training { samples: 0 } } else { Phase::Compensating };
        Compensation { phase, events: Events::none() }
    }
}
