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
/// Share of the held-out gap below which what is not significant is nothing.
const SHOWN: f64 = 0.05;

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
    let is_wrong = |f: &&FindingReport| matches!(f.kind, "wrong-unit" | "swapped" | "undriven");
    let mislabelled = report.findings.iter().find(is_wrong);
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
        if closed.low <= 0.0 && closed.fraction < SHOWN {
            return "; nor does a black-box compensation remove it from held-out data".to_owned();
        }
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
        _ if closed.fraction < 0.0 && report.findings.iter().any(|f| f.kind == "clock") => {
            ", as it depends on the time since the start of a run".to_owned()
        }
        _ if closed.high < 0.0 => ": the held-out data contradict it".to_owned(),
        _ if closed.low < 0.0 && closed.fraction < SHOWN => {
            ": the held-out data do not show it".to_owned()
        }
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
    let hz = |f: f64| fd_report::figure(f);
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

pub(super) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |c| c.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::report::{
        BandReport, CeilingReport, ClosedReport, CompensationReport, GroupReport, HorizonReport,
        NoiseReport, NuisanceReport,
    };

    fn named(name: &str, strength: &str, probability: f64) -> CauseReport {
        let (name, strength) = (name.to_owned(), strength.to_owned());
        CauseReport { name, strength, probability, gap_sigma: 3.25, ..CauseReport::default() }
    }

    fn closed(fraction: f64, low: f64, high: f64) -> ClosedReport {
        ClosedReport { fraction, low, high, block_samples: 50 }
    }

    /// A report in which Coulomb friction leads, and most of what is left is in the last band.
    fn report(verdict: &'static str) -> Report {
        let band = |low_hz, high_hz, after| BandReport {
            low_hz,
            high_hz,
            after,
            floor: 0.1,
            is_above_floor_after: 0.1 < after,
            ..BandReport::default()
        };
        let bands = vec![band(0.0, 4.0, 0.12), band(4.0, 12.0, 0.1), band(12.0, 50.0, 0.9)];
        let spectrum = SpectrumReport { output: "y".into(), bands, statement: String::new() };
        let mut report = Report {
            verdict,
            no_gap: 0.2,
            none_of_these: 0.93,
            causes: vec![
                named("Coulomb friction at joint 2", "0.31 ± 0.02 N m", 0.97),
                named("delay at input u", "12 ± 1 ms", 0.02),
            ],
            how_far: vec![HorizonReport {
                horizon: "free-run",
                closed_of_refit: Some(closed(0.92, 0.88, 0.95)),
                ..HorizonReport::default()
            }],
            noise: vec![NoiseReport { output: "y".into(), ..NoiseReport::default() }],
            ..Report::default()
        };
        report.location.spectra = vec![spectrum];
        report
    }

    #[test]
    fn a_cause() {
        assert_eq!(
            headline(&report("cause")),
            "Coulomb friction at joint 2 (0.31 ± 0.02 N m), p = 0.97; adding it closes 92 % \
             (88..95) of the gap that refitted parameters leave on held-out data; 8 % remains, \
             mostly above 12.0 Hz."
        );
    }

    #[test]
    fn causes_that_are_tied_or_act_together() {
        let mut tied = report("tied");
        tied.causes.iter_mut().for_each(|cause| cause.is_tied = true);
        let text = headline(&tied);
        let expected = "Coulomb friction at joint 2 (0.31 ± 0.02 N m) or delay at input u (12 ± 1 \
                        ms) (together p = 0.99): this log cannot tell which; adding the first";
        assert!(text.starts_with(expected), "{text}");
        let mut pair = report("pair");
        let causes = pair.causes.clone();
        pair.pairs = vec![PairReport { causes, probability: 0.9, ..PairReport::default() }];
        let text = headline(&pair);
        let expected = "Two causes together: Coulomb friction at joint 2 (0.31 ± 0.02 N m) and delay \
                        at input u (12 ± 1 ms), p = 0.90; adding both closes 92 % (88..95)";
        assert!(text.starts_with(expected), "{text}");
    }

    #[test]
    fn none_and_nothing() {
        let mut none = report("none-of-these");
        let compensation = CompensationReport {
            closed: Some(closed(0.6, 0.5, 0.7)),
            ..CompensationReport::default()
        };
        none.ceiling =
            Some(CeilingReport { linear: Some(compensation), ..CeilingReport::default() });
        assert_eq!(
            headline(&none),
            "None of the known effects explains the gap (p = 0.93): the best, Coulomb friction at \
             joint 2, leaves 3.2 times the noise, mostly above 12.0 Hz; a black-box compensation \
             could remove 60 % (50..70) of the gap on held-out data."
        );
        let mut nothing = report("no-gap");
        nothing.no_gap = 0.98;
        nothing.parameters = vec![NuisanceReport {
            name: "m".into(),
            nominal: 2.0,
            refitted: 2.03,
            deviation_sd: 0.8,
            ..NuisanceReport::default()
        }];
        assert_eq!(
            headline(&nothing),
            "No gap: with its parameters refitted within their tolerances (most of all `m`, by +1.5 \
             %) the model explains the logs down to the noise (p = 0.98)."
        );
    }

    #[test]
    fn unclear_says_what_is_clear() {
        let mut unclear = report("unclear");
        unclear.causes[0].probability = 0.4;
        unclear.groups = vec![GroupReport {
            name: "friction at joint 2".into(),
            probability: 0.7,
            ..GroupReport::default()
        }];
        assert_eq!(
            headline(&unclear),
            "Unclear: no single cause stands out; candidates are Coulomb friction at joint 2 (p = \
             0.40) and delay at input u (p = 0.02), and no gap (p = 0.20); friction at joint 2 \
             altogether has p = 0.70."
        );
    }

    #[test]
    fn a_log_that_is_not_what_it_claims_names_no_cause() {
        let mut spoiled = report("cause");
        spoiled.findings = vec![FindingReport {
            severity: "serious",
            kind: "swapped",
            file: "run.csv".into(),
            channel: "y".into(),
            text: "the channel looks like `z`".into(),
        }];
        let text = headline(&spoiled);
        assert!(text.starts_with("Check the log first: run.csv, `y`: the channel looks"), "{text}");
        assert!(!text.contains("friction"), "{text}");
    }
}
