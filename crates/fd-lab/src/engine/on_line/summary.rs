//! What all engines say together of the way on line.

use serde::{Deserialize, Serialize};

use super::trial::{Drift, InTraining, OnLine, Opened};
use crate::{
    compare::Share,
    engine::{range::Range, trial::Trial},
};

/// Shares with their 95 % intervals, medians and ranges over the engines.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OnLineSummary {
    /// Engines for which the switch opened.
    pub opened: Share,
    /// Time to open in s, of those.
    pub opened_s: Range,
    /// How many times smaller the largest fault-free residual became.
    pub fault_free_ratio: Range,
    /// Share of fault-free test runs with an alarm, without compensation.
    pub false_alarms_primary: f64,
    /// The same with it.
    pub false_alarms_compensated: f64,
    /// Smallest detectable size of each faulty sensor.
    pub smallest: Vec<Range>,
    /// One entry per fault in training.
    pub in_training: Vec<TrainingFaultSummary>,
    /// Healthy engines that were said to have changed after the opening.
    pub healthy_changed: Share,
    /// Healthy engines with an alarm after the opening.
    pub healthy_alarm: Share,
    /// The same, of alarms while the threshold was not said to be void.
    pub healthy_stated: Share,
    /// Mean share of the time for which it was.
    pub healthy_void: f64,
    /// Healthy engines with an alarm when the input jumped further than the threshold was set on.
    pub jumps_alarm: Share,
    /// The same, of alarms while the threshold was not said to be void.
    pub jumps_stated: Share,
    /// Mean share of the time for which it was.
    pub jumps_void: f64,
    /// One entry per fault that began after the opening: an alarm, and its delay in s.
    pub faults: Vec<(Share, Range)>,
    /// Engines with an incipient fault that were said to have changed before there was an alarm.
    pub incipient_mistaken: Share,
    /// Engines with an incipient fault and an alarm.
    pub incipient_found: Share,
    /// Delay of that alarm in s.
    pub incipient_delay_s: Range,
    /// Engines that drifted and were said to have changed.
    pub drift_seen: Share,
    /// Engines that drifted, with an alarm before that was said.
    pub drift_alarm: Share,
    /// Engines that drifted and had their bias learned again at the end of the run.
    pub drift_learned: Share,
    /// Time in s from the beginning of the drift until then.
    pub drift_learned_s: Range,
    /// Root mean square of `r*` at the end relative to before the drift, with the old parameters.
    pub drift_old: Range,
    /// The same with what was learned again, of the engines that had it.
    pub drift_new: Range,
}

/// What one kind of fault in training did.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrainingFaultSummary {
    /// Reported as a hard fault.
    pub reported: Share,
    /// Delay of the report in s.
    pub reported_s: Range,
    /// The switch opened although the fault was there.
    pub opened: Share,
    /// Of those, an alarm followed.
    pub alarm: Share,
    /// Of those, how much of the fault `r*` shows.
    pub shown: Range,
}

impl OnLineSummary {
    /// `None` when nothing was done on line.
    pub(in crate::engine) fn of(trials: &[Trial]) -> Option<Self> {
        let lines: Vec<&OnLine> = trials.iter().filter_map(|t| t.on_line.as_ref()).collect();
        let open: Vec<&Opened> = lines.iter().filter_map(|line| line.open.as_ref()).collect();
        let first = *open.first()?;
        let range = |f: &dyn Fn(&Opened) -> f64| Range::of(open.iter().map(|o| f(o)));
        let mean =
            |f: &dyn Fn(&Opened) -> f64| open.iter().map(|o| f(o)).sum::<f64>() / open.len() as f64;
        let share = |f: &dyn Fn(&Opened) -> bool| shared(open.iter().map(|o| f(o)));
        let drifts: Vec<Drift> = open.iter().filter_map(|o| o.drift).collect();
        let drifted = |f: &dyn Fn(&Drift) -> bool| shared(drifts.iter().map(f));
        let learned = || drifts.iter().filter(|d| d.learned_s.is_some());
        let faults = (0..first.in_training.len()).map(|i| {
            let all: Vec<&InTraining> = open.iter().map(|o| &o.in_training[i]).collect();
            TrainingFaultSummary::of(&all)
        });
        let smallest = (0..first.smallest.len()).map(|i| range(&|o| o.smallest[i]));
        Some(Self {
            opened: shared(lines.iter().map(|line| line.opened_s.is_some())),
            opened_s: Range::of(lines.iter().filter_map(|line| line.opened_s)),
            fault_free_ratio: range(&|o| o.fault_free.ratio()),
            false_alarms_primary: mean(&|o| o.false_alarms.primary),
            false_alarms_compensated: mean(&|o| o.false_alarms.compensated),
            smallest: smallest.collect(),
            in_training: faults.collect(),
            healthy_changed: share(&|o| o.healthy.changed_s.is_some()),
            healthy_alarm: share(&|o| o.healthy.alarm_s.is_some()),
            healthy_stated: share(&|o| o.healthy.stated_alarm_s.is_some()),
            healthy_void: mean(&|o| o.healthy.void),
            jumps_alarm: share(&|o| o.jumps.alarm_s.is_some()),
            jumps_stated: share(&|o| o.jumps.stated_alarm_s.is_some()),
            jumps_void: mean(&|o| o.jumps.void),
            faults: (0..first.faults.len())
                .map(|i| {
                    let alarms = || open.iter().map(|o| o.faults[i].alarm_s);
                    (shared(alarms().map(|s| s.is_some())), Range::of(alarms().flatten()))
                })
                .collect(),
            incipient_mistaken: share(&|o| before(o.incipient.changed_s, o.incipient.alarm_s)),
            incipient_found: share(&|o| o.incipient.alarm_s.is_some()),
            incipient_delay_s: Range::of(open.iter().filter_map(|o| o.incipient.alarm_s)),
            drift_seen: drifted(&|d| d.said.changed_s.is_some()),
            drift_alarm: drifted(&|d| before(d.said.alarm_s, d.said.changed_s)),
            drift_learned: drifted(&|d| d.learned_s.is_some()),
            drift_learned_s: Range::of(learned().filter_map(|d| d.learned_s)),
            drift_old: Range::of(drifts.iter().map(|d| d.old / d.before)),
            drift_new: Range::of(learned().map(|d| d.new / d.before)),
        })
    }
}

impl TrainingFaultSummary {
    fn of(all: &[&InTraining]) -> Self {
        let opened = || all.iter().filter(|fault| fault.opened);
        Self {
            reported: shared(all.iter().map(|fault| fault.reported_s.is_some())),
            reported_s: Range::of(all.iter().filter_map(|fault| fault.reported_s)),
            opened: shared(all.iter().map(|fault| fault.opened)),
            alarm: shared(opened().map(|fault| fault.alarm)),
            shown: Range::of(opened().filter_map(|fault| fault.shown)),
        }
    }
}

/// Whether one happened, and before the other.
fn before(one: Option<f64>, other: Option<f64>) -> bool {
    one.is_some_and(|one| other.is_none_or(|other| one < other))
}

fn shared(hits: impl Iterator<Item = bool>) -> Share {
    let (hits, of) = hits.fold((0, 0), |(hits, of), hit| (hits + u64::from(hit), of + 1));
    Share::new(hits, of)
}
