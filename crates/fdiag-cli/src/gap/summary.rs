//! From the parts of an answer to the report.

use fd_gap::{
    calibrate::Confusion,
    ceiling::Ceiling,
    diagnose::{Diagnosis, Regime, Settings, Verdict},
    experiment::Advice,
    fit::Horizon,
    locate::Location,
};
use fd_model::Record;
use fd_sim::model::Model;

use super::{
    data::{Data, Pace},
    findings::{file_name, findings},
    headline::mostly,
    memory::Memory,
    patched::PatchedFile,
    report::{
        AdviceReport, CalibrationReport, CauseReport, CeilingReport, FileReport, GroupReport,
        HorizonReport, InputReport, LawReport, LeftoverReport, LogReport, NoiseReport,
        NotTestedReport, NuisanceReport, PairReport, REPORT_VERSION, Report, SettingsReport,
        SideReport, SiteReport, TimingReport, WhereReport, WorkReport,
    },
    request::{HeldOutChoice, HorizonChoice, Named, Request},
    words::percent,
};

/// All that a report is made from.
pub(super) struct Parts<'a> {
    pub(super) request: &'a Request,
    pub(super) model: &'a Model,
    pub(super) data: &'a Data,
    pub(super) memory: Memory,
    pub(super) settings: &'a Settings,
    pub(super) diagnosis: &'a Diagnosis,
    pub(super) location: &'a Location,
    pub(super) ceiling: Option<&'a Ceiling>,
    pub(super) advice: Option<&'a Advice>,
    pub(super) calibration: Option<&'a Confusion>,
    pub(super) law: Option<LawReport>,
    pub(super) models: &'a [PatchedFile],
}

/// The report, but for its headline and timing.
pub(super) fn summary(parts: Parts<'_>) -> Report {
    let Parts { model, diagnosis, location, .. } = parts;
    let outputs = model.output_channels();
    let (causes, pairs) = (CauseReport::all(diagnosis), PairReport::all(diagnosis));
    let mut report = Report {
        version: REPORT_VERSION,
        headline: String::new(),
        verdict: verdict(diagnosis.verdict),
        regime: match diagnosis.regime {
            Regime::AtTheFloor => "at-the-floor",
            Regime::AboveTheFloor => "above-the-floor",
        },
        no_gap: diagnosis.no_gap,
        none_of_these: diagnosis.none_of_these,
        groups: diagnosis.groups.iter().map(GroupReport::of).collect(),
        sides: SideReport::all(diagnosis, location),
        location: WhereReport::from(location),
        how_far: diagnosis.held_out.iter().map(|h| HorizonReport::of(h, &outputs)).collect(),
        remains: String::new(),
        ceiling: parts.ceiling.map(CeilingReport::of),
        next: parts.advice.map(|advice| AdviceReport::of(advice, &causes, &pairs)),
        calibration: parts.calibration.map(|c| CalibrationReport::of(c, &causes)),
        causes,
        pairs,
        findings: findings(diagnosis, parts.data, model),
        input: input(&parts),
        noise: noise(model, diagnosis),
        is_unexplained: diagnosis.is_unexplained,
        is_coloured: diagnosis.is_coloured,
        leftover: LeftoverReport {
            level: diagnosis.leftover.level,
            pattern: diagnosis.leftover.pattern,
            share: diagnosis.leftover.share,
        },
        parameters: nuisances(model, diagnosis),
        not_tested: not_tested(diagnosis),
        files: files(parts.models),
        settings: settings(&parts),
        work: WorkReport { causes: diagnosis.causes.len(), simulations: diagnosis.simulations },
        timing: TimingReport::default(),
        law: parts.law,
    };
    report.remains = remains(&report);
    report
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "no-gap",
        Verdict::Cause => "cause",
        Verdict::Tied => "tied",
        Verdict::Pair => "pair",
        Verdict::NoneOfThese => "none-of-these",
        Verdict::Unclear => "unclear",
    }
}

/// What is left, with where in frequency most of it is.
fn remains(report: &Report) -> String {
    let left = report.how_far.first().and_then(HorizonReport::closed);
    match left.map(|closed| 1.0 - closed.fraction) {
        Some(rest) if 0.005 <= rest => {
            format!("{} of the gap remains{}", percent(rest), mostly(&report.location.spectra))
        }
        _ => String::new(),
    }
}

fn input(parts: &Parts<'_>) -> InputReport {
    let Parts { request, model, data, memory, .. } = parts;
    let ts = data.ts().map_or(model.sample_time, fd_model::SampleTime::seconds);
    let records = data.fit.iter().chain(&data.held_out);
    let logs = data.parts.iter().zip(records).map(|(part, record)| LogReport {
        file: file_name(&part.file),
        role: if part.is_held_out { "held-out" } else { "fit" },
        samples: record.len(),
        from_s: part.samples[0] as f64 * ts,
        to_s: part.samples[1] as f64 * ts,
        rows: part.time_base.rows,
        is_even: part.time_base.even,
        jitter_s: part.time_base.jitter_s,
        gaps: part.time_base.gaps.len(),
        left_out: part.time_base.duplicates + part.time_base.out_of_order,
        missing_share: missing(record),
    });
    let pace = match data.pace {
        Pace::Stated => "as stated",
        Pace::Model => "at the pace of the model, which is sampled itself",
        Pace::FirstLog => "at the median pace of the first log",
    };
    InputReport {
        model_file: file_name(&request.model),
        model: model.name.clone(),
        logs: logs.collect(),
        sample_time_s: ts,
        policy: format!(
            "Logs are on an even time base {pace}: inputs keep their last value, outputs are \
             interpolated over short holes; outputs that are missing are not compared."
        ),
        memory_s: memory.seconds,
        forgets: memory.forgets,
    }
}

fn missing(record: &Record) -> f64 {
    let values = (0..record.outputs().len()).flat_map(|c| record.output(c));
    let (missing, all) =
        values.fold((0.0, 0.0), |(m, n), v| (m + f64::from(u8::from(!v.is_finite())), n + 1.0));
    missing / f64::max(all, 1.0)
}

fn noise(model: &Model, diagnosis: &Diagnosis) -> Vec<NoiseReport> {
    let sizes = diagnosis.sigma.iter().zip(&diagnosis.floor);
    let each = model.outputs.iter().zip(sizes).map(|(output, (sigma, floor))| NoiseReport {
        output: output.name.clone(),
        unit: output.unit.clone(),
        stated: output.noise,
        sigma: *sigma,
        floor: floor * sigma,
    });
    each.collect()
}

fn nuisances(model: &Model, diagnosis: &Diagnosis) -> Vec<NuisanceReport> {
    let known = |name: &str| model.parameters.iter().find(|p| p.name == name);
    let each = diagnosis.best.nuisances.iter().map(|nuisance| NuisanceReport {
        name: nuisance.name.clone(),
        unit: known(&nuisance.name).map_or_else(String::new, |p| p.unit.clone()),
        nominal: known(&nuisance.name).map_or(f64::NAN, |p| p.value),
        refitted: nuisance.value,
        deviation_sd: nuisance.deviation,
    });
    each.collect()
}

fn not_tested(diagnosis: &Diagnosis) -> Vec<NotTestedReport> {
    let each = diagnosis.not_tested.iter().map(|n| NotTestedReport {
        label: n.label,
        law: n.law,
        site: SiteReport::from(&n.site),
        reason: n.reason.clone(),
    });
    each.collect()
}

fn files(models: &[PatchedFile]) -> Vec<FileReport> {
    let page = FileReport { file: "report.html".into(), content: "the report as a page".into() };
    let models = models
        .iter()
        .map(|model| FileReport { file: model.file.clone(), content: model.content.clone() });
    std::iter::once(page).chain(models).collect()
}

fn settings(parts: &Parts<'_>) -> SettingsReport {
    let Parts { request, settings, data, .. } = parts;
    let ts = data.ts().map_or(f64::NAN, fd_model::SampleTime::seconds);
    let named = |all: &[Named]| all.iter().map(|n| format!("{}={}", n.name, n.value)).collect();
    let window = match settings.horizon {
        Horizon::FreeRun => None,
        Horizon::Windows { samples } => Some(samples as f64 * ts),
    };
    SettingsReport {
        seed: request.seed,
        horizon: if window.is_some() { "windows" } else { "free-run" },
        window_s: window,
        horizon_from: match request.horizon {
            HorizonChoice::Auto => "memory of the model",
            _ => "stated",
        },
        split: match request.held_out {
            HeldOutChoice::Split(share) => Some(share),
            HeldOutChoice::Logs(_) => None,
        },
        exclude: request.exclude.clone(),
        only: request.only.clone(),
        tolerances: named(&request.tolerances),
        noise: named(&request.noise),
        finalists: settings.finalists,
        prior_no_gap: settings.no_gap,
        prior_unknown: settings.unknown,
        prior_two: settings.two,
        temperature: settings.temperature,
        bayes_factor: settings.bayes_factor,
        bootstrap_replicas: settings.replicas,
        calibration_replicas: request.calibrate,
    }
}
