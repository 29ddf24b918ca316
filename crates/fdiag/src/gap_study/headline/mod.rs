//! The answer in one sentence.

use self::road::several;
use fd_gap::{
    ceiling::Ceiling,
    diagnose::{Cause, CauseId, Objection, Pair, PairId, Verdict},
    estimate::{Calibrated, Standing},
    fit::Horizon,
    locate::Spectrum,
    quality::Defect,
};
use fd_model::{duration, figure};

use crate::gap_study::{
    log_finding::{LogDefect, LogFinding, TimeBaseDefect},
    report::Report,
    words::{self, capital, list, p, percent, share, with_strength},
};

/// Causes that are named when none stands out.
const NAMED: usize = 3;
/// Probability below which a candidate is not worth its name beside others …
const LEAST: f64 = 0.01;
/// … and from which "none of these" is one.
const DOUBTED: f64 = 0.1;
/// Probability that a named cause is one of two from which that is said.
const SECOND: f64 = 0.1;
/// Share of what is left that "mostly" means.
const MOSTLY: f64 = 0.7;
/// Part of the bands beyond which "mostly" says nothing.
const NARROW: f64 = 0.6;
/// Share of the held-out gap below which what is not significant is nothing.
const SHOWN: f64 = 0.05;

/// Tolerances by which a parameter has moved to speak of: half a standard deviation of what was known …
const SOME: f64 = 0.33;
/// … and two of them, which is an answer.
const FAR: f64 = 1.33;

/// What came out, in one sentence.
pub(super) fn headline(report: &Report) -> String {
    let answer = answer(report) + &left_out(report);
    let answer = match report.time_limit {
        _ if report.stopped.is_empty() => answer,
        Some(limit) => {
            format!("Stopped by the time limit of {}; so far: {answer}", duration(limit))
        }
        None => format!("Stopped before the end; so far: {answer}"),
    };
    let Some(reading) = &report.reading else { return answer };
    format!(
        "The log reads as if {} ({}); with that corrected: {answer}",
        reading.statement,
        p(reading.probability)
    )
}

/// Outputs that stand still in a log, of which the answer says nothing.
fn left_out(report: &Report) -> String {
    let constant = LogDefect::Channel(Defect::Constant);
    let is_still =
        |name: &String| report.findings.iter().any(|f| f.channel == *name && f.defect == constant);
    let names = report.inputs.outputs.iter().map(|output| &output.name);
    let still: Vec<String> =
        names.filter(|name| is_still(name)).map(|name| format!("`{name}`")).collect();
    if still.is_empty() || report.spoiled().is_some() {
        return String::new();
    }
    let (does, was) = if still.len() == 1 { ("does", "was") } else { ("do", "were") };
    let still = list(&still, "and");
    format!(
        " {still} {does} not change in the log and {was} left out: stuck, or logged too coarsely?"
    )
}

fn answer(report: &Report) -> String {
    if let Some(finding) = report.spoiled() {
        return format!(
            "Check the log first: {}, `{}`: {}; as it is, no cause can be named.",
            finding.file,
            finding.channel,
            words::defect(&finding.defect)
        );
    }
    if let Some(road) = report.list() {
        return several(road);
    }
    match report.diagnosis.verdict {
        Verdict::NoGap => no_gap(report),
        Verdict::Cause => cause(report),
        Verdict::Tied => tied(report),
        Verdict::Pair => pair(report),
        Verdict::NoneOfThese => none_of_these(report),
        Verdict::Unclear => unclear(report),
    }
}

fn no_gap(report: &Report) -> String {
    let moved = match far_moved(report) {
        Some(moved) => format!(", {moved},"),
        None => most_moved(report).map_or_else(String::new, |p| {
            let relative = 100.0 * (p.value / p.nominal - 1.0);
            format!(" (most of all `{}`, by {relative:+.1} %)", p.name)
        }),
    };
    let p = p(report.diagnosis.no_gap);
    let slow = words::slow_noise(report);
    let slow =
        slow.map_or_else(String::new, |slow| format!(", if the slow wander of {slow} is noise"));
    let steps = words::steps(report)
        .map_or_else(String::new, |steps| format!("; the rounding of {steps} counts as noise"));
    match words::missed(report) {
        None => format!(
            "No gap: with its parameters refitted within their tolerances{moved} the model explains \
             the logs down to the noise ({p}){slow}{steps}."
        ),
        Some(missed) => format!(
            "No gap in the fitted logs, which the model explains down to the noise with its parameters \
             refitted within their tolerances{moved} ({p}){slow}; but {missed}."
        ),
    }
}

/// The parameter that has moved furthest, for what was known of it, if any has moved to speak of.
fn most_moved(report: &Report) -> Option<&Calibrated> {
    let by_distance =
        |a: &&Calibrated, b: &&Calibrated| a.tolerances.abs().total_cmp(&b.tolerances.abs());
    let moved = report.diagnosis.parameters.iter().max_by(by_distance);
    moved.filter(|p| SOME < p.tolerances.abs())
}

/// Parameters that have moved further than what was known of them lets expect, which is an answer in itself.
fn far_moved(report: &Report) -> Option<String> {
    let far = report.diagnosis.parameters.iter().filter(|p| FAR < p.tolerances.abs());
    let told = far.map(|p| {
        let way = if p.tolerances < 0.0 { "below" } else { "above" };
        let most = if p.standing == Standing::AtEdge { ", the most allowed" } else { "" };
        let (by, to) = (100.0 * (p.value / p.nominal - 1.0).abs(), p.tolerances.abs());
        format!("`{}` {by:.1} % {way} nominal ({to:.1} tolerances{most})", p.name)
    });
    let told: Vec<String> = told.collect();
    (!told.is_empty()).then(|| list(&told, "and"))
}

fn cause(report: &Report) -> String {
    let Some(first) = report.diagnosis.causes.first() else { return no_gap(report) };
    let at_work = report.diagnosis.at_work(first);
    let beside =
        if first.probability + SECOND < at_work { ", alone or with a second cause" } else { "" };
    format!(
        "{}{beside}, {}; {}.",
        capital(&with_strength(first)),
        p(at_work),
        closes(report, "adding it")
    )
}

fn tied(report: &Report) -> String {
    let causes = report.diagnosis.causes.iter().enumerate();
    let tied = causes.filter(|(i, _)| report.tied().contains(&CauseId(*i)));
    let tied: Vec<&Cause> = tied.map(|(_, cause)| cause).collect();
    let names: Vec<String> = tied.iter().map(|cause| with_strength(cause)).collect();
    let together: f64 = tied.iter().map(|cause| cause.probability).sum();
    format!(
        "{} (together {}): this log cannot tell which; {}.",
        capital(&list(&names, "or")),
        p(together),
        closes(report, "adding the first")
    )
}

fn pair(report: &Report) -> String {
    let names = |pair: &Pair| list(&pair.causes.each_ref().map(with_strength), "and");
    let pairs = report.diagnosis.pairs.iter().enumerate();
    let tied = pairs.filter(|(i, _)| report.tied_pairs().contains(&PairId(*i)));
    let tied: Vec<String> = tied.map(|(_, pair)| names(pair)).collect();
    match report.diagnosis.pairs.first() {
        None => unclear(report),
        Some(_) if 1 < tied.len() => format!(
            "Two causes together, {}: this log cannot tell which; {}.",
            list(&tied, "or"),
            closes(report, "adding the first two")
        ),
        Some(pair) => format!(
            "Two causes together: {}, {}; {}.",
            names(pair),
            p(pair.probability),
            closes(report, "adding both")
        ),
    }
}

fn none_of_these(report: &Report) -> String {
    let best = report.diagnosis.causes.first().map_or_else(String::new, |first| {
        format!(
            ": the best, {}, leaves {:.1} times the noise{}",
            words::cause(first),
            first.gap,
            mostly(&report.location.spectra)
        )
    });
    let black_box = report.ceiling.as_ref().and_then(Ceiling::share);
    let black_box = black_box.map_or_else(String::new, |closed| {
        if closed.interval[0] <= 0.0 && closed.fraction < SHOWN {
            return "; nor does a black-box compensation remove it from held-out data".to_owned();
        }
        format!(
            "; a black-box compensation could remove {} of the gap on held-out data",
            share(closed.fraction, closed.interval)
        )
    });
    let edges = |objection: &Objection| matches!(objection, Objection::ParametersAtEdges { .. });
    let objections = &report.diagnosis.objections;
    // Where many are at their edges that is said already.
    let moved = far_moved(report).filter(|_| !objections.iter().any(edges));
    let moved = moved.map(|moved| format!("with {moved}"));
    let against = objections.iter().map(words::objection);
    let first = std::iter::once(format!("{best}{black_box}"));
    let rest: Vec<String> = first.chain(moved).chain(against).collect();
    format!(
        "None of the known effects explains the gap ({}){}.",
        p(report.diagnosis.none_of_these),
        rest.join("; ")
    )
}

fn unclear(report: &Report) -> String {
    let diagnosis = &report.diagnosis;
    let against = diagnosis.objections.iter().filter(|objection| objection.forbids());
    let against: Vec<String> = against.map(words::objection).collect();
    if let (Some(first), false) = (diagnosis.causes.first(), against.is_empty()) {
        let best = match diagnosis.pairs.first().filter(|p| first.probability < p.probability) {
            Some(pair) => words::pair(pair),
            None => words::cause(first),
        };
        return format!(
            "No cause can be named: {best} explains the fitted logs best, but {}.",
            list(&against, "and")
        );
    }
    let singles = diagnosis.causes.iter().map(|cause| (words::cause(cause), cause.probability));
    let pairs = diagnosis.pairs.iter().map(|pair| (words::pair(pair), pair.probability));
    let mut candidates: Vec<(String, f64)> = pairs.chain(singles).collect();
    candidates.sort_by(|a, b| b.1.total_cmp(&a.1));
    let least = candidates.first().map_or(0.0, |(_, first)| first.min(LEAST));
    candidates.retain(|(_, probability)| least <= *probability);
    let names = candidates.into_iter().take(NAMED).map(|(name, is)| format!("{name} ({})", p(is)));
    let none = format!("none of the known effects ({})", p(diagnosis.none_of_these));
    let none = (DOUBTED <= diagnosis.none_of_these).then_some(none);
    let names: Vec<String> = names.chain(none).collect();
    let group = diagnosis.groups.first().filter(|group| {
        diagnosis.causes.first().is_some_and(|c| c.probability + 0.1 < group.probability)
    });
    let group = group.map_or_else(String::new, |group| {
        format!("; {} altogether has {}", words::group(group), p(group.probability))
    });
    let missed =
        words::missed(report).map_or_else(String::new, |missed| format!("; at best, {missed}"));
    format!(
        "Unclear: no single cause stands out; candidates are {}, and no gap ({}){group}{missed}.",
        list(&names, "and"),
        p(diagnosis.no_gap)
    )
}

/// How far the gap shrinks, and where the rest is.
fn closes(report: &Report, adding: &str) -> String {
    let Some(held_out) = report.forecast() else {
        return format!("{adding} was not checked on held-out data, because there are none");
    };
    let Some(closed) = held_out.closed() else {
        return "the held-out data show no gap above the noise".to_owned();
    };
    if closed.fraction == 0.0 && closed.interval == [0.0, 0.0] {
        return "it only changes the measurement, so it brings no simulation closer".to_owned();
    }
    let of = if held_out.closed_of_refit.is_some() {
        "the gap that refitted parameters leave on held-out data"
    } else {
        "the gap on held-out data"
    };
    let of = match held_out.horizon {
        Horizon::FreeRun => of.to_owned(),
        Horizon::Windows { .. } => {
            format!("{of}, in forecasts of {}", duration(held_out.seconds))
        }
    };
    let is_clock = |f: &LogFinding| f.defect == LogDefect::TimeBase(TimeBaseDefect::Clock);
    let [low, high] = closed.interval;
    let rest = match 1.0 - closed.fraction {
        rest if rest < 0.005 => String::new(),
        _ if closed.fraction < 0.0 && report.findings.iter().any(is_clock) => {
            ", as it depends on the time since the start of a run".to_owned()
        }
        _ if high < 0.0 => ": the held-out data contradict it".to_owned(),
        _ if low < 0.0 && closed.fraction < SHOWN => {
            ": the held-out data do not show it".to_owned()
        }
        rest => format!("; {} remains{}", percent(rest), mostly(&report.location.spectra)),
    };
    let redrawn =
        if held_out.is_redrawn { ", with its path over time drawn anew there," } else { "" };
    format!("{adding}{redrawn} closes {} of {of}{rest}", share(closed.fraction, closed.interval))
}

/// Where in frequency most of what is left above the floor is, if it is anywhere in particular.
fn mostly(spectra: &[Spectrum]) -> String {
    let excess = |spectrum: &Spectrum| -> Vec<f64> {
        let bands = spectrum.bands.iter();
        bands
            .map(|b| if b.is_above_floor_after { (b.after - b.floor).max(0.0) } else { 0.0 })
            .collect()
    };
    let total = |spectrum: &Spectrum| excess(spectrum).iter().sum::<f64>();
    let Some(worst) = spectra.iter().max_by(|a, b| total(a).total_cmp(&total(b))) else {
        return String::new();
    };
    let (excess, all) = (excess(worst), total(worst));
    let n = excess.len();
    // The narrowest run of bands that has most of it.
    let runs = (0..n).flat_map(|from| (from + 1..=n).map(move |to| (from, to)));
    let has_most =
        |(from, to): &(usize, usize)| MOSTLY * all <= excess[*from..*to].iter().sum::<f64>();
    let narrowest = runs.filter(has_most).min_by_key(|(from, to)| to - from);
    let Some((from, to)) = narrowest.filter(|_| 0.0 < all) else { return String::new() };
    if NARROW * (n as f64) < (to - from) as f64 {
        return String::new();
    }
    let output = if 1 < spectra.len() { format!(" in {}", worst.output) } else { String::new() };
    match (from, to) {
        (0, to) => format!(", mostly below {} Hz{output}", figure(worst.bands[to - 1].high_hz)),
        (from, to) if to == n => {
            format!(", mostly above {} Hz{output}", figure(worst.bands[from].low_hz))
        }
        (from, to) => format!(
            ", mostly between {} and {} Hz{output}",
            figure(worst.bands[from].low_hz),
            figure(worst.bands[to - 1].high_hz)
        ),
    }
}

mod road;
#[cfg(test)]
mod tests;
