//! How reliable a diagnosis of such a log is: the same diagnosis of simulated logs with known causes.
//!
//! The leading causes, as fitted, and "no gap" are simulated with the logged inputs, the noise found, and newly
//! drawn uncertain parameters; each log is diagnosed in the same way. The result is the confusion matrix to
//! expect for *this* log, the temperature that calibrates the probabilities, and sets that contain the truth in
//! 90 % of such logs.
//!
//! *When not to use:* it shows whether causes can be separated, and nothing about a cause that is not in the
//! library. Logs in which every cause leaves more than noise (regime above the floor) are simulated without
//! that remainder: rows are then too optimistic, and the temperature means nothing. Strengths are the fitted
//! ones: if an effect was fitted as weak, its row is that of a weak effect.

mod replica;
mod result;
mod verdicts;

use crate::together::each;

pub use self::result::{Confusion, Truth};
use self::{
    replica::Source,
    verdicts::{Answers, Outcome, best_temperature, column},
};
use crate::{
    diagnose::{
        Case, Cause, CauseId, Diagnosis, Monitor, Regime, Settings, Stage, Start, diagnose,
    },
    fit::FitError,
    locate::{bench::Bench, places::name},
};

/// Most causes that are simulated.
const MOST_CAUSES: usize = 4;
/// Part of such logs whose truth may be outside of the set.
const OUTSIDE: f64 = 0.1;

/// Diagnoses `replicas` simulated logs for each of the leading causes and for "no gap". The seed of
/// the settings settles the answer, whatever the number of threads. The monitor sees one stage,
/// [`Stage::Calibrate`], with a piece per replica. What comes out after the monitor has stopped it, of the replicas that
/// had been begun, is worth little: the later rows have fewest.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::{diagnose::{Case, Settings, diagnose}, calibrate::self_calibrate};
/// use fd_sim::model::Model;
/// # use fd_model::{Channel, Record};
/// # let model: Model = r#"
/// # version = 1
/// # kind = "equations"
/// # name = "lag"
/// # sample_time = 0.1
/// # inputs = { u = { unit = "V" } }
/// # outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// # parameters = { T = { unit = "s", value = 1.0 } }
/// # states = { x = { unit = "V", initial = 0.0, derivative = "(u - x)/T" } }
/// # "#.parse()?;
/// # let (u, y) = ([Channel::new("u", "V")], [Channel::new("y", "V")]);
/// # let noise = |k: u32| 0.01 * f64::from(k * 7919 % 13).sin();
/// # let x = |k: u32| 1.0 - (-0.1 * f64::from(k)).exp();
/// # let rows = (0..100).map(|k| ([1.0], [x(k) + noise(k)]));
/// # let log = Record::from_rows(u.to_vec(), y.to_vec(), rows, model.sample_time()?)?;
/// let (logs, held_out) = ([log.clone()], [log]);
/// let suspects: Vec<Candidate> = Vec::new();
/// let case = Case { nominal: &model, suspects: &suspects, logs: &logs, held_out: &held_out };
/// let settings = Settings::default();
/// let diagnosis = diagnose(&case, &settings, &())?;
/// let confusion = self_calibrate(&case, &diagnosis, &settings, 4, &())?;
/// assert_eq!(confusion.counts, [[4, 0, 0]]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the model cannot be simulated or does not fit the logs of the case.
pub fn self_calibrate(
    case: &Case<'_>,
    diagnosis: &Diagnosis,
    settings: &Settings,
    replicas: usize,
    monitor: &dyn Monitor,
) -> Result<Confusion, FitError> {
    let bench = Bench::new(case, diagnosis)?;
    let source = Source::new(case, diagnosis, &bench);
    let leading = leading(diagnosis);
    let truths: Vec<Option<&Cause>> =
        std::iter::once(None).chain(leading.iter().map(|id| diagnosis.cause(*id))).collect();
    let jobs: Vec<(usize, usize)> =
        (0..truths.len()).flat_map(|row| (0..replicas).map(move |i| (row, i))).collect();
    monitor.begin(Stage::Calibrate, jobs.len());
    let outcomes = each(jobs, |(row, i)| {
        if monitor.is_over() || monitor.is_stopped() {
            return None;
        }
        let (model, starts) = match truths[row] {
            None => (&diagnosis.refit.model, diagnosis.refit.starts.clone()),
            Some(cause) => (&cause.model, starts(diagnosis, cause)),
        };
        let seed = seed(settings.seed, row, i);
        let outcome = source.draw(model, &starts, seed).and_then(|logs| {
            let case = Case { logs: &logs, held_out: &[], ..*case };
            // A replica that cannot be diagnosed is left out, and counted as such.
            let found = diagnose(&case, settings, &()).ok()?;
            let answers = Answers::of(&found, truths[row], settings.no_gap);
            Some(Outcome { row, column: column(&found, &truths, row), answers })
        });
        monitor.advance();
        outcome
    });
    let outcomes: Vec<Outcome> = outcomes.into_iter().flatten().collect();
    Ok(confusion(diagnosis, settings, &leading, &outcomes))
}

fn confusion(
    diagnosis: &Diagnosis,
    settings: &Settings,
    leading: &[CauseId],
    outcomes: &[Outcome],
) -> Confusion {
    let truth = |id: Option<CauseId>| {
        let words = |cause: &Cause| format!("{} at {}", cause.label, name(&cause.site));
        let cause = id.and_then(|id| diagnosis.cause(id));
        Truth { cause: id, name: cause.map_or_else(|| "no gap".to_owned(), words) }
    };
    let truths: Vec<Truth> =
        std::iter::once(None).chain(leading.iter().copied().map(Some)).map(truth).collect();
    let extra = ["another cause", "no answer"].map(str::to_owned);
    let columns: Vec<String> = truths.iter().map(|t| t.name.clone()).chain(extra).collect();
    let mut counts = vec![vec![0; columns.len()]; truths.len()];
    for outcome in outcomes {
        counts[outcome.row][outcome.column] += 1;
    }
    let n = outcomes.len().max(1) as f64;
    let right = outcomes.iter().filter(|o| o.row == o.column).count() as f64;
    let top = |o: &Outcome| o.answers.top(settings.temperature);
    let temperature = best_temperature(outcomes, settings.temperature);
    let mut scores: Vec<f64> = outcomes.iter().map(|o| o.answers.of_truth(temperature)).collect();
    scores.sort_by(f64::total_cmp);
    // The k-th smallest of n, k = ⌊(n + 1) 10 %⌋: a new one is below it in at most 10 %.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let rank = ((scores.len() + 1) as f64 * OUTSIDE) as usize;
    let threshold = rank.checked_sub(1).and_then(|k| scores.get(k)).copied().unwrap_or(0.0);
    let size = |o: &Outcome| o.answers.at_least(threshold, temperature) as f64;
    let set = Answers::of(diagnosis, None, settings.no_gap).set(threshold, temperature);
    let mut confusion = Confusion {
        replicas: counts.iter().map(|row| row.iter().sum()).collect(),
        truths,
        columns,
        counts,
        accuracy: right / n,
        confidence: outcomes.iter().map(top).sum::<f64>() / n,
        temperature,
        threshold,
        set_size: outcomes.iter().map(size).sum::<f64>() / n,
        set,
        statement: String::new(),
    };
    confusion.statement = words(&confusion, diagnosis.regime);
    confusion
}

/// Causes that are worth a row: the tied ones, the rivals, then others, as far as there is evidence
/// for them.
fn leading(diagnosis: &Diagnosis) -> Vec<CauseId> {
    let rivals = diagnosis.rivals.iter().map(|rival| rival.cause);
    let others = (0..diagnosis.causes.len()).map(CauseId);
    let mut all: Vec<CauseId> = Vec::new();
    for id in diagnosis.tied.iter().copied().chain(rivals).chain(others) {
        let is_evident = diagnosis.cause(id).is_some_and(|c| 0.0 < c.log_evidence);
        if is_evident && !all.contains(&id) {
            all.push(id);
        }
    }
    all.truncate(MOST_CAUSES);
    all
}

/// Where the logs start with a cause: as fitted for the best one, else as the model says.
fn starts(diagnosis: &Diagnosis, cause: &Cause) -> Vec<Start> {
    if diagnosis.best.model == cause.model {
        return diagnosis.best.starts.clone();
    }
    let state = cause.model.initial();
    let start = |start: &Start| Start { state: state.clone(), ..start.clone() };
    diagnosis.refit.starts.iter().map(start).collect()
}

/// Seeds that differ by row and replica.
fn seed(seed: u64, row: usize, replica: usize) -> u64 {
    seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ ((row as u64) << 32 | replica as u64)
}

fn words(confusion: &Confusion, regime: Regime) -> String {
    let Confusion { accuracy, confidence, temperature, set_size, .. } = confusion;
    let total: usize = confusion.replicas.iter().sum();
    if total == 0 {
        return "no simulated log could be diagnosed".to_owned();
    }
    let blamed: usize = confusion.counts[0][1..confusion.columns.len() - 1].iter().sum();
    let null = confusion.replicas[0];
    let right = format!(
        "on {total} simulated logs like this one the diagnosis is right in {:.0} % (and {:.0} % certain \
         of it); it blames a cause in {blamed} of {null} logs without a gap",
        100.0 * accuracy,
        100.0 * confidence
    );
    match regime {
        Regime::AtTheFloor => format!(
            "{right}; sets of {set_size:.1} answers contain the truth in 90 %, with temperature \
             {temperature:.2}"
        ),
        // What no effect explains is not simulated, and sharpens likelihoods.
        Regime::AboveTheFloor => format!(
            "{right}. These logs leave more than the noise, the simulated ones do not: expect \
             worse, and do not use the temperature"
        ),
    }
}
