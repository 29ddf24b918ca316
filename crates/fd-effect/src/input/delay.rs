//! Delay of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::{each_place, may_be_from_rest};
use crate::{Effect, Offers};

/// Longest delay, in samples: what is slow is often logged fast.
const LONGEST: f64 = 200.0;
/// Delays from which to start, in samples.
const STARTS: [[f64; 1]; 9] =
    [[0.5], [2.0], [6.0], [15.0], [28.0], [45.0], [70.0], [110.0], [165.0]];

/// The longest delay that a log can show, and the delays up to it from which to start, in samples.
pub(crate) fn delays(scales: &ReplayScales) -> (f64, Vec<[f64; 1]>) {
    let longest = LONGEST.min(0.25 * scales.duration / scales.ts);
    (longest, STARTS.into_iter().filter(|[start]| *start < longest).collect())
}

/// Delay by any fraction of a sample. Before the first command arrives it is as if that had been given for long, in the law
/// `from-rest` nothing has. Over each integration step the plant sees the mean of the
/// held input that arrives, so outputs are continuous in the delay.
#[derive(Clone, Copy, Debug)]
pub struct InputDelay;

impl Effect for InputDelay {
    fn label(&self) -> &'static str {
        "input-delay"
    }

    fn family(&self) -> &'static str {
        "actuator-dynamics"
    }

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let (longest, starts) = delays(scales);
        each_place(self, nominal, scales, |sketch, input| {
            let pure = |law| {
                sketch(law)
                    .strength("T", "delay", "s", scales.ts, [0.0, longest])
                    .delay("late", "delayed", "u", "T")
            };
            let mut laws = vec![pure("pure").wrap_input("late").starts(starts.clone())];
            if may_be_from_rest(scales, input) {
                let arriving = pure("pure-from-rest").onset("on", "arrived", "T");
                laws.push(arriving.wrap_input("late*on").starts(starts.clone()));
            }
            laws
        })
    }
}
