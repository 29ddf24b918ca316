//! Choosing the gain of a fault detection filter.

use faer::{Mat, MatRef, Scale, c64};
use fd_core::Shape;
use fd_model::{Discrete, ModelError, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use crate::{
    error::DesignError,
    form::{ResidualForm, design_by_part},
    matrix::check_shape,
    observer::{
        ErrorPoles, ObserverDesign, entry_ranks, natural, place_visible, pole_of_rate, rank,
    },
};

/// An observer whose residual keeps a direction for each fault.
///
/// Continuous designs can be analysed through their [`form`](Self::form); only discrete ones run.
#[derive(Clone, Debug)]
pub struct BeardDesign<D = Discrete> {
    observer: ObserverDesign<D>,
}

impl<D: TimeDomain> BeardDesign<D> {
    /// A filter for events that enter along the columns of `E` (states × events); their modes die
    /// out at `rate` (1/s), the others at least as fast.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::HiddenDirection`] when the outputs do not show all events at once,
    /// or [`DesignError::UndecayingZero`] when a zero from the events to the outputs does not
    /// decay.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::directional::BeardDesign;
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let a = mat![[0.9, 0.1, 0.0], [0.0, 0.8, 0.1], [0.1, 0.0, 0.7]];
    /// let (b, c) = (mat![[0.0], [0.0], [1.0]], mat![[1.0, 0.0, 0.0], [0.0, 1.0, 1.0]]);
    /// let plant = StateSpace::new(a, b, c, mat![[0.0], [0.0]], domain)?;
    /// let event = mat![[1.0], [1.0], [0.0]];
    /// let filter = BeardDesign::for_events(&plant, event.as_ref(), 2.0)?;
    /// // (A − L C) e = exp(−0.2) e
    /// let closed = plant.a() - filter.observer().gain() * plant.c();
    /// let moved = closed * &event - faer::Scale((-0.2_f64).exp()) * &event;
    /// assert!(moved.norm_max() < 1e-14);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn for_events(
        model: &StateSpace<D>,
        e: MatRef<'_, f64>,
        rate: f64,
    ) -> Result<Self, DesignError> {
        let (a, c, n, ny) = (model.a(), model.c(), model.nx(), model.ny());
        check_shape("event matrix E", e, Shape::new(n, e.ncols()))?;
        let pole = pole_of_rate(model.domain(), rate)?.re;
        let ce = c * e;
        let ([rank_ce, _], rank_e) = (entry_ranks(&natural(model, e)?)?, e.ncols());
        if rank_ce < rank_e {
            return Err(DesignError::HiddenDirection { rank_ce, rank_e });
        }
        let failed = || ModelError::NoConvergence { what: "inverse of C E", order: n };
        let inverse = ce.full_svd().map_err(|_| failed())?.pseudoinverse();
        let fixed = (a * e - Scale(pole) * e) * &inverse;
        // Z sees what is left of the outputs, which does not show the events.
        let left = Mat::<f64>::identity(ny, ny) - &ce * inverse;
        let (block, shown) = (a - &fixed * c, &left * c);
        let zero = |mode: c64| DesignError::UndecayingZero { re: mode.re, im: mode.im };
        let poles = ErrorPoles::Rate(rate);
        let z = place_visible(model.domain(), block.as_ref(), shown.as_ref(), &poles, zero)?;
        let gain = fixed + z * left;
        Ok(Self { observer: ObserverDesign::with_gain(model, gain.as_ref())? })
    }

    /// The filter `L = (A − λ I) C⁺` for a plant with as many independent outputs as states,
    /// whose error forgets everything at `rate` (1/s); `λ = −rate` in continuous time.
    ///
    /// # Errors
    ///
    /// Returns an error when the outputs do not determine the state.
    pub fn full_state(model: &StateSpace<D>, rate: f64) -> Result<Self, DesignError> {
        let (a, n) = (model.a(), model.nx());
        let pole = pole_of_rate(model.domain(), rate)?.re;
        let shown = rank(model.c())?;
        if shown < n {
            return Err(DesignError::HiddenDirection { rank_ce: shown, rank_e: n });
        }
        let failed = || ModelError::NoConvergence { what: "inverse of C", order: n };
        let inverse = model.c().full_svd().map_err(|_| failed())?.pseudoinverse();
        let gain = (a - Scale(pole) * Mat::<f64>::identity(n, n)) * inverse;
        Ok(Self { observer: ObserverDesign::with_gain(model, gain.as_ref())? })
    }

    /// The directions in which a fault of sensor `output` keeps the residual of a
    /// [`full_state`](Self::full_state) filter: `I_j` and `C L_j`.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such output.
    pub fn sensor_plane(&self, output: usize) -> Result<Mat<f64>, DesignError> {
        let (model, gain) = (self.observer.model(), self.observer.gain());
        let count = model.ny();
        if count <= output {
            return Err(DesignError::Index { what: "output", index: output, count });
        }
        let through = model.c() * gain.subcols(output, 1);
        let unit = |i: usize| if i == output { 1.0 } else { 0.0 };
        Ok(Mat::from_fn(count, 2, |i, j| if j == 0 { unit(i) } else { through[(i, 0)] }))
    }

    /// The observer with this gain.
    #[must_use]
    pub fn observer(&self) -> &ObserverDesign<D> {
        &self.observer
    }

    /// The transfer functions from `u` and `y` to the residual.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn form(&self) -> Result<ResidualForm<D>, DesignError> {
        self.observer.form()
    }
}

design_by_part!(BeardDesign<Discrete>, observer);
