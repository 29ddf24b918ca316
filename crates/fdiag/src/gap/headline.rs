//! The answer in one sentence.

use super::{
    report::{CauseReport, FindingReport, PairReport, Report, SpectrumReport},
    words::{list, p, percent, share},
};

/// Causes that are named when none stands out.
const NAMED: usize = 3;
/// Share of what is left that "mostly" means.
const MOSTLY: f64 = 0.7;
/// Part of the bands beyond which "mostly" says nothing.
const NARROW: f64 = 0.6;

/// What came out, in one sentence.
pub(super) fn headline(report: &Report) -> String {
    if let Some(finding) = spoiled(report) {
        return format!(
            "Check the log first: {}, `{}`: {}; as it is, no cause can be named.",
            finding.file, finding.channel, finding.text
        );
    }
    match report.verdict {
        "no-gap" => no_gap(report),
        "cause" => cause(report),
        "tied" => tied(report),
        "pair" => pair(report),
        "none-of-these" => none_of_these(report),
        _ => unclear(report),
    }
}

/// A finding that makes every answer void: a log that is not what it claims to be, or that says
/// nothing at all.
pub(super) fn spoiled(report: &Report) -> Option<&FindingReport> {
    let mislabelled = report.findings.iter().find(|f| matches!(f.kind, "wrong-unit" | "swapped"));
    let is_still = |output: &str| {
        let still = |f: &&FindingReport| {
            f.channel == output && matches!(f.kind, "not-excited" | "constant")
        };
        report.findings.iter().find(still)
    };
    mislabelled.or_else(|| {
        let still: Vec<_> = report.noise.iter().map(|noise| is_still(&noise.output)).collect();
        if still.iter().all(Option::is_some) { still.into_iter().flatten().next() } else { None }
    })
}

fn no_gap(report: &Report) -> String {
    let moved = report
        .parameters
        .iter()
        .max_by(|a, b| a.deviation_sd.abs().total_cmp(&b.deviation_sd.abs()));
    let moved = moved.filter(|p| 0.5 < p.deviation_sd.abs()).map_or_else(String::new, |p| {
        let relative = 100.0 * (p.refitted / p.nominal - 1.0);
        format!(" (most of all `{}`, by {relative:+.1} %)", p.name)
    });
    format!(
        "No gap: with its parameters refitted within their tolerances{moved} the model explains \
         the logs down to the noise ({}).",
        p(report.no_gap)
    )
}

fn cause(report: &Report) -> String {
    let Some(first) = report.causes.first() else { return no_gap(report) };
    format!(
        "{}{}, {}; {}.",
        capital(&first.name),
        in_parentheses(&first.strength),
        p(first.probability),
        closes(report, "adding it")
    )
}

fn tied(report: &Report) -> String {
    let tied: Vec<&CauseReport> = report.causes.iter().filter(|cause| cause.is_tied).collect();
    let names: Vec<String> = tied
        .iter()
        .map(|cause| format!("{}{}", cause.name, in_parentheses(&cause.strength)))
        .collect();
    let together: f64 = tied.iter().map(|cause| cause.probability).sum();
    format!(
        "{} (together {}): this log cannot tell which; {}.",
        capital(&list(&names, "or")),
        p(together),
        closes(report, "adding the first")
    )
}

fn pair(report: &Report) -> String {
    let names = |pair: &PairReport| {
        let each = pair.causes.iter();
        let names: Vec<String> = each
            .map(|cause| format!("{}{}", cause.name, in_parentheses(&cause.strength)))
            .collect();
        list(&names, "and")
    };
    let tied: Vec<String> = report.pairs.iter().filter(|pair| pair.is_tied).map(names).collect();
    match report.pairs.first() {
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
    let best = report.causes.first().map_or_else(String::new, |first| {
        format!(
            ": the best, {}, leaves {:.1} times the noise{}",
            first.name,
            first.gap_sigma,
            mostly(&report.location.spectra)
        )
    });
    let black_box = report.ceiling.as_ref().and_then(|ceiling| {
        let both = [&ceiling.linear, &ceiling.nonlinear];
        let shares = both.into_iter().flatten().filter_map(|c| c.closed);
        shares.max_by(|a, b| a.fraction.total_cmp(&b.fraction))
    });
    let black_box = black_box.map_or_else(String::new, |closed| {
        format!(
            "; a black-box compensation could remove {} of the gap on held-out data",
            share(closed.fraction, [closed.low, closed.high])
        )
    });
    format!(
        "None of the known effects explains the gap ({}){best}{black_box}.",
        p(report.none_of_these)
    )
}

fn unclear(report: &Report) -> String {
    let first = report.causes.iter().take(NAMED);
    let names: Vec<String> =
        first.map(|cause| format!("{} ({})", cause.name, p(cause.probability))).collect();
    let group = report.groups.first().filter(|group| {
        report.causes.first().is_some_and(|c| c.probability + 0.1 < group.probability)
    });
    let group = group.map_or_else(String::new, |group| {
        format!("; {} altogether has {}", group.name, p(group.probability))
    });
    format!(
        "Unclear: no single cause stands out; candidates are {}, and no gap ({}){group}.",
        list(&names, "and"),
        p(report.no_gap)
    )
}

/// How far the gap shrinks, and where the rest is.
fn closes(report: &Report, adding: &str) -> String {
    let Some(horizon) = report.how_far.first() else {
        return format!("{adding} was not checked on held-out data, as there are none");
    };
    let Some(closed) = horizon.closed() else {
        return "the held-out data show no gap above the noise".to_owned();
    };
    let of = if horizon.closed_of_refit.is_some() {
        "the gap that refitted parameters leave on held-out data"
    } else {
        "the gap on held-out data"
    };
    let rest = match 1.0 - closed.fraction {
        rest if rest < 0.005 => String::new(),
        _ if closed.fraction < 0.0 => ": the held-out data contradict it".to_owned(),
        rest => format!("; {} remains{}", percent(rest), mostly(&report.location.spectra)),
    };
    format!("{adding} closes {} of {of}{rest}", share(closed.fraction, [closed.low, closed.high]))
}

/// Where in frequency most of what is left above the floor is, if it is anywhere in particular.
pub(super) fn mostly(spectra: &[SpectrumReport]) -> String {
    let excess = |spectrum: &SpectrumReport| -> Vec<f64> {
        let bands = spectrum.bands.iter();
        bands
            .map(|b| if b.is_above_floor_after { (b.after - b.floor).max(0.0) } else { 0.0 })
            .collect()
    };
    let total = |spectrum: &SpectrumReport| excess(spectrum).iter().sum::<f64>();
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
    let hz = |f: f64| crate::report::figure(f);
    let output = if 1 < spectra.len() { format!(" in {}", worst.output) } else { String::new() };
    match (from, to) {
        (0, to) => format!(", mostly below {} Hz{output}", hz(worst.bands[to - 1].high_hz)),
        (from, to) if to == n => {
            format!(", mostly above {} Hz{output}", hz(worst.bands[from].low_hz))
        }
        (from, to) => format!(
            ", mostly between {} and {} Hz{output}",
            hz(worst.bands[from].low_hz),
            hz(worst.bands[to - 1].high_hz)
        ),
    }
}

fn in_parentheses(text: &str) -> String {
    if text.is_empty() { String::new() } else { format!(" ({text})") }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect())
}
