//! The smallest fault that is seen.

use fd_core::stage::Detector;

use super::alarms::{alarms, debounced_statistics};
use crate::{
    decide::{Debouncing, RuleError},
    rows::{DrivenRows, SampleRows},
};

/// Smallest fault that raises an alarm on a scalar residual with the statistic `|r|`, in closed form.
///
/// The residual is linear in the fault, `r(k) = r₀(k) + s g(k)`, with `g` the response to a fault of
/// size 1. Sample `k` exceeds the threshold for every `s` above
/// `max(0, (thr − r₀ sign g) / |g|)`, and the raise condition holds above the `raise`-th smallest of
/// these in a window of `out_of`. The least of those is returned: this fault *just* reaches the
/// threshold, every larger one is detected. `None` if no size is (`g` vanishes). For a fault of the
/// other sign pass `−g`.
///
/// ```
/// use fd_compensate::{decide::Debouncing, evaluate::smallest_detectable};
///
/// let size = smallest_detectable(&[0.1, -0.2], &[0.5, 1.0], 1.0, Debouncing::default());
/// assert_eq!(size, Some(1.2));
/// ```
#[must_use]
pub fn smallest_detectable(
    fault_free_residual: &[f64],
    unit_fault_response: &[f64],
    threshold: f64,
    debouncing: Debouncing,
) -> Option<f64> {
    let reached = fault_free_residual.iter().zip(unit_fault_response).map(|(&r, &g)| {
        if g == 0.0 {
            if r.abs() > threshold { 0.0 } else { f64::INFINITY }
        } else {
            ((threshold - r * g.signum()) / g.abs()).max(0.0)
        }
    });
    // The raise-th smallest size is minus the raise-th largest of the negated ones.
    let negated: Vec<f64> = reached.map(|size| -size).collect();
    let raised = debounced_statistics(&negated, debouncing);
    let smallest = raised.into_iter().fold(f64::NEG_INFINITY, f64::max);
    smallest.is_finite().then_some(-smallest).map(f64::abs)
}

/// Smallest fault that raises an alarm with any detector, by halving the interval from 0 to `largest`.
///
/// The residual is `healthy + s · response`, row by row, next to the inputs of `healthy` if there are
/// any; the detector is reset for every size tried.
/// It is assumed that larger faults are not harder to see. The answer is at most `2⁻⁴⁰ · largest` too
/// large; `None` if `largest` itself is not seen, 0 if the healthy residual alarms by itself.
///
/// ```
/// use fd_compensate::{
///     SampleRows, decide::Debouncing, detect::Magnitude, evaluate::smallest_detectable_by_search,
/// };
///
/// let (healthy, response) = ([0.1, -0.2], [0.5, 1.0]);
/// let (healthy, response) = (SampleRows::new(1, &healthy)?, SampleRows::new(1, &response)?);
/// let mut detector = Magnitude::new(&[1.0], 1.0)?;
/// let rule = Debouncing::default();
/// let size = smallest_detectable_by_search(&mut detector, rule, healthy, response, 8.0)?;
/// assert!((size.unwrap_or(0.0) - 1.2).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the debouncing is malformed.
pub fn smallest_detectable_by_search<'a, D: Detector<f64> + ?Sized>(
    detector: &mut D,
    debouncing: Debouncing,
    healthy: impl Into<DrivenRows<'a>>,
    response: SampleRows<'_>,
    largest: f64,
) -> Result<Option<f64>, RuleError> {
    let healthy = healthy.into();
    let mut sum = vec![0.0; healthy.residuals().channels()];
    let mut is_seen = |size: f64| -> Result<bool, RuleError> {
        detector.reset();
        let margins: Vec<f64> = response
            .iter()
            .take(healthy.len())
            .enumerate()
            .map(|(k, g)| {
                for ((sum, &r), &g) in sum.iter_mut().zip(healthy.r(k)).zip(g) {
                    *sum = r + size * g;
                }
                let verdict = detector.update(healthy.u(k), &sum);
                verdict.statistic - verdict.threshold
            })
            .collect();
        Ok(alarms(&margins, 0.0, debouncing)?.contains(&true))
    };
    if is_seen(0.0)? {
        return Ok(Some(0.0));
    }
    if !is_seen(largest)? {
        return Ok(None);
    }
    let (mut unseen, mut seen) = (0.0, largest);
    for _ in 0..40 {
        let middle = f64::midpoint(unseen, seen);
        if is_seen(middle)? {
            seen = middle;
        } else {
            unseen = middle;
        }
    }
    Ok(Some(seen))
}
