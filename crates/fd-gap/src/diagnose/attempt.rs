//! One attempt at an answer: singles, the colour of the noise, pairs.

use fd_effect::Candidate;
use fd_sim::model::Model;

use super::{
    answer::{Answer, Rest},
    case::Case,
    explain::explain,
    judge::worth,
    misfit::CATCH_ALL,
    monitor::Monitor,
    observe::{Observed, observe},
    offered::Offered,
    pairs::{Duo, PAIR, Workshop, learn, seek_pairs},
    prepare::{KnownNoise, Prepared, prepare},
    rank::{Ranking, Yardstick, rank},
    search::{Found, search},
    settings::Settings,
    steps::refine,
};
use crate::{
    evidence::{NoisePrior, evidence, likelihood},
    fit::{FitError, Horizon, Problem},
};

/// Errors within this many times the noise may be noise of another colour.
pub(super) const REACHED: f64 = 2.0;
/// Errors above this many times the noise leave room for a second effect, which must be looked for
/// before the noise gets a colour that hides it.
const NEAR: f64 = 1.15;
/// Log-likelihood that something else could gain from which second causes are tried.
const SOMETHING: f64 = 3.0;

/// How deep to look.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// Single causes with white noise: what a wrong model leaves is no noise.
    Singles,
    /// Pairs, and noise with a colour.
    All,
}

/// Everything that was fitted and weighed.
#[derive(Debug)]
pub(super) struct Attempt<'a> {
    /// The nominal model with the integration step that is in use.
    pub(super) model: Model,
    pub(super) noise: KnownNoise,
    pub(super) found: Found<'a>,
    pub(super) weighing: Weighing<'a>,
    pub(super) duos: Vec<Duo>,
    pub(super) best: Answer,
    pub(super) rest: Rest,
}

/// Single causes, weighed with the noise as it is taken to be.
#[derive(Debug)]
pub(super) struct Weighing<'a> {
    pub(super) base: Problem,
    pub(super) refitted: Answer,
    pub(super) priors: Vec<NoisePrior>,
    /// Logarithm of the evidence of "no gap".
    pub(super) reference: f64,
    pub(super) observed: Vec<(&'a Candidate, Observed)>,
    pub(super) causes: Ranking,
}

impl<'a> Weighing<'a> {
    fn of(
        found: &mut Found<'a>,
        model: &Model,
        noise: &KnownNoise,
        observations: &'a [Candidate],
    ) -> Result<Self, FitError> {
        let mut base = found.null.problem.clone();
        let at = &found.null.minimum;
        let errors = base.errors(&at.z).ok_or(FitError::Diverged)?;
        let explanation = explain(model, &mut base, &at.z).ok_or(FitError::Diverged)?;
        let priors = noise.priors(found.is_coloured);
        let reference = evidence(&base, at, &likelihood(&errors, &priors), &[]);
        let reference = reference.ok_or(FitError::Diverged)?;
        let weigh = |candidate: &'a Candidate| {
            Some((candidate, observe(candidate, &errors, noise, found.is_coloured)?))
        };
        let observed: Vec<_> = observations.iter().filter_map(weigh).collect();
        let yardstick = Yardstick { noise: &priors, reference };
        let causes = rank(&mut found.trials, &observed, &explanation, yardstick);
        let refitted = Answer { explanation, errors, fit: None, effects: 0, log_evidence: 0.0 };
        Ok(Self { base, refitted, priors, reference, observed, causes })
    }

    /// What the best single cause makes of the logs, or the refit where none is worth it.
    fn best(&self, found: &Found<'_>, settings: &Settings) -> Answer {
        let Self { causes, refitted, observed, .. } = self;
        Answer::first(causes, &found.trials, refitted, observed)
            .filter(|single| worth(settings, causes.len()) < single.log_evidence)
            .unwrap_or_else(|| refitted.clone())
    }

    pub(super) fn yardstick(&self) -> Yardstick<'_> {
        Yardstick { noise: &self.priors, reference: self.reference }
    }
}

impl<'a> Attempt<'a> {
    pub(super) fn new(
        case: &Case<'_>,
        offers: &'a Offered,
        horizon: Horizon,
        depth: Depth,
        settings: &Settings,
        monitor: &dyn Monitor,
    ) -> Result<Self, FitError> {
        let Prepared { mut model, null, noise } = prepare(case, horizon)?;
        let nominal = case.nominal;
        let mut found = search(null, (nominal, &model), &offers.simulated, settings, monitor)?;
        refine(nominal, &mut model, &mut found.null, &mut found.trials)?;
        let observations = &offers.observed;
        // Second causes, and whether single ones learned from them, which are weighed again then.
        let seek = |found: &mut Found<'a>, weighing: &mut Weighing<'a>| {
            let (suspects, null, lines) = (case.suspects, &found.null, found.lines.as_slice());
            let yardstick = weighing.yardstick();
            let workshop = Workshop { nominal, suspects, null, lines, yardstick };
            let duos = seek_pairs(workshop, &found.trials, &weighing.causes, monitor);
            let have_learned = learn(&mut found.trials, &duos, &found.null);
            if have_learned {
                *weighing = Weighing::of(found, &model, &noise, observations)?;
            }
            Ok::<_, FitError>((duos, have_learned))
        };
        // Far above the noise its colour cannot be told, and may be another effect.
        let mut left = found.best_errors().ok_or(FitError::Diverged)?;
        let mut duos = Vec::new();
        let mut weighing = None;
        let is_near = depth == Depth::Singles || noise.reach(&left) <= NEAR;
        if !is_near {
            let mut white = Weighing::of(&mut found, &model, &noise, observations)?;
            (duos, _) = seek(&mut found, &mut white)?;
            if let Some(answer) = duos.first().and_then(Duo::answer) {
                left = answer.errors;
            }
            weighing = Some(white);
        }
        let is_coloured = depth == Depth::All
            && noise.reach(&left) <= REACHED
            && found.colour(&left, &noise, settings.finalists)?;
        let mut weighing = match weighing.filter(|_| !is_coloured) {
            Some(white) => white,
            None => Weighing::of(&mut found, &model, &noise, observations)?,
        };
        let rest = |answer: &Answer, weighing: &Weighing<'_>| {
            answer.rest(&weighing.refitted, &weighing.base, &noise, is_coloured)
        };
        let mut best = weighing.best(&found, settings);
        let mut left = rest(&best, &weighing);
        // A free curve is no law, and two laws may draw it.
        let first = weighing.causes.first().and_then(|(trial, _)| *trial);
        let is_curve = best.effects == 1
            && first.is_some_and(|trial| found.trials[trial].candidate.family == CATCH_ALL);
        let is_open = left.is_unexplained || SOMETHING < left.leftover.gain() || is_curve;
        if depth == Depth::All && (is_near && is_open || !is_near && is_coloured) {
            let have_learned;
            (duos, have_learned) = seek(&mut found, &mut weighing)?;
            if have_learned {
                best = weighing.best(&found, settings);
                left = rest(&best, &weighing);
            }
        }
        if let Some(answer) = duos.first().and_then(Duo::answer)
            && best.log_evidence + PAIR < answer.log_evidence
        {
            best = answer;
            left = rest(&best, &weighing);
        }
        Ok(Self { model, noise, found, weighing, duos, best, rest: left })
    }
}
