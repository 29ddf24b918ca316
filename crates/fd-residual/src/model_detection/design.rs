//! The bank, and what each of its residuals makes of each model.

use faer::{Mat, MatRef, Scale};
use fd_core::{Heap, IoDims, Shape, ShapeError, stage::ResidualGenerator};
use fd_model::{Discrete, StateSpace, TimeDomain};

use super::{
    models::PlantModel,
    run::{Memory, ModelDetector},
};
use crate::{
    analysis::{UnknownInputs, weak_structure},
    bank::BankDesign,
    decouple::LeftNullSpace,
    error::DesignError,
    form::{GeneratorDesign, ResidualForm, peak_gain},
    least_order::filter_of,
    matrix::{blocks, check_shape, spread_rows},
    observer::ErrorPoles,
    optimal::{Exposure, OptimalDesign},
    parity::NaturalPlant,
    rank::RankTolerance,
};

/// Which residuals of each model's null space are taken.
#[derive(Clone, Debug, PartialEq)]
pub enum DetectionRows {
    /// All of them.
    All,
    /// One combination of all, with one factor per residual of the null space.
    Combination(Vec<f64>),
    /// One channel of the least order that reacts to every other model, of those combinations whose weakest reaction
    /// is strongest. For models without noise.
    LeastOrder,
}

/// A residual for each model that is blind to it; for models with noise, whitened.
#[derive(Clone, Debug)]
pub struct ModelDetection<D = Discrete> {
    names: Vec<String>,
    forms: Vec<ResidualForm<D>>,
    norms: Mat<f64>,
    gaps: Vec<f64>,
}

impl<D: TimeDomain> ModelDetection<D> {
    /// One residual per model, with modes that die out at least at `rate` (1/s).
    ///
    /// Without noise each residual is scaled so that its weakest reaction to another model is one (as the published
    /// tables are); with noise it has noise of unit size when its model is the plant.
    ///
    /// # Errors
    ///
    /// Returns an error when there are fewer than two models or they differ in their channels, as
    /// [`LeftNullSpace::of`] and [`OptimalDesign::new`] do, and [`DesignError::SameModel`] when the residual of one
    /// model does not react to another.
    ///
    /// # Examples
    ///
    /// An actuator in order and with half its efficiency:
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::model_detection::{DetectionRows, ModelDetection, PlantModel};
    ///
    /// let lag = |k: f64| StateSpace::new(mat![[-k]], mat![[k]], mat![[1.0]], mat![[0.0]], Continuous);
    /// let models = [PlantModel::new("in order", lag(14.0)?), PlantModel::new("worn", lag(7.0)?)];
    /// let bank = ModelDetection::new(&models, &DetectionRows::All, 20.0)?;
    /// assert!(bank.norms()[(0, 0)] < 1e-12 && bank.norms()[(1, 1)] < 1e-12);
    /// assert!((bank.norms()[(0, 1)] - 1.0).abs() < 1e-7);
    /// let twins = [PlantModel::new("a", lag(14.0)?), PlantModel::new("b", lag(14.0)?)];
    /// assert!(ModelDetection::new(&twins, &DetectionRows::All, 20.0).is_err());
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(
        models: &[PlantModel<D>],
        rows: &DetectionRows,
        rate: f64,
    ) -> Result<Self, DesignError> {
        if models.len() < 2 {
            let what = "models to choose from";
            return Err(DesignError::Count { what, expected: 2, found: models.len() });
        }
        let first = models[0].plant();
        let expected = Shape::new(first.ny(), first.nu());
        for model in models {
            first.domain().join(model.plant().domain())?;
            let found = Shape::new(model.plant().ny(), model.plant().nu());
            if found != expected {
                return Err(ShapeError { role: "model to choose from", expected, found }.into());
            }
        }
        let count = models.len();
        let mut norms = Mat::zeros(count, count);
        let (mut forms, mut gaps) = (Vec::new(), Vec::new());
        for i in 0..count {
            let one = row(models, i, rows, rate)?;
            for (j, reaction) in one.reactions.iter().enumerate() {
                norms[(i, j)] = *reaction;
            }
            forms.push(one.form);
            gaps.push(one.gap);
        }
        let names = models.iter().map(|model| model.name().to_owned()).collect();
        Ok(Self { names, forms, norms, gaps })
    }

    /// Names of the models.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The residual generators, one per model.
    #[must_use]
    pub fn forms(&self) -> &[ResidualForm<D>] {
        &self.forms
    }

    /// `‖R_ij‖∞`: the largest gain from inputs and disturbances to residual `i` when model `j` is the plant.
    #[must_use]
    pub fn norms(&self) -> MatRef<'_, f64> {
        self.norms.as_ref()
    }

    /// By how much the weakest reaction of each residual to another model stands above its own noise; infinite
    /// without noise.
    #[must_use]
    pub fn gaps(&self) -> &[f64] {
        &self.gaps
    }

    /// The model whose residual reacts least to a plant, and the reactions of all: where an unknown plant belongs.
    ///
    /// # Errors
    ///
    /// Returns an error when the plant has other channels or another sample time.
    pub fn nearest(&self, plant: &PlantModel<D>) -> Result<(usize, Vec<f64>), DesignError> {
        let mut all = Vec::new();
        for form in &self.forms {
            all.push(reaction(form, plant)?);
        }
        let best = all.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
        Ok((best.map_or(0, |best| best.0), all))
    }
}

impl ModelDetection<Discrete> {
    /// Moves the bank to run time, with a memory for its decisions.
    ///
    /// # Errors
    ///
    /// Returns an error when a form is unstable, or the memory makes no sense.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::model_detection::{DetectionRows, Memory, ModelDetection, PlantModel};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = |gain: f64| StateSpace::new(mat![[0.8]], mat![[gain]], mat![[1.0]], mat![[0.0]], domain);
    /// let models = [PlantModel::new("in order", lag(0.2)?), PlantModel::new("worn", lag(0.1)?)];
    /// let bank = ModelDetection::new(&models, &DetectionRows::All, 5.0)?;
    /// let mut detector = bank.freeze(Memory::default())?;
    /// // The plant is worn.
    /// let (mut x, mut r) = (0.0, [0.0; 2]);
    /// for k in 0..40 {
    ///     detector.step(Frame::new(detector.io(), k, &[1.0], &[x])?, &mut r);
    ///     x = 0.8 * x + 0.1;
    /// }
    /// assert_eq!(detector.best(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn freeze(&self, memory: Memory) -> Result<ModelDetector, DesignError> {
        let members: Result<Vec<_>, _> =
            self.forms.iter().map(ResidualForm::freeze::<f64, Heap, Heap>).collect();
        ModelDetector::new(members?, memory)
    }

    fn bank(&self) -> Result<BankDesign, DesignError> {
        let boxed = |form: &ResidualForm| Box::new(form.clone()) as Box<dyn GeneratorDesign>;
        BankDesign::new(self.forms.iter().map(boxed).collect())
    }
}

/// The residuals of all models side by side. Eq. (5) holds for each with its own model only.
impl GeneratorDesign for ModelDetection<Discrete> {
    fn io(&self) -> IoDims {
        self.forms.first().map_or(IoDims { nu: 0, ny: 0 }, ResidualForm::io)
    }

    fn residual_len(&self) -> usize {
        self.forms.iter().map(ResidualForm::residual_len).sum()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        self.bank()?.form()
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        Ok(Box::new(self.freeze(Memory::default())?))
    }
}

/// A row of the bank.
struct Row<D> {
    form: ResidualForm<D>,
    reactions: Vec<f64>,
    gap: f64,
}

fn row<D: TimeDomain>(
    models: &[PlantModel<D>],
    i: usize,
    rows: &DetectionRows,
    rate: f64,
) -> Result<Row<D>, DesignError> {
    let own = &models[i];
    let form = match rows {
        DetectionRows::LeastOrder if own.noise().is_empty() => least_order(models, i, rate)?,
        DetectionRows::LeastOrder => {
            let what = "noise of a model for residuals of least order";
            return Err(DesignError::Count { what, expected: 0, found: own.noise().len() });
        }
        rows => all_rows(own, rows, rate)?,
    };
    for (j, other) in models.iter().enumerate() {
        if seen(&form, other)? == (i == j) {
            let name = |k: usize| models[k].name().to_owned();
            return Err(DesignError::SameModel { model: name(i), other: name(j) });
        }
    }
    let reactions: Result<Vec<f64>, DesignError> =
        models.iter().map(|model| reaction(&form, model)).collect();
    let mut reactions = reactions?;
    let others = |all: &[f64]| {
        let of = all.iter().enumerate().filter(|(j, _)| *j != i);
        of.map(|(_, reaction)| *reaction).fold(f64::INFINITY, f64::min)
    };
    let weakest = others(&reactions);
    if own.noise().is_empty() {
        let factor = Mat::from_fn(form.residual_len(), form.residual_len(), |i, j| {
            if i == j { weakest.recip() } else { 0.0 }
        });
        for reaction in &mut reactions {
            *reaction /= weakest;
        }
        let form = form.weighted(factor.as_ref())?;
        return Ok(Row { form, reactions, gap: f64::INFINITY });
    }
    let noise = peak_gain(&form.residual_of(&own.noise().system(own.plant())?)?)?.norm;
    Ok(Row { form, reactions, gap: weakest / noise })
}

/// The null space of a model, whitened for its noise if there is any.
fn all_rows<D: TimeDomain>(
    own: &PlantModel<D>,
    rows: &DetectionRows,
    rate: f64,
) -> Result<ResidualForm<D>, DesignError> {
    let (plant, disturbances) = (own.plant(), own.disturbances());
    let combination = |count: usize| match rows {
        DetectionRows::Combination(h) => {
            let h = Mat::from_fn(1, h.len(), |_, j| h[j]);
            check_shape("combination of residuals", h.as_ref(), Shape::new(1, count))?;
            Ok::<_, DesignError>(Some(h))
        }
        _ => Ok(None),
    };
    if own.noise().is_empty() {
        let space = LeftNullSpace::of(plant, disturbances)?;
        return match combination(space.residual_len())? {
            Some(h) => space.combined(h.as_ref())?.placed(&ErrorPoles::Rate(rate)),
            None => space.placed(&ErrorPoles::Rate(rate)),
        };
    }
    let none = UnknownInputs::none(plant);
    let exposure = Exposure { faults: &none, disturbances, noise: own.noise() };
    let form = OptimalDesign::new(plant, &exposure, rate)?.form().clone();
    match combination(form.residual_len())? {
        Some(h) => form.weighted((Scale(h.norm_l2().recip()) * h).as_ref()),
        None => Ok(form),
    }
}

/// The scalar filter of least order that is blind to model `i` and reacts to all others.
fn least_order<D: TimeDomain>(
    models: &[PlantModel<D>],
    i: usize,
    rate: f64,
) -> Result<ResidualForm<D>, DesignError> {
    let (plant, disturbances) = (models[i].plant(), models[i].disturbances());
    let natural = NaturalPlant::of(plant, disturbances)?;
    let ignored: Vec<_> = (0..disturbances.len()).collect();
    let longest = plant.nx() + disturbances.len();
    for order in 0..=longest {
        let decided = natural.window(order).decoupled_from(&ignored, RankTolerance::default())?;
        let all = decided.annihilators();
        let (mut best, mut strongest) = (None, 0.0);
        for mix in spread_rows(all.nrows()) {
            let w = mix * &all;
            let form = filter_of(plant, &natural, order, w.as_ref(), &ErrorPoles::Rate(rate))?;
            let scale = peak_gain(form.system())?.norm.recip();
            let mut weakest = f64::INFINITY;
            for (_, other) in models.iter().enumerate().filter(|(j, _)| *j != i) {
                // Never larger than before; most combinations are out after the first.
                weakest = weakest.min(scale * reaction(&form, other)?);
                if weakest <= strongest {
                    break;
                }
            }
            if strongest < weakest {
                (best, strongest) = (Some(form), weakest);
            }
        }
        // Not by rounding.
        if let Some(form) = best {
            let others = models.iter().enumerate().filter(|(j, _)| *j != i);
            let all: Result<Vec<bool>, _> = others.map(|(_, m)| seen(&form, m)).collect();
            if all?.into_iter().all(|reacts| reacts) {
                return Ok(form);
            }
        }
    }
    let (inputs, outputs) = (disturbances.len(), plant.ny());
    Err(DesignError::NothingLeft { inputs, outputs })
}

/// `[u; G_u u + G_d d]`, the signals that the plant gives a residual generator.
fn signals<D: TimeDomain>(model: &PlantModel<D>) -> Result<StateSpace<D>, DesignError> {
    let (plant, gd) = (model.plant(), model.disturbances().system(model.plant())?);
    let (nu, nd) = (plant.nu(), gd.nu());
    let pass = Mat::from_fn(nu, nu + nd, |i, j| if i == j { 1.0 } else { 0.0 });
    let none = Mat::<f64>::zeros(nu, plant.nx());
    Ok(StateSpace::new(
        plant.a().to_owned(),
        blocks(&[&[plant.b(), gd.b()]]),
        blocks(&[&[none.as_ref()], &[plant.c()]]),
        blocks(&[&[pass.as_ref()], &[blocks(&[&[plant.d(), gd.d()]]).as_ref()]]),
        plant.domain(),
    )?)
}

/// The form as a filter of `[u; y]` alike.
fn of_signals<D: TimeDomain>(form: &ResidualForm<D>) -> Result<ResidualForm<D>, DesignError> {
    let IoDims { nu, ny } = form.io();
    ResidualForm::new(IoDims { nu: 0, ny: nu + ny }, form.system().clone())
}

/// Whether a model is visible in a residual at any frequency.
fn seen<D: TimeDomain>(form: &ResidualForm<D>, model: &PlantModel<D>) -> Result<bool, DesignError> {
    let rows = weak_structure(&of_signals(form)?, &signals(model)?)?;
    Ok(rows.iter().any(|row| row.0.contains(&true)))
}

/// The largest gain from the inputs of a model to a residual.
fn reaction<D: TimeDomain>(
    form: &ResidualForm<D>,
    model: &PlantModel<D>,
) -> Result<f64, DesignError> {
    let all = signals(model)?.series(form.system())?;
    Ok(peak_gain(&all)?.norm)
}
