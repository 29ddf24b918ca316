//! A detector over the test runs: false alarms, the smallest fault, the delay.

use fd_compensate::{
    DrivenRows, SampleRows,
    decide::Debouncing,
    evaluate::{alarms, smallest_detectable_by_search},
};
use fd_core::stage::Detector;
use fd_numeric::median;
use fdiag::training::{Trained, TrainingError};

/// Largest fault that is tried, relative to the reading.
const LARGEST_FAULT: f64 = 10.0;

/// A residual and the input that drove the plant, row by row.
pub(super) struct Run {
    pub inputs: Vec<f64>,
    pub residual: Vec<f64>,
}

/// The calibrated detector of one of the two residuals.
pub(super) struct Watch {
    detector: Box<dyn Detector>,
    rule: Debouncing,
    nu: usize,
    channels: usize,
}

/// What a detector finds of a fault.
pub(super) struct Found {
    pub smallest: f64,
    pub share: f64,
    /// In samples.
    pub delay: f64,
}

impl Watch {
    pub(super) fn new(trained: &Trained, healthy: &[f64]) -> Result<Self, TrainingError> {
        let (nu, channels) = (trained.design().io().nu, trained.design().residual_len());
        let detector = trained.detector(healthy)?;
        Ok(Self { detector, rule: trained.spec().rule, nu, channels })
    }

    /// Any detector of one channel.
    pub(super) fn of(detector: Box<dyn Detector>, rule: Debouncing, nu: usize) -> Self {
        Self { detector, rule, nu, channels: 1 }
    }

    /// First sample with a reported fault.
    fn first_alarm(
        &mut self,
        inputs: &[f64],
        residual: &[f64],
    ) -> Result<Option<usize>, TrainingError> {
        self.detector.reset();
        let margins: Vec<f64> = inputs
            .chunks_exact(self.nu)
            .zip(residual.chunks_exact(self.channels))
            .map(|(u, r)| {
                let verdict = self.detector.update(u, r);
                verdict.statistic - verdict.threshold
            })
            .collect();
        Ok(alarms(&margins, 0.0, self.rule)?.iter().position(|&alarm| alarm))
    }

    pub(super) fn false_alarms(&mut self, runs: &[Run]) -> Result<f64, TrainingError> {
        let mut count = 0;
        for run in runs {
            count += usize::from(self.first_alarm(&run.inputs, &run.residual)?.is_some());
        }
        Ok(count as f64 / runs.len() as f64)
    }

    /// A fault of size `s` makes the residual `r + s φ` exactly, so no run is simulated again.
    pub(super) fn find(
        &mut self,
        runs: &[Run],
        phi: &[f64],
        size: f64,
        start: usize,
    ) -> Result<Found, TrainingError> {
        let (mut sizes, mut delays, mut looks) = (Vec::new(), Vec::new(), 0_usize);
        for Run { inputs, residual: r } in runs {
            // A run that alarms by itself is a false alarm, counted as such and not as a find.
            if self.first_alarm(inputs, r)?.is_some() {
                continue;
            }
            let healthy = SampleRows::new(self.channels, r)?;
            let healthy = DrivenRows::new(SampleRows::new(self.nu, inputs)?, healthy)?;
            for sign in [1.0, -1.0] {
                looks += 1;
                let response: Vec<f64> = phi.iter().map(|v| sign * v).collect();
                let rows = SampleRows::new(self.channels, &response)?;
                let (detector, rule) = (self.detector.as_mut(), self.rule);
                let smallest =
                    smallest_detectable_by_search(detector, rule, healthy, rows, LARGEST_FAULT)?;
                sizes.push(smallest.unwrap_or(f64::INFINITY));
                let faulty: Vec<f64> = r.iter().zip(&response).map(|(r, g)| r + size * g).collect();
                if let Some(k) = self.first_alarm(inputs, &faulty)? {
                    delays.push(k.saturating_sub(start) as f64);
                }
            }
        }
        let share = if looks > 0 { delays.len() as f64 / looks as f64 } else { f64::NAN };
        Ok(Found { smallest: median(&mut sizes), share, delay: median(&mut delays) })
    }
}
