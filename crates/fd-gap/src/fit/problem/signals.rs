//! What a simulation leaves and gives, as signals.

use std::ops::Range;

use super::{By, Problem};
use crate::fit::{Log, Minimum, Segment};

impl Problem {
    /// Errors (simulated less measured) in units of sigma, not whitened, NaN where nothing was
    /// measured: per output, one signal per segment. `None` when a simulation diverges.
    #[must_use]
    pub fn errors(&mut self, z: &[f64]) -> Option<Vec<Vec<Vec<f64>>>> {
        self.simulations += 1;
        let mut r = vec![0.0; self.layout.residuals()];
        let mut raw = r.clone();
        for s in 0..self.layout.segments.len() {
            let y = self.segment_outputs(s, z)?;
            self.weigh(s, &y, &mut r, Some(&mut raw));
        }
        r.iter().all(|value| value.is_finite()).then(|| self.signals(&raw))
    }

    /// As [`errors`](Self::errors) at a minimum of this problem with these weights. From the residuals that are known
    /// there, if they were kept: without a simulation, and the same but for rounding (to the bit where the noise is
    /// white).
    #[must_use]
    pub fn errors_at(&mut self, at: &Minimum) -> Option<Vec<Vec<Vec<f64>>>> {
        if at.r.is_empty() {
            return self.errors(&at.z);
        }
        let mut raw = vec![0.0; at.r.len()];
        let segments = self.layout.segments.iter().zip(&self.plan.segments);
        for (s, (rows, Segment { log, from, to })) in segments.enumerate() {
            let mut r = at.r[rows.clone()].to_vec();
            if let Some(unknown) = &self.weights.unknown {
                unknown.restore(s, &mut r);
            }
            let log = &self.plan.logs[*log];
            let length = to - from;
            for (c, colour) in self.weights.colour.iter().enumerate() {
                let own = c * length..(c + 1) * length;
                let error = &mut raw[rows.start + own.start..rows.start + own.end];
                let measured = log.y[from * log.ny..].iter().skip(c).step_by(log.ny);
                // Missing where nothing was measured.
                error.iter_mut().zip(measured).for_each(|(e, m)| *e = 0.0 * m);
                colour.restore(&r[own], error);
            }
        }
        Some(self.signals(&raw))
    }

    /// Residuals as signals: per output, one per segment.
    fn signals(&self, raw: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let ny = self.weights.sigma.len();
        let rows = |c: usize, rows: &Range<usize>| {
            let length = rows.len() / ny;
            raw[rows.start + c * length..rows.start + (c + 1) * length].to_vec()
        };
        let signals = |c: usize| self.layout.segments.iter().map(|s| rows(c, s)).collect();
        (0..ny).map(signals).collect()
    }

    /// The logs of the plan with simulated outputs in place of the measured ones; holes stay.
    #[must_use]
    pub fn simulated(&mut self, z: &[f64]) -> Option<Vec<Log>> {
        let mut logs = self.plan.logs.clone();
        for s in 0..self.layout.segments.len() {
            let y = self.segment_outputs(s, z)?;
            let Segment { log, from, to } = self.plan.segments[s];
            let log = &mut logs[log];
            for (m, y) in log.y[from * log.ny..to * log.ny].iter_mut().zip(&y) {
                if m.is_finite() {
                    *m = *y;
                }
            }
        }
        Some(logs)
    }

    /// Simulated outputs of each log of the plan, row by row; `None` when a simulation diverges.
    #[must_use]
    pub fn outputs(&mut self, z: &[f64]) -> Option<Vec<Vec<f64>>> {
        let logs = self.plan.logs.iter();
        let mut outputs: Vec<Vec<f64>> = logs.map(|log| vec![f64::NAN; log.y.len()]).collect();
        for s in 0..self.layout.segments.len() {
            let y = self.segment_outputs(s, z)?;
            let Segment { log, from, .. } = self.plan.segments[s];
            let first = from * self.plan.logs[log].ny;
            outputs[log][first..first + y.len()].copy_from_slice(&y);
        }
        Some(outputs)
    }

    /// Simulated outputs of a segment; `None` when it diverges.
    fn segment_outputs(&mut self, s: usize, z: &[f64]) -> Option<Vec<f64>> {
        let mut y = [vec![0.0; self.layout.segments[s].len()]];
        self.simulate(By::Simulator, s, &[z], &mut y)[0].then(|| std::mem::take(&mut y[0]))
    }
}
