//! The training logs of a case, as a diagnosis cut them, and models that run on them.

use std::ops::Range;

use fd_sim::simulate::{Outcome, Simulator, walk};

use crate::{
    diagnose::{Case, Diagnosis, Start},
    fit::{FitError, Log, Segment},
};

/// The training logs of a case, in the order and the units of its simulator, with the segments that
/// a diagnosis has cut them into.
#[derive(Clone, Debug)]
pub(crate) struct Bench {
    pub simulator: Box<dyn Simulator>,
    pub logs: Vec<Log>,
    pub segments: Vec<Segment>,
    /// Noise of each output.
    pub sigma: Vec<f64>,
}

/// Values per log, row by row.
pub(crate) type Rows = Vec<Vec<f64>>;

impl Bench {
    pub(crate) fn new(case: &Case<'_>, diagnosis: &Diagnosis) -> Result<Self, FitError> {
        let ts = case.logs.first().ok_or(FitError::NoLog)?.ts();
        let simulator = case.nominal.simulator(ts)?;
        let logs = Log::all(case.logs, &*simulator, &[])?;
        let starts = &diagnosis.refit.starts;
        let segments = starts.iter().enumerate().map(|(s, start)| {
            let next = starts.get(s + 1).filter(|next| next.log == start.log);
            let to = next.map_or(logs[start.log].samples, |next| next.from);
            Segment { log: start.log, from: start.from, to }
        });
        let segments = segments.collect();
        Ok(Self { simulator, logs, segments, sigma: diagnosis.sigma.clone() })
    }

    /// Time between samples, in seconds.
    pub(crate) fn ts(&self) -> f64 {
        self.simulator.ts().seconds()
    }

    /// Number of outputs.
    pub(crate) fn ny(&self) -> usize {
        self.sigma.len()
    }

    /// Whether logs are cut into windows.
    pub(crate) fn is_cut(&self) -> bool {
        let stretches = |log: &Log| 1 + log.restarts.len();
        self.logs.iter().map(stretches).sum::<usize>() < self.segments.len()
    }

    /// Residuals (measured less simulated) in sigma: one signal per output and log, NaN where
    /// nothing was measured.
    pub(crate) fn residuals(&self, outputs: &Rows) -> Vec<Vec<Vec<f64>>> {
        let ny = self.ny();
        let residual = |c: usize, (log, simulated): (&Log, &Vec<f64>)| -> Vec<f64> {
            let pairs = log.y.iter().zip(simulated).skip(c).step_by(ny);
            let error = |(measured, simulated): (&f64, &f64)| {
                log.circles[c].difference(*measured, *simulated) / self.sigma[c]
            };
            pairs.map(error).collect()
        };
        let of_output = |c| self.logs.iter().zip(outputs).map(|pair| residual(c, pair)).collect();
        (0..ny).map(of_output).collect()
    }

    /// Runs through all segments from `starts` with parameters `theta`. `extra` has a value per log
    /// and sample for an input of the simulator that the nominal one does not have. Returns outputs
    /// and states, or `None` when something diverges.
    pub(crate) fn run(
        &self,
        simulator: &mut dyn Simulator,
        theta: &[f64],
        starts: &[Start],
        extra: &Rows,
    ) -> Option<(Rows, Rows)> {
        let known = self.simulator.inputs();
        let places: Vec<Option<usize>> = (simulator.inputs().iter())
            .map(|input| known.iter().position(|known| known.name == input.name))
            .collect();
        let (ny, nx) = (simulator.outputs().len(), simulator.initial().len());
        let fresh = |width: usize| -> Rows {
            self.logs.iter().map(|log| vec![f64::NAN; log.samples * width]).collect()
        };
        let (mut outputs, mut states) = (fresh(ny), fresh(nx));
        for (segment, start) in self.segments.iter().zip(starts) {
            let log = &self.logs[segment.log];
            let value = |k: usize, place: &Option<usize>| match place {
                Some(i) => log.input(k)[*i],
                None => extra.get(segment.log).map_or(0.0, |extra| extra[k]),
            };
            let rows = segment.from..(segment.to + 1).min(log.samples);
            let u: Vec<f64> =
                rows.flat_map(|k| places.iter().map(move |place| value(k, place))).collect();
            let y = &mut outputs[segment.log][segment.from * ny..segment.to * ny];
            let x = &mut states[segment.log][segment.from * nx..segment.to * nx];
            let note = |k: usize, now: &[f64]| x[k * nx..(k + 1) * nx].copy_from_slice(now);
            let first = segment.from as u64;
            if walk(simulator, theta, &start.state, first, &u, y, note) != Outcome::Complete {
                return None;
            }
        }
        Some((outputs, states))
    }

    /// Rows of a stacked vector of residuals: segment by segment, output by output.
    pub(crate) fn row_ranges(&self) -> Vec<Range<usize>> {
        let mut end = 0;
        let range = |segment: &Segment| {
            let from = end;
            end += (segment.to - segment.from) * self.ny();
            from..end
        };
        self.segments.iter().map(range).collect()
    }

    /// Stacks signals per output and log; missing values become zero.
    pub(crate) fn stack(&self, signals: &[Vec<Vec<f64>>], scale: &[f64]) -> Vec<f64> {
        let mut all = Vec::new();
        for segment in &self.segments {
            for (c, scale) in scale.iter().enumerate() {
                let signal = &signals[c][segment.log][segment.from..segment.to];
                let value = |v: &f64| if v.is_finite() { v / scale } else { 0.0 };
                all.extend(signal.iter().map(value));
            }
        }
        all
    }
}

/// Values of the parameters of a simulator as they are.
pub(crate) fn settled(simulator: &dyn Simulator) -> Vec<f64> {
    simulator.parameters().iter().map(|parameter| parameter.value).collect()
}
