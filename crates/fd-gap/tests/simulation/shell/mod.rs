//! Shells: what is diagnosed when a simulator only steps.

mod allocation;
mod diagnosis;
mod laws;
mod pendulum;
