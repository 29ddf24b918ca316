//! The approximate problem.

use faer::{Mat, MatRef};
use fd_core::{IoDims, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use super::{exact::check_reference, filter::Estimation, stable::joined};
use crate::{
    decouple::LeftNullSpace,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    observer::ErrorPoles,
    optimal::{Exposure, Regular, loudest, regular},
    simulation::check_stable,
};

/// States that are reached or seen by less than this, relatively, are not.
const MINIMAL: f64 = 1e-10;

/// In which sense the residual is near the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MatchingNorm {
    /// The largest error over all frequencies and directions of `[f; w]`: `‖·‖∞`.
    Peak,
    /// The root mean square of the error when faults and noise are white. In continuous time for a reference that is
    /// strictly proper.
    H2,
}

/// A residual near `M_r f`; runs as [`FormGenerator`](crate::form::FormGenerator).
#[derive(Clone, Debug)]
pub struct ApproximateMatching<D = Discrete> {
    form: ResidualForm<D>,
    lags: usize,
    distance: f64,
    bound: f64,
}

impl<D: TimeDomain> ApproximateMatching<D> {
    /// The residual nearest to what `reference` (residuals × faults) makes of the faults, with as little noise.
    ///
    /// Where noise and faults do not reach all channels at infinite frequency, the best filter would differentiate; it is
    /// then led through [`lags`](Self::lags) low-passes with the corner `rate` (rad/s), and so is the reference.
    ///
    /// # Errors
    ///
    /// Returns an error when the reference has not one input per fault or is unstable, as [`LeftNullSpace::of`], and when
    /// faults and noise have a zero on the frequency axis.
    ///
    /// # Examples
    ///
    /// A sensor with noise as large as its faults. With `r = q y` the error from `[f; w]` is `[1 − q, −q]`, least at
    /// `q = 1/2`:
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{
    ///     analysis::UnknownInputs,
    ///     matching::{ApproximateMatching, MatchingNorm},
    ///     optimal::Exposure,
    /// };
    ///
    /// let plant = StateSpace::new(mat![[-1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let none = UnknownInputs::none(&plant);
    /// let fault = none.clone().sensor(&plant, 0)?;
    /// let exposure = Exposure { faults: &fault, disturbances: &none, noise: &fault };
    /// let wanted = StateSpace::gain(mat![[1.0]], Continuous)?;
    /// let design = ApproximateMatching::new(&plant, &exposure, &wanted, 1.0, MatchingNorm::Peak)?;
    /// assert!((design.distance() - 0.5_f64.sqrt()).abs() < 1e-4);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<D>,
        exposure: &Exposure<'_>,
        reference: &StateSpace<D>,
        rate: f64,
        norm: MatchingNorm,
    ) -> Result<Self, DesignError> {
        check_reference(reference, model, exposure.faults)?;
        let space = LeftNullSpace::of(model, exposure.disturbances)?;
        let gain = space.gain_for(&ErrorPoles::Rate(rate))?;
        let first = space.with_gain(gain.as_ref())?;
        let all = exposure.faults.and(exposure.noise)?;
        let seen = space.seen(&all)?;
        let reached = StateSpace::new(
            seen.a() - &gain * seen.c(),
            seen.b() - &gain * seen.d(),
            seen.c().to_owned(),
            seen.d().to_owned(),
            model.domain(),
        )?
        .minimal(MINIMAL)?;
        // Residuals beyond the rank of faults and noise show nothing.
        let rank = reached.ny().min(reached.nu());
        let rows =
            if rank < reached.ny() { loudest(&reached, rank)? } else { Mat::identity(rank, rank) };
        let combined = reached.series(&StateSpace::gain(rows.clone(), model.domain())?)?;
        let half = D::half_plane(&combined)?;
        let Regular { system, filters } = regular(&half, rate)?;
        let problem = Estimation::new(&system, &D::half_plane(reference)?)?;
        let found = match norm {
            MatchingNorm::Peak => problem.least_peak()?,
            MatchingNorm::H2 => problem.least_squares()?,
        };
        let mut after = found.filter.clone();
        for filter in filters.iter().rev() {
            after = filter.series(&after)?;
        }
        let after = model.domain().of_half_plane(&after)?;
        let rows = StateSpace::gain(rows, model.domain())?;
        let form = ResidualForm::new(first.io(), first.system().series(&rows)?.series(&after)?)?;
        check_stable("an approximate model matching", form.system())?;
        Ok(Self { form, lags: filters.len(), distance: found.distance, bound: found.bound })
    }

    /// The transfer functions from `u` and `y` to the residual.
    #[must_use]
    pub fn form(&self) -> &ResidualForm<D> {
        &self.form
    }

    /// Low-passes that residual and reference were both led through; none where the best filter is proper.
    #[must_use]
    pub fn lags(&self) -> usize {
        self.lags
    }

    /// How far the residual is from the reference in the wanted sense, before the low-passes.
    #[must_use]
    pub fn distance(&self) -> f64 {
        self.distance
    }

    /// What no filter falls below, up to the accuracy of the search (1e-4 relative).
    #[must_use]
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// The error `[M_r 0] − Q [G_f G_w]`, when there are no low-passes.
    ///
    /// # Errors
    ///
    /// Returns an error when the exposure or the reference belong to another model.
    pub fn error(
        &self,
        model: &StateSpace<D>,
        exposure: &Exposure<'_>,
        reference: &StateSpace<D>,
    ) -> Result<StateSpace<D>, DesignError> {
        let made = self.form.residual_of(&exposure.faults.and(exposure.noise)?.system(model)?)?;
        let widen = |m: MatRef<'_, f64>| {
            joined(m, Mat::<f64>::zeros(m.nrows(), exposure.noise.len()).as_ref())
        };
        let wanted = StateSpace::new(
            reference.a().to_owned(),
            widen(reference.b()),
            reference.c().to_owned(),
            widen(reference.d()),
            reference.domain(),
        )?;
        Ok(wanted.difference(&made)?)
    }
}

impl GeneratorDesign for ApproximateMatching<Discrete> {
    fn io(&self) -> IoDims {
        self.form.io()
    }

    fn residual_len(&self) -> usize {
        self.form.residual_len()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        Ok(self.form.clone())
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        self.form.build()
    }
}
