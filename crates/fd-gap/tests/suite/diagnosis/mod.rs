//! Diagnoses: fits, evidence, answers, and what is said around them.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    clippy::print_stdout,
    reason = "tests panic to fail, compare numbers that are exact, and print what they saw"
)]

mod alike;
mod another_run;
mod bad_input;
mod bench_cases;
mod bent;
mod calibrate;
mod circles;
mod diagnose;
mod evidence;
mod experiment;
mod feedback;
mod fit;
mod forecasts;
mod frequency;
mod holes;
mod lanes;
mod laplace;
mod locate;
mod measurement;
mod motion;
mod peoples_systems;
mod quality;
mod reading;
mod reproduce;
mod road;
mod sets;
mod slow_noise;
mod through_windows;
mod valleys;
