//! Which parameters are followed, and how fast.

use faer::{Mat, MatRef};
use fd_core::{IoDims, Scalar, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain, freeze};

use super::run::{AdaptiveObserver, Direction, ParameterNoise};
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::check_shape,
    observer::ObserverDesign,
};

/// What one parameter does to the model per unit: `A + θ ΔA`, `B + θ ΔB`.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterShift {
    a: Mat<f64>,
    b: Mat<f64>,
}

impl ParameterShift {
    /// A shift from its matrices (states × states, states × inputs).
    ///
    /// # Errors
    ///
    /// Returns an error when an entry is not finite.
    pub fn new(a: Mat<f64>, b: Mat<f64>) -> Result<Self, DesignError> {
        check_shape("parameter shift of A", a.as_ref(), Shape::new(a.nrows(), a.nrows()))?;
        check_shape("parameter shift of B", b.as_ref(), Shape::new(a.nrows(), b.ncols()))?;
        Ok(Self { a, b })
    }

    /// The shift from one model to another, for `θ = 1`; for a physical parameter, take the model
    /// with its value and the model with another, discretised alike.
    ///
    /// # Errors
    ///
    /// Returns an error when the models have other sizes or sample times.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::adaptive::ParameterShift;
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = |a: f64| StateSpace::new(mat![[a]], mat![[1.0 - a]], mat![[1.0]], mat![[0.0]], domain);
    /// let slower = ParameterShift::between(&lag(0.5)?, &lag(0.75)?)?;
    /// assert_eq!(slower, ParameterShift::new(mat![[0.25]], mat![[-0.25]])?);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn between(
        nominal: &StateSpace<Discrete>,
        other: &StateSpace<Discrete>,
    ) -> Result<Self, DesignError> {
        nominal.domain().join(other.domain())?;
        check_shape("other A", other.a(), Shape::new(nominal.nx(), nominal.nx()))?;
        check_shape("other B", other.b(), Shape::new(nominal.nx(), nominal.nu()))?;
        Self::new(other.a() - nominal.a(), other.b() - nominal.b())
    }

    /// One parameter per input: the relative error of its gain.
    #[must_use]
    pub fn input_gains(model: &StateSpace<Discrete>) -> Vec<Self> {
        let n = model.nx();
        let only = |input: usize| {
            let entry = |i: usize, j: usize| if j == input { model.b()[(i, j)] } else { 0.0 };
            Self { a: Mat::zeros(n, n), b: Mat::from_fn(n, model.nu(), entry) }
        };
        (0..model.nu()).map(only).collect()
    }

    /// One parameter per state: the relative error of its rate of change `x⁺ − x`.
    #[must_use]
    pub fn state_rates(model: &StateSpace<Discrete>) -> Vec<Self> {
        let (n, nu) = (model.nx(), model.nu());
        let only = |state: usize| {
            let rate = |i: usize, j: usize| match (i == state, i == j) {
                (true, true) => model.a()[(i, j)] - 1.0,
                (true, false) => model.a()[(i, j)],
                (false, _) => 0.0,
            };
            let drive = |i: usize, j: usize| if i == state { model.b()[(i, j)] } else { 0.0 };
            Self { a: Mat::from_fn(n, n, rate), b: Mat::from_fn(n, nu, drive) }
        };
        (0..n).map(only).collect()
    }

    /// `ΔA`.
    #[must_use]
    pub fn a(&self) -> MatRef<'_, f64> {
        self.a.as_ref()
    }

    /// `ΔB`.
    #[must_use]
    pub fn b(&self) -> MatRef<'_, f64> {
        self.b.as_ref()
    }
}

/// An observer that learns parameters of the plant.
#[derive(Clone, Debug)]
pub struct AdaptiveDesign {
    observer: ObserverDesign,
    shifts: Vec<ParameterShift>,
    noise: ParameterNoise,
}

impl AdaptiveDesign {
    /// An adaptive form of an observer.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no parameter, a shift has other sizes than the model, or a
    /// setting is out of range.
    ///
    /// # Examples
    ///
    /// The plant has twice the gain of its model, and the observer finds out:
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     adaptive::{AdaptiveDesign, ParameterNoise, ParameterShift}, observer::ObserverDesign,
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let observer = ObserverDesign::with_gain(&lag, mat![[0.2]].as_ref())?;
    /// let noise = ParameterNoise { prior: 1.0, drift: 0.0, output: 1e-6, bound: 3.0 };
    /// let design = AdaptiveDesign::new(observer, ParameterShift::input_gains(&lag), noise)?;
    /// let mut running = design.freeze::<f64>()?;
    /// let (mut x, mut r) = (0.0, [0.0]);
    /// for k in 0..100 {
    ///     let u = [(0.3 * k as f64).sin()];
    ///     running.step(Frame::new(running.io(), k, &u, &[x])?, &mut r);
    ///     x = 0.5 * x + 2.0 * u[0];
    /// }
    /// assert!((running.theta()[0] - 1.0).abs() < 1e-3 && r[0].abs() < 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(
        observer: ObserverDesign,
        shifts: Vec<ParameterShift>,
        noise: ParameterNoise,
    ) -> Result<Self, DesignError> {
        let model = observer.model();
        if shifts.is_empty() {
            return Err(DesignError::Empty { what: "parameter" });
        }
        for shift in &shifts {
            check_shape("parameter shift of A", shift.a(), Shape::new(model.nx(), model.nx()))?;
            check_shape("parameter shift of B", shift.b(), Shape::new(model.nx(), model.nu()))?;
        }
        let ParameterNoise { prior, drift, output, bound } = noise;
        for (role, value, least) in [
            ("prior deviation of the parameters", prior, f64::MIN_POSITIVE),
            ("drift of the parameters", drift, 0.0),
            ("output noise", output, f64::MIN_POSITIVE),
            ("bound of the parameters", bound, f64::MIN_POSITIVE),
        ] {
            if !(least <= value && value.is_finite()) {
                let range = if least > 0.0 { "(0, inf)" } else { "[0, inf)" };
                return Err(ModelError::OutOfRange { role, range, value }.into());
            }
        }
        Ok(Self { observer, shifts, noise })
    }

    /// Moves the observer to run time, starting at `x̂ = 0`, `θ̂ = 0`.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn freeze<T: Scalar>(&self) -> Result<AdaptiveObserver<T>, DesignError> {
        let model = self.observer.model();
        let mut directions = Vec::new();
        for shift in &self.shifts {
            let a = freeze("parameter shift of A", shift.a())?;
            let b = freeze("parameter shift of B", shift.b())?;
            directions.push(Direction { a, b });
        }
        let gain = self.observer.gain();
        let parts = [
            freeze("observer transition A − L C", (model.a() - gain * model.c()).as_ref())?,
            freeze("input matrix B − L D", (model.b() - gain * model.d()).as_ref())?,
            freeze("observer gain L", gain)?,
            freeze("output matrix C", model.c())?,
            freeze("feedthrough D", model.d())?,
        ];
        Ok(AdaptiveObserver::new(parts, directions, self.noise))
    }
}

impl GeneratorDesign for AdaptiveDesign {
    fn io(&self) -> IoDims {
        GeneratorDesign::io(&self.observer)
    }

    fn residual_len(&self) -> usize {
        GeneratorDesign::residual_len(&self.observer)
    }

    /// The observer before it has learned anything.
    fn form(&self) -> Result<ResidualForm, DesignError> {
        self.observer.form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze::<f64>()?))
    }
}
