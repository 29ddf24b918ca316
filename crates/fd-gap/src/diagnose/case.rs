//! The subject of a diagnosis: simulator, suspects, logs.

use fd_effect::Suspects;
use fd_model::Record;
use fd_sim::simulate::Nominal;

/// What is diagnosed: a simulator, what it may lack, and logs of the real thing.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// The simulator.
    pub nominal: &'a dyn Nominal,
    /// What is tried.
    pub suspects: &'a dyn Suspects,
    /// Logs that models are fitted to, all of one sample time.
    pub logs: &'a [Record],
    /// Logs that no fit sees.
    pub held_out: &'a [Record],
}
