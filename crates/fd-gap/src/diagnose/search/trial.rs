//! A candidate on its way through short fits and the full fit.

use std::sync::Arc;

use fd_effect::{Candidate, EffectParameter};
use fd_sim::{model::Model, simulate::Nominal};

use super::{base::is_of_the_fit, change::Change};
use crate::{
    diagnose::prepare::step::with_step,
    fit::{
        FitError, LeastSquares, Minimum, NullFit, Problem, Score, Search, Surroundings, Variable,
        Weights, minimise, promised,
    },
};

/// Iterations of a short fit.
const SHORT: Search = Search { iterations: 3, absolute: 0.1, relative: 1e-4, ..Search::PLAIN };
/// A fit to the end: what is left is a hundredth of a nat, or a part of the errors that decides nothing far above the noise.
const FULL: Search = Search { iterations: 30, absolute: 1e-2, relative: 1e-5, ..Search::PLAIN };
/// A short fit with all slopes.
const AGAIN: Search = Search { iterations: 2, ..SHORT };
/// A candidate that promises less than this part of what the best one has gained is not fitted …
const HOPELESS: f64 = 0.1;
/// … if it is also so much less, in sums of squares.
const FAR_BELOW: f64 = 200.0;
/// A candidate whose sum of squares is above this multiple of the best is out of reach.
const OUT_OF_REACH: f64 = 1.2;

/// A sum of squares may fall by so many times what slopes promise.
pub(super) const MORE_THAN_PROMISED: f64 = 2.0;

/// Whether twice a promise is far below what another candidate has `gained`.
pub(super) fn is_hopeless(promise: f64, gained: f64) -> bool {
    let gain = MORE_THAN_PROMISED * promise;
    gain < HOPELESS * gained && gain < gained - FAR_BELOW
}

/// A start of a fit.
#[derive(Clone, Debug)]
pub(in crate::diagnose) struct ScoredStart {
    /// Values of the parameters of the effect.
    pub(super) values: Vec<f64>,
    /// Where the nuisances and the amplitude go, and what is left there.
    pub(super) score: Score,
    /// How much less that is than without any effect.
    pub(super) gain: f64,
    /// How it changes the residuals.
    pub(super) change: Change,
}

impl ScoredStart {
    /// What the first of several, the best, could explain.
    pub(super) fn gain_of(scored: &[Self]) -> f64 {
        scored.first().map_or(0.0, |start| start.gain)
    }
}

/// A candidate on its way: screened, fitted a little, fitted to the end. It is at work within the
/// functions that own it, and rests once it is part of a step.
#[derive(Debug)]
pub(in crate::diagnose) struct Trial<'a> {
    pub candidate: &'a Candidate,
    /// The model of the candidate, with the integration step that is in use.
    pub model: Model,
    /// Place among the candidates.
    pub index: usize,
    pub problem: Problem,
    /// Neutral values of strengths; `None` for shapes.
    pub strengths: Vec<Option<f64>>,
    pub best: Option<Minimum>,
    /// Whether it was fitted to the end.
    pub is_final: bool,
    /// The starts of the candidate and what they could explain, the best first.
    pub(super) scored: Vec<ScoredStart>,
}

impl<'a> Trial<'a> {
    pub(in crate::diagnose) fn new(
        nominal: &dyn Nominal,
        candidate: &'a Candidate,
        index: usize,
        null: &NullFit,
    ) -> Result<Self, FitError> {
        let plan = Arc::clone(null.problem.plan());
        let ts = null.problem.simulator().ts();
        let simulator = nominal.patched(&candidate.model, ts)?;
        let variable = Variable::effect;
        let effects = candidate.parameters.iter().map(variable).collect();
        let weights = null.problem.weights().clone();
        let problem = Problem::new(plan, simulator, effects, weights)?;
        let neutral = |p: &EffectParameter| p.is_strength.then_some(p.neutral);
        let strengths = candidate.parameters.iter().map(neutral).collect();
        let model = candidate.model.clone();
        Ok(Self {
            candidate,
            model,
            index,
            problem,
            strengths,
            best: None,
            is_final: false,
            scored: Vec::new(),
        })
    }

    /// Fits a little from the best start. Where runs are dear that is done to the end on the stand-in, which costs none,
    /// and one run shows what the simulator is there.
    pub(in crate::diagnose) fn first_fit(&mut self, null: &NullFit, around: &Surroundings<'_>) {
        if !self.problem.begins_on_stand_in() {
            self.fit_from_start(null, around);
            if self.best.is_none() {
                self.fall_back(null);
            }
            return;
        }
        let dear = self.problem.clone();
        self.problem = dear.clone().on_stand_in();
        self.fit_from_start(null, around);
        let found = match self.best.take() {
            Some(best) => minimise(&mut self.problem, &best.z, None, FULL).unwrap_or(best).z,
            None => self.problem.place(&null.minimum.z, &self.neutral()),
        };
        self.problem = dear;
        self.best = minimise(&mut self.problem, &found, None, Search::LOOK);
        if self.best.is_none() {
            self.fall_back(null);
        }
    }

    /// A few iterations from the best start.
    fn fit_from_start(&mut self, null: &NullFit, around: &Surroundings<'_>) {
        let Some(ScoredStart { values, score, .. }) = self.scored.first() else { return };
        let place = self.problem.place(&score.nuisances, &self.scaled(values, score.amplitude));
        let fitted = is_of_the_fit(around, null).then_some(around.at());
        self.short_fit(fitted, &place, SHORT);
    }

    /// A few iterations from a place, with the slopes of the nuisances as they are at a `base` without the effect, if any
    /// is near.
    fn short_fit(&mut self, base: Option<&Minimum>, place: &[f64], search: Search) {
        let shared = self.problem.plan().nuisances().len();
        let known = base.filter(|_| 0 < shared).map(|base| {
            let mut slopes = base.slopes.clone();
            let rows = self.problem.layout().residuals();
            let new = vec![vec![0.0; rows]; self.strengths.len()];
            slopes.splice(shared..shared, new);
            slopes
        });
        let frozen = if known.is_some() { shared } else { 0 };
        let search = self.patient(Search { frozen, ..search });
        let minimum = minimise(&mut self.problem, place, known.as_ref(), search);
        self.keep(minimum);
    }

    /// The same from values of the effect, where the nuisances are as they are without it.
    fn short_fit_from(&mut self, null: &NullFit, values: &[f64]) {
        let place = self.problem.place(&null.minimum.z, values);
        self.short_fit(Some(&null.minimum), &place, self.short());
    }

    /// A search that is not more patient than runs are cheap.
    fn patient(&self, search: Search) -> Search {
        if self.problem.is_dear() { search.of_dear_runs() } else { search }
    }

    pub(super) fn keep(&mut self, minimum: Option<Minimum>) {
        let Some(minimum) = minimum else { return };
        if self.best.as_ref().is_none_or(|best| minimum.cost < best.cost) {
            self.best = Some(self.lean(minimum));
        }
    }

    /// Without its slopes, unless runs are so dear that these must not be computed again.
    fn lean(&self, minimum: Minimum) -> Minimum {
        if self.problem.is_dear() { minimum } else { minimum.condensed(&self.problem) }
    }

    /// Fits everything, to the end. The effect can be absent, so that the result is never worse
    /// than that without it.
    pub(in crate::diagnose) fn full_fit(&mut self, null: &NullFit) {
        self.is_final = true;
        if let Some(best) = self.best.take() {
            // From the same place, so never worse, and with all slopes.
            let search = self.patient(FULL);
            let minimum = minimise(&mut self.problem, &best.z, None, search);
            self.best = minimum.map(|minimum| self.lean(minimum)).or(Some(best));
        }
        self.fall_back(null);
    }

    /// A short fit; where fits have begun on the stand-in, a look at the simulator.
    fn short(&self) -> Search {
        if self.problem.begins_on_stand_in() { Search::LOOK } else { SHORT }
    }

    /// Starts where the effect is absent, if that is better.
    fn fall_back(&mut self, null: &NullFit) {
        if self.best.as_ref().is_some_and(|best| best.cost <= null.minimum.cost) {
            return;
        }
        self.short_fit_from(null, &self.neutral());
    }

    /// The effect is absent.
    pub(super) fn neutral(&self) -> Vec<f64> {
        self.candidate.parameters.iter().map(|p| p.neutral.clamp(p.low, p.high)).collect()
    }

    /// Goes on from the same place with noise of another colour; a candidate that is out of reach
    /// of the `best` sum of squares stays there.
    pub(in crate::diagnose) fn recolour(&mut self, null: &NullFit, weights: &Weights, best: f64) {
        let iterations = if OUT_OF_REACH * best < self.cost() { 0 } else { AGAIN.iterations };
        self.problem.set_weights(weights.clone());
        let Some(best) = self.best.take() else { return };
        let search = Search { iterations, ..AGAIN };
        let search = self.patient(search);
        let minimum = minimise(&mut self.problem, &best.z, None, search);
        self.keep(minimum);
        self.fall_back(null);
    }

    /// Goes on from the same place with another integration step, at which `base` was fitted, too.
    pub(in crate::diagnose) fn refine(
        &mut self,
        nominal: &dyn Nominal,
        step: f64,
        base: &NullFit,
    ) -> Result<(), FitError> {
        let model = with_step(&self.model, step);
        let simulator = nominal.patched(&model, self.problem.simulator().ts())?;
        let (plan, effects) = (Arc::clone(self.problem.plan()), self.problem.effects().to_vec());
        self.problem = Problem::new(plan, simulator, effects, self.problem.weights().clone())?;
        self.model = model;
        if let Some(best) = self.best.take() {
            self.best = minimise(&mut self.problem, &best.z, None, AGAIN);
        }
        self.full_fit(base);
        Ok(())
    }

    /// The fitted parameters, as far as a law of the same label has them; the rest is neutral.
    pub(in crate::diagnose) fn values_for(&self, other: &Candidate) -> Option<Vec<f64>> {
        let values = self.problem.effect_values(&self.best.as_ref()?.z);
        let own = &self.candidate.parameters;
        let value = |p: &EffectParameter| {
            own.iter().position(|known| known.name == p.name).map_or(p.neutral, |i| values[i])
        };
        Some(other.parameters.iter().map(value).collect())
    }

    /// A short fit from other values; says whether it is better than what was known.
    pub(in crate::diagnose) fn warm_start(&mut self, null: &NullFit, values: &[f64]) -> bool {
        let before = self.cost();
        self.short_fit_from(null, values);
        self.cost() < before
    }

    /// The same from other nuisances as well, which may have moved far with these values.
    pub(in crate::diagnose) fn warm_start_at(&mut self, nuisances: &[f64], values: &[f64]) -> bool {
        let before = self.cost();
        let place = self.problem.place(nuisances, values);
        let search = self.patient(AGAIN);
        let minimum = minimise(&mut self.problem, &place, None, search);
        self.keep(minimum);
        self.cost() < before
    }

    /// Whether it is out of reach of the `best` sum of squares, however much lower its slopes promise to bring it, and
    /// runs are too dear to see how far.
    pub(super) fn is_not_worth_a_run(&self, best: f64) -> bool {
        let Some(here) = self.best.as_ref().filter(|_| self.problem.is_dear()) else {
            return false;
        };
        let promised =
            if self.problem.begins_on_stand_in() { promised(&self.problem, here) } else { 0.0 };
        let lowest = here.cost - MORE_THAN_PROMISED * promised;
        OUT_OF_REACH * best < lowest && best + FAR_BELOW < lowest
    }

    pub(in crate::diagnose) fn cost(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |best| best.cost)
    }
}
