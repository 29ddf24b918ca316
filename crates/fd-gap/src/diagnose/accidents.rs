//! Single bad samples that only the best answer reveals: they are named with their rows and left out.
//!
//! A garbled sample that stands out from its neighbours is found before any fit
//! ([`wrong_samples`](crate::quality::wrong_samples)). One that is hidden by the motion of the plant stands out
//! only in the residual of the best answer, where it looks like "outliers of the sensor". A sensor that is
//! wrong once in a log does not have that property: the sample is an accident, and the logs are diagnosed
//! without it.
//!
//! *When not to use:* for more than a few bad samples. How often a sensor is wrong is then worth knowing.

use fd_model::Record;

use super::{case::Case, judge::judged::Judged, result::Verdict};
use crate::quality::{Finding, MOST_ACCIDENTS, wrong_sample};

/// Samples of the fitted logs that are wrong by accident.
#[derive(Debug)]
pub(super) struct Accidents {
    /// What there is to say of each.
    pub findings: Vec<Finding>,
    /// The fitted logs without them.
    pub logs: Vec<Record>,
}

impl Accidents {
    /// The samples that the best answer leaves out because they are wrong, if they are few.
    pub(super) fn of(judged: &Judged<'_>, case: &Case<'_>) -> Option<Self> {
        if judged.verdict == Verdict::NoGap {
            return None;
        }
        let (outputs, plan) =
            (judged.singles.base.simulator().outputs(), judged.singles.base.plan());
        let mut places = Vec::new();
        for (c, (channel, signals)) in outputs.iter().zip(&judged.best.errors).enumerate() {
            let mut counts = vec![0; case.logs.len()];
            for (errors, segment) in signals.iter().zip(plan.segments()) {
                let fitted = &plan.logs[segment.log].y;
                let is_measured = |row: usize| fitted[row * outputs.len() + c].is_finite();
                let left_out = (segment.from..).zip(errors).filter(|(_, error)| error.is_nan());
                for (row, _) in left_out.filter(|(row, _)| is_measured(*row)) {
                    counts[segment.log] += 1;
                    places.push((segment.log, channel.name.as_str(), row));
                }
            }
            if counts.iter().any(|count| MOST_ACCIDENTS < *count) {
                return None;
            }
        }
        if places.is_empty() {
            return None;
        }
        let mut all = Self { findings: Vec::new(), logs: case.logs.to_vec() };
        for (log, channel, row) in places {
            all.leave_out(log, channel, row)?;
        }
        Some(all)
    }

    /// Takes a sample out of a log.
    fn leave_out(&mut self, log: usize, channel: &str, row: usize) -> Option<()> {
        let record = self.logs.get_mut(log)?;
        let c = record.output_index(channel)?;
        let defect = wrong_sample(&record.output(c).collect::<Vec<f64>>(), row)?;
        self.findings.push(Finding { log: log + 1, channel: channel.to_owned(), defect });
        record.y_mut(row)[c] = f64::NAN;
        Some(())
    }
}
