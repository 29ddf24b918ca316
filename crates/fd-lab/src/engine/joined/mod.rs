//! The two halves joined: the cause of the bias is named, patched into the simulator, and only what is left is
//! learned as a bias.
//!
//! Each nonlinear engine is watched by several residuals of its five outputs, all judged as the fair figure of the
//! benchmark is: the best combination of channels for the sensor in question, a constant threshold, the same healthy
//! runs for all. The opponent is the linear observer with such a threshold and no compensation.
//!
//! What is diagnosed is the beginning of the run that the bias is learned from, and nothing else; the first
//! calibration run judges what is named. Faults and test runs are seen by nobody before.

mod diagnose;
mod exact;
mod scenario;
mod summary;
mod trial;

pub(crate) use self::diagnose::name;
pub use self::{
    scenario::{JoinedScenario, scenarios},
    summary::table,
    trial::{JoinedTrial, Residual, Smallest},
};
