//! Sizes of all signals in a run without any effect.

use super::simulate::{Observer, Snapshot};

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
    fn of(values: &[f64]) -> Self {
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

/// Records all signals of a run.
#[derive(Default)]
pub(super) struct Recorder {
    inputs: Vec<Vec<f64>>,
    states: Vec<Vec<f64>>,
    outputs: Vec<Vec<f64>>,
    /// Per site: position, velocity, acceleration, acceleration per force.
    sites: Vec<[Vec<f64>; 4]>,
    inner: Vec<Vec<f64>>,
}

impl Observer for Recorder {
    fn see(&mut self, now: &Snapshot<'_>) {
        let add = |to: &mut Vec<Vec<f64>>, from: &[f64]| {
            to.resize(from.len(), Vec::new());
            to.iter_mut().zip(from).for_each(|(to, from)| to.push(*from));
        };
        add(&mut self.inputs, now.u);
        add(&mut self.states, now.x);
        add(&mut self.outputs, now.y);
        add(&mut self.inner, now.inner);
        self.sites.resize_with(now.sites.len(), Default::default);
        for (to, site) in self.sites.iter_mut().zip(now.sites) {
            for (to, value) in to.iter_mut().zip([site.x, site.v, site.a, site.c]) {
                to.push(value);
            }
        }
    }
}

impl Recorder {
    pub(super) fn scales(&self, ts: f64) -> Scales {
        let all = |signals: &[Vec<f64>]| signals.iter().map(|s| Signal::of(s)).collect();
        let optional =
            |values: &Vec<f64>| values.iter().all(|v| v.is_finite()).then(|| Signal::of(values));
        let site = |[x, v, a, c]: &[Vec<f64>; 4]| {
            let acceleration = Signal::of(a).std;
            SiteScale {
                position: optional(x),
                velocity: optional(v),
                acceleration,
                force: acceleration / Signal::of(c).mean.abs().max(1e-300),
            }
        };
        let samples = self.outputs.first().map_or(0, Vec::len) as f64;
        Scales {
            inputs: all(&self.inputs),
            states: all(&self.states),
            outputs: all(&self.outputs),
            sites: self.sites.iter().map(site).collect(),
            inner: all(&self.inner),
            ts,
            duration: samples * ts,
        }
    }
}
