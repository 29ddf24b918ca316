//! Every detector, decision rule and compensator, for tests that must see them all.
//!
//! Only with the feature `testing`. A test of a law walks one of these lists and keeps none of its own,
//! so what is added to a list is put to every law. Each room keeps its list beside its table.

pub use crate::{
    decide::every_rule, detect::every_detector, residual_compensation::every_compensator,
};
