//! What fitted logs explain and held-out logs contradict.

use crate::gap_study::report::Report;

/// Times the noise from which a held-out output is missed: three quarters of the squares are then something else …
const MISSED: f64 = 2.0;
/// … and where the noise is slow and of unknown size: it is another one in every run.
const MISSED_SLOWLY: f64 = 4.0;

/// The output of held-out data that the answer misses most, and by how many times the noise, such as "held-out `y`
/// is missed by 3.3 times the noise"; `None` where the fitted logs are missed as well, or nothing is.
pub(in crate::gap_study) fn missed(report: &Report) -> Option<String> {
    let held_out = report.forecast()?;
    if report.diagnosis.is_unexplained {
        return None;
    }
    let times = held_out.after.iter().zip(&held_out.floor).map(|(after, floor)| after / floor);
    let limits =
        report.diagnosis.slow_noise.iter().map(|is| if *is { MISSED_SLOWLY } else { MISSED });
    let missed = times.zip(limits).zip(&report.inputs.outputs);
    let missed = missed.filter(|((times, limit), _)| limit < times && times.is_finite());
    let ((times, _), output) = missed.max_by(|((a, _), _), ((b, _), _)| a.total_cmp(b))?;
    Some(format!("held-out `{}` is missed by {times:.1} times the noise", output.name))
}
