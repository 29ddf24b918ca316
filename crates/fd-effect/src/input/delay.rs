//! Delay of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::each_place;
use crate::{Effect, Offers};

/// Longest delay and time constant, in samples.
pub(crate) const LONGEST: f64 = 60.0;
/// Delays and time constants from which to start, in samples.
pub(crate) const STARTS: [[f64; 1]; 4] = [[0.5], [2.0], [6.0], [15.0]];

/// Delay by any fraction of a sample. Over each integration step the plant sees the mean of the
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

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        let longest = LONGEST.min(0.25 * scales.duration / scales.ts);
        each_place(self, nominal, scales, |sketch, _| {
            vec![
                sketch("pure")
                    .strength("T", "delay", "s", scales.ts, [0.0, longest])
                    .delay("late", "delayed", "u", "T")
                    .wrap_input("late")
                    .starts(STARTS),
            ]
        })
    }
}
