//! The work of the command line `fdiag` on a user's own models and logs, as a library.
//!
//! [`logs`] learns the bias of a residual from healthy logs and looks for faults in others.
//! [`fdiag::gap_study`] finds the unmodelled effect that separates a simulator from logs of the real system;
//! `fd_page` presents it.

pub mod logs;
