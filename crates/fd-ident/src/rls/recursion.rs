//! The recursive least-squares step, written once for every forgetting and factorisation.

use fd_core::{
    Buffer, Scalar, StateVisitor,
    stage::{GuardReport, Stage},
};
use fd_numeric::dot;

use crate::{
    error::IdentError,
    rls::{
        RlsKernel,
        covariance::{Covariance, add_scaled},
        forgetting::{Forgetting, RlsDesign},
    },
};

/// Recursive least squares with a covariance `C` and any [`Forgetting`].
///
/// # Examples
///
/// Two parameters on the stack, learned from three samples of `y = 2 φ₁ − φ₂`:
///
/// ```
/// use fd_ident::rls::{RlsDesign, RlsKernel, Rls, Static, Ud};
///
/// let mut rls = Rls::<f64, Ud<f64, Static<2>>>::new(2, &RlsDesign::default())?;
/// let mut theta = [0.0; 2];
/// for (phi, y) in [([1.0, 0.0], 2.0), ([1.0, 1.0], 1.0), ([0.0, 3.0], -3.0)] {
///     rls.update(&phi, y, &mut theta);
/// }
/// assert!((theta[0] - 2.0).abs() < 1e-5 && (theta[1] + 1.0).abs() < 1e-5);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Rls<T: Scalar, C: Covariance<T>> {
    forgetting: Forgetting<T>,
    prior_variance: T,
    /// Samples with `φᵀPφ` of `α` times this or less are skipped.
    silence: T,
    /// `α(k)` of eq. (18), else 1.
    alpha: T,
    /// What forgetting multiplies `P` by, and at least what it multiplies the trace by.
    growth: T,
    growth_of_trace: T,
    /// Trace of `P₀` and the largest trace that forgetting may lead to.
    initial_trace: T,
    largest_trace: T,
    /// At least the trace of `P`, as far as exponential forgetting changes it.
    trace_bound: T,
    covariance: C,
    report: GuardReport,
    /// Axis that [`Forgetting::Bounded`] regularises next.
    axis: u64,
    p_phi: C::Parameters,
}

impl<T: Scalar, C: Covariance<T>> Rls<T, C> {
    /// An estimator of `n` parameters.
    ///
    /// # Errors
    ///
    /// Returns an error when a setting is out of range, or the storage is fixed and has another
    /// size.
    pub fn new(n: usize, design: &RlsDesign) -> Result<Self, IdentError> {
        design.check()?;
        let prior_variance = T::from_design(design.prior_variance);
        let covariance = C::isotropic(n, prior_variance)?;
        let initial_trace = covariance.trace();
        let forgetting: Forgetting<T> = design.forgetting.freeze();
        let (alpha, growth) = match forgetting {
            Forgetting::None | Forgetting::Directional { .. } => (T::one(), T::one()),
            Forgetting::Equation18 { alpha, .. } => (alpha, T::one()),
            Forgetting::Exponential { lambda }
            | Forgetting::Bounded { lambda, .. }
            | Forgetting::Resetting { lambda, .. } => (T::one(), T::one() / lambda),
        };
        let silence = design.guard.silence(&design.forgetting);
        // Learning lowers the trace. What the factors are rounded by is less than the margin.
        let margin = T::one() + T::from_design(8.0) * T::default_epsilon();
        Ok(Self {
            forgetting,
            prior_variance,
            silence,
            alpha,
            growth,
            growth_of_trace: growth * margin,
            initial_trace,
            largest_trace: initial_trace * T::from_design(design.guard.trace_limit),
            trace_bound: initial_trace,
            covariance,
            report: GuardReport::default(),
            axis: 0,
            p_phi: C::Parameters::zeros("gain", n)?,
        })
    }

    /// The covariance `P`.
    #[must_use]
    pub fn covariance(&self) -> &C {
        &self.covariance
    }

    /// Sets `α(k)` of eq. (18) for the next sample, for a course that somebody else decides about; from
    /// there it goes on as the design says. Other kinds of forgetting have no `α`, and what is not
    /// positive and finite is ignored.
    pub fn set_alpha(&mut self, alpha: T) {
        let fits = matches!(self.forgetting, Forgetting::Equation18 { .. });
        if fits && T::zero() < alpha && alpha.is_finite() {
            self.alpha = alpha;
        }
    }

    /// Moves the estimate along `Pφ`.
    fn correct(&mut self, gain: T, innovation: T, theta: &mut [T]) {
        add_scaled(theta, gain * innovation, self.p_phi.as_ref());
    }

    /// One step of all kinds but the directional one, with the regressor projected.
    #[expect(clippy::inline_always, reason = "as part of `update` it needs no detour by memory")]
    #[inline(always)]
    fn step(&mut self, noise: T, is_forgetting: bool, innovation: T, theta: &mut [T]) {
        let scale = if is_forgetting { self.growth } else { T::one() };
        let inverse = self.covariance.learn(T::one(), noise, scale, self.p_phi.as_mut());
        self.correct(inverse, innovation, theta);
        if is_forgetting {
            self.trace_bound *= self.growth_of_trace;
        }
    }

    /// The step where the bound of the trace is at the limit, so that forgetting might leave `P` above
    /// it. Here `φ` counts only where it is more than rounding.
    ///
    /// Out of line, for then the usual step has the projected regressor in registers.
    #[cold]
    #[inline(never)]
    fn step_near_limit(&mut self, lambda: T, phi: &[T], innovation: T, theta: &mut [T]) {
        self.covariance.ignore_rounding(phi);
        // The bound may be too large: look at the trace itself.
        self.trace_bound = self.covariance.trace();
        let may_forget = self.trace_bound <= self.largest_trace * lambda;
        if !may_forget {
            self.report.bounded += 1;
        }
        let noise = if may_forget { lambda } else { T::one() };
        self.step(noise, may_forget, innovation, theta);
    }

    /// Kulhavý's step: the information along `φ` changes by `w = λ − (1−λ)/φᵀPφ`.
    #[inline(never)]
    fn learn_directionally(&mut self, lambda: T, energy: T, innovation: T, theta: &mut [T]) {
        if energy <= T::zero() {
            self.report.skipped += 1;
            return;
        }
        let weight = lambda - (T::one() - lambda) / energy;
        let total = T::one() + energy;
        if weight >= T::zero() {
            self.covariance.absorb(weight, self.p_phi.as_mut());
        } else if self.covariance.trace() <= self.largest_trace {
            // 1 + w φᵀPφ = λ (1 + φᵀPφ), without the cancellation.
            self.covariance.release(-weight, lambda * total, self.p_phi.as_mut());
        } else {
            self.report.bounded += 1;
            self.covariance.absorb(T::zero(), self.p_phi.as_mut());
        }
        self.correct(T::one() / total, innovation, theta);
    }

    /// Adds `n (1−λ)/c` to the information of the next axis.
    fn regularise_next_axis(&mut self, lambda: T, variance: T) {
        let unit = self.p_phi.as_mut();
        let n = unit.len() as u64;
        let axis = self.axis;
        for (i, unit) in (0..).zip(unit.iter_mut()) {
            *unit = if i == axis { T::one() } else { T::zero() };
        }
        self.axis = (axis + 1) % n;
        self.covariance.energy(self.p_phi.as_ref());
        let weight = T::from_design(n as f64) * (T::one() - lambda) / variance;
        self.covariance.absorb(weight, self.p_phi.as_mut());
    }
}

impl<T: Scalar, C: Covariance<T>> RlsKernel<T> for Rls<T, C> {
    fn parameters(&self) -> usize {
        self.p_phi.as_ref().len()
    }

    fn update(&mut self, phi: &[T], target: T, theta: &mut [T]) {
        // Lengths that the compiler knows where the storage is fixed.
        let n = self.parameters();
        let (phi, theta) = (&phi[..n], &mut theta[..n]);
        let energy = self.covariance.energy(phi);
        let innovation = target - dot(phi, theta);
        // Not a number when the innovation is not finite.
        let size = (energy + T::zero() * innovation).abs();
        let is_loud = self.silence * self.alpha < size && size.is_finite();
        if !is_loud {
            self.report.skipped += 1;
            return;
        }
        let (noise, is_forgetting) = match self.forgetting {
            Forgetting::Directional { lambda } => {
                self.learn_directionally(lambda, energy, innovation, theta);
                return;
            }
            Forgetting::None => (T::one(), false),
            Forgetting::Equation18 { .. } => (self.alpha, false),
            Forgetting::Bounded { lambda, .. }
            | Forgetting::Exponential { lambda }
            | Forgetting::Resetting { lambda, .. } => (lambda, true),
        };
        let is_bounded = matches!(self.forgetting, Forgetting::Bounded { .. });
        if is_forgetting && !is_bounded && self.largest_trace * noise < self.trace_bound {
            self.step_near_limit(noise, phi, innovation, theta);
        } else {
            self.step(noise, is_forgetting, innovation, theta);
        }
        match self.forgetting {
            Forgetting::Bounded { lambda, variance } => {
                self.regularise_next_axis(lambda, variance);
            }
            Forgetting::Resetting { floor, .. }
                if self.covariance.trace() < floor * self.initial_trace =>
            {
                self.covariance.restart(self.prior_variance);
                self.trace_bound = self.initial_trace;
                self.report.bounded += 1;
            }
            Forgetting::Equation18 { falling: Some(falling), .. } => {
                self.alpha = falling.after(self.alpha);
            }
            _ => {}
        }
    }

    fn variance_into(&self, variance: &mut [T]) {
        self.covariance.diagonal_into(variance);
    }

    fn guard(&self) -> GuardReport {
        self.report
    }
}

impl<T: Scalar, C: Covariance<T>> Stage<T> for Rls<T, C> {
    fn reset(&mut self) {
        self.covariance.restart(self.prior_variance);
        self.trace_bound = self.initial_trace;
        self.report = GuardReport::default();
        self.axis = 0;
        if let Forgetting::Equation18 { alpha, .. } = self.forgetting {
            self.alpha = alpha;
        }
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.covariance.visit(visitor);
        visitor.reals("trace bound", std::slice::from_mut(&mut self.trace_bound));
        let mut counts = [self.report.skipped, self.report.bounded, self.axis];
        visitor.counts("skipped, bounded, axis", &mut counts);
        [self.report.skipped, self.report.bounded, self.axis] = counts;
        if matches!(self.forgetting, Forgetting::Equation18 { .. }) {
            visitor.reals("alpha", std::slice::from_mut(&mut self.alpha));
        }
    }
}
