//! How much a candidate could explain beyond the nuisance parameters, start by start, before any fit.

use fd_effect::EffectParameter;

use super::{
    change::Change,
    command::Command,
    trial::{ScoredStart, Trial},
};
use crate::fit::{AT_A_TIME, NullFit, Surroundings};

/// Largest amplitude that a score test may ask for: laws are not linear.
const AMPLITUDE: f64 = 4.0;
/// Fewest and most eighths of a quantum per peak of a command that are tried where its
/// [`Command`] is not known.
const EIGHTHS: [u16; 2] = [64, 480];
/// The best quantum is refined so often …
const ROUGH_ROUNDS: usize = 2;
/// … with so many points on either side, up to its neighbour.
const ROUGH_POINTS: i32 = 8;

impl Trial<'_> {
    /// Scores every start; `lines` are the frequencies of the lines of the residual, in Hz, and
    /// `command` is that of the input of the candidate.
    pub(in crate::diagnose) fn screen(
        &mut self,
        null: &NullFit,
        around: &Surroundings<'_>,
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
        self.score(null, around, &starts);
        if self.candidate.rounding.is_some() {
            for _ in 0..ROUGH_ROUNDS {
                let Some(ScoredStart { values: best, .. }) = self.scored.first() else { return };
                let ratio = |other: &ScoredStart| (other.values[0] / best[0] - 1.0).abs();
                let others = self.scored.iter().skip(1).map(ratio).filter(|r| 0.0 < *r);
                // An eighth of a quantum at the peak, or as far as the next one that was tried.
                let eighth = 0.125 * best[0] / self.candidate.parameters[0].scale;
                let half_width = others.fold(eighth, f64::min);
                let near = (-ROUGH_POINTS..=ROUGH_POINTS).filter(|i| *i != 0).map(|i| {
                    let factor = 1.0 + half_width * f64::from(i) / f64::from(ROUGH_POINTS + 1);
                    self.scaled(best, factor)
                });
                let near: Vec<Vec<f64>> = near.collect();
                self.score(null, around, &near);
            }
        }
        self.scored.truncate(1);
    }

    /// Scores starts, and sorts all by what they could explain.
    fn score(&mut self, null: &NullFit, around: &Surroundings<'_>, starts: &[Vec<f64>]) {
        let at = around.at();
        let neutral = self.problem.place(&at.z, &self.neutral());
        self.problem.go_on(true);
        for starts in starts.chunks(AT_A_TIME) {
            let place = |start: &Vec<f64>| self.problem.place(&at.z, start);
            let places: Vec<Vec<f64>> = starts.iter().map(place).collect();
            let found = self.problem.residuals_beside([&neutral, &at.r], &places);
            for (start, r) in starts.iter().zip(found) {
                let Some(mut change) = r else { continue };
                change.iter_mut().zip(&at.r).for_each(|(r, before)| *r -= before);
                let range = self.amplitudes(start);
                let Some(score) = around.score(&change, range) else { continue };
                let gain = (null.minimum.cost.min(around.left()) - score.left).max(0.0);
                let change = Change::new(range, &change);
                self.scored.push(ScoredStart { values: start.clone(), score, gain, change });
            }
            self.scored.sort_by(|a, b| b.gain.total_cmp(&a.gain));
            // What will not be fitted is not remembered.
            let others = self.scored.iter_mut().skip(1);
            others.for_each(|start| start.change = Change::default());
        }
        self.problem.go_on(false);
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

    /// Amplitudes that keep all strengths within their bounds.
    pub(super) fn amplitudes(&self, start: &[f64]) -> [f64; 2] {
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
    pub(super) fn scaled(&self, start: &[f64], amplitude: f64) -> Vec<f64> {
        let parameters = self.candidate.parameters.iter().zip(start);
        let value = parameters.map(|(p, value)| {
            if p.is_strength { p.neutral + amplitude * (value - p.neutral) } else { *value }
        });
        value.collect()
    }
}
