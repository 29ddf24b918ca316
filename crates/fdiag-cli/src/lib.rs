//! What the command line `fdiag` does with a user's own models and logs, as a library.
//!
//! [`logs`] learns the bias of a residual from healthy logs and looks for faults in others. Which unmodelled effect
//! separates a simulator from logs of the real system is found by [`fdiag::gap_study`] and shown by `fd_page`.

pub mod logs;
