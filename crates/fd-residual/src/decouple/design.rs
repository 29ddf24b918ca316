//! The null space, and the residual generators that it holds.

use faer::{Mat, MatRef};
use fd_core::{IoDims, Shape, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use super::{
    invariant::{Invariant, invariant},
    verified::refuse_what_passes,
};
use crate::{
    analysis::{Signature, UnknownInputs},
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::{blocks, check_shape},
    observer::{ErrorPoles, place_visible, visible_part_of},
    rank::{RankDecision, RankTolerance},
};

/// All residuals that are free of the state and of the unknown inputs, before their poles are
/// chosen.
#[derive(Clone, Debug)]
pub struct LeftNullSpace<D = Discrete> {
    model: StateSpace<D>,
    natural: Invariant,
    /// Norm of the combinations that were taken.
    gain: f64,
    tolerance: RankTolerance,
    v: Mat<f64>,
    phi: Mat<f64>,
    g: Mat<f64>,
    w: Mat<f64>,
}

impl<D: TimeDomain> LeftNullSpace<D> {
    /// The null space of a model with its unknown inputs.
    ///
    /// # Errors
    ///
    /// Returns an error when the unknown inputs belong to another model, or
    /// [`DesignError::NothingLeft`] when they hide every output.
    ///
    /// # Examples
    ///
    /// A load on the first of two coupled tanks; one residual of order one is left:
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{analysis::UnknownInputs, decouple::LeftNullSpace};
    ///
    /// let a = mat![[-1.0, 1.0], [1.0, -2.0]];
    /// let (b, c) = (mat![[1.0], [0.0]], Mat::identity(2, 2));
    /// let tanks = StateSpace::new(a, b, c, Mat::zeros(2, 1), Continuous)?;
    /// let load = UnknownInputs::none(&tanks).component("load", &[1.0, 0.0], &[0.0, 0.0])?;
    /// let residuals = LeftNullSpace::of(&tanks, &load)?;
    /// assert_eq!((residuals.residual_len(), residuals.order()), (1, 1));
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn of(model: &StateSpace<D>, unknown: &UnknownInputs) -> Result<Self, DesignError> {
        Self::within(model, unknown, RankTolerance::default())
    }

    /// The same for a model that is known to a given tolerance.
    ///
    /// # Errors
    ///
    /// As [`of`](Self::of).
    pub fn within(
        model: &StateSpace<D>,
        unknown: &UnknownInputs,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        let natural = invariant(model, unknown, tolerance)?;
        if natural.w.nrows() == 0 {
            let (inputs, outputs) = (unknown.len(), model.ny());
            return Err(DesignError::NothingLeft { inputs, outputs });
        }
        Self::observable(model.clone(), natural, 1.0, tolerance)
    }

    /// Some combinations of the residuals: `W ← T W`.
    ///
    /// # Errors
    ///
    /// Returns an error when `T` has not one column per residual.
    pub fn combined(&self, t: MatRef<'_, f64>) -> Result<Self, DesignError> {
        check_shape("combinations T", t, Shape::new(t.nrows(), self.residual_len()))?;
        let natural =
            Invariant { w: t * &self.natural.w, m: t * &self.natural.m, ..self.natural.clone() };
        let gain = self.gain * t.norm_l2();
        Self::observable(self.model.clone(), natural, gain, self.tolerance)
    }

    /// Without what `M` does not show of `ξ`, which never comes back to the rest.
    fn observable(
        model: StateSpace<D>,
        natural: Invariant,
        gain: f64,
        tolerance: RankTolerance,
    ) -> Result<Self, DesignError> {
        let size = gain * natural.scale;
        let (phi, m) = (natural.phi.as_ref(), natural.m.as_ref());
        let (seen, _) = visible_part_of(phi, m, [natural.scale, size], tolerance.value())?;
        let onto = seen.transpose();
        let natural = Invariant {
            v: onto * &natural.v,
            phi: onto * &natural.phi * &seen,
            g: onto * &natural.g,
            m: &natural.m * &seen,
            ..natural
        };
        let (x, y, rate) = (&natural.units.states, &natural.units.outputs, natural.units.rate);
        let per = |m: &Mat<f64>, units: &[f64], factor: f64| {
            Mat::from_fn(m.nrows(), m.ncols(), |i, j| factor * m[(i, j)] / units[j])
        };
        Ok(Self {
            v: per(&natural.v, x, 1.0),
            phi: faer::Scale(rate) * &natural.phi,
            g: per(&natural.g, y, rate),
            w: per(&natural.w, y, 1.0),
            model,
            natural,
            gain,
            tolerance,
        })
    }

    /// The nearest of the rank decisions behind this space.
    #[must_use]
    pub fn nearest(&self) -> RankDecision {
        self.natural.nearest
    }

    /// Number of independent residuals.
    #[must_use]
    pub fn residual_len(&self) -> usize {
        self.w.nrows()
    }

    /// States of the generator of all of them.
    #[must_use]
    pub fn order(&self) -> usize {
        self.phi.nrows()
    }

    /// `V` (order × states): what is estimated is `V x`.
    #[must_use]
    pub fn v(&self) -> MatRef<'_, f64> {
        self.v.as_ref()
    }

    /// `Φ` (order × order), with `V A = Φ V + G C`.
    #[must_use]
    pub fn phi(&self) -> MatRef<'_, f64> {
        self.phi.as_ref()
    }

    /// `G` (order × outputs), with `V E = G F` for unknown inputs that enter by `E` and `F`.
    #[must_use]
    pub fn g(&self) -> MatRef<'_, f64> {
        self.g.as_ref()
    }

    /// `W` (residuals × outputs), with `W F = 0`.
    #[must_use]
    pub fn w(&self) -> MatRef<'_, f64> {
        self.w.as_ref()
    }

    /// `M` (residuals × order), with `W C = M V`.
    #[must_use]
    pub fn m(&self) -> MatRef<'_, f64> {
        self.natural.m.as_ref()
    }

    /// What faults or noise do to the residual before its poles are chosen: `(Φ, V B_f − G D_f,
    /// M, W D_f)`, a plant without known inputs whose outputs are free of the unknown ones.
    ///
    /// # Errors
    ///
    /// Returns an error when the faults belong to another model.
    pub fn seen(&self, faults: &UnknownInputs) -> Result<StateSpace<D>, DesignError> {
        let entry = faults.system(&self.model)?;
        let b = &self.v * entry.b() - &self.g * entry.d();
        let (phi, m) = (self.phi.clone(), self.natural.m.clone());
        Ok(StateSpace::new(phi, b, m, &self.w * entry.d(), self.model.domain())?)
    }

    /// The faults that any residual of this space reacts to.
    ///
    /// # Errors
    ///
    /// Returns an error when the faults belong to another model.
    pub fn detects(&self, faults: &UnknownInputs) -> Result<Signature, DesignError> {
        let reactions = self.reactions(faults)?;
        Ok(Signature(reactions.iter().map(|reaction| reaction.rank == 1).collect()))
    }

    /// The same with the decision about each fault: how far its entry into the residual is from what a
    /// change of the data could make of it.
    ///
    /// # Errors
    ///
    /// Returns an error when the faults belong to another model.
    pub fn reactions(&self, faults: &UnknownInputs) -> Result<Vec<RankDecision>, DesignError> {
        let entry = faults.system(&self.model)?;
        let Invariant { v, g, w, units, kept, .. } = &self.natural;
        let of = |j: usize| {
            let b = Mat::from_fn(entry.nx(), 1, |i, _| {
                entry.b()[(i, j)] / (units.states[i] * units.rate)
            });
            let d = Mat::from_fn(entry.ny(), 1, |i, _| entry.d()[(i, j)] / units.outputs[i]);
            // (M, Φ) is observable, so a fault is unseen only when its entry vanishes.
            let seen = (v * &b - g * &d).norm_l2().hypot((w * &d).norm_l2());
            let size = b.norm_l2() + (g.norm_l2() + self.gain) * d.norm_l2();
            // V, G and W move by the reciprocal of the smallest value that was kept.
            let moved = size * (1.0 + kept.recip());
            let seen = if 0.0 < moved { seen / moved } else { 0.0 };
            RankDecision::of(1, &[seen], self.tolerance)
        };
        Ok((0..faults.len()).map(of).collect())
    }

    /// Refuses a fault that no residual of this space reacts to.
    ///
    /// # Errors
    ///
    /// Returns [`DesignError::Undetectable`] with the name of the first such fault.
    ///
    /// # Examples
    ///
    /// A load and a fault that enter at the same place cannot be told apart:
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::{DesignError, analysis::UnknownInputs, decouple::LeftNullSpace};
    ///
    /// let (a, b) = (mat![[-2.0, 0.0], [0.0, -3.0]], mat![[1.0], [1.0]]);
    /// let plant = StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)?;
    /// let none = UnknownInputs::none(&plant);
    /// let load = none.clone().component("load", &[1.0, 0.0], &[0.0, 0.0])?;
    /// let leak = none.component("leak", &[-3.0, 0.0], &[0.0, 0.0])?;
    /// let refusal = LeftNullSpace::of(&plant, &load)?.require(&leak).unwrap_err();
    /// assert!(matches!(refusal, DesignError::Undetectable { fault, .. } if fault == "leak"));
    /// # Ok::<(), DesignError>(())
    /// ```
    pub fn require(&self, faults: &UnknownInputs) -> Result<(), DesignError> {
        match self.detects(faults)?.0.iter().position(|&bit| !bit) {
            Some(fault) => Err(DesignError::Undetectable {
                fault: faults.names()[fault].clone(),
                residuals: self.residual_len(),
            }),
            None => Ok(()),
        }
    }

    /// The residuals with a gain `K` (order × residuals).
    ///
    /// # Errors
    ///
    /// Returns an error when the gain has another size.
    pub fn with_gain(&self, k: MatRef<'_, f64>) -> Result<ResidualForm<D>, DesignError> {
        check_shape("residual gain K", k, Shape::new(self.order(), self.residual_len()))?;
        let plant = &self.model;
        let from_y = &self.g + k * &self.w;
        let from_u = &self.v * plant.b() - &from_y * plant.d();
        let system = StateSpace::new(
            &self.phi - k * &self.natural.m,
            blocks(&[&[from_u.as_ref(), from_y.as_ref()]]),
            -&self.natural.m,
            blocks(&[&[(-(&self.w * plant.d())).as_ref(), self.w.as_ref()]]),
            plant.domain(),
        )?;
        ResidualForm::new(IoDims { nu: plant.nu(), ny: plant.ny() }, system)
    }

    /// The residuals with all poles placed.
    ///
    /// # Errors
    ///
    /// Fails as [`place_poles`](crate::observer::place_poles) does.
    pub fn placed(&self, poles: &ErrorPoles) -> Result<ResidualForm<D>, DesignError> {
        self.with_gain(self.gain_for(poles)?.as_ref())
    }

    /// The gain `K` of [`placed`](Self::placed).
    pub(crate) fn gain_for(&self, poles: &ErrorPoles) -> Result<Mat<f64>, DesignError> {
        let domain = self.model.domain();
        let hidden =
            |mode: faer::c64| DesignError::Unobservable { re: mode.re, im: mode.im, distance: 0.0 };
        place_visible(domain, self.phi.as_ref(), self.natural.m.as_ref(), poles, hidden)
    }

    /// The model that this space belongs to.
    #[must_use]
    pub fn model(&self) -> &StateSpace<D> {
        &self.model
    }
}

/// Residuals that are free of unknown inputs; runs as [`FormGenerator`](crate::form::FormGenerator).
#[derive(Clone, Debug)]
pub struct DecoupledDesign {
    space: LeftNullSpace,
    form: ResidualForm,
}

impl DecoupledDesign {
    /// All residuals of the null space, with the given poles.
    ///
    /// # Errors
    ///
    /// Returns why there is none, a pole that does not decay, or [`DesignError::NotDecoupled`] when the
    /// residual, looked at again over frequency, lets one of the inputs pass.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{
    ///     GeneratorDesign, analysis::UnknownInputs, decouple::DecoupledDesign,
    ///     observer::ErrorPoles,
    /// };
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let a = mat![[0.9, 0.1], [0.0, 0.8]];
    /// let (b, c) = (mat![[1.0], [0.0]], Mat::identity(2, 2));
    /// let model = StateSpace::new(a, b, c, Mat::zeros(2, 1), domain)?;
    /// let load = UnknownInputs::none(&model).component("load", &[1.0, 0.0], &[0.0, 0.0])?;
    /// let design = DecoupledDesign::new(&model, &load, &ErrorPoles::Rate(3.0))?;
    /// let gd = design.form()?.residual_of(&load.system(&model)?)?;
    /// assert!(gd.frequency_response(1.0)?[(0, 0)].norm() < 1e-14);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        model: &StateSpace<Discrete>,
        unknown: &UnknownInputs,
        poles: &ErrorPoles,
    ) -> Result<Self, DesignError> {
        let space = LeftNullSpace::of(model, unknown)?;
        let form = space.placed(poles)?;
        crate::simulation::check_stable("a decoupled residual", form.system())?;
        refuse_what_passes(&form, unknown, &unknown.system(model)?, 0, space.nearest())?;
        Ok(Self { space, form })
    }

    /// The space that the residuals span.
    #[must_use]
    pub fn space(&self) -> &LeftNullSpace {
        &self.space
    }
}

impl GeneratorDesign for DecoupledDesign {
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
