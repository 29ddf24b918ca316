//! What sets of effects are fitted to, and how they are compared.

use std::sync::Arc;

use fd_effect::Candidate;

use super::{
    Wanted, beside,
    set::{EffectSet, chained},
};
use crate::{
    diagnose::{
        candidates::{Candidates, is_law},
        case::Case,
        context::Context,
        judge::{Entrant, horizons, standings},
        monitor::Monitor,
        prepare::{prepared, start::in_motion},
        result::{Cause, Diagnosis},
        search::searched::Searched,
        settings::Settings,
        weigh::{
            colour::{colour_of, with_colour},
            singles::{Singles, weigh_singles},
            slow::with_slow,
            values::FittedValues,
        },
    },
    evidence::{SEPARATED, distance, probabilities},
    fit::{FitError, Horizon, Log},
    quality::REACHED,
    shrink::{Forecasts, Rules, Settled, as_begun, forecast_errors},
};

/// Nothing is tried but sets.
static NOTHING: Candidates =
    Candidates { simulated: Vec::new(), measured: Vec::new(), refused: Vec::new() };

/// The logs, the noise and the fit without any effect that sets of effects are compared by, after a diagnosis.
///
/// Effects that a log shows together are found together, each beside the others:
///
/// ```
/// use fd_effect::{Candidate, EverySite, library};
/// use fd_gap::diagnose::{Case, SetSearch, Settings, Wanted, diagnose};
/// use fd_model::Record;
/// use fd_sim::{model::Model, scales::ReplayScales};
///
/// let lag: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "V" } }
/// outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// states = { x = { unit = "V", initial = 0.0, derivative = "u - x" } }
/// "#.parse()?;
/// // In reality the sensor has a bias of 0.2 V, and the amplifier delivers 10 % less.
/// let ts = lag.sample_time()?;
/// let (mut x, mut rows) = (0.0, Vec::new());
/// for k in 0..300_u32 {
///     let (u, k) = ((0.05 * f64::from(k)).sin() + 0.3, f64::from(k));
///     rows.push(([u], [x + 0.2 + 0.0173 * ((k * k * 0.618).sin().asin() / 1.5708)]));
///     x = 0.9 * u + (-0.1_f64).exp() * (x - 0.9 * u);
/// }
/// let logs = [Record::from_rows(lag.external_inputs(), lag.output_channels(), rows, ts)?];
/// let mut effects = library();
/// effects.retain(|effect| ["sensor-bias", "input-gain"].contains(&effect.label()));
/// let u: Vec<f64> = logs[0].samples().flat_map(|(u, _)| u.to_vec()).collect();
/// let suspects = EverySite::new(effects, &lag, ReplayScales::of(&lag, ts, &u, u.len())?);
/// let case = Case { nominal: &lag, suspects: &suspects, logs: &logs, held_out: &[] };
/// let settings = Settings::default();
/// let first = diagnose(&case, &settings, &())?;
///
/// let search = SetSearch::new(&case, &first, None, false, &settings, &())?;
/// let none = search.none()?;
/// let named = |label: &'static str| move |candidate: &Candidate| candidate.label == label;
/// let bias = named("sensor-bias");
/// let one = search.beside(&none, &Wanted { candidate: &bias, least: 0.0 })?.swap_remove(0);
/// let gain = named("input-gain");
/// let both = search.beside(&one, &Wanted { candidate: &gain, least: 0.0 })?.swap_remove(0);
/// assert!(!search.is_noise(&one) && search.is_noise(&both));
/// assert!(both.cost() < one.cost() && 5.0 < search.gain(&both, &one));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// *When not to use:* instead of a diagnosis. It needs one, for the noise, the beginnings and the step of integration.
pub struct SetSearch<'a> {
    case: Case<'a>,
    /// Those for one effect at a time.
    settings: Settings,
    monitor: &'a dyn Monitor,
    /// The fit without any effect; no causes.
    singles: Singles<'a>,
    /// Whether fits are made in windows, the free run being lost.
    pub(crate) is_in_windows: bool,
    held_out: Vec<Log>,
    /// Horizon at which forecasts judge; `None` without held-out logs.
    horizon: Option<Horizon>,
    /// Horizons at which causes compete.
    horizons: Vec<Horizon>,
}

impl<'a> SetSearch<'a> {
    /// With the beginnings and the integration step of the `first` diagnosis, and in its windows if they
    /// `may_be_in_windows`; forecasts are judged at this horizon.
    ///
    /// # Errors
    ///
    /// Returns an error when the model cannot be simulated or does not fit the logs.
    pub fn new(
        case: &Case<'a>,
        first: &Diagnosis,
        horizon: Option<Horizon>,
        may_be_in_windows: bool,
        settings: &Settings,
        monitor: &'a dyn Monitor,
    ) -> Result<Self, FitError> {
        let settings = Settings { beginning: first.beginning(), ..settings.for_one_law() };
        let begin = |horizon| {
            let prepared = prepared(case, first.refit.model.step, horizon)?;
            let free = in_motion(&prepared, case, &settings)?;
            Ok::<_, FitError>(free.unwrap_or(prepared))
        };
        let mut start = begin(settings.horizon)?;
        let simulator = start.null.problem.simulator().boxed();
        let logs =
            Log::held_out(case.held_out, &*simulator, case.logs, &start.null.problem.plan().logs)?;
        let horizons = horizons::memory(&*simulator, &start.null, &logs);
        let windows = first.windows.filter(|_| may_be_in_windows);
        if let Some(windows) = windows {
            start = begin(windows)?;
        }
        let is_in_windows = windows.is_some();
        let settings = start.with_chance(&settings);
        let (model, null, noise) = (start.model, start.null, start.noise);
        let searched = Searched {
            model,
            null,
            noise,
            screening: 0,
            changes: Arc::default(),
            trials: vec![],
            not_tested: vec![],
            is_coloured: false,
        };
        let singles = weigh_singles(searched, &NOTHING)?;
        let held_out = logs;
        let case = *case;
        Ok(Self { case, settings, monitor, singles, is_in_windows, held_out, horizon, horizons })
    }

    fn context(&self) -> Context<'_> {
        let Self { case, settings, monitor, .. } = self;
        Context { case: *case, candidates: &NOTHING, settings, monitor: *monitor }
    }

    /// Whether nobody wants to wait any longer.
    pub(crate) fn is_stopped(&self) -> bool {
        self.monitor.is_stopped()
    }

    /// How it is made.
    pub(crate) fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Noise of each output, in its unit.
    pub(crate) fn sigma(&self) -> &[f64] {
        &self.singles.searched.noise.sigma
    }

    /// Values that were measured.
    pub(crate) fn measured(&self) -> usize {
        self.singles.base.plan().measured()
    }

    /// Whether a cause is a law that can be in a set.
    pub(crate) fn is_law(&self, cause: &Cause) -> bool {
        is_law(&self.case, cause)
    }

    /// No effect.
    ///
    /// # Errors
    ///
    /// Returns an error when the model diverges.
    pub fn none(&self) -> Result<EffectSet, FitError> {
        EffectSet::none(&self.singles).ok_or(FitError::Diverged)
    }

    /// These causes together, from what was found of them; `None` where one cannot be beside the others.
    pub(crate) fn of_causes(&self, causes: &[Cause]) -> Option<EffectSet> {
        let is_it = |i: usize, c: &Candidate| {
            c.identity() == causes[i].identity() && c.law == causes[i].law
        };
        let step = self.singles.searched.model.step;
        let members = chained(causes.len(), is_it, step, &self.context())?;
        let values: Vec<f64> =
            causes.iter().flat_map(|cause| cause.parameters.iter().map(|p| p.value)).collect();
        let null = &self.singles.searched.null.minimum;
        EffectSet::fitted(members, &null.z, &values, &self.singles, &self.context())
    }

    /// The members of a set at these places alone, in this order, fitted from where they are.
    #[must_use]
    pub fn only(&self, set: &EffectSet, places: &[usize]) -> Option<EffectSet> {
        set.only(places, &self.singles, &self.context())
    }

    /// The set without a member, fitted from where it is.
    pub(crate) fn without(&self, set: &EffectSet, place: usize) -> Option<EffectSet> {
        let others: Vec<usize> = (0..set.members.len()).filter(|other| *other != place).collect();
        self.only(set, &others)
    }

    /// The set with an integration step on which its outputs do not depend.
    pub(crate) fn in_short_steps(&self, set: EffectSet) -> EffectSet {
        set.in_short_steps(&self.singles, &self.context())
    }

    /// The set with one more effect each, the most evidence first.
    ///
    /// # Errors
    ///
    /// Returns an error when the set cannot be simulated.
    pub fn beside(&self, set: &EffectSet, wanted: &Wanted<'_>) -> Result<Vec<EffectSet>, FitError> {
        beside(set, wanted, &self.singles, &self.context())
    }

    /// Whether a set leaves so much more than noise that likelihoods are no use.
    pub(crate) fn is_far(&self, set: &EffectSet) -> bool {
        set.errors().is_none_or(|errors| self.singles.searched.noise.is_far(&errors))
    }

    /// Whether a set leaves nothing but noise.
    #[must_use]
    pub fn is_noise(&self, set: &EffectSet) -> bool {
        let left = set.answer().map(|answer| self.singles.lack_of_fit(&answer));
        left.is_some_and(|left| !left.is_unexplained) && !self.is_far(set)
    }

    /// Logarithm of the evidence of a set over that of another, of which it has all members but one: near the noise in that
    /// of any colour, which would be explained by effects otherwise.
    #[must_use]
    pub fn gain(&self, set: &EffectSet, without: &EffectSet) -> f64 {
        let Searched { noise, is_coloured, .. } = &self.singles.searched;
        let is_near = set.errors().is_some_and(|errors| noise.reach(&errors) <= REACHED);
        let in_colour =
            || Some(set.evidence_in_colour(noise)? - without.evidence_in_colour(noise)?);
        let coloured = if is_near && !is_coloured { in_colour() } else { None };
        coloured.unwrap_or(set.log_evidence - without.log_evidence)
    }

    /// The same search with noise of the colour of what a set leaves; `None` where that is white.
    pub(crate) fn coloured(&self, set: &EffectSet) -> Result<Option<Self>, FitError> {
        let left = set.errors().ok_or(FitError::Diverged)?;
        let Searched { model, null, is_coloured, .. } = &self.singles.searched;
        let searched = Searched {
            model: model.clone(),
            null: null.clone(),
            noise: with_slow(&self.singles.searched, &left)?,
            screening: 0,
            changes: Arc::clone(&self.singles.searched.changes),
            trials: vec![],
            not_tested: vec![],
            is_coloured: *is_coloured,
        };
        let Some(weights) = colour_of(&searched, &searched.noise, &left) else { return Ok(None) };
        let searched = with_colour(searched, &weights, self.settings.finalists)?;
        Ok(Some(Self {
            singles: weigh_singles(searched, &NOTHING)?,
            settings: self.settings.clone(),
            held_out: self.held_out.clone(),
            horizons: self.horizons.clone(),
            ..*self
        }))
    }

    /// Whether the logs cannot tell two sets apart, of which the second has not much less evidence.
    #[must_use]
    pub fn are_tied(&self, set: &EffectSet, rival: &EffectSet) -> bool {
        let [a, b] = [&set.fit, &rival.fit];
        set.log_evidence - rival.log_evidence < self.settings.bayes_factor.ln()
            && distance(&a.problem, &a.minimum, &b.problem, &b.minimum) < SEPARATED
    }

    /// Probabilities of answers with this evidence, of which each is as likely before the data.
    pub(crate) fn shares(&self, evidence: &[f64]) -> Vec<f64> {
        let answers: Vec<(f64, f64)> = evidence.iter().map(|evidence| (*evidence, 1.0)).collect();
        probabilities(&answers, self.settings.temperature)
    }

    /// Errors of held-out forecasts of a set, in sigma; `None` without held-out logs, or where it diverges.
    pub(crate) fn forecast(&self, set: &EffectSet) -> Result<Option<Vec<Vec<Vec<f64>>>>, FitError> {
        let Some(horizon) = self.horizon else { return Ok(None) };
        let simulator = self.singles.base.simulator();
        let values = FittedValues::of(&set.fit.problem, &set.fit.minimum);
        let (logs, sigma) = (self.held_out.clone(), self.sigma());
        let logs = as_begun(simulator, values.settled(), logs, sigma)?;
        forecast_errors(simulator, values.settled(), &logs, horizon, sigma)
    }

    /// What a set and those with one more effect each forecast, from where held-out logs begin for the set.
    pub(crate) fn round(&self, set: &EffectSet, more: Vec<EffectSet>) -> Result<Round, FitError> {
        let simulator = self.singles.base.simulator();
        let fits = std::iter::once(set).chain(&more).map(|set| &set.fit);
        let values: Vec<FittedValues<'_>> =
            fits.map(|fit| FittedValues::of(&fit.problem, &fit.minimum)).collect();
        let settled: Vec<Settled<'_>> = values.iter().map(FittedValues::settled).collect();
        let held_out = as_begun(simulator, settled[0], self.held_out.clone(), self.sigma())?;
        let training = &self.singles.base.plan().logs;
        let logs: [&[Log]; 2] = [training, &held_out];
        let (horizons, sigma) = (&self.horizons, self.sigma());
        let forecasts = Forecasts::of(simulator, &settled, &logs, horizons, sigma)?;
        Ok(Round { more, forecasts })
    }

    /// How probable each cause of a round is by these forecasts, above this floor, and the place of its best law.
    pub(crate) fn standings(
        &self,
        round: &Round,
        forecasts: &Forecasts,
        floor: f64,
    ) -> Vec<(usize, f64)> {
        let mut causes: Vec<&Candidate> = Vec::new();
        let entrants = round.more.iter().filter_map(|set| {
            let last = set.members.last()?;
            let known = causes.iter().position(|known| known.identity() == last.identity());
            let cause = known.unwrap_or_else(|| {
                causes.push(last);
                causes.len() - 1
            });
            Some(Entrant { cause, cost: set.cost() })
        });
        let entrants: Vec<Entrant> = entrants.collect();
        let Settings { replicas, seed, .. } = self.settings;
        let contest = forecasts.contest(&Rules { floor, replicas, seed });
        let each = standings(causes.len(), &entrants, &contest).causes.into_iter();
        each.filter_map(|standing| Some((standing.best?, standing.probability))).collect()
    }
}

/// Sets with one more effect each than one that they compete to follow.
pub(crate) struct Round {
    pub more: Vec<EffectSet>,
    /// Of the set without any of them, and of each.
    pub forecasts: Forecasts,
}
