//! A model file, running.

mod engine;
mod lanes;
mod memory;
mod pieces;
mod signs;
mod steps;
mod system;

use std::sync::Arc;

use fd_core::{Scalar, StateVisitor};
use fd_model::{Channel, SampleTime};

use self::lanes::{Many, WIDEST};
pub(super) use self::{engine::Engine, system::System};
use super::{
    error::SimulateError,
    one_by_one::one_by_one,
    run::{Outcome, Run, drive},
    simulator::{Initial, Port, Simulator},
};
use crate::{
    model::{Model, Parameter},
    patch::open_ports,
};

/// Simulates a [`Model`]. Every run with the same parameters, states and inputs gives the same
/// bits; clones share the compiled equations.
///
/// The scalar is `f64` for simulations, `f32` for small machines, or a dual number, which gives
/// the exact sensitivity of a simulation to parameters and initial states.
///
/// ```
/// use fd_sim::{model::Model, simulate::{EquationSimulator, Outcome, Simulator}};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "1" } }
/// outputs = { y = { unit = "1", value = "x" } }
/// parameters = { T = { unit = "s", value = 2.0 } }
/// states = { x = { unit = "1", initial = 0.0, derivative = "(u - x)/T" } }
/// "#.parse()?;
/// let mut simulator = EquationSimulator::new(&model)?;
/// let mut y = [0.0; 21];
/// let outcome = Simulator::simulate(&mut simulator, &[2.0], &[0.0], &[1.0; 21], &mut y);
/// assert_eq!(outcome, Outcome::Complete);
/// assert!((y[20] - (1.0 - (-1.0_f64).exp())).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct EquationSimulator<T: Scalar = f64> {
    engine: Engine<T>,
    /// Several runs side by side.
    many: Many,
}

impl<T: Scalar> EquationSimulator<T> {
    /// Compiles a model, to be simulated with the sample time of the file.
    ///
    /// # Errors
    ///
    /// Returns an error when no integration step can be found or the controller does not act at
    /// samples.
    pub fn new(model: &Model) -> Result<Self, SimulateError> {
        Self::at(model, model.sample_time()?)
    }

    /// Compiles a model, to be simulated with another sample time, such as that of a log.
    ///
    /// # Errors
    ///
    /// As [`EquationSimulator::new`].
    pub fn at(model: &Model, ts: SampleTime) -> Result<Self, SimulateError> {
        System::new(model, ts, &[]).map(Self::of)
    }

    /// Compiles a model with a port at each of its sites.
    ///
    /// # Errors
    ///
    /// As [`EquationSimulator::new`].
    pub fn with_ports(model: &Model, ts: SampleTime) -> Result<Self, SimulateError> {
        let (model, ports) = open_ports(model);
        System::new(&model, ts, &ports).map(Self::of)
    }

    /// The same simulator with each integration step divided into `factor`, to see whether the
    /// step is short enough.
    #[must_use]
    pub fn refined(&self, factor: usize) -> Self {
        let mut system = (*self.engine.system).clone();
        system.timing = system.timing.refined(factor);
        Self::of(system)
    }

    /// Integration steps per sample.
    #[must_use]
    pub fn substeps(&self) -> usize {
        self.engine.system.timing.substeps
    }

    fn of(system: System) -> Self {
        Self { engine: Engine::new(Arc::new(system)), many: Many::default() }
    }

    /// As [`Simulator::start`], for any scalar.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn restart(&mut self, theta: &[T], x0: &[T], first: u64) {
        self.engine.restart(theta, x0, first);
    }

    /// As [`Simulator::step`], for any scalar.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn advance(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [T]) {
        self.engine.advance(u, u_next, f, y);
    }

    /// As [`Simulator::simulate`], for any scalar.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn run(&mut self, theta: &[T], x0: &[T], u: &[f64], y: &mut [T]) -> Outcome {
        let (nu, ny) = (self.engine.system.inputs.len(), self.engine.system.channels.len());
        self.restart(theta, x0, 0);
        drive(nu, ny, u, y, |now, next, row| self.advance(now, next, &[], row))
    }
}

impl Simulator for EquationSimulator<f64> {
    fn ts(&self) -> SampleTime {
        self.engine.system.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.engine.system.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.engine.system.channels
    }

    fn parameters(&self) -> &[Parameter] {
        &self.engine.system.parameters
    }

    fn initial(&self) -> &[Initial] {
        &self.engine.system.initial
    }

    fn ports(&self) -> &[Port] {
        &self.engine.system.ports
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        self.restart(theta, x0, first);
    }

    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]) {
        self.advance(u, u_next, f, y);
    }

    /// Not with delays or a sampled controller, which remember what they have seen.
    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        self.engine.measure_now(u, y)
    }

    fn state(&self) -> &[f64] {
        &self.engine.x
    }

    fn go_on_from(&mut self, x: &[f64]) -> bool {
        self.engine.x.copy_from_slice(x);
        true
    }

    fn visit_memory(&mut self, visitor: &mut dyn StateVisitor<f64>) -> bool {
        self.engine.visit_memory(visitor);
        true
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }

    fn simulate(&mut self, theta: &[f64], x0: &[f64], u: &[f64], y: &mut [f64]) -> Outcome {
        self.run(theta, x0, u, y)
    }

    fn simulate_many(&mut self, first: u64, u: &[f64], runs: &mut [Run<'_>]) {
        for some in runs.chunks_mut(WIDEST) {
            match some.len() {
                1 => one_by_one(self, first, u, some),
                _ => self.many.run(&self.engine.system, first, u, some),
            }
        }
    }
}
