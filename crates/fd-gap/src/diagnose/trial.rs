//! A candidate on its way through screening, short fits and full fit.

use std::sync::Arc;

use fd_effect::{Candidate, EffectParameter};
use fd_sim::{model::Model, simulate::Nominal};

use super::{command::Command, prepare::with_step};
use crate::fit::{
    FitError, LeastSquares, Minimum, NullFit, Problem, Projection, Score, Search, Variable,
    Weights, minimise, minimise_all,
};

/// Starts of a candidate that get a short fit.
const SHORT_FITS: usize = 3;
/// Iterations of a short fit.
const SHORT: Search =
    Search { iterations: 3, absolute: 0.1, relative: 1e-4, frozen: usize::MAX, own_only: false };
/// A fit to the end: what is left is a hundredth of a nat.
const FULL: Search =
    Search { iterations: 30, absolute: 1e-2, relative: 1e-6, frozen: 0, own_only: false };
/// A short fit with all slopes.
const AGAIN: Search = Search { iterations: 2, frozen: 0, ..SHORT };
/// Largest amplitude that a score test may ask for: laws are not linear.
const AMPLITUDE: f64 = 4.0;
/// Smallest amplitude to start from: at zero strength a shape cannot be fitted.
const SMALLEST_AMPLITUDE: f64 = 0.1;
/// Starts whose gain is below this part of the best one get no short fit.
const HOPEFUL: f64 = 0.5;

/// A candidate whose gain is below this part of the best of all gets one short fit.
const PROMISING: f64 = 0.2;

/// A candidate whose gain is below this part of the best of all gets one iteration of it.
const HOPELESS: f64 = 0.02;
/// A gain that is hopeless must also be so much less than the best, in sums of squares.
const FAR_BELOW: f64 = 200.0;
/// A candidate whose sum of squares is above this multiple of the best is out of reach.
const OUT_OF_REACH: f64 = 1.2;

/// Fewest and most eighths of a quantum per peak of a command that are tried where its
/// [`Command`] is not known.
const EIGHTHS: [u16; 2] = [64, 480];
/// The best quantum is refined so often …
const ROUGH_ROUNDS: usize = 2;
/// … with so many points on either side, up to its neighbour.
const ROUGH_POINTS: i32 = 8;
/// Starts that are simulated at a time: their residuals must fit into memory.
const AT_A_TIME: usize = 16;

/// A candidate with its fit.
#[derive(Debug)]
pub(super) struct Trial<'a> {
    pub(super) candidate: &'a Candidate,
    /// The model of the candidate, with the integration step that is in use.
    pub(super) model: Model,
    /// Place among the candidates.
    pub(super) index: usize,
    pub(super) problem: Problem,
    /// Neutral values of strengths; `None` for shapes.
    pub(super) strengths: Vec<Option<f64>>,
    pub(super) best: Option<Minimum>,
    /// Whether it was fitted to the end.
    pub(super) is_final: bool,
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

    /// Scores every start; `lines` are the frequencies of the lines of the residual, in Hz, and
    /// `command` is that of the input of the candidate.
    pub(super) fn screen(
        &mut self,
        null: &NullFit,
        projection: &Projection<'_>,
        lines: &[f64],
        command: Option<&Command>,
    ) {
        let mut starts = self.starts(lines);
        if let Some(rounding) = self.candidate.rounding {
            let peak = self.candidate.parameters[0].scale;
            let quanta = command.map_or_else(
                || (EIGHTHS[0]..=EIGHTHS[1]).map(|n| 8.0 * peak / f64::from(n)).collect(),
                |command| command.quanta(rounding, peak),
            );
            starts.extend(quanta.into_iter().map(|quantum| vec![quantum]));
        }
        self.score(null, projection, &starts);
        if self.candidate.rounding.is_some() {
            for _ in 0..ROUGH_ROUNDS {
                let Some((_, best)) = self.scored.first() else { return };
                let ratio = |(_, other): &(Score, Vec<f64>)| (other[0] / best[0] - 1.0).abs();
                let others = self.scored.iter().skip(1).map(ratio).filter(|r| 0.0 < *r);
                // An eighth of a quantum at the peak, or as far as the next one that was tried.
                let eighth = 0.125 * best[0] / self.candidate.parameters[0].scale;
                let half_width = others.fold(eighth, f64::min);
                let near = (-ROUGH_POINTS..=ROUGH_POINTS).filter(|i| *i != 0).map(|i| {
                    let factor = 1.0 + half_width * f64::from(i) / f64::from(ROUGH_POINTS + 1);
                    self.scaled(best, factor)
                });
                let near: Vec<Vec<f64>> = near.collect();
                self.score(null, projection, &near);
            }
        }
    }

    /// Scores starts, and sorts all by what they could explain.
    fn score(&mut self, null: &NullFit, projection: &Projection<'_>, starts: &[Vec<f64>]) {
        for starts in starts.chunks(AT_A_TIME) {
            let place = |start: &Vec<f64>| self.problem.place(&null.minimum.z, start);
            let places: Vec<Vec<f64>> = starts.iter().map(place).collect();
            for (start, r) in starts.iter().zip(self.problem.residuals_of_all(&places)) {
                if let Some(r) = r {
                    let score = projection.score(&r, self.amplitudes(start));
                    self.scored.push((score, start.clone()));
                }
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
        let hopeful = self.scored.iter().take(fits);
        let mut starts: Vec<Vec<f64>> = hopeful
            .take_while(|(score, _)| HOPEFUL * top <= score.gain)
            .map(|(score, start)| {
                let smallest = SMALLEST_AMPLITUDE.copysign(score.amplitude);
                let is_small = score.amplitude.abs() < SMALLEST_AMPLITUDE;
                self.scaled(start, if is_small { smallest } else { score.amplitude })
            })
            .collect();
        let is_hopeless = top < HOPELESS * most && top < most - FAR_BELOW;
        let search = if is_hopeless { Search { iterations: 1, ..SHORT } } else { SHORT };
        if is_hopeless {
            // So that one step is never worse than none.
            starts.push(self.neutral());
        }
        self.short_fit(null, &starts, search);
        if self.best.is_none() {
            self.fall_back(null);
        }
    }

    /// Amplitudes that keep all strengths within their bounds.
    fn amplitudes(&self, start: &[f64]) -> [f64; 2] {
        // A limit that is moved a little may cut off nothing at all.
        let is_limit = self.candidate.parameters.iter().any(|p| p.is_strength && p.is_reciprocal);
        if self.candidate.rounding.is_some() || is_limit {
            return [1.0, 1.0];
        }
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

    /// A few iterations from each start, with the slopes of the nuisances as they are without the
    /// effect.
    pub(super) fn short_fit(&mut self, null: &NullFit, starts: &[Vec<f64>], search: Search) {
        let place = |values: &Vec<f64>| self.problem.place(&null.minimum.z, values);
        let places: Vec<Vec<f64>> = starts.iter().map(place).collect();
        let shared = self.problem.plan().nuisances().len();
        let mut slopes = null.minimum.slopes.clone();
        let rows = self.problem.layout().residuals();
        let new = vec![vec![0.0; rows]; self.strengths.len()];
        slopes.splice(shared..shared, new);
        let search = Search { frozen: shared, ..search };
        let known = if shared == 0 { None } else { Some(slopes.as_slice()) };
        for minimum in minimise_all(&mut self.problem, &places, known, search) {
            self.keep(minimum);
        }
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
        self.is_final = true;
        if let Some(best) = self.best.take() {
            // From the same place, so never worse, and with all slopes.
            let minimum = minimise(&mut self.problem, &best.z, None, FULL);
            self.best = minimum.or(Some(best));
        }
        self.fall_back(null);
    }

    /// Starts where the effect is absent, if that is better.
    fn fall_back(&mut self, null: &NullFit) {
        if self.best.as_ref().is_some_and(|best| best.cost <= null.minimum.cost) {
            return;
        }
        self.short_fit(null, &[self.neutral()], SHORT);
    }

    /// The effect is absent.
    fn neutral(&self) -> Vec<f64> {
        self.candidate.parameters.iter().map(|p| p.neutral.clamp(p.low, p.high)).collect()
    }

    /// Goes on from the same place with noise of another colour; a candidate that is out of reach
    /// of the `best` sum of squares stays there.
    pub(super) fn recolour(&mut self, null: &NullFit, weights: &Weights, best: f64) {
        let iterations = if OUT_OF_REACH * best < self.cost() { 0 } else { AGAIN.iterations };
        self.problem.set_weights(weights.clone());
        let Some(best) = self.best.take() else { return };
        let search = Search { iterations, ..AGAIN };
        let minimum = minimise(&mut self.problem, &best.z, None, search);
        self.keep(minimum);
        self.fall_back(null);
    }

    /// Goes on from the same place with another integration step, at which `base` was fitted, too.
    pub(super) fn refine(
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
        self.short_fit(null, &[values.to_vec()], SHORT);
        self.cost() < before
    }

    pub(super) fn cost(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |best| best.cost)
    }
}
