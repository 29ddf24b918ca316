//! The integration tests of `fd-compensate`, one program.

mod adaptive;
mod allocation;
mod calibration;
mod compensation;
mod convergence_rules;
mod decisions;
mod detectors;
mod hard_faults;
mod held_out;
mod isolation;
mod laws;
mod pipeline;
mod plant_change;
mod pre_fitted;
mod sequential;
mod support;
mod two_sample;
mod void;
