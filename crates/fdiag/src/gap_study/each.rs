//! The same diagnosis on several logs, each by itself: which causes and which strengths agree.
//!
//! Logs of one robot, or of several, that are fitted together give one answer; asked one by one they may give several, and people
//! do not know which to believe. A cause that every log names with the same strength is one of the plant; one that a single log
//! names is one of that run, or chance.

use fd_effect::SiteRef;
use fd_gap::diagnose::{Cause, Estimate, Verdict};
use schemars::JsonSchema;
use serde::Serialize;

use super::{
    report::Report,
    words::{self, capital, list, with_unit},
};

/// Answers of several logs, side by side.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Compared {
    /// What agrees, in a sentence.
    pub headline: String,
    /// The logs with their answers.
    pub logs: Vec<LogAnswer>,
    /// What at least one of them names, what most of them name first.
    pub causes: Vec<ComparedCause>,
}

/// What one log says.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LogAnswer {
    /// The log.
    pub log: String,
    /// The answer in words, or why there is none.
    pub headline: String,
    /// The answer in one word; `None` where there is none, or the log has to be checked first.
    pub verdict: Option<Verdict>,
}

/// A cause, log by log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct ComparedCause {
    /// Label of the effect.
    pub label: &'static str,
    /// Where it is.
    pub site: SiteRef,
    /// What each log says of it, in the order of the logs; `None` where it has no fit there.
    pub logs: Vec<Option<CauseInLog>>,
    /// How many name it, alone, tied or among others.
    pub named: usize,
    /// The mean of its strengths where it is named, weighted by their errors; none unless at least two logs have the same one.
    pub strengths: Vec<MeanStrength>,
}

/// A cause in the answer of one log.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CauseInLog {
    /// Whether the answer names it.
    pub is_named: bool,
    /// Its probability there, alone or beside others.
    pub probability: f64,
    /// Its strength in words.
    pub strength: String,
}

/// A strength over several logs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct MeanStrength {
    /// Name of the parameter.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The mean, weighted by the inverse squares of the standard errors.
    pub mean: f64,
    /// Its standard error, if the strength is the same in all logs.
    pub standard_error: f64,
    /// How much more the strengths differ than their errors let expect, a factor: Birge's ratio (1932), 1 where the errors
    /// explain all.
    pub differ: f64,
}

/// A log by its name, with its report or why there is none.
pub type Answered<'a> = (String, Result<&'a Report, String>);

impl Compared {
    /// The answers of logs.
    ///
    /// ```
    /// use fdiag::gap_study::Compared;
    ///
    /// let compared = Compared::of(&[("monday.csv".to_owned(), Err("no column `u`".to_owned()))]);
    /// assert_eq!(compared.headline, "1 of 1 logs has no answer.");
    /// ```
    #[must_use]
    pub fn of(answered: &[Answered<'_>]) -> Self {
        let reports: Vec<Option<&Report>> =
            answered.iter().map(|(_, report)| report.as_ref().ok().copied()).collect();
        let mut found: Vec<(&'static str, SiteRef)> = Vec::new();
        for cause in reports.iter().flatten().flat_map(|report| report.named()) {
            let key = (cause.label, cause.site.clone());
            if !found.contains(&key) {
                found.push(key);
            }
        }
        let compared = found.into_iter().map(|(label, site)| compared(label, site, &reports));
        let mut causes: Vec<ComparedCause> = compared.collect();
        causes.sort_by_key(|cause| std::cmp::Reverse(cause.named));
        let answer = |(log, report): &Answered<'_>| match report {
            Ok(report) => LogAnswer {
                log: log.clone(),
                headline: report.headline.clone(),
                verdict: report.spoiled().is_none().then_some(report.diagnosis.verdict),
            },
            Err(why) => LogAnswer { log: log.clone(), headline: why.clone(), verdict: None },
        };
        let logs: Vec<LogAnswer> = answered.iter().map(answer).collect();
        Self { headline: headline(&logs, &causes), logs, causes }
    }
}

/// A cause in all logs.
fn compared(label: &'static str, site: SiteRef, reports: &[Option<&Report>]) -> ComparedCause {
    let in_log = |report: &Report| {
        let named = find(report.named(), label, &site);
        let cause = named.or_else(|| find(&report.diagnosis.causes, label, &site))?;
        Some(CauseInLog {
            is_named: named.is_some(),
            probability: report.probability(cause),
            strength: words::strength(cause),
        })
    };
    let logs = reports.iter().map(|report| report.and_then(in_log)).collect();
    let named = reports.iter().flatten().filter_map(|report| find(report.named(), label, &site));
    let causes: Vec<&Cause> = named.collect();
    let strengths = means(label, &causes);
    ComparedCause { label, site, logs, named: causes.len(), strengths }
}

fn find<'r>(
    causes: impl IntoIterator<Item = &'r Cause>,
    label: &str,
    site: &SiteRef,
) -> Option<&'r Cause> {
    causes.into_iter().find(|cause| cause.label == label && cause.site == *site)
}

/// Means of the strengths that all of the causes have.
fn means(label: &str, causes: &[&Cause]) -> Vec<MeanStrength> {
    let [first, _, ..] = causes else { return Vec::new() };
    let strengths = first.parameters.iter().filter(|p| p.is_strength);
    let mean = |strength: &Estimate| {
        let same =
            |cause: &&Cause| cause.parameters.iter().find(|p| p.name == strength.name).cloned();
        let all = causes.iter().map(same).collect::<Option<Vec<Estimate>>>()?;
        let shown: Vec<(f64, f64, String)> = all.iter().map(|p| words::shown(label, p)).collect();
        let is_known = |(value, error, _): &(f64, f64, String)| value.is_finite() && 0.0 < *error;
        if !shown.iter().all(is_known) {
            return None;
        }
        let weight: f64 = shown.iter().map(|(_, error, _)| error.powi(-2)).sum();
        let mean =
            shown.iter().map(|(value, error, _)| value / (error * error)).sum::<f64>() / weight;
        let squares =
            shown.iter().map(|(value, error, _)| ((value - mean) / error).powi(2)).sum::<f64>();
        Some(MeanStrength {
            name: strength.name.clone(),
            unit: shown[0].2.clone(),
            mean,
            standard_error: weight.sqrt().recip(),
            differ: (squares / (shown.len() - 1) as f64).sqrt(),
        })
    };
    strengths.filter_map(mean).collect()
}

/// What most logs name, and which answer otherwise.
fn headline(logs: &[LogAnswer], causes: &[ComparedCause]) -> String {
    let all = logs.len();
    // A list of causes that leaves something unexplained names causes all the same.
    let names_one = |log: usize| {
        causes.iter().any(|cause| cause.logs[log].as_ref().is_some_and(|cause| cause.is_named))
    };
    let count = |verdict: Verdict| {
        let silent = logs.iter().enumerate().filter(|(log, _)| !names_one(*log));
        silent.filter(|(_, log)| log.verdict == Some(verdict)).count()
    };
    let in_all: Vec<String> =
        causes.iter().filter(|cause| cause.named == all).map(in_words).collect();
    let in_some = causes.iter().filter(|cause| cause.named < all);
    let in_some = in_some.map(|cause| format!("{} ({} of {all})", named(cause), cause.named));
    let in_some: Vec<String> = in_some.collect();
    let silent = logs.iter().filter(|log| log.verdict.is_none()).count();
    let others = [
        (count(Verdict::NoGap), "shows no gap"),
        (count(Verdict::NoneOfThese), "shows a gap that none of the known effects explains"),
        (count(Verdict::Unclear), "shows no cause that stands out"),
        (silent, "has no answer"),
    ];
    let others = others.iter().filter(|(count, _)| 0 < *count);
    let others = others.map(|(count, what)| format!("{count} of {all} logs {what}"));
    let mut parts = Vec::new();
    if !in_all.is_empty() {
        let logs = if all == 2 { "both logs".to_owned() } else { format!("all {all} logs") };
        parts.push(format!("{logs} name {}", list(&in_all, "and")));
    }
    if !in_some.is_empty() {
        let only = if in_all.is_empty() {
            "no cause is named by all logs, but"
        } else {
            "not all of them name"
        };
        parts.push(format!("{only} {}", list(&in_some, "and")));
    }
    parts.extend(others);
    format!("{}.", capital(&parts.join("; ")))
}

fn named(cause: &ComparedCause) -> String {
    words::effect_at(cause.label, &cause.site)
}

/// A cause with its strengths over all logs.
fn in_words(cause: &ComparedCause) -> String {
    let strengths: Vec<String> = cause.strengths.iter().map(mean_in_words).collect();
    if strengths.is_empty() {
        named(cause)
    } else {
        format!("{} ({})", named(cause), list(&strengths, "and"))
    }
}

/// A mean strength, and whether the logs agree on it.
fn mean_in_words(strength: &MeanStrength) -> String {
    let MeanStrength { unit, mean, standard_error, differ, .. } = strength;
    let mean = with_unit(*mean, *standard_error, unit);
    format!("{mean} on average, differing {differ:.1} times as much as their errors say")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strength(value: f64, standard_error: f64) -> Cause {
        let limit = Estimate {
            name: "limit".into(),
            unit: "1/V".into(),
            value,
            standard_error,
            is_strength: true,
            is_reciprocal: true,
        };
        let outputs = "outputs = { y = { unit = \"1\", value = \"0\" } }";
        let model = format!(
            "version = 1\nkind = \"equations\"\nname = \"none\"\nsample_time = 1.0\n{outputs}"
        );
        Cause {
            label: "input-saturation",
            site: SiteRef::Input(0, "u".into()),
            partner: None,
            family: "saturation",
            side: fd_effect::Side::Input,
            probability: 1.0,
            log_evidence: 0.0,
            law: "hard",
            parameters: vec![limit],
            gap: 1.0,
            model: model.parse().unwrap(),
        }
    }

    /// Limits of 2 and 4 V with errors of .1 and .4 V: told as a person would, not as inverses.
    #[test]
    fn strengths_are_averaged_as_a_person_states_them() {
        let causes = [strength(0.5, 0.025), strength(0.25, 0.025)];
        let found = means("input-saturation", &causes.each_ref());
        let MeanStrength { unit, mean, standard_error, differ, .. } = &found[0];
        let weights = [100.0, 6.25];
        assert_eq!(unit, "V");
        assert!((mean - (200.0 + 25.0) / 106.25).abs() < 1e-12, "{mean}");
        assert!((standard_error - 1.0 / f64::sqrt(106.25)).abs() < 1e-12, "{standard_error}");
        let squares = weights[0] * (2.0 - mean).powi(2) + weights[1] * (4.0 - mean).powi(2);
        assert!((differ - squares.sqrt()).abs() < 1e-12, "{differ}");
        assert!(means("input-saturation", &[&causes[0]]).is_empty(), "one log has no mean");
    }

    #[test]
    fn the_headline_says_what_all_name_and_what_some_do() {
        let answer = |verdict| LogAnswer { log: "a".into(), headline: String::new(), verdict };
        let in_log =
            |is_named| Some(CauseInLog { is_named, probability: 1.0, strength: String::new() });
        let cause = |label, named_in: &[bool]| ComparedCause {
            label,
            site: SiteRef::Input(0, "u".into()),
            logs: named_in.iter().map(|is_named| in_log(*is_named)).collect(),
            named: named_in.iter().filter(|is_named| **is_named).count(),
            strengths: Vec::new(),
        };
        let logs = [Some(Verdict::Cause), Some(Verdict::Pair), None].map(answer);
        let text = headline(&logs, &[cause("input-delay", &[true, true, false])]);
        assert_eq!(
            text,
            "No cause is named by all logs, but delay at input u (2 of 3); 1 of 3 logs has no answer."
        );
        let both = [cause("input-delay", &[true, true]), cause("input-gain", &[true, false])];
        assert_eq!(
            headline(&logs[..2], &both),
            "Both logs name delay at input u; not all of them name gain error at input u (1 of 2)."
        );
        // A list that leaves something unexplained is no log without a known cause; one without a list is.
        let logs = [Some(Verdict::NoneOfThese), Some(Verdict::NoneOfThese)].map(answer);
        assert_eq!(
            headline(&logs, &[cause("input-delay", &[true, false])]),
            "No cause is named by all logs, but delay at input u (1 of 2); \
             1 of 2 logs shows a gap that none of the known effects explains."
        );
    }
}
