//! Size of a signal.

/// Size of a signal.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalScale {
    /// Name, or the expression.
    pub name: String,
    /// Unit, if it is known.
    pub unit: String,
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
    /// First value.
    pub first: f64,
}

impl SignalScale {
    /// Largest magnitude.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Root of the mean square.
    #[must_use]
    pub fn rms(&self) -> f64 {
        self.mean.hypot(self.std)
    }

    /// Whether the signal changes by more than rounding.
    #[must_use]
    pub fn moves(&self) -> bool {
        self.std > 1e-9 * self.peak()
    }

    pub(crate) fn of(name: &str, unit: &str, values: impl Iterator<Item = f64> + Clone) -> Self {
        let [mean, std] = fd_numeric::mean_and_deviation(values.clone());
        let first = values.clone().next().unwrap_or(0.0);
        let low = values.clone().fold(f64::INFINITY, f64::min);
        let high = values.fold(f64::NEG_INFINITY, f64::max);
        Self { name: name.to_owned(), unit: unit.to_owned(), mean, std, low, high, first }
    }
}
