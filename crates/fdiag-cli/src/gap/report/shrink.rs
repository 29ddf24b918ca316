//! How far the gap shrinks on held-out data.

use fd_gap::{diagnose::HeldOut, fit::Horizon, shrink::Closed};
use fd_model::Channel;
use serde::Serialize;

/// The gap on held-out data at one horizon.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HorizonReport {
    /// `free-run` or `windows`.
    pub horizon: &'static str,
    /// Length of the horizon, in seconds.
    pub seconds: f64,
    /// Gaps of each output.
    pub outputs: Vec<OutputGap>,
    /// Share of the gap of the nominal model that is closed; none without such a gap.
    pub closed_of_nominal: Option<ClosedReport>,
    /// Share of the gap of the refitted model that is closed; none without such a gap.
    pub closed_of_refit: Option<ClosedReport>,
}

/// The held-out gap of an output: root mean squares in its unit.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputGap {
    /// Name of the output.
    pub output: String,
    /// Its unit.
    pub unit: String,
    /// With the model as it came.
    pub before: f64,
    /// With parameters refitted.
    pub refit: f64,
    /// With the best explanation.
    pub after: f64,
    /// Noise floor.
    pub floor: f64,
}

/// A share of a gap above the noise floor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ClosedReport {
    /// The share; 1 is all of it, negative is harm.
    pub fraction: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// Length of a block of the bootstrap, in samples.
    pub block_samples: usize,
}

impl From<&Closed> for ClosedReport {
    fn from(closed: &Closed) -> Self {
        let Closed { fraction, interval: [low, high], block } = *closed;
        Self { fraction, low, high, block_samples: block }
    }
}

impl HorizonReport {
    pub(in crate::gap) fn of(held_out: &HeldOut, outputs: &[Channel]) -> Self {
        let gap = |(i, channel): (usize, &Channel)| OutputGap {
            output: channel.name.clone(),
            unit: channel.unit.clone(),
            before: held_out.nominal[i],
            refit: held_out.refit[i],
            after: held_out.after[i],
            floor: held_out.floor[i],
        };
        Self {
            horizon: match held_out.horizon {
                Horizon::FreeRun => "free-run",
                Horizon::Windows { .. } => "windows",
            },
            seconds: held_out.seconds,
            outputs: outputs.iter().enumerate().map(gap).collect(),
            closed_of_nominal: held_out.closed_of_nominal.as_ref().map(ClosedReport::from),
            closed_of_refit: held_out.closed_of_refit.as_ref().map(ClosedReport::from),
        }
    }

    /// The share that counts: of what refitted parameters leave, or of the nominal gap when they
    /// leave none.
    pub(in crate::gap) fn closed(&self) -> Option<ClosedReport> {
        self.closed_of_refit.or(self.closed_of_nominal)
    }
}
