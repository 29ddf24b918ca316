//! One withheld cause in a jet engine, two simulators that lack it: which of them names it?
//!
//! [`engine_log`] makes logs of an engine that has a cause, by another integration than that of the
//! simulators in [`fdiag::engine_plant`].
//!
//! *What is not independent:* the engine of the logs and that of the nonlinear simulator share the
//! equations of the gas path; only step, scatter, noise and the withheld cause differ.

mod reality;
mod study;

pub(crate) use self::study::engine_as_black_box;
pub use self::{
    reality::{EngineCause, engine_log},
    study::{Answer, FewRunsOfEngine, diagnose_engine, diagnose_with_few_runs},
};
