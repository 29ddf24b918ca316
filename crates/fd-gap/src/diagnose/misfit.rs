//! Logs of which no model reaches the noise: forecasts judge instead of evidence.
//!
//! Real logs end at 6 to 230 times the noise, whatever single effect is added. Then
//! * models are fitted in windows if the free run is lost without any effect ([`is_lost`]),
//! * the noise has no colour: what a wrong model leaves is no noise,
//! * causes compete in forecasts at three horizons, on the logs of the fit and on those held out;
//!   what to believe is how often they win ([`weigh`]),
//! * a cause that does not clearly close a part of the gap at two horizons is no answer.

use fd_sim::simulate::Simulator;

use super::{
    explain::nuisances,
    judge::Judgement,
    rank::{Ranking, Yardstick, groups, is_same},
    result::{Cause, CauseId, Group},
    settings::Settings,
    trial::Trial,
};
use crate::{
    evidence::confidence,
    fit::{FitError, Horizon, Log, Minimum, NullFit, Problem, Variable},
    quality::noise_floor,
    shrink::{
        Closed, Contest, Rules, Settled, contest, dominant_time_constant, gap_per_output, horizons,
    },
};

/// A free run whose error is above this part of the signal is lost.
const LOST: f64 = 0.5;
/// A cause must close more than this part of the held-out gap, with 97.5 % confidence …
const WORTH_A_NAME: f64 = 0.2;
/// … at so many horizons.
const AT_HORIZONS: usize = 2;
/// The family of free curves, which are no law.
pub(super) const CATCH_ALL: &str = "map";

/// Whether the simulation without any effect has little to do with some output.
pub(super) fn is_lost(null: &NullFit) -> bool {
    let mut problem = null.problem.clone();
    let Some(errors) = problem.errors(&null.minimum.z) else { return true };
    let logs = &null.problem.plan().logs;
    gap_per_output(&errors).iter().zip(&null.problem.weights().sigma).enumerate().any(
        |(c, (gap, sigma))| {
            let measured = || {
                let each = logs.iter().flat_map(|log| log.y.iter().skip(c).step_by(log.ny));
                each.copied().filter(|value| value.is_finite())
            };
            let n = measured().count().max(1) as f64;
            let mean = measured().sum::<f64>() / n;
            let spread = (measured().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
            LOST * spread < gap * sigma
        },
    )
}

/// The horizons at which the refitted model is to be judged, and fitted in windows: the middle one.
pub(super) fn memory(simulator: &dyn Simulator, null: &NullFit, held_out: &[Log]) -> Vec<Horizon> {
    let Minimum { z, .. } = &null.minimum;
    let refitted = nuisances(&null.problem, z);
    let parameters = simulator.parameters().iter();
    let value = |p: &fd_sim::model::Parameter| {
        let refitted = refitted.iter().find(|nuisance| nuisance.name == p.name);
        refitted.map_or(p.value, |nuisance| nuisance.value)
    };
    let theta: Vec<f64> = parameters.map(value).collect();
    let x0 = null.problem.start_of(0, z);
    let logs = &null.problem.plan().logs;
    let time = dominant_time_constant(simulator, &theta, &x0, &logs[0]);
    let shortest = logs.iter().chain(held_out).map(Log::samples).min().unwrap_or(0);
    horizons(time, simulator.initial().len(), shortest)
}

/// A horizon for fits: the middle one.
pub(super) fn windows(horizons: &[Horizon]) -> Horizon {
    let windows = horizons.iter().rev().find(|h| matches!(h, Horizon::Windows { .. }));
    windows.copied().unwrap_or(Horizon::FreeRun)
}

/// The noise floor below errors, in sigma, over all outputs.
pub(super) fn floor(errors: &[Vec<Vec<f64>>]) -> f64 {
    let floors = errors.iter().map(|signals| noise_floor(&signals.join(&f64::NAN), None));
    let squares: f64 = floors.map(|floor| floor.unwrap_or(1.0).powi(2)).sum();
    f64::sqrt(squares / errors.len().max(1) as f64)
}

/// Gives causes their probabilities by forecasts, and orders them by these. All laws of the first
/// `settings.finalists` causes compete, and a cause wins what its laws win; the others have
/// nothing. Without held-out logs those of the fit count alone.
#[expect(clippy::too_many_arguments, reason = "one call")]
pub(super) fn weigh(
    simulator: &dyn Simulator,
    null: &NullFit,
    trials: &mut [Trial<'_>],
    causes: &mut Ranking,
    held_out: &[Log],
    rules: &Rules<'_>,
    yardstick: Yardstick<'_>,
    settings: &Settings,
) -> Result<Judgement, FitError> {
    let finalists = settings.finalists.min(causes.len());
    // The place of the cause of each law, and that of its trial.
    let mut laws: Vec<(usize, usize)> = Vec::new();
    let mut entrants = vec![Entrant::new(&null.problem, &null.minimum)];
    for (c, (representative, _)) in causes[..finalists].iter().enumerate() {
        let Some(representative) = *representative else { continue };
        for (t, trial) in trials.iter().enumerate() {
            let same = is_same(trial.candidate, trials[representative].candidate);
            let best = trial.best.as_ref().filter(|_| same);
            if let Some(best) = best {
                laws.push((c, t));
                entrants.push(Entrant::new(&trial.problem, best));
            }
        }
    }
    let curves = laws.iter().map(|(_, t)| trials[*t].candidate.family == CATCH_ALL);
    let is_catch_all: Vec<bool> = std::iter::once(false).chain(curves).collect();
    let settled: Vec<Settled<'_>> = entrants.iter().map(Entrant::settled).collect();
    let run = |logs: &[Log]| contest(simulator, &settled, &is_catch_all, logs, rules);
    let training = run(&null.problem.plan().logs)?;
    let test = if held_out.is_empty() { training.clone() } else { run(held_out)? };

    let no_gap = confidence(test.wins[0], training.wins[0]);
    let wins_of = |contest: &Contest, c: usize| -> f64 {
        let all = laws.iter().zip(&contest.wins[1..]);
        all.filter(|((cause, _), _)| *cause == c).map(|(_, wins)| wins).sum()
    };
    let wins: Vec<[f64; 2]> =
        (0..finalists).map(|c| [wins_of(&test, c), wins_of(&training, c)]).collect();
    let mut closed: Vec<Vec<Option<Closed>>> = vec![Vec::new(); causes.len()];
    for c in 0..finalists {
        let of_cause = laws.iter().enumerate().filter(|(_, (cause, _))| *cause == c);
        let score = |law: usize| test.wins[law + 1] + training.wins[law + 1];
        let best = of_cause.max_by(|(a, x), (b, y)| {
            // Laws that win nothing are ranked by their fit; of equal ones the first counts.
            let fit = trials[y.1].cost().total_cmp(&trials[x.1].cost());
            score(*a).total_cmp(&score(*b)).then(fit).then(b.cmp(a))
        });
        if let Some((law, (_, t))) = best {
            closed[c].clone_from(&test.closed[law + 1]);
            if causes[c].0 != Some(*t) {
                let weighed = trials[*t].weigh(*t, yardstick);
                let log_evidence = causes[c].1.log_evidence;
                causes[c] = (Some(*t), Cause { log_evidence, ..weighed.cause });
            }
        }
    }
    believe(causes, &wins);
    let mut order: Vec<usize> = (0..causes.len()).collect();
    order.sort_by(|a, b| causes[*b].1.probability.total_cmp(&causes[*a].1.probability));
    *causes = order.iter().map(|&i| causes[i].clone()).collect();

    let clear = |closed: &&Closed| WORTH_A_NAME < closed.interval[0];
    let first = order.first().map_or(&[][..], |first| &closed[*first]);
    let convincing = first.iter().flatten().filter(clear).count();
    let named: f64 = causes.iter().map(|(_, cause)| cause.probability).sum();
    let mut none_of_these = (1.0 - no_gap - named).max(0.0);
    if convincing < AT_HORIZONS.min(rules.horizons.len()) {
        // The order stays, the belief goes.
        let left = (1.0 - no_gap).max(0.0);
        none_of_these = confidence(1.0, 1.0) * left;
        let factor = (left - none_of_these) / named.max(f64::MIN_POSITIVE);
        for (_, cause) in causes.iter_mut() {
            cause.probability *= factor;
        }
    }
    Ok(Judgement { no_gap, none_of_these })
}

/// Sets probabilities from the shares of wins on held-out logs and on those of the fit, of as many
/// causes. A mechanism at a place is believed as a whole, and its causes share that.
fn believe(causes: &mut [(Option<usize>, Cause)], wins: &[[f64; 2]]) {
    for (_, cause) in causes.iter_mut() {
        cause.probability = 0.0;
    }
    let all: Vec<Cause> = causes[..wins.len()].iter().map(|(_, cause)| cause.clone()).collect();
    for Group { causes: members, .. } in groups(&all, &[]) {
        let sum = |value: &dyn Fn([f64; 2]) -> f64| -> f64 {
            members.iter().map(|c| value(wins[c.0])).sum()
        };
        let together = confidence(sum(&|w| w[0]), sum(&|w| w[1]));
        let both = |[a, b]: [f64; 2]| a * b;
        let either = |[a, b]: [f64; 2]| a + b;
        for CauseId(c) in members.iter().copied() {
            let (weight, weights) = if 0.0 < sum(&|w| both(w).sqrt()) {
                (both(wins[c]).sqrt(), sum(&|w| both(w).sqrt()))
            } else {
                (either(wins[c]), sum(&either))
            };
            causes[c].1.probability = together * weight / weights.max(f64::MIN_POSITIVE);
        }
    }
}

/// A fitted model with its values.
struct Entrant<'a> {
    simulator: &'a dyn Simulator,
    nuisances: Vec<(String, f64)>,
    effects: Vec<(Variable, f64)>,
}

impl<'a> Entrant<'a> {
    fn new(problem: &'a Problem, at: &Minimum) -> Self {
        let nuisances = nuisances(problem, &at.z).into_iter();
        let values = problem.effect_values(&at.z);
        Self {
            simulator: problem.simulator(),
            nuisances: nuisances.map(|n| (n.name, n.value)).collect(),
            effects: problem.effects().iter().cloned().zip(values).collect(),
        }
    }

    fn settled(&self) -> Settled<'_> {
        let Self { simulator, nuisances, effects } = self;
        Settled { simulator: *simulator, nuisances, effects }
    }
}
