//! The filter for the plant with its faults.

use faer::{Mat, MatRef, prelude::Solve};
use fd_core::{IoDims, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain, riccati};
use fd_numeric::dense::Dense;

use crate::{
    analysis::UnknownInputs,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::blocks,
    observer::check_observable,
};

/// Variances per sample, in the squared (scaled) unit of what they belong to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultNoise {
    /// Noise on each state.
    pub process: f64,
    /// Noise on each output.
    pub output: f64,
    /// Steps of each fault's random walk; the filter forgets after about
    /// `√(output/drift)` samples.
    pub drift: f64,
}

/// An estimator of faults; runs as [`FormGenerator`](crate::form::FormGenerator).
#[derive(Clone, Debug)]
pub struct FaultEstimatorDesign {
    form: ResidualForm,
    deviations: Vec<f64>,
}

impl FaultEstimatorDesign {
    /// An estimator of all `faults` at once.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::Unobservable`] with the mode 1 when two faults cannot be told apart
    /// or one is invisible at steady state, and an error when there is no fault or a variance is
    /// out of range.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_core::Frame;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     GeneratorDesign, analysis::UnknownInputs,
    ///     estimation::{FaultEstimatorDesign, FaultNoise},
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let faults = UnknownInputs::none(&lag).actuator(&lag, 0)?;
    /// let noise = FaultNoise { process: 1e-6, output: 1e-4, drift: 1e-4 };
    /// let design = FaultEstimatorDesign::new(&lag, &faults, &noise)?;
    /// let mut estimator = design.build()?;
    /// // u = 0, but the output settles at 2 · 0.3: the actuator is 0.3 too high.
    /// let mut f = [0.0];
    /// for k in 0..200 {
    ///     estimator.step(Frame::new(estimator.io(), k, &[0.0], &[0.6])?, &mut f);
    /// }
    /// assert!((f[0] - 0.3).abs() < 1e-9 && design.deviations()[0] < 0.02);
    ///
    /// // One output cannot tell an actuator from a sensor at steady state.
    /// let both = faults.sensor(&lag, 0)?;
    /// assert!(FaultEstimatorDesign::new(&lag, &both, &noise).is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        model: &StateSpace<Discrete>,
        faults: &UnknownInputs,
        noise: &FaultNoise,
    ) -> Result<Self, DesignError> {
        let (n, nf, nu, ny) = (model.nx(), faults.len(), model.nu(), model.ny());
        if nf == 0 {
            return Err(DesignError::Empty { what: "fault" });
        }
        let entry = faults.system(model)?;
        let a = blocks(&[
            &[model.a(), entry.b()],
            &[Mat::zeros(nf, n).as_ref(), Mat::identity(nf, nf).as_ref()],
        ]);
        let b = blocks(&[&[model.b()], &[Mat::zeros(nf, nu).as_ref()]]);
        let c = blocks(&[&[model.c(), entry.d()]]);
        check_observable(a.as_ref(), c.as_ref(), |mode| !model.domain().decays(mode))?;
        let diagonal = |size: usize, value: &dyn Fn(usize) -> f64| {
            Mat::from_fn(size, size, |i, j| if i == j { value(i) } else { 0.0 })
        };
        let q = diagonal(n + nf, &|i| if i < n { noise.process } else { noise.drift });
        let r = diagonal(ny, &|_| noise.output);
        let found = riccati::discrete_filter(a.as_ref(), c.as_ref(), q.as_ref(), r.as_ref())?;

        // f̂(k|k) = f̂(k|k−1) + P_f Cᵀ S⁻¹ ε, with the covariance P − P Cᵀ S⁻¹ C P.
        let pc = &found.p * c.transpose();
        let correct = found.weight.lu().solve(pc.transpose()).transpose().to_owned();
        let left = &found.p - &correct * pc.transpose();
        let deviations = (n..n + nf).map(|i| left[(i, i)].max(0.0).sqrt()).collect();
        let correct = correct.subrows(n, nf);
        let form =
            estimate_form(model, [a.as_ref(), b.as_ref(), c.as_ref()], &found.gain, correct)?;
        crate::simulation::check_stable("a fault estimator", form.system())?;
        Ok(Self { form, deviations })
    }

    /// Standard deviations of the errors of the estimates, one per fault.
    ///
    /// The interval `f̂ ± 1.96 σ` holds 95 % of faults that walk as assumed.
    #[must_use]
    pub fn deviations(&self) -> &[f64] {
        &self.deviations
    }
}

/// `z⁺ = A z + B u + L ε`, `f̂ = [0 I] z + K ε`, `ε = y − C z − D u`.
fn estimate_form(
    model: &StateSpace<Discrete>,
    [a, b, c]: [MatRef<'_, f64>; 3],
    gain: &Mat<f64>,
    correct: MatRef<'_, f64>,
) -> Result<ResidualForm, DesignError> {
    let (size, nf) = (a.nrows(), correct.nrows());
    let pick = Mat::from_fn(nf, size, |i, j| if i + size == j + nf { 1.0 } else { 0.0 });
    let from_u = b - gain * model.d();
    let direct = -(correct * model.d());
    let system = StateSpace::new(
        a - gain * c,
        blocks(&[&[from_u.as_ref(), gain.as_ref()]]),
        pick - correct * c,
        blocks(&[&[direct.as_ref(), correct]]),
        model.domain(),
    )?;

    ResidualForm::new(IoDims { nu: model.nu(), ny: model.ny() }, system)
}

impl GeneratorDesign for FaultEstimatorDesign {
    fn io(&self) -> IoDims {
        self.form.io()
    }

    fn residual_len(&self) -> usize {
        self.deviations.len()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        Ok(self.form.clone())
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        self.form.build()
    }
}
