//! Which fault an alarm was ascribed to, with how sure that is and how large the fault is.

use fd_core::stage::Decision;
use fd_model::{figure, file::ModelChannel};
use fd_report::Table;
use fdiag::{spec::IsolationSpec, training::Trace};
use serde::{Deserialize, Serialize};

/// What the decision says of a fault at the last sample with an alarm.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedFault {
    /// Time in s of the sample that this was said at.
    pub said_at_s: f64,
    /// The fault that explains the residual best; none when no fault is clear.
    pub name: Option<String>,
    /// Probability that it is this one, or, without a name, that there is a fault at all; only if the
    /// isolation says.
    pub confidence: Option<f64>,
    /// Its size.
    pub size: Option<f64>,
    /// Where the size lies with the probability that the spec asks for.
    pub size_interval: Option<[f64; 2]>,
    /// Unit of the size.
    pub unit: String,
}

impl NamedFault {
    /// From the last alarm of a trace; `None` without an alarm, or when the spec asks for no isolation.
    pub(super) fn of(
        trace: &Trace,
        isolation: &IsolationSpec,
        inputs: &[ModelChannel],
        outputs: &[ModelChannel],
    ) -> Option<Self> {
        let places = isolation.places(inputs, outputs)?;
        let (k, fault) = trace.decision.iter().enumerate().rev().find_map(|(k, decision)| {
            if let Decision::Fault(fault) = decision { Some((k, *fault)) } else { None }
        })?;
        let place = fault.hypothesis.and_then(|at| places.get(at));
        let scale = place.map_or(1.0, |place| place.scale);
        Some(Self {
            said_at_s: trace.time[k],
            name: place.map(|place| place.name.clone()),
            confidence: fault.confidence,
            size: fault.size.map(|size| scale * size),
            size_interval: fault.size_interval.map(|ends| ends.map(|end| scale * end)),
            unit: place.map_or_else(String::new, |place| place.unit.clone()),
        })
    }

    /// As a table of a report.
    pub(super) fn table(&self) -> Table {
        let mut table = Table::new(
            format!("Which fault it is, at {:.1} s", self.said_at_s),
            &["fault", "probability [%]", "size", "interval"],
        );
        let none = || "-".to_owned();
        let with_unit = |text: String| format!("{text} {}", self.unit);
        table.push([
            self.name.clone().unwrap_or_else(|| "none is clear".to_owned()),
            self.confidence.map_or_else(none, |p| figure(100.0 * p)),
            self.size.map_or_else(none, |size| with_unit(figure(size))),
            self.size_interval.map_or_else(none, |[low, high]| {
                with_unit(format!("{} .. {}", figure(low), figure(high)))
            }),
        ]);
        table
    }
}
