//! Sizes of all signals in a run without any effect.

/// Size of a signal.
#[derive(Clone, Debug, Default)]
pub(super) struct Signal {
    pub mean: f64,
    pub std: f64,
    /// Largest magnitude.
    pub peak: f64,
    pub low: f64,
    pub high: f64,
    /// Root mean square of the change from sample to sample.
    pub slope: f64,
}

/// Sizes at a site.
#[derive(Clone, Debug)]
pub(super) struct SiteScale {
    pub position: Option<Signal>,
    pub velocity: Option<Signal>,
    /// Spread of the acceleration (of the position's rate where there is no velocity).
    pub acceleration: f64,
    /// The force that makes such an acceleration.
    pub force: f64,
}

/// Sizes of all signals.
#[derive(Clone, Debug)]
pub(super) struct Scales {
    pub inputs: Vec<Signal>,
    pub states: Vec<Signal>,
    pub outputs: Vec<Signal>,
    pub sites: Vec<SiteScale>,
    /// Signals inside the plant.
    pub inner: Vec<Signal>,
    pub ts: f64,
    pub duration: f64,
}

impl Signal {
    pub(super) fn of(values: &[f64]) -> Self {
        let n = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / n;
        let square = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n;
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        // A constant signal has a size all the same.
        let peak = low.abs().max(high.abs()).max(1e-12);
        let slope = values.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / n;
        let std = square.sqrt().max(1e-9 * peak);
        Self { mean, std, peak, low, high, slope: slope.sqrt() }
    }
}
