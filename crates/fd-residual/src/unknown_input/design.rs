//! Checking the conditions and choosing the gain.

use faer::{Mat, MatRef, c64};
use fd_core::{IoDims, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain, riccati};
use fd_numeric::dense::Dense;

use crate::{
    decouple::refuse_what_enters,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::{blocks, check_shape},
    observer::{ErrorPoles, entry_ranks, natural, place_visible},
    rank::{RankDecision, RankTolerance},
    simulation::check_stable,
};

/// An observer whose error does not know the unknown inputs; runs as
/// [`FormGenerator`](crate::form::FormGenerator).
///
/// Continuous designs can be analysed through their [`form`](Self::form); only discrete ones run.
#[derive(Clone, Debug)]
pub struct UnknownInputObserver<D = Discrete> {
    model: StateSpace<D>,
    h: Mat<f64>,
    t: Mat<f64>,
    k1: Mat<f64>,
}

impl<D: TimeDomain> UnknownInputObserver<D> {
    /// An observer with a given gain `K₁` (states × outputs), which gets `A₁ = T A`.
    ///
    /// # Errors
    ///
    /// Returns the condition that fails, an error when the gain leaves a growing error, or
    /// [`DesignError::NotDecoupled`] when the residual, looked at again over frequency, lets an unknown input pass.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::unknown_input::UnknownInputObserver;
    ///
    /// // A load on the first state; with C = I, K₁ = A₁ + 3 I makes F = −3 I.
    /// let (a, b) = (mat![[-1.0, 1.0], [1.0, -2.0]], mat![[0.0], [1.0]]);
    /// let plant = StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)?;
    /// let observer = UnknownInputObserver::with_gain(&plant, mat![[1.0], [0.0]].as_ref(), |a1| {
    ///     Mat::from_fn(2, 2, |i, j| a1[(i, j)] + if i == j { 3.0 } else { 0.0 })
    /// })?;
    /// assert_eq!(observer.t(), mat![[0.0, 0.0], [0.0, 1.0]]);
    /// assert_eq!(observer.f(), mat![[-3.0, 0.0], [0.0, -3.0]]);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn with_gain(
        model: &StateSpace<D>,
        e: MatRef<'_, f64>,
        gain: impl FnOnce(MatRef<'_, f64>) -> Mat<f64>,
    ) -> Result<Self, DesignError> {
        let (h, t) = decoupling(model, e)?;
        let k1 = gain((&t * model.a()).as_ref());
        check_shape("observer gain K1", k1.as_ref(), Shape::new(model.nx(), model.ny()))?;
        let design = Self { model: model.clone(), h, t, k1 };
        let form = design.form()?;
        check_stable("the unknown-input observer error", form.system())?;
        refuse_what_enters(&form, model, e, RankDecision::clear(RankTolerance::default()))?;
        Ok(design)
    }

    /// An observer with prescribed poles of the part of `(C, A₁)` that can be moved.
    ///
    /// # Errors
    ///
    /// Returns the condition that fails, or fails as
    /// [`place_poles`](crate::observer::place_poles) does.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{DesignError, observer::ErrorPoles, unknown_input::UnknownInputObserver};
    ///
    /// let (a, b) = (mat![[-1.0, 1.0], [1.0, -2.0]], mat![[0.0], [1.0]]);
    /// let rate = ErrorPoles::Rate(3.0);
    /// let both = StateSpace::new(a.clone(), b.clone(), Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)?;
    /// assert!(UnknownInputObserver::place(&both, mat![[1.0], [0.0]].as_ref(), &rate).is_ok());
    ///
    /// // The second output alone sees the load only through the second state.
    /// let one = StateSpace::new(a, b, mat![[0.0, 1.0]], mat![[0.0]], Continuous)?;
    /// let refused = UnknownInputObserver::place(&one, mat![[1.0], [0.0]].as_ref(), &rate);
    /// assert!(matches!(refused, Err(DesignError::HiddenDirection { rank_ce: 0, rank_e: 1 })));
    /// # Ok::<(), DesignError>(())
    /// ```
    pub fn place(
        model: &StateSpace<D>,
        e: MatRef<'_, f64>,
        poles: &ErrorPoles,
    ) -> Result<Self, DesignError> {
        let a1 = decoupling(model, e)?.1 * model.a();
        let zero = |mode: c64| DesignError::UndecayingZero { re: mode.re, im: mode.im };
        // In natural units, which decide what the outputs show.
        let units = natural(model, e)?.units;
        let (x, y) = (&units.states, &units.outputs);
        let a1 = Mat::from_fn(x.len(), x.len(), |i, j| a1[(i, j)] * (x[j] / x[i]));
        let c = Mat::from_fn(y.len(), x.len(), |i, j| model.c()[(i, j)] * (x[j] / y[i]));
        let k1 = place_visible(model.domain(), a1.as_ref(), c.as_ref(), poles, zero)?;
        let k1 = Mat::from_fn(x.len(), y.len(), |i, j| k1[(i, j)] * (x[i] / y[j]));
        Self::with_gain(model, e, |_| k1)
    }

    /// `H = E (C E)⁺` (states × outputs).
    #[must_use]
    pub fn h(&self) -> MatRef<'_, f64> {
        self.h.as_ref()
    }

    /// `T = I − H C` (states × states), which takes the unknown inputs out: `T E = 0`.
    #[must_use]
    pub fn t(&self) -> MatRef<'_, f64> {
        self.t.as_ref()
    }

    /// `K₁`, the part of the gain that places the poles (states × outputs).
    #[must_use]
    pub fn k1(&self) -> MatRef<'_, f64> {
        self.k1.as_ref()
    }

    /// `F = T A − K₁ C`, the transition of the error.
    #[must_use]
    pub fn f(&self) -> Mat<f64> {
        &self.t * self.model.a() - &self.k1 * self.model.c()
    }

    /// `K = K₁ + F H`, the gain on the outputs (states × outputs).
    #[must_use]
    pub fn k(&self) -> Mat<f64> {
        // K₁ (I − C H) + T A H: the same without the difference of what cancels.
        &self.k1 * identity_less(self.model.c(), self.h()) + &self.t * self.model.a() * &self.h
    }

    /// The transfer functions from `u` and `y` to the residual.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn form(&self) -> Result<ResidualForm<D>, DesignError> {
        let m = &self.model;
        let k = self.k();
        let from_u = &self.t * m.b() - &k * m.d();
        let from_y = identity_less(m.c(), self.h());
        let system = StateSpace::new(
            self.f(),
            blocks(&[&[from_u.as_ref(), k.as_ref()]]),
            -m.c(),
            blocks(&[&[(-(&from_y * m.d())).as_ref(), from_y.as_ref()]]),
            m.domain(),
        )?;
        ResidualForm::new(IoDims { nu: m.nu(), ny: m.ny() }, system)
    }
}

impl UnknownInputObserver<Discrete> {
    /// The gain of a stationary Kalman filter for `(C, A₁)`: independent noises of covariance
    /// `q I` on the states and `r I` on the outputs.
    ///
    /// The noise that `H` carries from the outputs into `T A x` is left out of the balance.
    ///
    /// # Errors
    ///
    /// Returns the condition that fails, or an error when there is no stabilising solution.
    pub fn kalman(
        model: &StateSpace<Discrete>,
        e: MatRef<'_, f64>,
        q: f64,
        r: f64,
    ) -> Result<Self, DesignError> {
        let a1 = decoupling(model, e)?.1 * model.a();
        let scaled = |n, v| Mat::from_fn(n, n, |i, j| if i == j { v } else { 0.0 });
        let (q, r) = (scaled(model.nx(), q), scaled(model.ny(), r));
        let filter = riccati::discrete_filter(a1.as_ref(), model.c(), q.as_ref(), r.as_ref())?;
        Self::with_gain(model, e, |_| filter.gain)
    }
}

impl GeneratorDesign for UnknownInputObserver<Discrete> {
    fn io(&self) -> IoDims {
        IoDims { nu: self.model.nu(), ny: self.model.ny() }
    }

    fn residual_len(&self) -> usize {
        self.model.ny()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        UnknownInputObserver::form(self)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        GeneratorDesign::form(self)?.build()
    }
}

/// `H` and `T`, when the first condition holds and something is left.
fn decoupling<D: TimeDomain>(
    model: &StateSpace<D>,
    e: MatRef<'_, f64>,
) -> Result<(Mat<f64>, Mat<f64>), DesignError> {
    let n = model.nx();
    check_shape("unknown input matrix E", e, Shape::new(n, e.ncols()))?;
    if e.ncols() == 0 {
        return Ok((Mat::zeros(n, model.ny()), Mat::identity(n, n)));
    }
    let natural = natural(model, e)?;
    let [rank_ce, rank_e] = entry_ranks(&natural)?;
    if rank_ce < rank_e {
        return Err(DesignError::HiddenDirection { rank_ce, rank_e });
    }
    if rank_ce == model.ny() {
        return Err(DesignError::NothingLeft { inputs: rank_e, outputs: model.ny() });
    }
    // H does not depend on the units of the unknown inputs, but its rounding does.
    let e = Mat::from_fn(n, e.ncols(), |i, j| e[(i, j)] * natural.units.inputs[j]);
    let ce = model.c() * &e;
    let svd = ce
        .full_svd()
        .map_err(|_| ModelError::NoConvergence { what: "inverse of C E", order: n })?;
    let scaled = Mat::from_fn(rank_ce, model.ny(), |i, j| svd.U()[(j, i)] / svd.S()[i]);
    let h = e * (svd.V().subcols(0, rank_ce) * scaled);
    let t = identity_less(h.as_ref(), model.c());
    Ok((h, t))
}

/// `I − A B`, where what cancels but for rounding is zero: a channel that is nothing else would be taken
/// at its word.
fn identity_less(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Mat<f64> {
    let (n, inner) = (a.nrows(), a.ncols());
    let product = a * b;
    Mat::from_fn(n, n, |i, j| {
        let one = if i == j { 1.0 } else { 0.0 };
        let terms = one + (0..inner).map(|k| (a[(i, k)] * b[(k, j)]).abs()).sum::<f64>();
        let left = one - product[(i, j)];
        // Some roundings for each term, and those of the inverse in H.
        let rounding = 16.0 * (inner + 1) as f64 * f64::EPSILON * terms;
        if rounding < left.abs() { left } else { 0.0 }
    })
}
