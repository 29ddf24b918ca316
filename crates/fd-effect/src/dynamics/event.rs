//! A parameter that changes in the course of a log.

use fd_sim::{model::Model, scales::ReplayScales};

use super::{parameter::is_used, sites::BETWEEN};
use crate::{Effect, InAnotherRun, Offers, Reason, Sketch};

/// Times of a step from which to start: a fit does not see from one motion that shows it to the next.
const ONSETS: u8 = 24;
/// Beginnings of a slope.
const SLOPES: [f64; 3] = [0.1, 0.4, 0.7];

/// A parameter with another value from some time on (a fan that is switched on, a tool that is picked up), `p (1 + e)`; between
/// two times; or one that moves away in a straight line from then on, `p (1 + r (t - since))`.
///
/// A step is exact within an integration step: it counts with the part of it in which it is there.
#[derive(Clone, Copy, Debug)]
pub struct ParameterEvent;

impl Effect for ParameterEvent {
    fn label(&self) -> &'static str {
        "parameter-event"
    }

    fn family(&self) -> &'static str {
        "parameter"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let length = scales.duration;
        let offers = nominal.parameters.iter().enumerate().flat_map(|(i, parameter)| {
            let event = |law| {
                Sketch::of_parameter(self, law, nominal, scales, i)
                    // A black box takes its parameters when it starts.
                    .require(!scales.states.is_empty(), Reason::Missing("state"))
                    .require(parameter.tolerance > 0.0, Reason::Exact)
                    .require(is_used(nominal, parameter), Reason::Unused)
            };
            let step = |law| {
                event(law)
                    .strength("e", "event", "1", 1.0, [-0.9, 3.0])
                    .shape("since", "since", "s", length, [0.0, 1.0], 0.0)
                    .onset("on", "since", "since")
            };
            let steps = (0..ONSETS).map(|i| [0.1, (f64::from(i) + 0.5) / f64::from(ONSETS)]);
            [
                step("step").wrap_parameter("p*(1 + e*on)").starts(steps),
                step("between")
                    .shape("lasts", "lasts", "s", length, [0.0, 1.0], 1.0)
                    .onset("off", "until", "since + lasts")
                    .wrap_parameter("p*(1 + e*(on - off))")
                    .starts(BETWEEN.map(|[since, lasts]| [0.1, since, lasts])),
                event("slope")
                    .strength("r", "event_slope", "1/s", 1.0 / length, [-2.0, 6.0])
                    .shape("since", "since", "s", length, [0.0, 1.0], 0.0)
                    .wrap_parameter("p*max(1 + r*max(t - since, 0), 0.05)")
                    .starts(SLOPES.map(|since| [0.2, since])),
            ]
            .map(|sketch| sketch.in_another_run(InAnotherRun::GoesOn).finish())
        });
        offers.collect()
    }
}
