//! Constant load.

use super::each_site;
use crate::{
    effect::{Effect, Offers, ReplayScales},
    model::Model,
};

/// A constant force.
#[derive(Clone, Copy, Debug)]
pub struct ConstantLoad;

impl Effect for ConstantLoad {
    fn label(&self) -> &'static str {
        "constant-load"
    }

    fn family(&self) -> &'static str {
        "load"
    }

    fn candidates(&self, nominal: &Model, scales: &ReplayScales) -> Offers {
        each_site(self, nominal, scales, |sketch, at| {
            vec![
                sketch("constant")
                    .strength("c", "constant", &at.site.unit, at.force(), [-3.0, 3.0])
                    .force("constant_load", "c")
                    .starts([[0.1]]),
            ]
        })
    }
}
