//! Error of the gain of an actuator.

use fd_sim::{model::Model, scales::ReplayScales};

use super::places::each_place;
use crate::{Effect, Offers};

/// Gain error `u + e u`; in the asymmetric law `u + e u + a |u|`, that is `e ± a` for the two
/// signs.
#[derive(Clone, Copy, Debug)]
pub struct InputGain;

impl Effect for InputGain {
    fn label(&self) -> &'static str {
        "input-gain"
    }

    fn family(&self) -> &'static str {
        "actuator-gain"
    }

    fn is_signed(&self) -> bool {
        true
    }

    fn is_often_alike(&self) -> bool {
        true
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_place(self, nominal, scales, |sketch, _| {
            let gain = |law| sketch(law).strength("e", "gain_error", "1", 1.0, [-0.9, 2.0]);
            vec![
                gain("symmetric").wrap_input("(1 + e)*u").starts([[0.05], [-0.2]]),
                gain("asymmetric")
                    .strength("a", "gain_asymmetry", "1", 1.0, [-1.0, 1.0])
                    .wrap_input("(1 + e)*u + a*abs(u)")
                    .starts([[0.05, 0.05], [-0.05, -0.05]]),
            ]
        })
    }
}
