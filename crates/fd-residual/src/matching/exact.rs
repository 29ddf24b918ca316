//! The exact problem.

use faer::{Mat, Scale};
use fd_core::{IoDims, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use super::{
    inverse::inverted,
    stable::{above, diagonal, shares, with_modes_at},
};
use crate::{
    analysis::UnknownInputs,
    decouple::{LeftNullSpace, refuse_what_passes},
    error::DesignError,
    form::{GeneratorDesign, ResidualForm, peak_gain},
    matrix::{blocks, check_shape},
    observer::{ErrorPoles, pole_of_rate},
    simulation::check_stable,
};

/// Corner of the lags for zeros at infinity, in units of the rate: the inverse has modes there, which are not to be moved.
const CORNER: f64 = 2.0;

/// Part of the reference that a design may miss.
const MISSED: f64 = 1e-6;

/// Feedthrough of a row, relative to its gain, that is nothing but rounding.
const DIRECT: f64 = 1e-9;

/// States that are reached or seen by less than this, relatively, are not.
const MINIMAL: f64 = 1e-9;

/// A residual `r = M M_r f`; runs as [`FormGenerator`](crate::form::FormGenerator).
#[derive(Clone, Debug)]
pub struct ExactMatching<D = Discrete> {
    form: ResidualForm<D>,
    updates: Vec<StateSpace<D>>,
    target: StateSpace<D>,
    missed: f64,
}

impl<D: TimeDomain> ExactMatching<D> {
    /// The residual that makes `reference` (residuals × faults) of the faults and nothing of inputs and disturbances.
    ///
    /// All modes die out at least at `rate` (1/s), those of lags twice as fast; what this costs is in
    /// [`updates`](Self::updates).
    ///
    /// # Errors
    ///
    /// Returns an error when the reference has not one input per fault or is unstable, as [`LeftNullSpace::of`], and
    /// [`DesignError::NotMatched`] when no filter makes this of the faults.
    ///
    /// # Examples
    ///
    /// Two tanks with a leak each; every residual shows one leak through a lag with the corner 4 rad/s:
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{analysis::UnknownInputs, matching::ExactMatching};
    ///
    /// let a = mat![[-1.0, 0.3], [0.2, -0.5]];
    /// let tanks =
    ///     StateSpace::new(a, mat![[1.0], [0.0]], Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)?;
    /// let leaks = UnknownInputs::new("leak", Mat::identity(2, 2), Mat::zeros(2, 2))?;
    /// let wanted = StateSpace::gain(Mat::identity(2, 2), Continuous)?;
    /// let design = ExactMatching::new(&tanks, &leaks, &UnknownInputs::none(&tanks), &wanted, 2.0)?;
    /// // A flow shows in a level only through an integral, so the reference gets a lag.
    /// let made = design.form().residual_of(&leaks.system(&tanks)?)?.frequency_response(4.0)?;
    /// assert!((made[(0, 0)].norm() - 0.5_f64.sqrt()).abs() < 1e-9 && made[(0, 1)].norm() < 1e-9);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
        reference: &StateSpace<D>,
        rate: f64,
    ) -> Result<Self, DesignError> {
        let gf = faults.system(model)?;
        check_reference(reference, model, faults)?;
        pole_of_rate(model.domain(), rate)?;
        let Moved { model: moved, faults: by_faults, disturbances: hidden } =
            Moved::of(model, faults, disturbances)?;
        let space = LeftNullSpace::of(&moved, &hidden)?;
        let gain = space.gain_for(&ErrorPoles::Rate(rate))?;
        let first = space.with_gain(gain.as_ref())?;
        let seen = space.seen(&by_faults)?;
        // R_f with the states of the null space that faults reach: the others would be zeros of it.
        let rf = StateSpace::new(
            seen.a() - &gain * seen.c(),
            seen.b() - &gain * seen.d(),
            seen.c().to_owned(),
            seen.d().to_owned(),
            model.domain(),
        )?
        .minimal(MINIMAL)?;
        let unmatched = |missed: f64| DesignError::NotMatched { missed };
        let corner = CORNER * rate;
        let found = inverted(&rf, rate, corner)?.ok_or_else(|| unmatched(1.0))?;
        let domain = model.domain();
        let mut front = StateSpace::gain(found.rows.clone(), domain)?;
        for filter in &found.filters {
            front = front.series(filter)?;
        }
        let before = first.system().series(&front)?.minimal(MINIMAL)?;
        let all: Vec<_> = (0..reference.nu()).collect();
        let (mut rows, mut updates) = (Vec::new(), Vec::new());
        for i in 0..reference.ny() {
            let wanted = reference.select(&[i], &found.columns)?;
            // Modes that the null space has as zeros cancel here.
            let row = before.series(&found.inverse.series(&wanted)?)?.minimal(MINIMAL)?;
            let factored = with_modes_at(&row, rate)?;
            let row = factored.filter.minimal(MINIMAL)?;
            let (row, lags) = without_lags(row, found.filters.len(), corner)?;
            let mut update = factored.factor;
            for _ in 0..lags {
                update = update.series(&delay(domain, corner)?)?;
            }
            rows.push(row);
            updates.push(update);
        }
        let updated: Result<Vec<_>, DesignError> = (updates.iter().enumerate())
            .map(|(i, update)| Ok(reference.select(&[i], &all)?.series(update)?))
            .collect();
        let nothing = || DesignError::Empty { what: "row of the reference" };
        let target = above(&updated?)?.ok_or_else(nothing)?.minimal(MINIMAL)?;
        let form = ResidualForm::new(first.io(), above(&rows)?.ok_or_else(nothing)?)?;
        check_stable("a model matching", form.system())?;

        let missed = shares(&form.residual_of(&gf)?.difference(&target)?, &target)?;
        if missed.is_nan() || MISSED < missed {
            return Err(unmatched(missed));
        }
        refuse_what_passes(&form, disturbances, &disturbances.system(model)?, 0, space.nearest())?;
        Ok(Self { form, updates, target, missed })
    }

    /// The transfer functions from `u` and `y` to the residual.
    #[must_use]
    pub fn form(&self) -> &ResidualForm<D> {
        &self.form
    }

    /// The diagonal of `M`: what each row of the reference had to be multiplied by.
    #[must_use]
    pub fn updates(&self) -> &[StateSpace<D>] {
        &self.updates
    }

    /// `M`, as one system.
    ///
    /// # Errors
    ///
    /// Never fails for a checked design.
    pub fn update(&self) -> Result<StateSpace<D>, DesignError> {
        diagonal(&self.updates, self.target.domain())
    }

    /// `M M_r`, which the residual makes of the faults.
    #[must_use]
    pub fn target(&self) -> &StateSpace<D> {
        &self.target
    }

    /// The part of the reference that was missed when the residual was looked at again: rounding.
    #[must_use]
    pub fn missed(&self) -> f64 {
        self.missed
    }
}

impl GeneratorDesign for ExactMatching<Discrete> {
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

/// A plant with those of its states that are moved by inputs, disturbances or faults.
///
/// The others would be zeros of the null space, and the update would have to carry them.
struct Moved<D> {
    model: StateSpace<D>,
    faults: UnknownInputs,
    disturbances: UnknownInputs,
}

impl<D: TimeDomain> Moved<D> {
    /// The plant as it is when a state that nothing moves does not die out: residuals have to be blind to it.
    fn of(
        model: &StateSpace<D>,
        faults: &UnknownInputs,
        disturbances: &UnknownInputs,
    ) -> Result<Self, DesignError> {
        let (f, d) = (faults.system(model)?, disturbances.system(model)?);
        let [b, through] =
            [blocks(&[&[model.b(), d.b(), f.b()]]), blocks(&[&[model.d(), d.d(), f.d()]])];
        let (a, c, domain) = (model.a().to_owned(), model.c().to_owned(), model.domain());
        let all = StateSpace::new(a, b, c, through, domain)?;
        let lean = all.minimal(MINIMAL)?;
        let lasting = |system: &StateSpace<D>| -> Result<usize, DesignError> {
            Ok(system.poles()?.into_iter().filter(|&pole| !domain.decays(pole)).count())
        };
        let (faults, disturbances) = (faults.clone(), disturbances.clone());
        if lasting(&lean)? < lasting(&all)? {
            return Ok(Self { model: model.clone(), faults, disturbances });
        }
        let (nu, nd) = (model.nu(), disturbances.len());
        let part = |from: usize, count: usize| {
            let [b, d] = [lean.b(), lean.d()].map(|m| m.subcols(from, count).to_owned());
            (b, d)
        };
        let (b, through) = part(0, nu);
        let (into, onto) = part(nu, nd);
        let (by, at) = part(nu + nd, faults.len());
        Ok(Self {
            model: StateSpace::new(lean.a().to_owned(), b, lean.c().to_owned(), through, domain)?,
            faults: UnknownInputs::new("fault", by, at)?,
            disturbances: UnknownInputs::new("disturbance", into, onto)?,
        })
    }
}

/// A stable reference for these faults on the time axis of the model.
pub(super) fn check_reference<D: TimeDomain>(
    reference: &StateSpace<D>,
    model: &StateSpace<D>,
    faults: &UnknownInputs,
) -> Result<(), DesignError> {
    model.domain().join(reference.domain())?;
    let expected = Shape::new(reference.ny(), faults.len());
    check_shape("reference of the faults", reference.d(), expected)?;
    if reference.ny() == 0 {
        return Err(DesignError::Empty { what: "row of the reference" });
    }
    check_stable("the reference of a model matching", reference)
}

/// `a/(s + a)`, or `1/z`: what one zero at infinity costs.
fn delay<D: TimeDomain>(domain: D, corner: f64) -> Result<StateSpace<D>, DesignError> {
    let (keep, enter) =
        if domain.highest_frequency().is_finite() { (0.0, 1.0) } else { (-corner, corner) };
    let one = |value: f64| Mat::from_fn(1, 1, |_, _| value);
    Ok(StateSpace::new(one(keep), one(enter), one(1.0), one(0.0), domain)?)
}

/// A row multiplied by `(s + a)/a`, or `z`, as often as it stays proper, at most `lags` times; and how often not.
fn without_lags<D: TimeDomain>(
    mut row: StateSpace<D>,
    lags: usize,
    corner: f64,
) -> Result<(StateSpace<D>, usize), DesignError> {
    let sampled = row.domain().highest_frequency().is_finite();
    for left in (1..=lags).rev() {
        let size = peak_gain(&row)?.norm;
        if row.d().norm_l2() > DIRECT * size {
            return Ok((row, left));
        }
        let (a, b, c) = (row.a(), row.b(), row.c());
        let (c, d) = if sampled {
            (c * a, c * b)
        } else {
            let slow = Scale(corner.recip());
            (slow * (c * a) + c, slow * (c * b))
        };
        let advanced = StateSpace::new(a.to_owned(), b.to_owned(), c, d, row.domain())?;
        row = advanced.minimal(MINIMAL)?;
    }
    Ok((row, 0))
}
