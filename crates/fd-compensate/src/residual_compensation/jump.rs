//! The test for hard faults while the bias is still being learned.

use fd_core::{Scalar, StateVisitor};

use super::design::HardFault;

/// Compares each innovation with its own running scale.
#[derive(Clone, Debug)]
pub(super) struct JumpTest<T> {
    watch: bool,
    factor: T,
    least_jump: T,
    gain: T,
    warm_up: u64,
    resume_after: u64,
    /// Running mean of `|innovation|` of each channel, deaf to jumps.
    scale: Vec<T>,
    /// Level below which a channel counts as recovered; infinite where nothing jumped.
    recovery: Vec<T>,
    seen: u64,
    quiet: u64,
}

/// One sample moves the running scale at most as if it were this many times the scale.
const CLIP: f64 = 3.0;

impl<T: Scalar> JumpTest<T> {
    pub(super) fn new(plan: &HardFault, residual_len: usize) -> Self {
        Self {
            watch: plan.watch,
            factor: T::from_design(plan.factor),
            least_jump: T::from_design(plan.least_jump),
            gain: T::from_design(plan.memory.recip()),
            warm_up: plan.warm_up,
            resume_after: plan.resume_after,
            scale: vec![T::zero(); residual_len],
            recovery: vec![T::zero(); residual_len],
            seen: 0,
            quiet: 0,
        }
    }

    /// Judges one innovation; `peak` is the largest residual so far.
    pub(super) fn jumps(&mut self, innovation: &[T], peak: T) -> bool {
        if !self.watch {
            return false;
        }
        let floor = self.least_jump * peak;
        let limit = |scale: T| (self.factor * scale).max(floor);
        let jumped = self.seen >= self.warm_up
            && innovation.iter().zip(&self.scale).any(|(e, &scale)| e.abs() > limit(scale));
        if jumped {
            let half = T::from_design(0.5);
            for ((level, e), &scale) in self.recovery.iter_mut().zip(innovation).zip(&self.scale) {
                *level = if e.abs() > limit(scale) { e.abs() * half } else { infinity() };
            }
            self.quiet = 0;
            return true;
        }
        self.seen += 1;
        // A plain mean at first, so that the scale does not start from nothing.
        let gain = self.gain.max(T::from_design((self.seen as f64).recip()));
        let clip = T::from_design(CLIP);
        // Where a model has no answer there is nothing to hear.
        let pairs = self.scale.iter_mut().zip(innovation);
        for (scale, e) in pairs.filter(|(_, e)| e.is_finite()) {
            let heard = if self.seen > self.warm_up { e.abs().min(clip * *scale) } else { e.abs() };
            *scale += gain * (heard - *scale);
        }
        false
    }

    /// Starts the warm-up again: the input does something new, so that the innovation may.
    pub(super) fn warm_up(&mut self) {
        self.seen = 0;
    }

    /// Whether the jumped channels have been back long enough.
    pub(super) fn has_recovered(&mut self, compensated: &[T]) -> bool {
        let back = compensated.iter().zip(&self.recovery).all(|(e, &level)| e.abs() <= level);
        self.quiet = if back { self.quiet + 1 } else { 0 };
        self.quiet >= self.resume_after
    }

    pub(super) fn reset(&mut self) {
        self.scale.fill(T::zero());
        self.recovery.fill(T::zero());
        self.seen = 0;
        self.quiet = 0;
    }

    pub(super) fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("innovation scale", &mut self.scale);
        visitor.reals("innovation recovery level", &mut self.recovery);
        let mut counts = [self.seen, self.quiet];
        visitor.counts("innovation seen, quiet", &mut counts);
        [self.seen, self.quiet] = counts;
    }
}

fn infinity<T: Scalar>() -> T {
    T::from_design(f64::INFINITY)
}
