//! A candidate on its way through screening, short fits and full fit.

use std::sync::Arc;

use crate::{
    effect::{Candidate, EffectParameter},
    fit::{
        FitError, LeastSquares, Minimum, NullFit, Problem, Projection, Score, Search, Variable,
        Weights, minimise,
    },
    simulate::Nominal,
};

/// Starts of a candidate that get a short fit.
const SHORT_FITS: usize = 3;
/// Iterations of a short fit.
const SHORT: Search =
    Search { iterations: 3, absolute: 0.1, relative: 1e-4, frozen: usize::MAX, own_only: false };
/// Largest amplitude that a score test may ask for: laws are not linear.
const AMPLITUDE: f64 = 4.0;
/// Smallest amplitude to start from: at zero strength a shape cannot be fitted.
const SMALLEST_AMPLITUDE: f64 = 0.1;
/// Starts whose gain is below this part of the best one get no short fit.
const HOPEFUL: f64 = 0.5;

/// A candidate whose gain is below this part of the best of all gets one short fit.
const PROMISING: f64 = 0.2;

/// A candidate with its fit.
#[derive(Debug)]
pub(super) struct Trial<'a> {
    pub(super) candidate: &'a Candidate,
    /// Place among the candidates.
    pub(super) index: usize,
    pub(super) problem: Problem,
    /// Neutral values of strengths; `None` for shapes.
    pub(super) strengths: Vec<Option<f64>>,
    pub(super) best: Option<Minimum>,
    /// Scores of the starts, the best first.
    scored: Vec<(Score, Vec<f64>)>,
}

impl<'a> Trial<'a> {
    pub(super) fn new(
        nominal: &dyn Nominal,
        candidate: &'a Candidate,
        index: usize,
        null: &NullFit,
    ) -> Result<Self, FitError> {
        let plan = Arc::clone(null.problem.plan());
        let ts = null.problem.simulator().ts();
        let simulator = nominal.patched(&candidate.model, ts)?;
        let variable = |p: &EffectParameter| Variable {
            name: p.name.clone(),
            unit: p.unit.clone(),
            start: p.neutral,
            scale: p.scale,
            low: p.low,
            high: p.high,
            prior: None,
        };
        let effects = candidate.parameters.iter().map(variable).collect();
        let weights = null.problem.weights().clone();
        let problem = Problem::new(plan, simulator, effects, weights)?;
        let neutral = |p: &EffectParameter| p.is_strength.then_some(p.neutral);
        let strengths = candidate.parameters.iter().map(neutral).collect();
        Ok(Self { candidate, index, problem, strengths, best: None, scored: Vec::new() })
    }

    /// Scores every start; `lines` are the frequencies of the lines of the residual, in Hz.
    pub(super) fn screen(&mut self, null: &NullFit, projection: &Projection<'_>, lines: &[f64]) {
        let mut r = vec![0.0; self.problem.layout().residuals()];
        for start in self.starts(lines) {
            let z = self.problem.place(&null.minimum.z, &start);
            if self.problem.residuals(&z, &mut r) {
                let score = projection.score(&r, self.amplitudes(&start));
                self.scored.push((score, start));
            }
        }
        self.scored.sort_by(|a, b| b.0.gain.total_cmp(&a.0.gain));
    }

    /// Those of the candidate; where a frequency is unknown, also each of them at each line.
    fn starts(&self, lines: &[f64]) -> Vec<Vec<f64>> {
        let mut starts = self.candidate.starts.clone();
        if let (Some(i), Some(first)) = (self.candidate.spectral, starts.first().cloned()) {
            let EffectParameter { low, high, .. } = self.candidate.parameters[i];
            for line in lines.iter().filter(|line| (low..=high).contains(*line)) {
                let mut start = first.clone();
                start[i] = *line;
                starts.push(start);
            }
        }
        starts
    }

    /// What the best start could explain.
    pub(super) fn gain(&self) -> f64 {
        self.scored.first().map_or(0.0, |(score, _)| score.gain)
    }

    /// Fits the best starts a little; only one when no start could explain much of `most`, which
    /// the best of all candidates could.
    pub(super) fn short_fits(&mut self, null: &NullFit, most: f64) {
        let top = self.gain();
        let fits = if top < PROMISING * most { 1 } else { SHORT_FITS };
        for (score, start) in self.scored.clone().into_iter().take(fits) {
            if score.gain < HOPEFUL * top {
                break;
            }
            let smallest = SMALLEST_AMPLITUDE.copysign(score.amplitude);
            let amplitude =
                if score.amplitude.abs() < SMALLEST_AMPLITUDE { smallest } else { score.amplitude };
            let values = self.scaled(&start, amplitude);
            self.short_fit(null, &values);
        }
        if self.best.is_none() {
            self.fall_back(null);
        }
    }

    /// Amplitudes that keep all strengths within their bounds.
    fn amplitudes(&self, start: &[f64]) -> [f64; 2] {
        let mut range = [-AMPLITUDE, AMPLITUDE];
        let parameters = self.candidate.parameters.iter().zip(start);
        for (p, value) in parameters.filter(|(p, _)| p.is_strength) {
            let reach = value - p.neutral;
            if reach.abs() <= f64::EPSILON * p.scale {
                continue;
            }
            let (a, b) = ((p.low - p.neutral) / reach, (p.high - p.neutral) / reach);
            range = [range[0].max(a.min(b)), range[1].min(a.max(b))];
        }
        [range[0], range[1].max(range[0])]
    }

    /// A start with its strengths multiplied.
    fn scaled(&self, start: &[f64], amplitude: f64) -> Vec<f64> {
        let parameters = self.candidate.parameters.iter().zip(start);
        let value = parameters.map(|(p, value)| {
            if p.is_strength { p.neutral + amplitude * (value - p.neutral) } else { *value }
        });
        value.collect()
    }

    /// A few iterations with the slopes of the nuisances as they are without the effect.
    pub(super) fn short_fit(&mut self, null: &NullFit, values: &[f64]) {
        let z = self.problem.place(&null.minimum.z, values);
        let shared = self.problem.plan().nuisances().len();
        let mut slopes = null.minimum.slopes.clone();
        let rows = self.problem.layout().residuals();
        let new = vec![vec![0.0; rows]; self.strengths.len()];
        slopes.splice(shared..shared, new);
        let search = Search { frozen: shared, ..SHORT };
        let minimum = if shared == 0 {
            minimise(&mut self.problem, &z, None, SHORT)
        } else {
            minimise(&mut self.problem, &z, Some(&slopes), search)
        };
        self.keep(minimum);
    }

    fn keep(&mut self, minimum: Option<Minimum>) {
        let Some(minimum) = minimum else { return };
        if self.best.as_ref().is_none_or(|best| minimum.cost < best.cost) {
            self.best = Some(minimum);
        }
    }

    /// Fits everything, to the end. The effect can be absent, so that the result is never worse
    /// than that without it.
    pub(super) fn full_fit(&mut self, null: &NullFit) {
        if let Some(best) = self.best.take() {
            let minimum = minimise(&mut self.problem, &best.z, None, Search::default());
            self.best = Some(best);
            self.keep(minimum);
        }
        self.fall_back(null);
        if let Some(best) = &mut self.best {
            let columns = 0..self.problem.layout().shared + self.problem.layout().own;
            self.problem.slopes(&best.z, &best.r, columns, &mut best.slopes);
        }
    }

    /// Starts where the effect is absent, if that is better.
    fn fall_back(&mut self, null: &NullFit) {
        if self.best.as_ref().is_some_and(|best| best.cost <= null.minimum.cost) {
            return;
        }
        let parameters = self.candidate.parameters.iter();
        let neutral: Vec<f64> = parameters.map(|p| p.neutral.clamp(p.low, p.high)).collect();
        let z = self.problem.place(&null.minimum.z, &neutral);
        let minimum = minimise(&mut self.problem, &z, None, Search::default());
        self.keep(minimum);
    }

    /// Goes on from the same place with noise of another colour.
    pub(super) fn recolour(&mut self, null: &NullFit, weights: &Weights) {
        self.problem.set_weights(weights.clone());
        let Some(best) = self.best.take() else { return };
        let minimum = minimise(&mut self.problem, &best.z, None, SHORT_ALL);
        self.keep(minimum);
        self.fall_back(null);
    }

    /// The fitted parameters, as far as a law of the same label has them; the rest is neutral.
    pub(super) fn values_for(&self, other: &Candidate) -> Option<Vec<f64>> {
        let values = self.problem.effect_values(&self.best.as_ref()?.z);
        let own = &self.candidate.parameters;
        let value = |p: &EffectParameter| {
            own.iter().position(|known| known.name == p.name).map_or(p.neutral, |i| values[i])
        };
        Some(other.parameters.iter().map(value).collect())
    }

    /// A short fit from other values; says whether it is better than what was known.
    pub(super) fn warm_start(&mut self, null: &NullFit, values: &[f64]) -> bool {
        let before = self.cost();
        self.short_fit(null, values);
        self.cost() < before
    }

    pub(super) fn cost(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |best| best.cost)
    }
}

/// A short fit with all slopes.
const SHORT_ALL: Search = Search { iterations: 2, frozen: 0, ..SHORT };
