//! The signals of a run, recorded for their sizes.

use super::{
    scales::{Scales, Signal, SiteScale},
    simulate::{Observer, Snapshot},
};

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
