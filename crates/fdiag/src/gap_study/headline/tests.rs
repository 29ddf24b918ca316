//! Every verdict in one sentence.

use fd_effect::{Side, SiteRef};
use fd_gap::{
    ceiling::Compensation,
    diagnose::{Diagnosis, Estimate, Explanation, Group, HeldOut, Leftover, Objection, Regime},
    fit::Horizon,
    locate::{Band, Location},
    quality::Severity,
    shrink::Closed,
};
use fd_sim::model::{Model, Output};

use super::*;
use crate::gap_study::{
    HorizonSource, Inputs, Memory, Pace, REPORT_VERSION, Request, StudySettings, Timing,
};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "arm"
sample_time = 0.01
parameters = { m = { unit = "kg", value = 2.0 } }
inputs = { u = { unit = "V" } }
states = { x = { unit = "m", initial = 0.0, derivative = "u/m - x" } }
outputs = { y = { unit = "m", value = "x" } }
"#;

fn model() -> Model {
    MODEL.parse().unwrap()
}

fn cause(label: &'static str, site: SiteRef, strength: [f64; 2], unit: &str, p: f64) -> Cause {
    let [value, standard_error] = strength;
    let (name, unit) = ("strength".to_owned(), unit.to_owned());
    let strength =
        Estimate { name, unit, value, standard_error, is_strength: true, is_reciprocal: false };
    Cause {
        label,
        site,
        partner: None,
        family: "friction",
        side: Side::Dynamics,
        probability: p,
        log_evidence: 0.0,
        law: "law",
        parameters: vec![strength],
        gap: 3.25,
        model: model(),
    }
}

fn explanation() -> Explanation {
    let (starts, outputs) = (Vec::new(), Vec::new());
    Explanation { model: model(), nuisances: Vec::new(), starts, outputs, gap: vec![1.0] }
}

fn closed(fraction: f64, interval: [f64; 2]) -> Closed {
    Closed { fraction, interval, block: 50 }
}

fn diagnosis(verdict: Verdict) -> Diagnosis {
    let friction = SiteRef::Force(0, "joint 2".to_owned());
    let input = SiteRef::Input(0, "u".to_owned());
    Diagnosis {
        verdict,
        regime: Regime::AtTheFloor,
        is_logged_loop: false,
        can_see_the_log: false,
        no_gap: 0.2,
        none_of_these: 0.93,
        causes: vec![
            cause("coulomb-friction", friction, [0.31, 0.02], "N m", 0.97),
            cause("input-delay", input, [12.0, 1.0], "ms", 0.02),
        ],
        groups: Vec::new(),
        sides: Vec::new(),
        tied: vec![CauseId(0)],
        rivals: Vec::new(),
        pairs: Vec::new(),
        tied_pairs: Vec::new(),
        leftover: Leftover { level: 0.0, pattern: 0.0, share: 0.0 },
        sigma: vec![1.0],
        floor: vec![1.0],
        is_unexplained: false,
        is_coloured: false,
        slow_noise: vec![false],
        steps: vec![None],
        nominal: explanation(),
        refit: explanation(),
        best: explanation(),
        parameters: Vec::new(),
        objections: Vec::new(),
        held_out: vec![HeldOut {
            horizon: Horizon::FreeRun,
            seconds: 10.0,
            nominal: vec![5.0],
            refit: vec![4.0],
            after: vec![1.2],
            constant: vec![20.0],
            last_value: vec![15.0],
            floor: vec![1.0],
            closed_of_nominal: None,
            closed_of_refit: Some(closed(0.92, [0.88, 0.95])),
            is_redrawn: false,
            errors: [Vec::new(), Vec::new()],
        }],
        findings: Vec::new(),
        not_tested: Vec::new(),
        idle: Vec::new(),
        is_in_motion: false,
        windows: None,
        cleaned: None,
        is_stopped: false,
        simulations: 0,
    }
}

/// Most of what is left is in the last band.
fn spectrum() -> Spectrum {
    let band = |low_hz, high_hz, after| Band {
        low_hz,
        high_hz,
        refit: 1.0,
        after,
        floor: 0.1,
        share: 0.3,
        is_above_floor: true,
        is_above_floor_after: 0.1 < after,
        coherence: vec![None],
    };
    let bands = vec![band(0.0, 4.0, 0.12), band(4.0, 12.0, 0.1), band(12.0, 50.0, 0.9)];
    Spectrum { output: "y".into(), bands, statement: String::new() }
}

/// A report in which Coulomb friction leads.
fn report(verdict: Verdict) -> Report {
    let request = Request::new("arm.toml", ["run.csv"]);
    let (channels, sides, places) = (Vec::new(), Vec::new(), Vec::new());
    let (regions, times) = (Vec::new(), Vec::new());
    Report {
        version: REPORT_VERSION,
        headline: String::new(),
        reading: None,
        diagnosis: diagnosis(verdict),
        location: Location { channels, sides, places, spectra: vec![spectrum()], regions, times },
        road: None,
        whole: None,
        sparing: None,
        stopped: Vec::new(),
        time_limit: None,
        next: Vec::new(),
        law: None,
        ceiling: None,
        advice: None,
        calibration: None,
        findings: Vec::new(),
        inputs: Inputs {
            model_file: "arm.toml".into(),
            model: "arm".into(),
            outputs: model().outputs.clone(),
            parameters: model().parameters.clone(),
            logs: Vec::new(),
            sample_time_s: 0.01,
            pace: Pace::Stated,
            memory: Memory { seconds: None, forgets: true, slowest: None, runs_away: false },
        },
        settings: StudySettings::of(&request, &fd_gap::diagnose::Settings::default(), 0.01, false),
        models: Vec::new(),
        timing: Timing::default(),
    }
}

#[test]
fn a_cause() {
    assert_eq!(
        headline(&report(Verdict::Cause)),
        "Coulomb friction at joint 2 (0.310 ± 0.020 N m), p = 0.97; adding it closes 92 % (88..95) \
         of the gap that refitted parameters leave on held-out data; 8 % remains, mostly above \
         12.0 Hz."
    );
}

#[test]
fn the_longest_forecast_that_says_something() {
    let mut cause = report(Verdict::Cause);
    let free = cause.diagnosis.held_out[0].clone();
    let forecast = |samples: usize, fraction| HeldOut {
        horizon: Horizon::Windows { samples },
        seconds: 0.01 * samples as f64,
        closed_of_refit: Some(closed(fraction, [fraction - 0.1, fraction + 0.1])),
        ..free.clone()
    };
    cause.diagnosis.held_out = vec![forecast(20, 0.2), forecast(100, 0.5), free.clone()];
    assert!(
        headline(&cause).contains("closes 92 % (88..95) of the gap that refitted parameters leave")
    );
    // No nearer than the mean of the fitted logs.
    cause.diagnosis.held_out[2].after = vec![20.0];
    let expected = "closes 50 % (40..60) of the gap that refitted parameters leave on held-out data, in \
                    forecasts of 1 s; 50 % remains";
    let text = headline(&cause);
    assert!(text.contains(expected), "{text}");
    // Who asks for a horizon hears of that.
    cause.settings.horizon_from = HorizonSource::Stated;
    cause.settings.window_s = Some(0.2);
    let text = headline(&cause);
    assert!(text.contains("closes 20 % (10..30)"), "{text}");
}

#[test]
fn a_cause_that_is_one_of_two() {
    let mut report = report(Verdict::Cause);
    report.diagnosis.causes[0].probability = 0.4;
    let causes = [0, 1].map(|i| report.diagnosis.causes[i].clone());
    report.diagnosis.pairs = vec![Pair { causes, probability: 0.3, log_evidence: 0.0, gap: 1.0 }];
    report.diagnosis.held_out[0].is_redrawn = true;
    let expected = "Coulomb friction at joint 2 (0.310 ± 0.020 N m), alone or with a second cause, p = \
                    0.70; adding it, with its path over time drawn anew there, closes 92 % (88..95)";
    let text = headline(&report);
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn causes_that_are_tied_or_act_together() {
    let mut tied = report(Verdict::Tied);
    tied.diagnosis.tied = vec![CauseId(0), CauseId(1)];
    let text = headline(&tied);
    let expected = "Coulomb friction at joint 2 (0.310 ± 0.020 N m) or delay at input u (12.0 ± 1.0 \
                    ms) (together p = 0.99): this log cannot tell which; adding the first";
    assert!(text.starts_with(expected), "{text}");
    let mut pair = report(Verdict::Pair);
    let causes = [0, 1].map(|i| pair.diagnosis.causes[i].clone());
    pair.diagnosis.pairs = vec![Pair { causes, probability: 0.9, log_evidence: 0.0, gap: 1.0 }];
    pair.diagnosis.tied_pairs = vec![PairId(0)];
    let text = headline(&pair);
    let expected = "Two causes together: Coulomb friction at joint 2 (0.310 ± 0.020 N m) and delay \
                    at input u (12.0 ± 1.0 ms), p = 0.90; adding both closes 92 % (88..95)";
    assert!(text.starts_with(expected), "{text}");
}

#[test]
fn none_and_nothing() {
    let mut none = report(Verdict::NoneOfThese);
    let (orders, after) = ([2, 2], vec![2.0]);
    let linear = Compensation { orders, after, closed: Some(closed(0.6, [0.5, 0.7])) };
    none.ceiling =
        Some(Ceiling { linear: Some(linear), nonlinear: None, statement: String::new() });
    assert_eq!(
        headline(&none),
        "None of the known effects explains the gap (p = 0.93): the best, Coulomb friction at \
         joint 2, leaves 3.2 times the noise, mostly above 12.0 Hz; a black-box compensation \
         could remove 60 % (50..70) of the gap on held-out data."
    );
    let names = vec!["m".to_owned(), "k".to_owned(), "d".to_owned()];
    none.diagnosis.objections =
        vec![Objection::ParametersAtEdges { names, of: 4, is_most: true, is_shown: false }];
    let text = headline(&none);
    let edges =
        "; 3 of 4 refitted parameters lie at the edges of their tolerances (`m`, `k` and `d`).";
    assert!(text.ends_with(edges), "{text}");
    let mut nothing = report(Verdict::NoGap);
    nothing.diagnosis.no_gap = 0.98;
    let mass = Calibrated {
        name: "m".into(),
        unit: "kg".into(),
        nominal: 2.0,
        value: 2.03,
        tolerances: 0.5,
        standard_error: 0.01,
        of_prior: 0.25,
        standing: Standing::Found,
    };
    nothing.diagnosis.parameters = vec![mass.clone()];
    let mut contradicted = nothing.clone();
    assert_eq!(
        headline(&nothing),
        "No gap: with its parameters refitted within their tolerances (most of all `m`, by +1.5 \
         %) the model explains the logs down to the noise (p = 0.98)."
    );
    contradicted.diagnosis.held_out[0].after = vec![3.3];
    assert_eq!(
        headline(&contradicted),
        "No gap in the fitted logs, which the model explains down to the noise with its parameters \
         refitted within their tolerances (most of all `m`, by +1.5 %) (p = 0.98); but held-out `y` \
         is missed by 3.3 times the noise."
    );
    let edge = Standing::AtEdge;
    let friction = Calibrated { name: "f".into(), tolerances: -1.5, value: 1.1, ..mass.clone() };
    let moved = Calibrated { tolerances: 2.0, value: 2.12, standing: edge, ..mass };
    nothing.diagnosis.parameters = vec![moved, friction];
    let told = "`m` 6.0 % above nominal (2.0 tolerances, the most allowed) and `f` 45.0 % below nominal (1.5 tolerances)";
    let text = headline(&nothing);
    assert!(text.contains(&format!("within their tolerances, {told}, the model")), "{text}");
    let mut unknown = report(Verdict::NoneOfThese);
    unknown.diagnosis.parameters = nothing.diagnosis.parameters;
    let text = headline(&unknown);
    assert!(text.contains(&format!("with {told}")), "{text}");
}

#[test]
fn unclear_says_what_is_clear() {
    let mut unclear = report(Verdict::Unclear);
    unclear.diagnosis.causes[0].probability = 0.4;
    unclear.diagnosis.none_of_these = 0.05;
    unclear.diagnosis.groups = vec![Group {
        family: "friction",
        site: SiteRef::Force(0, "joint 2".to_owned()),
        side: Side::Dynamics,
        probability: 0.7,
        causes: vec![CauseId(0)],
    }];
    assert_eq!(
        headline(&unclear),
        "Unclear: no single cause stands out; candidates are Coulomb friction at joint 2 (p = \
         0.40) and delay at input u (p = 0.02), and no gap (p = 0.20); friction at joint 2 \
         altogether has p = 0.70."
    );
    unclear.diagnosis.groups = Vec::new();
    unclear.diagnosis.none_of_these = 0.5;
    unclear.diagnosis.causes[1].probability = 1e-4;
    assert_eq!(
        headline(&unclear),
        "Unclear: no single cause stands out; candidates are Coulomb friction at joint 2 (p = 0.40) \
         and none of the known effects (p = 0.50), and no gap (p = 0.20)."
    );
}

#[test]
fn a_log_that_is_not_what_it_claims_names_no_cause() {
    let mut spoiled = report(Verdict::Cause);
    spoiled.findings = vec![LogFinding {
        severity: Severity::Serious,
        file: "run.csv".into(),
        channel: "y".into(),
        defect: LogDefect::Channel(Defect::Swapped { with: "z".into() }),
    }];
    let text = headline(&spoiled);
    assert!(text.starts_with("Check the log first: run.csv, `y`: the channel looks"), "{text}");
    assert!(!text.contains("friction"), "{text}");
}

#[test]
fn a_log_that_is_read_wrongly_is_said_first() {
    let reading = fd_gap::reading::Reading {
        mistake: fd_gap::reading::Mistake::sign("y"),
        also: Vec::new(),
        probability: 0.97,
        statement: "`y` had the other sign".to_owned(),
        advice: String::new(),
        lines: String::new(),
        before: vec![5.0],
        after: vec![1.0],
    };
    let plain = headline(&report(Verdict::NoGap));
    let said = headline(&Report { reading: Some(reading), ..report(Verdict::NoGap) });
    let begin = "The log reads as if `y` had the other sign (p = 0.97); with that corrected: ";
    assert_eq!(said, format!("{begin}{plain}"));
}

#[test]
fn an_output_that_stands_still_is_said_to_be_left_out() {
    let mut still = report(Verdict::NoGap);
    let plain = headline(&still);
    let second = Output { name: "z".into(), ..still.inputs.outputs[0].clone() };
    still.inputs.outputs.push(second);
    still.findings = vec![LogFinding {
        severity: Severity::Warning,
        file: "run.csv".into(),
        channel: "z".into(),
        defect: LogDefect::Channel(Defect::Constant),
    }];
    // In two logs, with something of another channel between: once is enough.
    let finding =
        |channel: &str| LogFinding { channel: channel.into(), ..still.findings[0].clone() };
    still.findings = vec![finding("z"), finding("u"), finding("z")];
    let said = " `z` does not change in the log and was left out: stuck, or logged too coarsely?";
    assert_eq!(headline(&still), plain + said);
    // An input that is constant is no sensor.
    still.findings.retain(|finding| finding.channel == "u");
    assert!(!headline(&still).contains("left out"));
}
