//! Coloured noise as an autoregression: fitted by Levinson's recursion, used to whiten.

/// Prediction of a sample of unit variance from those before it, the latest first.
#[derive(Clone, Debug, PartialEq)]
struct Predictor {
    coefficients: Vec<f64>,
    /// Standard deviation of the prediction error.
    spread: f64,
}

/// A stationary autoregression of unit variance, `w[k] = Σ aᵢ w[k − i] + g e[k]`.
///
/// At the start of a signal and after a hole the best predictor from the samples there are is
/// used, so that the whitened samples of an exact model are independent and of unit variance from
/// the first one on.
///
/// ```
/// use fd_gap::quality::Autoregression;
///
/// let white = Autoregression::white();
/// let mut e = [0.0; 3];
/// white.whiten(&[1.0, f64::NAN, 2.0], &mut e);
/// assert_eq!((e, white.innovation()), ([1.0, 0.0, 2.0], 1.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Autoregression {
    /// Best predictors from 0, 1, …, p past samples.
    predictors: Vec<Predictor>,
}

impl Autoregression {
    /// Order up to which noise is given a colour.
    pub const HIGHEST_ORDER: usize = 12;

    /// The autoregression of order 0.
    #[must_use]
    pub fn white() -> Self {
        Self { predictors: vec![Predictor { coefficients: Vec::new(), spread: 1.0 }] }
    }

    /// Order 1: `w[k] = a w[k − 1] + √(1 − a²) e[k]`, with `|a| < 1` (clamped).
    ///
    /// ```
    /// use fd_gap::quality::Autoregression;
    ///
    /// assert!((Autoregression::first_order(0.8).innovation() - 0.6).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn first_order(a: f64) -> Self {
        let a = a.clamp(-1.0 + f64::EPSILON, 1.0 - f64::EPSILON);
        let mut predictors = Self::white().predictors;
        predictors.push(Predictor { coefficients: vec![a], spread: (1.0 - a * a).sqrt() });
        Self { predictors }
    }

    /// Fits an autoregression to signals about zero, of the order up to `highest` with the least
    /// `n ln g² + p ln n` (Schwarz 1978). Missing samples (NaN) count as zero in the
    /// autocovariance, which keeps it positive definite.
    #[must_use]
    pub fn fit(signals: &[&[f64]], highest: usize) -> Self {
        let value = |signal: &[f64], k: usize| {
            let value = signal[k];
            if value.is_finite() { value } else { 0.0 }
        };
        let n = signals.iter().flat_map(|s| s.iter()).filter(|v| v.is_finite()).count() as f64;
        let covariance = |lag: usize| -> f64 {
            let products = signals.iter().flat_map(|signal| {
                (lag..signal.len()).map(move |k| value(signal, k) * value(signal, k - lag))
            });
            products.sum()
        };
        let power = covariance(0);
        let longest = signals.iter().map(|signal| signal.len()).max().unwrap_or(0);
        let highest = highest.min(longest / 10);
        let mut predictors = Self::white().predictors;
        if power <= 0.0 {
            return Self { predictors };
        }
        let (mut variance, mut least, mut order) = (1.0_f64, 0.0, 0);
        let correlations: Vec<f64> = (0..=highest).map(|lag| covariance(lag) / power).collect();
        for m in 1..=highest {
            // Levinson: k = (ρ(m) − Σ aᵢ ρ(m − i)) / v, aᵢ ← aᵢ − k a(m−i), v ← v (1 − k²).
            let a = &predictors[m - 1].coefficients;
            let known: f64 = (1..m).map(|i| a[i - 1] * correlations[m - i]).sum();
            let k = (correlations[m] - known) / variance;
            let left = variance * (1.0 - k * k);
            if left <= f64::EPSILON {
                break;
            }
            let next = (1..m).map(|i| a[i - 1] - k * a[m - i - 1]).chain([k]).collect();
            variance = left;
            predictors.push(Predictor { coefficients: next, spread: variance.sqrt() });
            let bic = n * variance.ln() + m as f64 * n.ln();
            if bic < least {
                (least, order) = (bic, m);
            }
        }
        predictors.truncate(order + 1);
        Self { predictors }
    }

    /// Number of past samples that predict the next one.
    #[must_use]
    pub fn order(&self) -> usize {
        self.predictors.len() - 1
    }

    /// Standard deviation `g` of the innovation, as a fraction of that of the signal.
    #[must_use]
    pub fn innovation(&self) -> f64 {
        self.predictors[self.order()].spread
    }

    /// Writes the innovations of `signal`, divided by their standard deviations; 0 where a sample
    /// is missing.
    ///
    /// # Panics
    ///
    /// Panics when the lengths differ.
    pub fn whiten(&self, signal: &[f64], innovations: &mut [f64]) {
        assert_eq!(signal.len(), innovations.len(), "one innovation per sample");
        let mut known = 0;
        for (k, &value) in signal.iter().enumerate() {
            if !value.is_finite() {
                (known, innovations[k]) = (0, 0.0);
                continue;
            }
            let Predictor { coefficients, spread } = &self.predictors[known];
            let past = signal[k - known..k].iter().rev();
            let predicted: f64 = coefficients.iter().zip(past).map(|(a, w)| a * w).sum();
            innovations[k] = (value - predicted) / spread;
            known = (known + 1).min(self.order());
        }
    }

    /// The signal that has these [innovations](Self::whiten), but for rounding. It stays missing
    /// where `signal` is; what else it holds is overwritten.
    ///
    /// ```
    /// use fd_gap::quality::Autoregression;
    ///
    /// let (slow, signal) = (Autoregression::first_order(0.8), [1.0, 0.5, f64::NAN, 2.0]);
    /// let (mut innovations, mut restored) = ([0.0; 4], [0.0, 0.0, f64::NAN, 0.0]);
    /// slow.whiten(&signal, &mut innovations);
    /// slow.restore(&innovations, &mut restored);
    /// assert!((restored[1] - 0.5).abs() < 1e-15 && restored[2].is_nan() && restored[3] == 2.0);
    /// ```
    ///
    /// # Panics
    ///
    /// Panics when the lengths differ.
    pub fn restore(&self, innovations: &[f64], signal: &mut [f64]) {
        assert_eq!(signal.len(), innovations.len(), "one innovation per sample");
        let mut known = 0;
        for (k, innovation) in innovations.iter().enumerate() {
            if !signal[k].is_finite() {
                (known, signal[k]) = (0, f64::NAN);
                continue;
            }
            let Predictor { coefficients, spread } = &self.predictors[known];
            let past = signal[k - known..k].iter().rev();
            let predicted: f64 = coefficients.iter().zip(past).map(|(a, w)| a * w).sum();
            signal[k] = innovation * spread + predicted;
            known = (known + 1).min(self.order());
        }
    }

    /// Sum of the logarithms of the standard deviations of the innovations of a signal: what the
    /// whitening adds to its log-likelihood, with a minus sign.
    #[must_use]
    pub fn log_spread(&self, signal: &[f64]) -> f64 {
        let mut known = 0;
        let mut sum = 0.0;
        for value in signal {
            if value.is_finite() {
                sum += self.predictors[known].spread.ln();
                known = (known + 1).min(self.order());
            } else {
                known = 0;
            }
        }
        sum
    }
}
