//! What to do next.

use fd_gap::diagnose::{ControllerSees, Diagnosis, Objection, Verdict};

use super::{
    further::advice,
    labels::{capital, list},
    missed::missed,
    slow_noise::slow_noise,
};
use crate::gap_study::{report::Report, whole::Whole};
use fd_model::figure;

/// Reasons of refusals that a line of the model file lifts.
const LIFTABLE: &str = "position";
/// Coherence of what is left with an input from which a law of that input may explain it.
const COHERENT: f64 = 0.5;
/// Part of a gap that a black box must remove for it to follow from the inputs.
const FORETOLD: f64 = 0.1;
/// Probability of "none of these" from which an unclear answer says what is left.
const DOUBTED: f64 = 0.3;

/// What to do next, the most useful first. Never empty when the answer is tied, unclear or none of these: the
/// input, sensor, rate or line of the model that would decide, or the statement that none in reach would.
pub(in crate::gap_study) fn next_steps(report: &Report) -> Vec<String> {
    let diagnosis = &report.diagnosis;
    let mut steps = Vec::new();
    let is_list = report.list().is_some();
    let is_open = !is_list
        && matches!(diagnosis.verdict, Verdict::Tied | Verdict::Unclear | Verdict::NoneOfThese);
    // That two causes need not be told apart says nothing where none is believed.
    let advised = report.advice.as_ref().filter(|found| !is_open || !found.between.is_empty());
    let said = advised.map(|found| advice(found, diagnosis));
    steps.extend(said.filter(|text| !text.is_empty()).map(|text| format!("{text}.")));
    steps.extend(diagnosis.objections.iter().filter_map(cure));
    steps.extend(report.whole.as_ref().and_then(unlike));
    steps.extend(missed(report).as_deref().map(fit_as_well));
    steps.extend(slow_noise(report).as_deref().map(state_it));
    let is_doubted = diagnosis.verdict == Verdict::Unclear && DOUBTED <= diagnosis.none_of_these;
    if !is_list && (diagnosis.verdict == Verdict::NoneOfThese || is_doubted) {
        steps.extend(liftable(report));
        steps.extend(limits(report));
        steps.push(of_what_is_left(report));
    }
    if is_open && diagnosis.verdict != Verdict::Tied {
        steps.extend(other_loop(report));
    }
    let is_mute = is_open && steps.is_empty();
    steps.extend(idle(&diagnosis.idle));
    if is_mute {
        steps.push(
            "No excitation, sensor or sampling within the range of this log would separate the \
             candidates: they are equivalent in this plant, unless it is taken apart."
                .to_owned(),
        );
    }
    steps
}

/// That limits were not tried, of which a linearised simulator knows nothing.
fn limits(report: &Report) -> Option<String> {
    let is_left = report.sparing.as_ref().is_some_and(|sparing| !sparing.limits);
    is_left.then(|| {
        "Search on the simulator itself (`--thorough`, some thousands of runs): the few runs of this diagnosis rest on a \
         linearisation, which knows nothing of limits that are reached only in reality."
            .to_owned()
    })
}

/// Parameters that nothing depends on.
fn idle(names: &[String]) -> Option<String> {
    let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
    let move_ = if names.len() == 1 { "moves" } else { "move" };
    (!names.is_empty()).then(|| {
        format!(
            "{} {move_} no output in these logs, which therefore say nothing about {}: if this is unexpected, check \
             whether the simulator uses it.",
            list(&quoted, "and"),
            if names.len() == 1 { "its value" } else { "their values" }
        )
    })
}

/// What was taken for noise, and how to say otherwise.
fn state_it(slow: &str) -> String {
    format!(
        "The slow wander of {slow} counts as noise, since nothing that was logged predicts it: if the sensor is better \
         than that, state its noise (`noise = …`, a standard deviation); then the wander counts as a gap."
    )
}

/// What to do about held-out data that contradict the fitted logs.
fn fit_as_well(missed: &str) -> String {
    format!(
        "{}, fitted logs are not: pass the held-out log to `--log` as well and hold out another. It shows something \
         that the fitted ones do not, or begins outside the range that the model allows (then widen the `tolerance` \
         of the initial states).",
        capital(missed)
    )
}

/// What would take an objection away.
fn cure(objection: &Objection) -> Option<String> {
    match objection {
        Objection::FaintStrength { .. } => Some(
            "Log a longer run, or one with larger motion: the strength is not much above its error."
                .to_owned(),
        ),
        Objection::NoBetterThanConstant
        | Objection::NoBetterThanLastValue
        | Objection::WorseThanNominal => Some(
            "Check the model and the reading of the log (signs, units, columns, start) before \
             considering any effect: its forecasts are useless."
                .to_owned(),
        ),
        Objection::WorseThanRefitted | Objection::NotShown => Some(
            "Log a second run in which the suspected effect shows more: this one does not carry over."
                .to_owned(),
        ),
        Objection::ParametersAtEdges { names, is_most: true, .. } => Some(format!(
            "Check {}: the fit wants them farther from nominal than their tolerances allow.",
            list(&names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>(), "and")
        )),
        Objection::ParametersAtEdges { .. } => None,
        Objection::ReadsBeyondLimit { .. } => Some(
            "Check the sensor itself: the log has readings that a saturated one could not give."
                .to_owned(),
        ),
    }
}

/// Windows of a long log that are unlike the others.
fn unlike(whole: &Whole) -> Option<String> {
    let worst = whole.unlike.first()?;
    let (of, count) = (whole.windows, whole.unlike_count);
    Some(format!(
        "Look at what happened in rows {} to {} of {}: the forecast there misses by {} times the noise, \
         {} in the median of all windows ({count} of {of} are unlike the others).",
        worst.rows[0],
        worst.rows[1],
        worst.file,
        figure(worst.explained),
        figure(whole.explained),
    ))
}

/// Effects that were refused for want of something that the user can say.
fn liftable(report: &Report) -> Option<String> {
    let refused = report.diagnosis.not_tested.iter();
    let mut names: Vec<String> = refused
        .filter(|refusal| refusal.reason.contains(LIFTABLE))
        .map(|refusal| {
            format!(
                "{} at {}",
                refusal.label.replace('-', " "),
                refusal.site.name().unwrap_or("it")
            )
        })
        .collect();
    names.sort();
    names.dedup();
    (!names.is_empty()).then(|| {
        format!(
            "Not tried because no position is known: {}. Name what moves there in the table `[sites]` of the \
             model (`position = \"…\"`), and they will be.",
            list(&names, "and")
        )
    })
}

/// That the controller may have acted on something else than it was run on.
fn other_loop(report: &Report) -> Option<String> {
    let Diagnosis { is_logged_loop, can_see_the_log, .. } = report.diagnosis;
    let is_open = can_see_the_log && report.settings.controller_sees == ControllerSees::Either;
    let (was, other) =
        if is_logged_loop { ("logged", "simulated") } else { ("simulated", "logged") };
    is_open.then(|| {
        format!(
            "Say what the controller acts on, if you know: it was run on what is {was}, which leaves less without any effect; \
             `--controller-sees {other}` is the other way."
        )
    })
}

/// What may be slow noise, of which the size is taken from its quick part as long as nobody states it.
fn unstated_noise(report: &Report) -> String {
    let unstated = report.inputs.outputs.iter().find(|output| output.noise.is_none());
    unstated.map_or_else(String::new, |output| {
        format!(
            " If it is slow noise of a sensor, state how much it has (`noise = …` of `{}`, a standard deviation).",
            output.name
        )
    })
}

/// Where to look for an effect that nobody has listed.
fn of_what_is_left(report: &Report) -> String {
    let spectra = report.location.spectra.iter();
    let coherent = spectra.flat_map(|spectrum| &spectrum.bands).filter(|b| b.is_above_floor_after);
    let best = coherent.flat_map(|band| band.coherence.iter().flatten()).copied();
    let best = best.fold(0.0, f64::max);
    let ceiling = report.ceiling.as_ref().and_then(fd_gap::ceiling::Ceiling::share);
    let is_known =
        ceiling.is_some_and(|closed| 0.0 < closed.interval[0] && FORETOLD < closed.fraction);
    let place = report.location.places.iter().find(|place| !place.statement.is_empty());
    let place = place.map_or_else(String::new, |place| format!(" {}.", capital(&place.statement)));
    if is_known || COHERENT < best {
        format!(
            "What is left follows from the logged inputs, so it is a law that the library lacks: write it \
             as an effect of your own, or into the model.{place}"
        )
    } else {
        format!(
            "What is left does not follow from the logged inputs: look for an input, a disturbance or a \
             mode of operation that is not in the log, and log it.{}{place}",
            unstated_noise(report)
        )
    }
}
