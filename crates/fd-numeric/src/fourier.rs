//! Fourier transforms of real signals, compiled once: rustfft is generic, and takes longer to compile than all else of a crate
//! that uses it.

pub use realfft::num_complex::Complex64;
use realfft::{FftError, RealFftPlanner};

/// Plans of transforms, kept for the next signal of the same length.
///
/// ```
/// use fd_numeric::fourier::Fourier;
///
/// let lines = Fourier::new().lines(&mut [1.0, 0.0, -1.0, 0.0]);
/// assert_eq!(lines.iter().map(|line| line.re).collect::<Vec<_>>(), [0.0, 2.0, 0.0]);
/// ```
#[expect(missing_debug_implementations, reason = "plans have none")]
pub struct Fourier(RealFftPlanner<f64>);

impl Fourier {
    /// Without plans.
    #[must_use]
    pub fn new() -> Self {
        Self(RealFftPlanner::new())
    }

    /// The lines of a real signal, which is spoilt, from zero to half the sample rate.
    pub fn lines(&mut self, signal: &mut [f64]) -> Vec<Complex64> {
        let plan = self.0.plan_fft_forward(signal.len());
        let mut lines = plan.make_output_vec();
        // Only wrong lengths are errors, and the plan has made them.
        if plan.process(signal, &mut lines).is_err() {
            lines.fill(Complex64::new(0.0, 0.0));
        }
        lines
    }

    /// The real signal of these lines, which are spoilt, times its length, into `signal`.
    ///
    /// # Errors
    ///
    /// Of realfft: for other than half as many lines and one as samples, and for first or last lines that are not real.
    pub fn signal_into(
        &mut self,
        lines: &mut [Complex64],
        signal: &mut [f64],
    ) -> Result<(), FftError> {
        self.0.plan_fft_inverse(signal.len()).process(lines, signal)
    }
}

impl Default for Fourier {
    fn default() -> Self {
        Self::new()
    }
}
