//! Effects on signals inside a model, where one of them may be what is missing.
//!
//! Every definition, and every term of a sum, is a place at which something may be missing, so that there are many of
//! them. They are tried after a diagnosis of what is around the model: with two at a time where that explains nothing, and
//! where it does explain the logs, only to see whether one law inside does so better. Around a model something can often
//! be found that stands for a law inside it: friction for a dead zone, two parameters that wander for a limit.
//!
//! *When not to use:* for a model whose equations are not known, or one that is followed along its logs: it has no such
//! signals.

use fd_effect::{Candidate, SiteRef};

use crate::{
    diagnose::{
        Case, Cause, Diagnosis, Monitor, Regime, SetSearch, Settings, Verdict, Wanted, diagnose,
        follows_anything, is_a_pair, is_curve_of_signal, wanders,
    },
    fit::FitError,
    quality::{Defect, Finding},
};

/// Diagnoses a case whose suspects have signals inside the model among them, after a diagnosis of what is `around` it.
/// `None` where that one is to stay: it finds no gap, or what is inside does not explain the logs down to the noise, or
/// not clearly better.
///
/// ```
/// use fd_effect::{EverySite, library, with_inner_places};
/// use fd_gap::{diagnose::{Case, Settings, diagnose}, inside::inside};
/// use fd_model::Record;
/// use fd_sim::{model::Model, scales::ReplayScales, simulate::Nominal};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "two lags"
/// sample_time = 0.1
/// inputs = { u = { unit = "V" } }
/// outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// definitions = { w = "2*a" }
/// [states]
/// a = { unit = "V", initial = 0.0, derivative = "u - a" }
/// x = { unit = "V", initial = 0.0, derivative = "w - x" }
/// "#.parse()?;
/// let (mut a, mut x, mut rows) = (0.0, 0.0, Vec::new());
/// for k in 0..400_u32 {
///     let u = (0.05 * f64::from(k)).sin() + (0.17 * f64::from(k)).cos();
///     rows.push(([u], [x + 0.014 * f64::from(k * k).sin()]));
///     for _ in 0..10 {
///         // What is between the lags does not exceed 1 V.
///         (a, x) = (a + 0.01 * (u - a), x + 0.01 * ((2.0_f64 * a).clamp(-1.0, 1.0) - x));
///     }
/// }
/// let ts = model.sample_time()?;
/// let u: Vec<f64> = rows.iter().map(|(u, _)| u[0]).collect();
/// let log = [Record::from_rows(model.external_inputs(), model.output_channels(), rows, ts)?];
/// let scales = ReplayScales::of(&model, ts, &u, 400)?;
/// let effects = || library().into_iter().filter(|e| e.label().starts_with("input-")).collect();
/// let settings = Settings::default();
/// let suspects = EverySite::new(effects(), &model, scales);
/// let case = Case { nominal: &model, suspects: &suspects, logs: &log, held_out: &[] };
/// let around = diagnose(&case, &settings, &())?;
///
/// let inner = with_inner_places(&model);
/// let scales = inner.scales(ts, &u, 400)?.with_signals(&inner, ts, &u, 400)?;
/// let suspects = EverySite::new(effects(), &inner, scales);
/// let case = Case { nominal: &inner, suspects: &suspects, ..case };
/// let found = inside(&case, &around, &settings, &())?.ok_or("something inside")?;
/// assert_eq!((found.causes[0].label, found.causes[0].site.name()), ("input-saturation", Some("w")));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// As [`diagnose`](crate::diagnose::diagnose()).
pub fn inside(
    case: &Case<'_>,
    around: &Diagnosis,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<Option<Diagnosis>, FitError> {
    if around.verdict == Verdict::NoGap {
        return Ok(None);
    }
    let case = &around.as_diagnosed(case);
    if !around.names_all() {
        // What comes near the noise from far above it is seen before a whole diagnosis.
        let is_far = around.regime == Regime::AboveTheFloor && !around.is_logged_loop;
        if is_far && !comes_near(case, around, settings, monitor)? {
            return Ok(None);
        }
        let found = diagnose(case, settings, monitor)?;
        return Ok(found.names_all().then(|| with_accidents(found, around)));
    }
    // A path over time says nothing of another log; against that a curve of a signal is an answer, too.
    let has_paths = is_of_paths(around);
    let is_worth_a_try = |candidate: &Candidate| {
        let is_answer = !follows_anything(candidate) || has_paths && is_curve_of_signal(candidate);
        is_inside(&candidate.site) && is_answer
    };
    let suspects = case.suspects.alone().into_iter().flatten();
    let laws: Vec<Candidate> = suspects.filter(is_worth_a_try).collect();
    if laws.is_empty() || monitor.is_stopped() {
        return Ok(None);
    }
    let one = Settings { report_horizons: vec![settings.horizon], ..settings.for_one_law() };
    let glance = diagnose(&Case { suspects: &laws, ..*case }, &one, monitor)?;
    // Which law it is, and how sure that is, is for the whole diagnosis to say.
    if !explains_more(&glance, around, settings) {
        return Ok(None);
    }
    let singles = Settings { two: 0.0, ..settings.clone() };
    let found = diagnose(case, &singles, monitor)?;
    let is_named = matches!(found.verdict, Verdict::Cause | Verdict::Tied);
    let is_answer = is_named && explains_more(&found, around, settings);
    Ok(is_answer.then(|| with_accidents(found, around)))
}

/// What was found with the samples left out that a diagnosis of what is `around` has left out.
fn with_accidents(mut found: Diagnosis, around: &Diagnosis) -> Diagnosis {
    let accidents = around.findings.iter();
    let accidents = accidents.filter(|f| matches!(f.defect, Defect::WrongSample { .. }));
    let missing: Vec<Finding> =
        accidents.filter(|accident| !found.findings.contains(accident)).cloned().collect();
    found.findings.extend(missing);
    found.cleaned = found.cleaned.or_else(|| around.cleaned.clone());
    found
}

/// Whether any single effect inside, or around, comes near the noise.
fn comes_near(
    case: &Case<'_>,
    around: &Diagnosis,
    settings: &Settings,
    monitor: &dyn Monitor,
) -> Result<bool, FitError> {
    let search = SetSearch::new(case, around, None, false, settings, monitor)?;
    let none = search.none()?;
    let found = search.beside(&none, &Wanted { candidate: &|_| true, least: 0.0 })?;
    Ok(found.iter().any(|set| !search.is_far(set)))
}

/// Whether what a diagnosis names are parameters that wander, and nothing else.
fn is_of_paths(diagnosis: &Diagnosis) -> bool {
    let named = match (diagnosis.verdict, diagnosis.pairs.first()) {
        (Verdict::Pair, Some(pair)) => &pair.causes[..],
        _ => diagnosis.causes.get(..1).unwrap_or_default(),
    };
    !named.is_empty() && named.iter().all(|cause| wanders(cause.label))
}

fn is_inside(site: &SiteRef) -> bool {
    matches!(site, SiteRef::Signal(..))
}

/// Whether the first cause is a law inside that explains the logs down to the noise, with evidence that two effects around
/// are not worth, or that is clearly more than that of one.
fn explains_more(found: &Diagnosis, around: &Diagnosis, settings: &Settings) -> bool {
    let own = found.causes.first().filter(|own| is_inside(&own.site));
    let (Some(Cause { log_evidence: own, .. }), Some(other)) = (own, around.causes.first()) else {
        return false;
    };
    let is_more = match (around.verdict, around.pairs.first()) {
        (Verdict::Pair, Some(pair)) => !is_a_pair(pair.log_evidence, *own),
        _ => other.log_evidence + settings.bayes_factor.ln() < *own,
    };
    found.explains_all() && is_more
}
