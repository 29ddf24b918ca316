//! Least squares over exactly the last samples.

use std::mem;

use fd_core::{
    Buffer, Heap, Scalar, Shape, StateVisitor,
    stage::{GuardReport, Stage},
};
use fd_numeric::dot;
use serde::{Deserialize, Serialize};

use crate::{
    error::IdentError,
    rls::{
        RlsKernel,
        covariance::{Covariance, add_scaled},
        forgetting::positive,
        storage::{Grid, RlsStorage},
        ud::Ud,
    },
};

/// Settings of [`WindowRls`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WindowDesign {
    /// Samples in the window.
    pub samples: usize,
    /// Variance of each parameter without any sample, relative to a noise of variance 1. This
    /// prior never leaves the window: a ridge of `1/prior_variance`.
    pub prior_variance: f64,
}

/// Recursive least squares over a sliding window: the newest sample is taken in, the oldest one
/// given up.
///
/// Giving up information loses digits, so the errors must not pile up. A second estimator, which
/// only takes in, starts afresh every `W` samples; when it has seen `W` of them it knows exactly
/// the window and takes over. So each sample costs the same, about three [`UdRls`](super::UdRls)
/// updates, and no error is older than `2 W` samples. When the sample that leaves was the only
/// one that told about some direction, giving it up would lose more than half of the digits; the
/// window is then factorised again at once (counted in [`GuardReport::bounded`], costs
/// `W` updates).
///
/// The prior mean is zero: hand in `θ = 0` after construction and reset.
///
/// # When not to use it
///
/// When memory is scarce (`W (n + 1)` numbers), or when excitation pauses for longer than the
/// window: the estimate then falls back to the prior in the silent directions.
///
/// # Examples
///
/// ```
/// use fd_ident::rls::{RlsKernel, Static, WindowDesign, WindowRls};
///
/// let design = WindowDesign { samples: 4, prior_variance: 1e6 };
/// let mut rls = WindowRls::<f64, Static<1, 4>>::new(1, &design)?;
/// let mut theta = [0.0];
/// for k in 0..20 {
///     let slope = if k < 10 { 1.0 } else { 3.0 };
///     rls.update(&[1.0], slope, &mut theta);
/// }
/// assert!((theta[0] - 3.0).abs() < 1e-5);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct WindowRls<T: Scalar, S: RlsStorage<T> = Heap> {
    samples: usize,
    prior_variance: T,
    /// The last samples, the oldest at `next` once the window is full.
    regressors: S::Regressors,
    targets: S::Targets,
    next: u64,
    filled: u64,
    window: Ud<T, S>,
    /// The estimator that takes over when its age reaches the length of the window.
    young: Ud<T, S>,
    young_theta: S::Parameters,
    age: u64,
    report: GuardReport,
    p_phi: S::Parameters,
}

impl<T: Scalar, S: RlsStorage<T>> WindowRls<T, S> {
    /// An estimator of `n` parameters.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of range, or the storage is fixed and has another
    /// size.
    pub fn new(n: usize, design: &WindowDesign) -> Result<Self, IdentError> {
        positive("prior variance", design.prior_variance)?;
        positive("samples in the window", design.samples as f64)?;
        let prior_variance = T::from_design(design.prior_variance);
        let shape = Shape::new(design.samples, n);
        Ok(Self {
            samples: design.samples,
            prior_variance,
            regressors: S::Regressors::zeros("regressors of the window", shape)?,
            targets: S::Targets::zeros("targets of the window", design.samples)?,
            next: 0,
            filled: 0,
            window: Ud::isotropic(n, prior_variance)?,
            young: Ud::isotropic(n, prior_variance)?,
            young_theta: S::Parameters::zeros("young estimate", n)?,
            age: 0,
            report: GuardReport::default(),
            p_phi: S::Parameters::zeros("gain", n)?,
        })
    }

    /// Gives up the oldest sample, or returns false when that would lose too many digits.
    fn give_up_oldest(&mut self, slot: usize, theta: &mut [T]) -> bool {
        let n = theta.len();
        let phi = &self.regressors.as_slice()[slot * n..(slot + 1) * n];
        let target = self.targets.as_ref()[slot];
        let remainder = T::one() - self.window.energy(phi);
        if remainder < T::default_epsilon().sqrt() {
            return false;
        }
        let innovation = target - dot(phi, theta);
        self.window.release(T::one(), remainder, self.p_phi.as_mut());
        add_scaled(theta, -(innovation / remainder), self.p_phi.as_ref());
        true
    }

    /// Computes the estimate of the window from the samples themselves.
    fn refactorise(&mut self, theta: &mut [T]) {
        let n = theta.len();
        self.window.restart(self.prior_variance);
        theta.fill(T::zero());
        let samples = self.regressors.as_slice().chunks_exact(n).zip(self.targets.as_ref());
        for (phi, &target) in samples {
            take_in(&mut self.window, phi, target, theta, self.p_phi.as_mut());
        }
        self.report.bounded += 1;
    }
}

/// One step of ordinary recursive least squares.
fn take_in<T: Scalar, C: Covariance<T>>(
    covariance: &mut C,
    phi: &[T],
    target: T,
    theta: &mut [T],
    p_phi: &mut [T],
) {
    let energy = covariance.energy(phi);
    let innovation = target - dot(phi, theta);
    covariance.absorb(T::one(), p_phi);
    add_scaled(theta, innovation / (T::one() + energy), p_phi);
}

impl<T: Scalar, S: RlsStorage<T>> RlsKernel<T> for WindowRls<T, S> {
    fn parameters(&self) -> usize {
        self.p_phi.as_ref().len()
    }

    fn update(&mut self, phi: &[T], target: T, theta: &mut [T]) {
        let innovation = target - dot(phi, theta);
        if !innovation.is_finite() || !self.window.energy(phi).is_finite() {
            self.report.skipped += 1;
            return;
        }
        let (n, samples) = (theta.len(), self.samples as u64);
        // Below the length of the window, which is a usize.
        let slot = usize::try_from(self.next).unwrap_or_default();
        let full = self.filled == samples;
        let gave_up = !full || self.give_up_oldest(slot, theta);

        self.regressors.as_mut_slice()[slot * n..(slot + 1) * n].copy_from_slice(phi);
        self.targets.as_mut()[slot] = target;
        self.next = (self.next + 1) % samples;
        self.filled = samples.min(self.filled + 1);

        let p_phi = self.p_phi.as_mut();
        take_in(&mut self.young, phi, target, self.young_theta.as_mut(), p_phi);
        self.age += 1;
        if self.age == samples {
            mem::swap(&mut self.window, &mut self.young);
            theta.copy_from_slice(self.young_theta.as_ref());
            self.young.restart(self.prior_variance);
            self.young_theta.as_mut().fill(T::zero());
            self.age = 0;
        } else if gave_up {
            take_in(&mut self.window, phi, target, theta, p_phi);
        } else {
            self.refactorise(theta);
        }
    }

    fn variance_into(&self, variance: &mut [T]) {
        self.window.diagonal_into(variance);
    }

    fn guard(&self) -> GuardReport {
        self.report
    }
}

impl<T: Scalar, S: RlsStorage<T>> Stage<T> for WindowRls<T, S> {
    fn reset(&mut self) {
        self.regressors.as_mut_slice().fill(T::zero());
        self.targets.as_mut().fill(T::zero());
        self.window.restart(self.prior_variance);
        self.young.restart(self.prior_variance);
        self.young_theta.as_mut().fill(T::zero());
        (self.next, self.filled, self.age) = (0, 0, 0);
        self.report = GuardReport::default();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("regressors of the window", self.regressors.as_mut_slice());
        visitor.reals("targets of the window", self.targets.as_mut());
        self.window.visit(visitor);
        self.young.visit(visitor);
        visitor.reals("young estimate", self.young_theta.as_mut());
        let GuardReport { skipped, bounded } = self.report;
        let mut counts = [self.next, self.filled, self.age, skipped, bounded];
        visitor.counts("next, filled, age, skipped, bounded", &mut counts);
        [self.next, self.filled, self.age, self.report.skipped, self.report.bounded] = counts;
        // A foreign snapshot must not point beyond the window.
        let samples = self.samples as u64;
        self.next %= samples;
        self.filled = self.filled.min(samples);
        self.age %= samples;
    }
}
