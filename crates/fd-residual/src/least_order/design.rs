//! From a parity vector to a filter.

use faer::{Mat, MatRef, Scale, c64};
use fd_core::{IoDims, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use crate::{
    analysis::{Signature, UnknownInputs, weak_structure},
    decouple::refuse_what_passes,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    observer::ErrorPoles,
    parity::{NaturalPlant, input_map, least_vector},
    rank::{RankDecision, RankTolerance},
};

/// A scalar filter with as few states as its signature allows; runs as
/// [`FormGenerator`](crate::form::FormGenerator).
#[derive(Clone, Debug)]
pub struct LeastOrderDesign<D = Discrete> {
    form: ResidualForm<D>,
    nearest: RankDecision,
}

impl<D: TimeDomain> LeastOrderDesign<D> {
    /// The filter that reacts to the faults with a one bit in `signature`, and to nothing else.
    ///
    /// Poles that are given are as many as the least order; [`order`](Self::order) tells it.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::NoSignature`] when no filter of at most as many states as the plant, and one for each
    /// ignored input, has the signature; a pole that does not decay; and [`DesignError::NotAchieved`] or
    /// [`DesignError::NotDecoupled`] when the filter, looked at again over frequency, is not what was asked for.
    ///
    /// # Examples
    ///
    /// A plant with two unstable channels and a disturbance on the first (Varga 2017, example 5.4): the published
    /// filter has one state.
    ///
    /// ```
    /// use fd_model::{Continuous, TransferFunction};
    /// use fd_residual::{
    ///     analysis::{Signature, UnknownInputs},
    ///     least_order::LeastOrderDesign,
    ///     observer::ErrorPoles,
    /// };
    ///
    /// let ratio = |num: &[f64], den: &[f64]| TransferFunction::new(num, den);
    /// let (first, second) = (ratio(&[1.0, 1.0], &[1.0, -2.0])?, ratio(&[1.0, 2.0], &[1.0, -3.0])?);
    /// let (wind, none) = (ratio(&[1.0, -1.0], &[1.0, 2.0])?, TransferFunction::gain(0.0)?);
    /// let rows = [vec![first, wind], vec![second, none]];
    /// let all = TransferFunction::realise_matrix(&rows, Continuous)?;
    /// let plant = all.select(&[0, 1], &[0])?;
    /// let wind = all.select(&[0, 1], &[1])?;
    /// let wind = UnknownInputs::new("wind", wind.b().to_owned(), wind.d().to_owned())?;
    /// let faults = UnknownInputs::none(&plant).actuator(&plant, 0)?.sensor(&plant, 1)?;
    /// let both = Signature(vec![true, true]);
    /// let design = LeastOrderDesign::new(&plant, &faults, &wind, &both, &ErrorPoles::Rate(3.0))?;
    /// assert_eq!(design.order(), 1);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        signature: &Signature,
        poles: &ErrorPoles,
    ) -> Result<Self, DesignError> {
        let tolerance = RankTolerance::default();
        Self::within(model, faults, disturbances, signature, poles, tolerance)
    }

    /// The same for a model that is known to a given tolerance.
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new).
    pub fn within(
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        signature: &Signature,
        poles: &ErrorPoles,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        // No residual needs a longer window than that.
        let longest = model.nx() + faults.len() + disturbances.len();
        let found = least_vector(model, faults, disturbances, signature, longest, tolerance)?;
        let form = filter_of(model, &found.plant, found.order, found.w.as_ref(), poles)?;
        let achieved = weak_structure(&form, &faults.system(model)?)?.swap_remove(0);
        let nearest = found.nearest;
        if &achieved != signature {
            let wanted = signature.clone();
            return Err(DesignError::NotAchieved { row: 0, wanted, achieved, nearest });
        }
        refuse_what_passes(&form, disturbances, &disturbances.system(model)?, 0, nearest)?;
        Ok(Self { form, nearest })
    }

    /// The transfer functions from `u` and `y` to the residual.
    #[must_use]
    pub fn form(&self) -> &ResidualForm<D> {
        &self.form
    }

    /// Number of states.
    #[must_use]
    pub fn order(&self) -> usize {
        self.form.system().nx()
    }

    /// The nearest decision behind it.
    #[must_use]
    pub fn nearest(&self) -> RankDecision {
        self.nearest
    }
}

impl GeneratorDesign for LeastOrderDesign<Discrete> {
    fn io(&self) -> IoDims {
        self.form.io()
    }

    fn residual_len(&self) -> usize {
        1
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        Ok(self.form.clone())
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        self.form.build()
    }
}

/// The filter with these poles that a parity vector, in natural units of signals and of time, stands for.
///
/// # Errors
///
/// Returns an error when the poles are not as many as the order, or one does not decay.
pub(crate) fn filter_of<D: TimeDomain>(
    model: &StateSpace<D>,
    plant: &NaturalPlant,
    order: usize,
    w: MatRef<'_, f64>,
    poles: &ErrorPoles,
) -> Result<ResidualForm<D>, DesignError> {
    let (nu, ny, rate) = (model.nu(), model.ny(), plant.rate());
    let units = plant.output_units();
    let from_y = Mat::from_fn(1, w.ncols(), |_, j| w[(0, j)] / units[j % ny]);
    let slow = Scale(rate.recip());
    let (a, b) = (slow * model.a(), slow * model.b());
    let from_u = -(&from_y * input_map(a.as_ref(), b.as_ref(), model.c(), model.d(), order));
    // Numerator coefficients, lowest power of p first, as rows over [u; y].
    let numerator = Mat::from_fn(order + 1, nu + ny, |k, j| {
        if j < nu { from_u[(0, k * nu + j)] } else { from_y[(0, k * ny + j - nu)] }
    });
    let roots = poles.values(model.domain(), order, order)?;
    let denominator = monic(&roots, rate);

    // Observer canonical form of Σ N_k pᵏ / Σ a_k pᵏ; the last state is r − N_s v.
    let lead = numerator.row(order);
    let a = Mat::from_fn(order, order, |i, j| {
        let below = if i == j + 1 { 1.0 } else { 0.0 };
        if j + 1 == order { below - denominator[i] } else { below }
    });
    let b = Mat::from_fn(order, nu + ny, |i, j| numerator[(i, j)] - denominator[i] * lead[j]);
    let c = Mat::from_fn(1, order, |_, j| if j + 1 == order { 1.0 } else { 0.0 });
    let d = Mat::from_fn(1, nu + ny, |_, j| lead[j]);
    let fast = Scale(rate);
    let system = StateSpace::new(fast * a, fast * b, c, d, model.domain())?;
    crate::simulation::check_stable("a filter of least order", &system)?;
    ResidualForm::new(IoDims { nu, ny }, system)
}

/// Coefficients of `Π (p − p_i)`, lowest power first, at the pace `rate`; the last one is one.
fn monic(roots: &[c64], rate: f64) -> Vec<f64> {
    let mut polynomial = vec![c64::new(1.0, 0.0)];
    for root in roots.iter().map(|root| root / rate) {
        polynomial.insert(0, c64::new(0.0, 0.0));
        for k in 0..polynomial.len() - 1 {
            let above = polynomial[k + 1];
            polynomial[k] -= root * above;
        }
    }
    polynomial.into_iter().map(|c| c.re).collect()
}
