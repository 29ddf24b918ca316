//! A detector over recorded residuals: how near it came to an alarm, and when it raised one.

use fd_compensate::{decide::Debouncing, evaluate::DebouncedStatistic};
use fd_core::{Snapshot, stage::Detector};
use fd_model::Record;

/// A detector whose margins are asked for: statistic over threshold, sample by sample, as the rule sees
/// it. A margin above `factor` means an alarm when all thresholds are taken `factor` times.
pub(super) struct Watch {
    detector: Box<dyn Detector>,
    recent: DebouncedStatistic,
    /// Samples at the start of a run that it does not see.
    unseen: usize,
}

/// A detector after the first samples of a run.
pub(super) struct Fork {
    detector: Snapshot,
    recent: DebouncedStatistic,
    /// The largest margin up to here.
    pub peak: f64,
}

/// Margins that mean something.
#[derive(Clone, Copy, Debug)]
pub(super) struct Levels {
    /// Above it is an alarm.
    pub alarm: f64,
    /// Above it nothing more is asked.
    pub enough: f64,
}

impl Levels {
    /// No margin means anything but how large it is.
    pub(super) const NONE: Self = Self { alarm: f64::INFINITY, enough: f64::INFINITY };
}

/// How a run with a fault went on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest {
    /// First sample after the fork with an alarm.
    pub alarm: Option<usize>,
    /// The largest margin, as far as it was looked at.
    pub peak: f64,
}

impl Watch {
    pub(super) fn new(detector: Box<dyn Detector>, rule: Debouncing, unseen: usize) -> Self {
        Self { detector, recent: DebouncedStatistic::new(rule), unseen }
    }

    /// The largest margin of a run without missing samples.
    pub(super) fn peak(&mut self, record: &Record, residual: &[f64]) -> f64 {
        self.detector.reset();
        self.recent.reset();
        let seen = (self.unseen * self.detector.residual_len()).min(residual.len());
        self.on((record, self.unseen), &residual[seen..], Levels::NONE).peak
    }

    /// The detector after the samples of a run that `residual` holds.
    pub(super) fn fork(&mut self, record: &Record, residual: &[f64]) -> Fork {
        let peak = self.peak(record, residual);
        let detector = Snapshot::of(&mut self.detector);
        Fork { detector, recent: self.recent.clone(), peak }
    }

    /// Goes on from a fork, where the residual begins, at this sample of the record, as far as the
    /// levels ask.
    pub(super) fn rest(
        &mut self,
        fork: &Fork,
        at: (&Record, usize),
        residual: &[f64],
        levels: Levels,
    ) -> Rest {
        let restored = fork.detector.restore(&mut self.detector);
        debug_assert!(restored.is_ok(), "the same detector: {restored:?}");
        self.recent = fork.recent.clone();
        self.on(at, residual, levels)
    }

    fn on(&mut self, (record, start): (&Record, usize), residual: &[f64], levels: Levels) -> Rest {
        let channels = self.detector.residual_len();
        let (mut alarm, mut peak) = (None, 0.0_f64);
        for (k, r) in residual.chunks_exact(channels).enumerate() {
            let verdict = self.detector.update(record.u(start + k), r);
            let margin = self.recent.add(verdict.statistic / verdict.threshold);
            if alarm.is_none() && margin > levels.alarm {
                alarm = Some(k);
            }
            peak = peak.max(margin);
            if peak > levels.enough {
                break;
            }
        }
        // Finite, so that it can be written as JSON.
        Rest { alarm, peak: peak.min(f64::MAX) }
    }
}

#[cfg(test)]
mod tests {
    use fd_compensate::{detect::Magnitude, evaluate::debounced_statistics};
    use fd_model::{Channel, SampleTime};

    use super::*;

    /// A record of one input and one output, all zero.
    fn record(samples: usize) -> Record {
        let one = vec![Channel::new("x", "")];
        let (ts, zero) = (SampleTime::new(0.1).unwrap(), vec![0.0; samples]);
        Record::new(one.clone(), one, zero.clone(), zero, ts).unwrap()
    }

    #[test]
    fn what_is_not_seen_plays_no_part() {
        let mut residual = vec![0.0; 100];
        (residual[10], residual[50]) = (5.0, 1.0);
        let peak = |unseen| {
            let detector = Magnitude::<f64>::new(&[1.0], 0.5).unwrap();
            let mut watch = Watch::new(Box::new(detector), Debouncing::default(), unseen);
            watch.peak(&record(100), &residual)
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(peak(0), 10.0) && near(peak(10), 10.0) && near(peak(11), 2.0));
        assert!(near(peak(51), 0.0) && near(peak(200), 0.0));
    }

    /// What is found from a fork, sample by sample, is what the whole run shows.
    #[test]
    fn a_fork_goes_on_as_the_whole_run() {
        let residual: Vec<f64> = (0..200).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
        let record = record(200);
        for rule in [Debouncing::default(), Debouncing::consecutive(3)] {
            let detector = Magnitude::<f64>::new(&[1.0], 0.5).unwrap();
            let mut watch = Watch::new(Box::new(detector), rule, 0);
            let ratios: Vec<f64> = residual.iter().map(|r| r.abs() / 0.5).collect();
            let margins = debounced_statistics(&ratios, rule);
            let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, &m| most.max(m));
            let fork = watch.fork(&record, &residual[..90]);
            assert_eq!(fork.peak.to_bits(), largest(&margins[..90]).to_bits());
            for factor in [0.5, 1.2, 1.9, 2.5] {
                let mut rest = |enough| {
                    let levels = Levels { alarm: factor, enough };
                    watch.rest(&fork, (&record, 90), &residual[90..], levels)
                };
                let alarm = margins[90..].iter().position(|&m| m > factor);
                assert_eq!(rest(10.0), Rest { alarm, peak: largest(&margins[90..]) });
                // Cut short, the alarm is the same and the peak is above what is enough.
                let short = rest(factor);
                assert_eq!((short.alarm, short.peak > factor), (alarm, alarm.is_some()));
            }
            let peak = watch.peak(&record, &residual);
            assert_eq!(peak.to_bits(), largest(&margins).to_bits());
        }
    }
}
