//! Causes compete in forecasts.

use fd_sim::simulate::Simulator;

use super::{groups::groups, probabilities::Probabilities};
use crate::{
    diagnose::{
        candidates::{follows_anything, is_same_cause},
        result::{Cause, CauseId, Group},
        search::searched::{Searched, TrialId},
        settings::Settings,
        weigh::{
            rank::{Basis, RankedCause, weigh_law},
            singles::Singles,
            values::FittedValues,
        },
    },
    evidence::confidence,
    fit::{FitError, Log},
    shrink::{self, Closed, Contest, Rules, Settled},
};

/// Causes in the order of their probabilities, with those of the other answers.
#[derive(Debug)]
pub(super) struct Contested<'a> {
    pub(super) others: Probabilities,
    pub(super) singles: Singles<'a>,
}

/// A law that takes part.
struct Law {
    /// Place of its cause.
    cause: usize,
    trial: TrialId,
}

/// A cause that takes part, or one that comes behind those that do and wins nothing.
struct Contestant {
    ranked: RankedCause,
    wins: Wins,
    /// The share of the held-out gap that its best law closes, per horizon.
    closed: Vec<Option<Closed>>,
}

/// Shares of wins.
#[derive(Clone, Copy, Debug, Default)]
struct Wins {
    held_out: f64,
    training: f64,
}

impl Wins {
    fn both(self) -> f64 {
        self.held_out * self.training
    }

    fn either(self) -> f64 {
        self.held_out + self.training
    }
}

/// Gives causes their probabilities by forecasts, and orders them by these. All laws of the first
/// `settings.finalists` causes compete, and a cause wins what its laws win; the others have
/// nothing. Without held-out logs those of the fit count alone.
pub(super) fn contest<'a>(
    simulator: &dyn Simulator,
    singles: Singles<'a>,
    held_out: &[Log],
    rules: &Rules<'_>,
    settings: &Settings,
) -> Result<Contested<'a>, FitError> {
    let Singles { mut searched, mut causes, .. } = singles;
    // What follows a log as it pleases draws what is missing: it is no explanation, but leaves room for one.
    causes.retain(|ranked| match ranked.basis {
        Basis::Simulation(id) => !follows_anything(searched.trial(id).candidate),
        Basis::Measurement(_) => true,
    });
    let finalists = settings.finalists.min(causes.len());
    let laws = laws(&causes[..finalists], &searched);
    let [test, training] = run(simulator, &laws, &searched, held_out, rules)?;
    let no_gap = confidence(test.wins[0], training.wins[0]);

    let mut contestants: Vec<Contestant> = Vec::with_capacity(causes.len());
    for (place, ranked) in causes.into_iter().enumerate() {
        let own = || laws.iter().enumerate().filter(move |(_, law)| law.cause == place);
        let sum = |contest: &Contest| own().map(|(i, _)| contest.wins[i + 1]).sum();
        let wins = if place < finalists {
            Wins { held_out: sum(&test), training: sum(&training) }
        } else {
            Wins::default()
        };
        let score = |i: usize| test.wins[i + 1] + training.wins[i + 1];
        let best = own().max_by(|(a, x), (b, y)| {
            // Laws that win nothing are ranked by their fit; of equal ones the first counts.
            let (x, y) = (searched.trial(x.trial), searched.trial(y.trial));
            score(*a).total_cmp(&score(*b)).then(y.cost().total_cmp(&x.cost())).then(b.cmp(a))
        });
        let closed = best.map_or_else(Vec::new, |(i, _)| test.closed[i + 1].clone());
        let other =
            best.map(|(_, law)| law.trial).filter(|id| ranked.basis != Basis::Simulation(*id));
        let ranked = match other {
            Some(id) => {
                let law = weigh_law(id, searched.trial_mut(id), &singles.reference);
                let log_evidence = ranked.cause.log_evidence;
                let cause = Cause { log_evidence, ..law.cause };
                RankedCause { basis: Basis::Simulation(id), cause }
            }
            None => ranked,
        };
        contestants.push(Contestant { ranked, wins, closed });
    }
    believe(&mut contestants, finalists);
    let probability = |contestant: &Contestant| contestant.ranked.cause.probability;
    contestants.sort_by(|a, b| probability(b).total_cmp(&probability(a)));

    let mut none_of_these = 1.0 - no_gap;
    let doubted = contestants.into_iter().map(|Contestant { ranked, closed, .. }| {
        let probability = ranked.cause.probability * trust(&closed);
        none_of_these -= probability;
        RankedCause { cause: Cause { probability, ..ranked.cause }, ..ranked }
    });
    let mut causes: Vec<_> = doubted.collect();
    causes.sort_by(|a, b| b.cause.probability.total_cmp(&a.cause.probability));
    let others = Probabilities { no_gap, none_of_these: none_of_these.max(0.0) };
    Ok(Contested { others, singles: Singles { searched, causes, ..singles } })
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

/// The contests on held-out logs and on those of the fit; the model without any effect takes part as
/// the first, the laws follow.
fn run(
    simulator: &dyn Simulator,
    laws: &[Law],
    searched: &Searched<'_>,
    held_out: &[Log],
    rules: &Rules<'_>,
) -> Result<[Contest; 2], FitError> {
    let null = &searched.null;
    let of_law = |law: &Law| {
        let trial = searched.trial(law.trial);
        trial.best.as_ref().map(|best| FittedValues::of(&trial.problem, best))
    };
    let null_entrant = FittedValues::of(&null.problem, &null.minimum);
    let entrants: Vec<FittedValues<'_>> =
        std::iter::once(null_entrant).chain(laws.iter().filter_map(of_law)).collect();
    let settled: Vec<Settled<'_>> = entrants.iter().map(FittedValues::settled).collect();
    let run = |logs: &[Log]| shrink::contest(simulator, &settled, logs, rules);
    let training = run(&null.problem.plan().logs)?;
    let test = if held_out.is_empty() { training.clone() } else { run(held_out)? };
    Ok([test, training])
}

/// Sets probabilities from the wins of the first so many. A mechanism at a place is believed as a
/// whole, and its causes share that.
fn believe(contestants: &mut [Contestant], finalists: usize) {
    for contestant in contestants.iter_mut() {
        contestant.ranked.cause.probability = 0.0;
    }
    let all = groups(contestants[..finalists].iter().map(|c| &c.ranked.cause), &[]);
    for Group { causes: members, .. } in all {
        let sum = |value: &dyn Fn(Wins) -> f64| -> f64 {
            members.iter().map(|id| value(contestants[id.0].wins)).sum()
        };
        let together = confidence(sum(&|w| w.held_out), sum(&|w| w.training));
        let products = sum(&|wins| wins.both().sqrt());
        let sums = sum(&Wins::either);
        for CauseId(place) in &members {
            let Contestant { ranked, wins, .. } = &mut contestants[*place];
            let (weight, weights) =
                if 0.0 < products { (wins.both().sqrt(), products) } else { (wins.either(), sums) };
            ranked.cause.probability = together * weight / weights.max(f64::MIN_POSITIVE);
        }
    }
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
