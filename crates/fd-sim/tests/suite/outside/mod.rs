//! Simulators outside of this program: real child processes, good ones and awkward ones.
#![cfg(unix)]
#![allow(clippy::float_cmp, reason = "the bits are what is compared")]
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a failure here is a failed test")]

mod bad;
mod good;
mod lanes;
mod lost;
mod settle;

use std::time::Duration;

use fd_model::SampleTime;
use fd_sim::{
    model::Model,
    outside::{OutsideError, OutsideSimulator, Process},
    simulate::{EquationSimulator, Simulator},
};

const SAMPLES: usize = 120;

/// The plant that the process has as well.
fn mass() -> Model {
    include_str!("../../../testing/mass.toml").parse().unwrap()
}

fn ts() -> SampleTime {
    SampleTime::new(0.02).unwrap()
}

/// The plant in this process.
fn inside() -> EquationSimulator {
    EquationSimulator::with_ports(&mass(), ts()).unwrap()
}

/// A process that misbehaves in this way.
fn process(manner: &[&str]) -> Process {
    let mut process = Process::new([env!("CARGO_BIN_EXE_awkward-simulator")]);
    process.command.extend(manner.iter().map(|&word| word.to_owned()));
    process.timeout = Duration::from_secs(20);
    process
}

fn open(process: Process, workers: usize) -> Result<OutsideSimulator, OutsideError> {
    OutsideSimulator::new(process.contract()?, process, workers)
}

fn outside(manner: &[&str]) -> OutsideSimulator {
    open(process(manner), 2).unwrap()
}

/// Steps of some height, each held for ten samples.
fn push() -> Vec<f64> {
    (0..SAMPLES).map(|k| [1.0, -0.7, 0.2, 1.3, -1.1, 0.0][k / 10 % 6]).collect()
}

/// The outputs of the nominal run, and whether it is complete.
fn nominal(simulator: &mut dyn Simulator) -> (Vec<f64>, bool) {
    with(simulator, &mass().nominal())
}

fn with(simulator: &mut dyn Simulator, theta: &[f64]) -> (Vec<f64>, bool) {
    let mut y = vec![0.0; 2 * SAMPLES];
    let outcome = simulator.simulate(theta, &mass().initial(), &push(), &mut y);
    (y, outcome == fd_sim::simulate::Outcome::Complete)
}

/// The same step by step, with a force at the port.
fn pushed(simulator: &mut dyn Simulator, force: f64) -> Vec<f64> {
    let mut y = vec![0.0; 2 * SAMPLES];
    simulator.start(&mass().nominal(), &mass().initial(), 0);
    for (u, row) in push().iter().zip(y.chunks_exact_mut(2)) {
        simulator.step(&[*u], &[*u], &[force], row);
    }
    y
}
