//! The recursive least-squares step, written once for every forgetting and factorisation.

use fd_core::{
    Buffer, Scalar, StateVisitor,
    stage::{GuardReport, Stage},
};

use crate::{
    error::IdentError,
    rls::{
        RlsKernel,
        covariance::{Covariance, add_scaled, dot},
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
    skip_silence: bool,
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
        Ok(Self {
            forgetting: design.forgetting.freeze(),
            prior_variance,
            skip_silence: design.guard.skip_silence,
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

    /// Moves the estimate along `Pφ`.
    fn correct(&mut self, gain: T, innovation: T, theta: &mut [T]) {
        add_scaled(theta, gain * innovation, self.p_phi.as_ref());
    }

    /// The forgetting factor of this sample: 1 while forgetting would lift `P` above its limit.
    fn guarded(&mut self, lambda: T) -> T {
        let largest = self.largest_trace * lambda;
        if self.trace_bound <= largest {
            return lambda;
        }
        // The bound may be too large: look at the trace itself.
        self.trace_bound = self.covariance.trace();
        if self.trace_bound <= largest {
            return lambda;
        }
        self.report.bounded += 1;
        T::one()
    }

    /// Computes `P ← factor · P`.
    fn scale(&mut self, factor: T) {
        self.covariance.scale(factor);
        // Learning lowers the trace. What the factors are rounded by is less than the margin.
        let margin = T::one() + T::from_design(8.0) * T::default_epsilon();
        self.trace_bound *= factor * margin;
    }

    /// Kulhavý's step: the information along `φ` changes by `w = λ − (1−λ)/φᵀPφ`.
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
        let noise = match self.forgetting {
            Forgetting::Equation18 { alpha } => alpha,
            _ => T::one(),
        };
        let silent = self.skip_silence && energy.abs() <= T::default_epsilon() * noise;
        if silent || !energy.is_finite() || !innovation.is_finite() {
            self.report.skipped += 1;
            return;
        }
        // One place for most kinds, so that the step is compiled once.
        let lambda = match self.forgetting {
            Forgetting::Directional { lambda } => {
                self.learn_directionally(lambda, energy, innovation, theta);
                return;
            }
            Forgetting::None | Forgetting::Equation18 { .. } => None,
            Forgetting::Bounded { lambda, .. } => Some(lambda),
            Forgetting::Exponential { lambda } | Forgetting::Resetting { lambda, .. } => {
                Some(self.guarded(lambda))
            }
        };
        let weight = T::one() / lambda.unwrap_or(noise);
        self.covariance.absorb(weight, self.p_phi.as_mut());
        // The same inverse as in `absorb`.
        let inverse = T::one() / (T::one() + weight * energy);
        self.correct(weight * inverse, innovation, theta);
        if lambda.is_some() {
            self.scale(weight);
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
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.covariance.visit(visitor);
        visitor.reals("trace bound", std::slice::from_mut(&mut self.trace_bound));
        let mut counts = [self.report.skipped, self.report.bounded, self.axis];
        visitor.counts("skipped, bounded, axis", &mut counts);
        [self.report.skipped, self.report.bounded, self.axis] = counts;
    }
}
