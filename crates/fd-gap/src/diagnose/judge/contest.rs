//! Causes compete in forecasts.

use fd_sim::simulate::Simulator;

use super::probabilities::Probabilities;
use crate::{
    diagnose::{
        candidates::{follows_anything, is_same_cause},
        result::Cause,
        search::searched::{Searched, TrialId},
        weigh::{
            rank::{Basis, RankedCause, weigh_law},
            singles::Singles,
            values::FittedValues,
        },
    },
    fit::{FitError, Horizon, Log},
    shrink::{Closed, Contest, Forecasts, Rules, Settled},
};

/// Causes in the order of their probabilities, with those of the other answers.
#[derive(Debug)]
pub(super) struct Contested<'a> {
    pub others: Probabilities,
    pub singles: Singles<'a>,
}

/// A law that takes part.
#[derive(Clone, Copy, Debug)]
pub(in crate::diagnose) struct Entrant {
    /// Place of its cause.
    pub cause: usize,
    /// Sum of squares of its fit: laws that win nothing are ranked by that.
    pub cost: f64,
}

/// A law of a search.
struct Law {
    /// Place of its cause.
    cause: usize,
    trial: TrialId,
}

/// How causes came out, the model that they were added to first.
pub(in crate::diagnose) struct Standings {
    no_gap: f64,
    pub causes: Vec<Standing>,
}

/// How a cause came out.
pub(in crate::diagnose) struct Standing {
    /// The place of its best law among the entrants; `None` where it has none.
    pub best: Option<usize>,
    /// How often it wins.
    wins: f64,
    /// What is believed of it.
    pub probability: f64,
}

/// The most that wins can say: the law may be in no library.
const SUREST: f64 = 0.95;

/// Gives causes their probabilities by forecasts, and orders them by these. All laws of the first
/// `finalists` causes compete, and a cause wins what its laws win; the others have
/// nothing. Without held-out logs those of the fit count alone.
pub(super) fn contest<'a>(
    simulator: &dyn Simulator,
    singles: Singles<'a>,
    held_out: &[Log],
    horizons: &[Horizon],
    rules: &Rules,
    finalists: usize,
) -> Result<Contested<'a>, FitError> {
    let Singles { mut searched, mut causes, .. } = singles;
    // What follows a log as it pleases draws what is missing: it is no explanation, but leaves room for one.
    causes.retain(|ranked| match ranked.basis {
        Basis::Simulation(id) => !follows_anything(searched.trial(id).candidate),
        Basis::Measurement(_) => true,
    });
    let finalists = finalists.min(causes.len());
    let laws = laws(&causes[..finalists], &searched);
    let null = FittedValues::of(&searched.null.problem, &searched.null.minimum);
    let (mut entrants, mut values) = (Vec::new(), vec![null]);
    for Law { cause, trial } in &laws {
        let trial = searched.trial(*trial);
        if let Some(best) = &trial.best {
            entrants.push(Entrant { cause: *cause, cost: best.cost });
            values.push(FittedValues::of(&trial.problem, best));
        }
    }
    let settled: Vec<Settled<'_>> = values.iter().map(FittedValues::settled).collect();
    let logs = [searched.null.problem.plan().logs.as_slice(), held_out];
    let sigma = &searched.noise.sigma;
    let forecasts = Forecasts::of(simulator, &settled, &logs, horizons, sigma)?;
    let Standings { no_gap, causes: standings } =
        standings(finalists, &entrants, &forecasts.contest(rules));
    let mut contested: Vec<(f64, RankedCause)> = Vec::with_capacity(causes.len());
    let mut standings = standings.into_iter();
    for ranked in causes {
        let standing = standings.next();
        let (wins, probability) = standing.as_ref().map_or((0.0, 0.0), |s| (s.wins, s.probability));
        let best = standing.and_then(|s| s.best).map(|place| laws[place].trial);
        let ranked = match best.filter(|id| ranked.basis != Basis::Simulation(*id)) {
            Some(id) => {
                let law = weigh_law(id, searched.trial_mut(id), &singles.reference);
                let log_evidence = ranked.cause.log_evidence;
                let cause = Cause { log_evidence, ..law.cause };
                RankedCause { basis: Basis::Simulation(id), cause }
            }
            None => ranked,
        };
        let cause = Cause { probability, ..ranked.cause };
        contested.push((wins, RankedCause { cause, ..ranked }));
    }
    contested.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    let mut causes: Vec<RankedCause> = contested.into_iter().map(|(_, ranked)| ranked).collect();
    causes.sort_by(|a, b| b.cause.probability.total_cmp(&a.cause.probability));
    let known: f64 = causes.iter().map(|ranked| ranked.cause.probability).sum();
    let others = Probabilities { no_gap, none_of_these: (1.0 - no_gap - known).max(0.0) };
    Ok(Contested { others, singles: Singles { searched, causes, ..singles } })
}

/// How causes come out by what their laws, after the model that they were added to, have won.
pub(in crate::diagnose) fn standings(
    causes: usize,
    entrants: &[Entrant],
    Contest { wins, closed }: &Contest,
) -> Standings {
    let of_cause = |place: usize| {
        let own = || entrants.iter().enumerate().filter(move |(_, law)| law.cause == place);
        let best = own().max_by(|(a, x), (b, y)| {
            // Of equal ones the first counts.
            let by_wins = wins[a + 1].total_cmp(&wins[b + 1]);
            by_wins.then(y.cost.total_cmp(&x.cost)).then(b.cmp(a))
        });
        let best = best.map(|(place, _)| place);
        let wins = own().map(|(i, _)| wins[i + 1]).sum();
        let trust = best.map_or(0.0, |place| trust(&closed[place + 1]));
        Standing { best, wins, probability: SUREST * wins * trust }
    };
    let causes = (0..causes).map(of_cause).collect();
    Standings { no_gap: SUREST * wins[0], causes }
}

/// How far a law may be believed: up to the share of the variance above the noise that it explains in forecasts, at the
/// horizon that suits it best. The best of the known laws may be a mimic of one that nobody has listed; what it leaves is the
/// work of something else.
fn trust(closed: &[Option<Closed>]) -> f64 {
    let explained = |closed: &Closed| 1.0 - (1.0 - closed.interval[0].clamp(0.0, 1.0)).powi(2);
    closed.iter().flatten().map(explained).fold(0.0, f64::max)
}

/// All laws of causes that were simulated.
fn laws(causes: &[RankedCause], searched: &Searched<'_>) -> Vec<Law> {
    let mut laws = Vec::new();
    for (cause, ranked) in causes.iter().enumerate() {
        let Basis::Simulation(representative) = ranked.basis else { continue };
        let candidate = searched.trial(representative).candidate;
        let of_cause = searched
            .trials()
            .filter(|(_, trial)| trial.best.is_some() && is_same_cause(trial.candidate, candidate));
        laws.extend(of_cause.map(|(trial, _)| Law { cause, trial }));
    }
    laws
}

#[cfg(test)]
mod tests {
    use super::trust;
    use crate::shrink::Closed;

    #[test]
    #[expect(clippy::float_cmp, reason = "powers of two are exact")]
    fn laws_are_trusted_as_far_as_they_surely_explain_at_their_best_horizon() {
        let closed = |low: f64, high: f64| {
            Some(Closed { fraction: f64::midpoint(low, high), interval: [low, high], block: 1 })
        };
        // Half of the root mean square is three quarters of the variance.
        assert_eq!(trust(&[closed(0.25, 1.0), None, closed(0.5, 0.5)]), 0.75);
        assert_eq!(trust(&[closed(-2.0, 1.0)]), 0.0);
        assert_eq!(trust(&[closed(1.5, 2.0)]), 1.0);
        assert_eq!(trust(&[None]), 0.0);
    }
}
