//! Constant load.

use fd_sim::{model::Model, scales::ReplayScales};

use super::sites::{BETWEEN, each_site};
use crate::{Effect, InAnotherRun, Offers};

/// A constant force, from the start of the log or, `applied-late`, since some time: in the integration step of that time it
/// counts with the part in which it is there, so that what it adds up to is exact. `between` two times it is there and goes
/// again; `put-on-slowly` it grows in a straight line for some time (a vessel that is filled, a brake that is tightened).
#[derive(Clone, Copy, Debug)]
pub struct ConstantLoad;

/// Times from which to start: what a step excites has died away after a part of the log, and a fit
/// cannot see from one step response to another.
const ONSETS: u8 = 24;

/// Beginnings and durations of what is put on slowly, as parts of the log, from which to start.
const SLOW: [[f64; 2]; 6] =
    [[0.0, 0.2], [0.1, 0.5], [0.25, 0.2], [0.3, 0.5], [0.5, 0.2], [0.7, 0.2]];

impl Effect for ConstantLoad {
    fn label(&self) -> &'static str {
        "constant-load"
    }

    fn family(&self) -> &'static str {
        "load"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            let load = |law| {
                let unit = &at.site.unit;
                sketch(law).strength("c", "constant", unit, at.force(), [-10.0, 10.0])
            };
            vec![
                load("constant").force("constant_load", "c").starts([[0.1]]),
                load("applied-late")
                    .shape("since", "since", "s", scales.duration, [0.0, 1.0], 0.0)
                    .onset("on", "on", "since")
                    .force("late_load", "c*on")
                    .in_another_run(InAnotherRun::GoesOn)
                    .starts((0..ONSETS).map(|i| [0.1, (f64::from(i) + 0.5) / f64::from(ONSETS)])),
                load("between")
                    .shape("since", "since", "s", scales.duration, [0.0, 1.0], 0.0)
                    .shape("lasts", "lasts", "s", scales.duration, [0.0, 1.0], 1.0)
                    .onset("on", "on", "since")
                    .onset("off", "off", "since + lasts")
                    .force("load_for_a_time", "c*(on - off)")
                    .in_another_run(InAnotherRun::GoesOn)
                    .starts(BETWEEN.map(|[since, lasts]| [0.1, since, lasts])),
                load("put-on-slowly")
                    .shape("since", "since", "s", scales.duration, [0.0, 1.0], 0.0)
                    .shape("lasts", "lasts", "s", scales.duration, [0.0, 1.0], 0.0)
                    .force("growing_load", "c*clamp((t - since)/max(lasts, dt), 0, 1)")
                    .in_another_run(InAnotherRun::GoesOn)
                    .starts(SLOW.map(|[since, lasts]| [0.1, since, lasts])),
            ]
        })
    }
}
