//! Every detector, decision rule and compensator, for tests that must see them all.
//!
//! Only with the feature `testing`. A shared test walks one of these lists and keeps none of its own, so every
//! test covers whatever is added to a list. Each module keeps its list beside its table.

pub use crate::{
    decide::every_rule, detect::every_detector, residual_compensation::every_compensator,
};
