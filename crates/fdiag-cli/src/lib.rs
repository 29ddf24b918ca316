//! What the command line `fdiag` does with a user's own models and logs, as a library.
//!
//! [`gap`] shows which unmodelled effect separates a simulator from logs of the real system
//! ([`fdiag::gap_study`] finds it); [`logs`] learns the bias of a residual from healthy logs and looks for faults in
//! others.

pub mod gap;
pub mod logs;
