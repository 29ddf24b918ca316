//! Second causes beside first ones.

use std::sync::Arc;

use fd_effect::{Candidate, Kind, Suspects, map::mechanism};
use fd_sim::{model::Model, simulate::Nominal};
use rayon::prelude::*;

use super::{
    answer::Answer,
    command::Command,
    misfit::CATCH_ALL,
    monitor::{Monitor, Stage},
    observe::{Observed, observe},
    prepare::{KnownNoise, with_step},
    rank::{Ranking, Yardstick, estimates, is_same, observed_cause},
    result::{Cause, Pair, PairId},
    settings::Settings,
    trial::Trial,
};
use crate::{
    evidence::{SEPARATED, distance, evidence, likelihood},
    fit::{FitError, Minimum, NullFit, Plan, Problem, Projection},
    shrink::gap,
};

/// First causes that others are tried beside.
const FIRSTS: usize = 4;
/// Best single causes of which all pairs are tried.
const SINGLES: usize = 6;
/// Other second causes that get a short fit, by what they could explain.
const HOPEFUL: usize = 6;
/// Second causes of each first one that are fitted to the end.
const FINALISTS: usize = 3;

/// Best pairs that single causes learn from.
const TEACHERS: usize = 4;

/// Evidence over that of the best single cause from which a second cause is accepted.
pub(super) const PAIR: f64 = 5.0;
/// Rivals of the best pair that are refitted to its simulation.
const MOST_RIVALS: usize = 6;

/// What pairs are made of.
#[derive(Clone, Copy, Debug)]
pub(super) struct Workshop<'a> {
    pub(super) nominal: &'a dyn Nominal,
    pub(super) suspects: &'a dyn Suspects,
    pub(super) null: &'a NullFit,
    pub(super) lines: &'a [f64],
    pub(super) yardstick: Yardstick<'a>,
}

/// Two causes, fitted together.
#[derive(Debug)]
pub(super) struct Duo {
    pub(super) pair: Pair,
    /// The model with both; its parameters are not settled.
    pub(super) model: Model,
    pub(super) problem: Problem,
    pub(super) best: Minimum,
    members: [Candidate; 2],
}

/// Pairs of simulated causes, the best first; evidence is over that of "no gap" still.
pub(super) fn seek_pairs(
    workshop: Workshop<'_>,
    trials: &[Trial<'_>],
    ranking: &Ranking,
    monitor: &dyn Monitor,
) -> Vec<Duo> {
    let singles: Vec<&Trial<'_>> = ranking
        .iter()
        .filter_map(|(trial, _)| trial.map(|trial| &trials[trial]))
        .filter(|trial| trial.candidate.family != CATCH_ALL && trial.best.is_some())
        .take(SINGLES)
        .collect();
    let firsts = &singles[..FIRSTS.min(singles.len())];
    monitor.begin(Stage::Pairs, firsts.len());
    let found: Vec<Vec<Duo>> = firsts
        .par_iter()
        .map(|first| {
            let duos = beside(workshop, first, &singles).unwrap_or_default();
            monitor.advance();
            duos
        })
        .collect();
    let mut all: Vec<Duo> = found.into_iter().flatten().collect();
    all.sort_by(|a, b| b.pair.log_evidence.total_cmp(&a.pair.log_evidence));
    let mut kept: Vec<Duo> = Vec::new();
    for duo in all {
        if !kept.iter().any(|known| known.is_of(&duo)) {
            kept.push(duo);
        }
    }
    kept
}

/// Fits single causes from where the best pairs have them: one of two may be next to nothing, and the
/// other have found beside it what it did not find alone. Says whether any came out better.
pub(super) fn learn(trials: &mut [Trial<'_>], duos: &[Duo], null: &NullFit) -> bool {
    let known: Vec<(&Candidate, Vec<f64>)> =
        duos.iter().take(TEACHERS).flat_map(Duo::values_of_members).collect();
    let learn = |trial: &mut Trial<'_>| {
        let is_better = known
            .iter()
            .filter(|(member, _)| is_same(member, trial.candidate))
            .filter(|(member, _)| member.law == trial.candidate.law)
            .filter(|(_, values)| trial.warm_start(null, values))
            .count();
        if 0 < is_better {
            trial.full_fit(null);
        }
        0 < is_better
    };
    trials.par_iter_mut().map(learn).reduce(|| false, |a, b| a | b)
}

/// The best second causes beside a first one.
fn beside(
    workshop: Workshop<'_>,
    first: &Trial<'_>,
    singles: &[&Trial<'_>],
) -> Result<Vec<Duo>, FitError> {
    let Workshop { nominal, suspects, null, lines, yardstick } = workshop;
    let Some(minimum) = first.best.clone() else { return Ok(Vec::new()) };
    // The first cause is one more nuisance.
    let plan: Plan = null.problem.plan().with_parameters(first.problem.effects());
    let (simulator, weights) = (first.problem.simulator(), first.problem.weights());
    let problem = Problem::new(Arc::new(plan), simulator.boxed(), vec![], weights.clone())?;
    let base = NullFit { problem, minimum };
    let projection = Projection::new(&base.problem, &base.minimum).ok_or(FitError::Diverged)?;
    let candidates: Vec<Candidate> = suspects
        .beside(first.candidate)
        .into_iter()
        .flatten()
        .filter(|second| second.kind == Kind::Simulation && second.family != CATCH_ALL)
        .filter(|second| !is_same(second, first.candidate))
        .map(|second| match first.model.step {
            Some(step) => Candidate { model: with_step(&second.model, step), ..second },
            None => second,
        })
        .collect();
    let commands = Command::all(nominal, &first.model, &base, &candidates);
    let mut trials: Vec<Trial<'_>> = Vec::with_capacity(candidates.len());
    for (index, candidate) in candidates.iter().enumerate() {
        if let Ok(mut trial) = Trial::new(nominal, candidate, index, &base) {
            trial.screen(&base, &projection, lines, Command::of_candidate(&commands, candidate));
            trials.push(trial);
        }
    }
    trials.sort_by(|a, b| b.gain().total_cmp(&a.gain()).then(a.index.cmp(&b.index)));
    let most = trials.first().map_or(0.0, Trial::gain);
    let is_single = |trial: &Trial<'_>| {
        singles.iter().any(|single| {
            is_same(single.candidate, trial.candidate)
                && single.candidate.law == trial.candidate.law
        })
    };
    let mut place = 0;
    trials.retain(|trial| {
        place += 1;
        place <= HOPEFUL || is_single(trial)
    });
    for trial in &mut trials {
        trial.short_fits(&base, most);
    }
    trials.sort_by(|a, b| a.cost().total_cmp(&b.cost()).then(a.index.cmp(&b.index)));
    trials.truncate(FINALISTS);
    let duos = trials.into_iter().filter_map(|mut second| {
        second.full_fit(&base);
        Duo::of(first, &second, null, yardstick)
    });
    Ok(duos.collect())
}

impl Duo {
    fn of(
        first: &Trial<'_>,
        second: &Trial<'_>,
        null: &NullFit,
        yardstick: Yardstick<'_>,
    ) -> Option<Self> {
        let best = second.best.clone()?;
        let effects = [first.problem.effects(), second.problem.effects()].concat();
        let simulator = second.problem.simulator().boxed();
        let weights = null.problem.weights().clone();
        let plan = Arc::clone(null.problem.plan());
        let mut problem = Problem::new(plan, simulator, effects, weights).ok()?;
        let errors = problem.errors(&best.z)?;
        let likelihood = likelihood(&errors, yardstick.noise);
        let scale = likelihood.scale.iter().copied().fold(0.0, f64::max);
        let strengths: [&[_]; 2] = [&first.strengths, &second.strengths];
        let log_evidence =
            evidence(&problem, &best, &likelihood, &strengths)? - yardstick.reference;
        let gap = gap(&errors);
        let model = super::explain::settle(&second.model, &problem, &best.z);
        let members = [first.candidate.clone(), second.candidate.clone()];
        let cause = |which: usize, from: usize| {
            let candidate = &members[which];
            Cause {
                label: candidate.label,
                site: candidate.site.clone(),
                partner: candidate.partner.clone(),
                family: mechanism(candidate),
                side: candidate.side,
                probability: 0.0,
                log_evidence,
                law: candidate.law,
                parameters: estimates(candidate, &problem, &best, scale, from),
                gap,
                model: model.clone(),
            }
        };
        let causes = [cause(0, 0), cause(1, first.strengths.len())];
        let pair = Pair { causes, probability: 0.0, log_evidence, gap };
        Some(Self { pair, model: second.model.clone(), problem, best, members })
    }

    /// Whether both are of the same two causes, in any order.
    fn is_of(&self, other: &Self) -> bool {
        let [a, b] = &self.members;
        let [c, d] = &other.members;
        is_same(a, c) && is_same(b, d) || is_same(a, d) && is_same(b, c)
    }

    /// Both causes with the values of their parameters.
    fn values_of_members(&self) -> [(&Candidate, Vec<f64>); 2] {
        let [first, second] = &self.members;
        let mut values = self.problem.effect_values(&self.best.z);
        let of_second = values.split_off(first.parameters.len());
        [(first, values), (second, of_second)]
    }

    /// The answer that it gives; `None` when it diverges.
    pub(super) fn answer(&self) -> Option<Answer> {
        Answer::of(&self.model, &self.problem, &self.best, 2, self.pair.log_evidence)
    }
}

/// A cause of the measurement beside a simulated one.
#[derive(Debug)]
pub(super) struct Beside<'a> {
    pub(super) pair: Pair,
    pub(super) candidate: &'a Candidate,
    pub(super) observed: Observed,
}

/// A cause of the measurement beside the first one, which is part of the `best` explanation.
pub(super) fn observed_beside<'a>(
    causes: &Ranking,
    best: &Answer,
    observations: &'a [Candidate],
    noise: &KnownNoise,
    is_coloured: bool,
) -> Option<Beside<'a>> {
    best.fit.as_ref()?;
    let (_, first) = causes.first()?;
    let weighed = observations.iter().filter_map(|candidate| {
        let observed = observe(candidate, &best.errors, noise, is_coloured)?;
        // Any simulation would have the rest of it.
        let gain = observed.gain - observed.given;
        Some((candidate, Observed { gain, ..observed }))
    });
    let (candidate, observed) = weighed.max_by(|a, b| a.1.gain.total_cmp(&b.1.gain))?;
    let second = observed_cause(candidate, &observed, &best.explanation);
    let pair = Pair {
        probability: 0.0,
        log_evidence: first.log_evidence + observed.gain,
        gap: second.gap,
        causes: [first.clone(), second],
    };
    Some(Beside { pair, candidate, observed })
}

/// The pairs that are worth being called so, the best first, with their evidence over that of the
/// best single cause, and those that the log cannot tell from the first.
pub(super) fn merge(
    duos: &mut Vec<Duo>,
    observed: Option<Pair>,
    causes: &Ranking,
    settings: &Settings,
) -> (Vec<Pair>, Vec<PairId>) {
    let single = causes.first().map_or(0.0, |(_, cause)| cause.log_evidence.max(0.0));
    duos.retain(|duo| single + PAIR < duo.pair.log_evidence);
    let observed = observed.filter(|pair| single + PAIR < pair.log_evidence);
    let tied = tied(duos, settings);
    let mut all: Vec<(bool, Pair)> =
        duos.iter().enumerate().map(|(i, duo)| (tied.contains(&i), duo.pair.clone())).collect();
    all.extend(observed.map(|pair| (false, pair)));
    all.sort_by(|(_, a), (_, b)| b.log_evidence.total_cmp(&a.log_evidence));
    let is_tied = |(place, (is_tied, _)): (usize, &(bool, Pair))| is_tied.then_some(PairId(place));
    let tied = match all.first() {
        None => vec![],
        Some((true, _)) => all.iter().enumerate().filter_map(is_tied).collect(),
        Some((false, _)) => vec![PairId(0)],
    };
    (all.into_iter().map(|(_, pair)| pair).collect(), tied)
}

/// Places of the pairs that this log cannot tell from the first.
fn tied(duos: &mut [Duo], settings: &Settings) -> Vec<usize> {
    let Some((first, others)) = duos.split_first_mut() else { return vec![] };
    let mut tied = vec![0];
    let near = others.iter().enumerate().take_while(|(_, duo)| {
        first.pair.log_evidence - duo.pair.log_evidence < settings.bayes_factor.ln()
    });
    for (place, duo) in near.take(MOST_RIVALS) {
        if distance(&mut first.problem, &first.best, &duo.problem, &duo.best) < SEPARATED {
            tied.push(place + 1);
        }
    }
    tied
}
