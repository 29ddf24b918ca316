//! How long a detector runs until it alarms, by simulation.

use fd_core::stage::Detector;
use serde::{Deserialize, Serialize};

/// Run lengths of a detector in simulated records.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunLength {
    /// Average run length in samples, the alarming one included.
    pub mean: f64,
    /// Standard error of the average.
    pub standard_error: f64,
    /// Runs simulated.
    pub runs: usize,
    /// Runs that did not alarm within the longest run allowed, and count with that length: the average
    /// is then too small.
    pub cut: usize,
}

impl RunLength {
    /// The interval of that many standard errors around the average.
    ///
    /// ```
    /// use fd_compensate::evaluate::RunLength;
    ///
    /// let found = RunLength { mean: 100.0, standard_error: 2.0, runs: 2500, cut: 0 };
    /// assert_eq!(found.interval(2.0), (96.0, 104.0));
    /// ```
    #[must_use]
    pub fn interval(&self, standard_errors: f64) -> (f64, f64) {
        let width = standard_errors * self.standard_error;
        (self.mean - width, self.mean + width)
    }
}

/// Runs a reset detector on residuals from `draw` until it alarms, `runs` times, each for at most
/// `longest` samples. `draw` is told the sample index and fills in the residual; the detector must not
/// need inputs.
///
/// ```
/// use fd_compensate::{detect::Magnitude, evaluate::run_length};
///
/// let mut detector = Magnitude::new(&[1.0], 2.5)?;
/// let found = run_length(&mut detector, 3, 100, |k, r| r[0] = k as f64);
/// assert_eq!((found.mean, found.cut), (4.0, 0)); // 0, 1, 2, 3
/// # Ok::<(), fd_compensate::detect::DetectorError>(())
/// ```
pub fn run_length<D: Detector<f64> + ?Sized>(
    detector: &mut D,
    runs: usize,
    longest: usize,
    mut draw: impl FnMut(usize, &mut [f64]),
) -> RunLength {
    let mut r = vec![0.0; detector.residual_len()];
    let (mut mean, mut squares, mut cut) = (0.0, 0.0, 0);
    for run in 0..runs {
        detector.reset();
        let alarm = (0..longest).find(|&k| {
            draw(k, &mut r);
            detector.update(&[], &r).alarm()
        });
        cut += usize::from(alarm.is_none());
        let length = alarm.map_or(longest, |k| k + 1) as f64;
        // Welford's update: no cancellation.
        let before = length - mean;
        mean += before / (run + 1) as f64;
        squares += before * (length - mean);
    }
    detector.reset();
    let n = runs as f64;
    let standard_error = (squares / (n - 1.0).max(1.0) / n.max(1.0)).sqrt();
    RunLength { mean, standard_error, runs, cut }
}
