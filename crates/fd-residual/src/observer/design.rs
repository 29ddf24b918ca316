//! Choosing the observer gain.

use faer::{Mat, MatRef, c64};
use fd_core::{Heap, IoDims, Scalar, Shape, Storage, stage::ResidualGenerator};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain, freeze, riccati};

use super::{observable::check_observable, place::place_poles, run::Observer};
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::{blocks, check_shape},
    simulation::check_stable,
};

/// A model with an observer gain `L` for `x̂⁺ = A x̂ + B u + L (y − C x̂ − D u)`.
///
/// Continuous designs can be analysed through their [`form`](Self::form); only discrete ones run.
#[derive(Clone, Debug)]
pub struct ObserverDesign<D = Discrete> {
    model: StateSpace<D>,
    gain: Mat<f64>,
}

impl<D: TimeDomain> ObserverDesign<D> {
    /// An observer with a given gain (states × outputs).
    ///
    /// # Errors
    ///
    /// Returns an error when the gain has another size or leaves an estimation error that grows.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::observer::ObserverDesign;
    ///
    /// let unstable = StateSpace::new(mat![[1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let design = ObserverDesign::with_gain(&unstable, mat![[3.0]].as_ref())?;
    /// assert!(design.form()?.consistency(&unstable)? < 1e-14);
    /// assert!(ObserverDesign::with_gain(&unstable, mat![[0.5]].as_ref()).is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn with_gain(model: &StateSpace<D>, gain: MatRef<'_, f64>) -> Result<Self, DesignError> {
        check_shape("observer gain L", gain, Shape::new(model.nx(), model.ny()))?;
        let design = Self { model: model.clone(), gain: gain.to_owned() };
        check_stable("the observer error A - L C", design.form()?.system())?;
        Ok(design)
    }

    /// An observer with prescribed poles, as insensitive as several outputs allow.
    ///
    /// # Errors
    ///
    /// Fails as [`place_poles`] does, or when a wanted pole does not decay.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{c64, mat};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{DesignError, observer::ObserverDesign};
    ///
    /// let domain = Discrete { ts: SampleTime::new(1.0)? };
    /// let a = mat![[0.9, 0.1], [0.0, 0.8]];
    /// let b = mat![[0.0], [1.0]];
    /// let fast = [c64::new(0.2, 0.0), c64::new(0.3, 0.0)];
    /// let shown = StateSpace::new(a.clone(), b.clone(), mat![[1.0, 0.0]], mat![[0.0]], domain)?;
    /// assert!(ObserverDesign::place(&shown, &fast).is_ok());
    ///
    /// // The second state alone does not show the first.
    /// let hidden = StateSpace::new(a, b, mat![[0.0, 1.0]], mat![[0.0]], domain)?;
    /// let error = ObserverDesign::place(&hidden, &fast).unwrap_err();
    /// assert!(matches!(error, DesignError::Unobservable { re, .. } if (re - 0.9).abs() < 1e-12));
    /// # Ok::<(), DesignError>(())
    /// ```
    pub fn place(model: &StateSpace<D>, poles: &[c64]) -> Result<Self, DesignError> {
        if let Some(pole) = poles.iter().find(|&&pole| !model.domain().decays(pole)) {
            let what = "a wanted observer";
            return Err(ModelError::Unstable { what, re: pole.re, im: pole.im }.into());
        }
        let placement = place_poles(model.a(), model.c(), poles)?;
        Self::with_gain(model, placement.gain.as_ref())
    }

    /// The gain `L`.
    #[must_use]
    pub fn gain(&self) -> MatRef<'_, f64> {
        self.gain.as_ref()
    }

    /// The model that the observer follows.
    #[must_use]
    pub fn model(&self) -> &StateSpace<D> {
        &self.model
    }

    /// The transfer functions from `u` and `y` to the residual.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn form(&self) -> Result<ResidualForm<D>, DesignError> {
        let (m, gain) = (&self.model, self.gain.as_ref());
        let a = m.a() - gain * m.c();
        let b = blocks(&[&[(m.b() - gain * m.d()).as_ref(), gain]]);
        let d = blocks(&[&[(-m.d()).as_ref(), Mat::identity(m.ny(), m.ny()).as_ref()]]);
        let system = StateSpace::new(a, b, -m.c(), d, m.domain())?;
        ResidualForm::new(IoDims { nu: m.nu(), ny: m.ny() }, system)
    }
}

impl ObserverDesign<Discrete> {
    /// An observer whose poles are those of the model, moved towards zero.
    ///
    /// Each pole keeps its angle and gets the modulus `|p|^factor` (of `1/|p|` when it is
    /// unstable), so that its mode dies out `factor` times as fast.
    ///
    /// # Errors
    ///
    /// Returns an error when the factor is not positive and finite, a pole of the model lies on
    /// the unit circle, or placement fails.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::observer::ObserverDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(1.0)? };
    /// let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let design = ObserverDesign::faster(&lag, 2.0)?; // pole 0.81 = 0.9 − L
    /// assert!((design.gain()[(0, 0)] - 0.09).abs() < 1e-15);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn faster(model: &StateSpace<Discrete>, factor: f64) -> Result<Self, DesignError> {
        if !(0.0 < factor && factor.is_finite()) {
            return Err(DesignError::Speed { factor });
        }
        let moved = |p: c64| {
            let radius = p.norm();
            if radius < f64::MIN_POSITIVE {
                return p;
            }
            p / radius * radius.min(radius.recip()).powf(factor)
        };
        let poles: Vec<_> = model.poles()?.into_iter().map(moved).collect();
        Self::place(model, &poles)
    }

    /// The stationary Kalman filter for independent noises: covariance `q I` on the states and
    /// `r I` on the outputs.
    ///
    /// Only the ratio `q / r` decides about the gain.
    ///
    /// # Errors
    ///
    /// Fails as [`kalman_with`](Self::kalman_with) does.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::observer::ObserverDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(1.0)? };
    /// let walk = StateSpace::new(mat![[1.0]], mat![[0.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let design = ObserverDesign::kalman(&walk, 1.0, 1.0)?;
    /// // p = (1 + √5)/2 solves p = p + 1 − p²/(p + 1), and L = p/(p + 1) = p − 1.
    /// assert!((design.gain()[(0, 0)] - (5.0_f64.sqrt() - 1.0) / 2.0).abs() < 1e-12);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn kalman(model: &StateSpace<Discrete>, q: f64, r: f64) -> Result<Self, DesignError> {
        let diagonal = |n, v| Mat::from_fn(n, n, |i, j| if i == j { v } else { 0.0 });
        let (q, r) = (diagonal(model.nx(), q), diagonal(model.ny(), r));
        Self::kalman_with(model, q.as_ref(), r.as_ref())
    }

    /// The stationary Kalman filter: state noise covariance `Q` (symmetric, ≥ 0) and output noise
    /// covariance `R` (symmetric, > 0), in squared units per sample.
    ///
    /// # Errors
    ///
    /// Returns an error when a covariance has the wrong size or definiteness, when a mode that
    /// does not decay is unobservable, or when the Riccati equation has no stabilising solution
    /// (a mode on the unit circle that no noise drives).
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::observer::ObserverDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(1.0)? };
    /// let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let quiet = ObserverDesign::kalman_with(&lag, mat![[0.0]].as_ref(), mat![[1.0]].as_ref())?;
    /// assert!(quiet.gain()[(0, 0)].abs() < 1e-12); // a plant without noise needs no correction
    /// assert!(ObserverDesign::kalman_with(&lag, mat![[1.0]].as_ref(), mat![[0.0]].as_ref()).is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn kalman_with(
        model: &StateSpace<Discrete>,
        q: MatRef<'_, f64>,
        r: MatRef<'_, f64>,
    ) -> Result<Self, DesignError> {
        check_shape("process noise covariance Q", q, Shape::new(model.nx(), model.nx()))?;
        check_shape("measurement noise covariance R", r, Shape::new(model.ny(), model.ny()))?;
        check_observable(model.a(), model.c(), |mode| !model.domain().decays(mode))?;
        let filter = riccati::discrete_filter(model.a(), model.c(), q, r)?;
        Self::with_gain(model, filter.gain.as_ref())
    }

    /// Moves the observer to run time, starting at `x̂ = 0`.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has other sizes.
    pub fn freeze<T: Scalar, S: Storage<T>>(&self) -> Result<Observer<T, S>, DesignError> {
        Ok(Observer::new(self.model.freeze()?, freeze("observer gain L", self.gain())?)?)
    }
}

impl GeneratorDesign for ObserverDesign<Discrete> {
    fn io(&self) -> IoDims {
        IoDims { nu: self.model.nu(), ny: self.model.ny() }
    }

    fn residual_len(&self) -> usize {
        self.model.ny()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        ObserverDesign::form(self)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze::<f64, Heap>()?))
    }
}
