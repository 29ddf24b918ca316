//! Exact average run length of the cumulative sum, and the threshold for a wanted one.

use faer::{Mat, linalg::solvers::Solve};
use fd_numeric::dense::Dense;
use statrs::distribution::{Continuous, ContinuousCDF, Normal};

use crate::{
    count::whole,
    detect::{
        error::{DetectorError, finite, positive},
        quadrature::gauss_legendre,
    },
};

/// Largest threshold that the quadrature is dense enough for.
const LARGEST_THRESHOLD: f64 = 50.0;

/// Run lengths beyond this drown in rounding (the system's condition is about the run length) and
/// count as infinite.
const LONGEST: f64 = 1e13;

/// Average run length of the two-sided cumulative sum with threshold `h` and reference value `k`, on
/// independent `N(shift, 1)` samples, started from zero. Infinite beyond 1e13.
///
/// ```
/// use fd_compensate::detect::cusum::average_run_length;
///
/// assert!((average_run_length(4.0, 0.5, 0.0)? - 167.68).abs() < 5e-3);
/// # Ok::<(), fd_compensate::detect::DetectorError>(())
/// ```
///
/// # Errors
///
/// Returns an error when `h` is not positive or beyond 50, `k` is negative, or a number is not
/// finite.
pub fn average_run_length(h: f64, k: f64, shift: f64) -> Result<f64, DetectorError> {
    check(h, k)?;
    finite("shift", shift)?;
    let alarms_per_sample = one_sided(h, k - shift).recip() + one_sided(h, k + shift).recip();
    Ok(alarms_per_sample.recip())
}

/// Threshold `h` of the two-sided cumulative sum for a wanted average run length between false
/// alarms on independent `N(0, 1)` samples.
///
/// ```
/// use fd_compensate::detect::cusum::{average_run_length, threshold_for};
///
/// let h = threshold_for(1000.0, 0.5)?;
/// assert!((average_run_length(h, 0.5, 0.0)? / 1000.0 - 1.0).abs() < 1e-9);
/// # Ok::<(), fd_compensate::detect::DetectorError>(())
/// ```
///
/// # Errors
///
/// Returns an error when the run length is below that of `h → 0` or beyond what 1e12 or `h = 50`
/// give, or `k` is negative.
pub fn threshold_for(run_length: f64, k: f64) -> Result<f64, DetectorError> {
    let (mut low, mut high) = (1e-9, LARGEST_THRESHOLD);
    check(high, k)?;
    let reachable = average_run_length(low, k, 0.0)?..=average_run_length(high, k, 0.0)?.min(1e12);
    if !reachable.contains(&run_length) {
        let (parameter, expected) = ("run length", "reachable with this k, and at most 1e12");
        return Err(DetectorError::Parameter { parameter, expected, found: run_length });
    }
    // The run length rises with h; halving the bracket 60 times exhausts an f64.
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if average_run_length(middle, k, 0.0)? < run_length {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(high)
}

fn check(h: f64, k: f64) -> Result<(), DetectorError> {
    positive("threshold h", h)?;
    if h > LARGEST_THRESHOLD {
        let (parameter, expected) = ("threshold h", "at most 50 standard deviations");
        return Err(DetectorError::Parameter { parameter, expected, found: h });
    }
    if k < 0.0 || !k.is_finite() {
        let (parameter, expected) = ("reference value k", "non-negative and finite");
        return Err(DetectorError::Parameter { parameter, expected, found: k });
    }
    Ok(())
}

/// `L(0)` of one side whose samples fall by `drift` on average.
fn one_sided(h: f64, drift: f64) -> f64 {
    // The kernel is a Gaussian of width 1: 24 nodes and 8 per unit resolve it below rounding.
    let nodes = gauss_legendre(24 + whole(8.0 * h), h);
    let size = nodes.len() + 1;
    // Unknowns: L(0), then L at the nodes.
    let start = |i: usize| if i == 0 { 0.0 } else { nodes[i - 1].0 };
    let normal = Normal::standard();
    let system = Mat::from_fn(size, size, |i, j| {
        let transition = if j == 0 {
            normal.cdf(drift - start(i))
        } else {
            let (x, weight) = nodes[j - 1];
            weight * normal.pdf(x + drift - start(i))
        };
        f64::from(u8::from(i == j)) - transition
    });
    let solution = system.lu().solve(Mat::<f64>::from_fn(size, 1, |_, _| 1.0));
    let length = solution[(0, 0)];
    // Past the reach of the arithmetic the solution is huge, negative or not a number.
    if (1.0..LONGEST).contains(&length) { length } else { f64::INFINITY }
}
