//! From a model, candidates and logs to an answer.
//!
//! 0. A controller in the loop is run on the logged outputs, if it did see these
//!    ([`LoggedLoop`](fd_sim::simulate::LoggedLoop)).
//! 1. The nuisances are fitted alone ([`null_fit`](crate::fit::null_fit)).
//! 2. Every candidate is scored at every start by what it could explain besides the nuisances,
//!    and fitted a little from the best three.
//! 3. The best causes (effect and site, all their laws) are fitted to the end; the integration step
//!    is halved until their outputs do not depend on it.
//! 4. If the best one leaves more than noise, or is a free curve, second causes are tried beside
//!    the first ones; single causes are fitted again from where the best pairs have them.
//! 5. If what is left then has a colour, everything is fitted again with whitened errors.
//! 6. Evidence, pooled over the laws of a cause; effects of the measurement, which change the
//!    likelihood and not the simulation, compete; what the log cannot separate; probabilities, that
//!    of "none of these" among them, from what the best explanation leaves and how it forecasts.
//! 7. Where nothing comes near the noise, forecasts judge instead of evidence.
//! 8. Forecasts of held-out logs, without and with the best explanation.
//!
//! Candidates are spread over threads; the answer does not depend on their number.

mod answer;
mod attempt;
mod case;
mod command;
mod explain;
mod feedback;
mod held_out;
mod judge;
mod leftover;
mod misfit;
mod monitor;
mod observe;
mod offered;
mod outliers;
mod outlook;
mod pairs;
mod prepare;
mod rank;
mod result;
mod search;
mod separate;
mod settings;
mod steps;
mod told_floor;
mod trial;

use fd_effect::Candidate;
use fd_sim::model::Model;

use self::{
    answer::Answer,
    attempt::{Attempt, Depth, Weighing},
    explain::{explain, nominal_explanation},
    feedback::Feedback,
    held_out::compare,
    judge::{Judgement, judge, unknown_gain, verdict},
    observe::Observed,
    offered::Offered,
    outlook::outlook,
    pairs::{PAIR, merge, observed_beside},
    prepare::inspect_all,
    rank::{Yardstick, groups, sides},
    separate::separate,
    told_floor::{around_the_loop, told_floor},
};
pub use self::{
    case::Case,
    monitor::{Monitor, Stage},
    result::{
        Cause, CauseId, Diagnosis, Estimate, Explanation, Group, HeldOut, Leftover, NotTested,
        Nuisance, Pair, PairId, Regime, RivalCause, SideShare, Start, Verdict,
    },
    settings::Settings,
};
use crate::{
    fit::{FitError, Horizon, Log, Minimum, Problem},
    shrink::Rules,
};

/// Diagnoses the gap between a model and logs of the real system.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::diagnose::{Case, Settings, Verdict, diagnose};
/// use fd_sim::model::Model;
/// use fd_model::{Channel, Record};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "V" } }
/// outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// parameters = { T = { unit = "s", value = 1.0 } }
/// states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// "#.parse()?;
/// let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13).sin();
/// let x = |k: u32| 1.0 - (-0.1 * f64::from(k)).exp();
/// let rows = (0..100).map(|k| ([1.0], [x(k) + noise(k)]));
/// let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, model.sample_time()?)?;
/// let suspects: Vec<Candidate> = Vec::new();
/// let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
/// let diagnosis = diagnose(&case, &Settings::default(), &())?;
/// assert_eq!(diagnosis.verdict, Verdict::NoGap);
/// assert!(0.9 < diagnosis.no_gap);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs. A candidate that
/// cannot be simulated is no error; see [`Diagnosis::not_tested`].
pub fn diagnose(
    case: &Case<'_>,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Diagnosis, FitError> {
    let feedback = Feedback::of(case, settings.horizon);
    let whole = case;
    let case = &feedback.case(case);
    let mut offers = Offered::of(case.suspects);
    let mut not_tested = std::mem::take(&mut offers.refused);
    let mut attempt = Attempt::new(case, &offers, settings.horizon, Depth::All, settings, monitor)?;
    let simulator = attempt.weighing.base.simulator().boxed();
    let held_out = Log::all(case.held_out, &*simulator, case.logs)?;

    monitor.begin(Stage::Judge, 2);
    let is_far = attempt.noise.is_far(&attempt.best.errors);
    let Judged { regime, judgement, tied, rivals, pairs, tied_pairs, report_horizons } = if is_far {
        by_forecasts(case, &offers, &mut attempt, &held_out, settings, monitor)?
    } else {
        by_evidence(&offers, &mut attempt, &held_out, settings)?
    };
    monitor.advance();

    let Attempt { model, noise, found, weighing, duos, mut best, mut rest } = attempt;
    let Weighing { base, mut refitted, observed, mut causes, .. } = weighing;
    let verdict = verdict(judgement, &causes, &tied, &pairs);
    if verdict == Verdict::NoGap {
        best = refitted.clone();
        rest = best.rest(&refitted, &base, &noise, found.is_coloured);
    }
    let mut floor = told_floor(&best, &rest, &noise, found.is_coloured);
    // What is reported is the simulator as it came, with its loop closed.
    let closed = feedback.closed(whole, &model, &base)?;
    let leader = match &best.fit {
        Some((problem, at)) => {
            Some((feedback.closed(whole, &best.explanation.model, problem)?, at.clone()))
        }
        None => None,
    };
    let null = &found.null;
    let again = |model: &Model, problem: &Problem, at: &Minimum| {
        explain(model, &mut problem.clone(), &at.z).filter(|_| feedback.is_logged())
    };
    if let Some(explanation) = again(&model, &closed, &null.minimum) {
        refitted.explanation = explanation;
    }
    let told = match &leader {
        Some((problem, at)) => again(&best.explanation.model, problem, at),
        None => Some(refitted.explanation.clone()),
    };
    if let Some(told) = told {
        around_the_loop(&mut floor, &best.explanation.gap, &told.gap);
        best.explanation = told;
    }
    let findings = inspect_all(whole.logs, &closed, &noise.stated, &refitted.errors)?;
    let leader = leader.as_ref().map(|(problem, at)| (problem, at));
    let settings = &Settings { report_horizons, ..settings.clone() };
    let held_out = Log::all(whole.held_out, closed.simulator(), whole.logs)?;
    let held_out =
        compare(closed.simulator(), null, leader, &held_out, [&noise.sigma, &floor], settings)?;
    monitor.advance();

    let is_seen = |candidate: &Candidate| observed.iter().any(|(c, _)| std::ptr::eq(*c, candidate));
    let unseen = offers.observed.iter().filter(|candidate| !is_seen(candidate));
    not_tested.extend(found.not_tested);
    not_tested.extend(unseen.map(|c| NotTested::of(c, "there is nothing of it in the log".into())));
    let fits = found.trials.iter().map(|t| &t.problem).chain(duos.iter().map(|duo| &duo.problem));
    let simulations = base.simulations() + fits.map(Problem::simulations).sum::<usize>();
    let causes: Vec<Cause> = causes.drain(..).map(|(_, cause)| cause).collect();
    Ok(Diagnosis {
        verdict,
        regime,
        is_logged_loop: feedback.is_logged(),
        no_gap: judgement.no_gap,
        none_of_these: judgement.none_of_these,
        groups: groups(&causes, &pairs),
        sides: sides(&causes, &pairs),
        causes,
        tied,
        rivals,
        pairs,
        tied_pairs,
        leftover: rest.leftover,
        nominal: nominal_explanation(&model, &closed)?,
        refit: refitted.explanation,
        is_unexplained: rest.is_unexplained,
        best: best.explanation,
        sigma: noise.sigma,
        floor,
        is_coloured: found.is_coloured,
        held_out,
        findings,
        not_tested,
        simulations,
    })
}

/// Rivals of the best cause whose forecasts are looked at.
const MOST_RIVALS: usize = 4;

/// What was made of the evidence.
struct Judged {
    regime: Regime,
    judgement: Judgement,
    tied: Vec<CauseId>,
    rivals: Vec<RivalCause>,
    pairs: Vec<Pair>,
    tied_pairs: Vec<PairId>,
    report_horizons: Vec<Horizon>,
}

/// The best explanation comes near the noise: likelihoods speak.
fn by_evidence(
    offers: &Offered,
    attempt: &mut Attempt<'_>,
    held_out: &[Log],
    settings: &Settings,
) -> Result<Judged, FitError> {
    let Attempt { noise, found, weighing, duos, best, rest, .. } = attempt;
    let causes = &mut weighing.causes;
    let (tied, rivals) = separate(causes, &mut found.trials, settings);
    let beside = observed_beside(causes, best, &offers.observed, noise, found.is_coloured);
    let mut doubt = 0.0;
    if let Some(beside) = &beside
        && PAIR < beside.observed.gain
        && duos.first().is_none_or(|duo| duo.pair.log_evidence < beside.pair.log_evidence)
    {
        doubt = beside.observed.doubt();
        *best = best.with(beside.candidate, &beside.observed);
        *rest = best.rest(&weighing.refitted, &weighing.base, noise, found.is_coloured);
    } else if let Some((None, first)) = causes.first() {
        let is_first = |(candidate, _): &&(&Candidate, Observed)| first.is_of(candidate);
        doubt = weighing.observed.iter().find(is_first).map_or(0.0, |(_, o)| o.doubt());
    }
    let beside = beside.map(|beside| beside.pair);
    let (mut pairs, tied_pairs) = merge(duos, beside, causes, settings);
    let (nominal, null) = (weighing.base.simulator(), &found.null);
    let forecast =
        |answer: &Answer| outlook(nominal, null, answer, held_out, (noise, &rest.floor), settings);
    let mut outlook = forecast(best)?;
    if 0.0 < outlook.loss && best.effects == 1 {
        // A free curve may forecast badly where a law that fits as well does not.
        let near = best.log_evidence - settings.bayes_factor.ln();
        let rivals = causes.iter().skip(1).take_while(|(_, cause)| near < cause.log_evidence);
        for (trial, cause) in rivals.take(MOST_RIVALS) {
            let Some(trial) = trial.map(|trial| &found.trials[trial]) else { continue };
            let Some(at) = &trial.best else { continue };
            let evidence = cause.log_evidence;
            let rival = Answer::of(&trial.model, &trial.problem, at, 1, evidence);
            let other = rival.as_ref().map(&forecast).transpose()?;
            if let Some(other) = other.filter(|other| other.loss < outlook.loss) {
                outlook = other;
            }
        }
    }
    let gain = unknown_gain(best, &rest.leftover, outlook) + doubt;
    let judgement = judge(causes, &mut pairs, best, gain, settings);
    let report_horizons = settings.report_horizons.clone();
    let regime = Regime::AtTheFloor;
    Ok(Judged { regime, judgement, tied, rivals, pairs, tied_pairs, report_horizons })
}

/// Nothing comes near the noise: forecasts speak.
fn by_forecasts<'a>(
    case: &Case<'_>,
    offers: &'a Offered,
    attempt: &mut Attempt<'a>,
    held_out: &[Log],
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Judged, FitError> {
    let simulator = attempt.weighing.base.simulator().boxed();
    let report_horizons = misfit::memory(&*simulator, &attempt.found.null, held_out);
    let windows = misfit::windows(&report_horizons);
    let is_free = settings.horizon == Horizon::FreeRun && windows != Horizon::FreeRun;
    if is_free && misfit::is_lost(&attempt.found.null) {
        *attempt = Attempt::new(case, offers, windows, Depth::Singles, settings, monitor)?;
    }
    let Attempt { noise, found, weighing, best, rest, duos, .. } = attempt;
    duos.clear();
    let rules = Rules {
        horizons: &report_horizons,
        sigma: &noise.sigma,
        floor: misfit::floor(&best.errors),
        replicas: settings.replicas,
        seed: settings.seed,
    };
    let Weighing { causes, priors, reference, refitted, observed, base } = weighing;
    let yardstick = Yardstick { noise: priors, reference: *reference };
    let trials = &mut found.trials;
    let logs = held_out;
    let (null, simulator) = (&found.null, &*simulator);
    let judgement =
        misfit::weigh(simulator, null, trials, causes, logs, &rules, yardstick, settings)?;
    let in_doubt = causes.iter().take_while(|(_, cause)| 0.0 < cause.probability).count();
    let (tied, rivals) = separate(&causes[..in_doubt], trials, settings);
    if let Some(first) = Answer::first(causes, trials, refitted, observed) {
        *rest = first.rest(refitted, base, noise, found.is_coloured);
        *best = first;
    }
    let (pairs, tied_pairs, regime) = (Vec::new(), Vec::new(), Regime::AboveTheFloor);
    Ok(Judged { regime, judgement, tied, rivals, pairs, tied_pairs, report_horizons })
}
