//! A model file, running.

mod steps;
mod system;

use std::sync::Arc;

use fd_core::Scalar;
use fd_model::{Channel, SampleTime};

use self::system::System;
use super::{
    delay_line::DelayLine,
    error::SimulateError,
    simulator::{Initial, Outcome, Port, Simulator, drive},
};
use crate::{
    equation::{Program, Workspace},
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
/// use fd_gap::{model::Model, simulate::{EquationSimulator, Outcome, Simulator}};
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
    system: Arc<System>,
    rates: Workspace<T>,
    updates: Workspace<T>,
    outputs: Workspace<T>,
    control: Option<Workspace<T>>,
    x: Vec<T>,
    u: Vec<T>,
    u_next: Vec<T>,
    /// Signals of a sampled controller, then delayed values.
    held: Vec<T>,
    lines: Vec<DelayLine<T>>,
    delays: Vec<Workspace<T>>,
    delay_times: Workspace<T>,
    /// 1 in the first integration step of a run.
    first: T,
    /// The four slopes of Runge-Kutta.
    k: [Vec<T>; 4],
    /// Results of update laws and of the controller, until they are stored.
    updated: Vec<T>,
    /// Sample number.
    sample: u64,
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
        let mut system = (*self.system).clone();
        system.timing = system.timing.refined(factor);
        Self::of(system)
    }

    /// Integration steps per sample.
    #[must_use]
    pub fn substeps(&self) -> usize {
        self.system.timing.substeps
    }

    fn of(system: System) -> Self {
        let zeros = |n: usize| vec![T::zero(); n];
        let (nx, nu) = (system.nx, system.inputs.len() + system.ports.len());
        let signals = system.control.as_ref().map_or(0, |control| control.signals);
        let acts = system.control.as_ref().map_or(0, |control| control.program.results());
        Self {
            rates: system.rates.workspace(),
            updates: system.updates.workspace(),
            outputs: system.outputs.workspace(),
            control: system.control.as_ref().map(|control| control.program.workspace()),
            x: zeros(nx),
            u: zeros(nu),
            u_next: zeros(nu),
            held: zeros(signals + system.delays.len()),
            lines: system.delays.iter().map(|_| DelayLine::new()).collect(),
            delays: system.delays.iter().map(Program::workspace).collect(),
            delay_times: system.delay_times.workspace(),
            first: T::one(),
            k: [zeros(nx), zeros(nx), zeros(nx), zeros(nx)],
            updated: zeros(nx.max(acts).max(system.delays.len())),
            sample: 0,
            system: Arc::new(system),
        }
    }

    /// As [`Simulator::start`], for any scalar.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn restart(&mut self, theta: &[T], x0: &[T], first: u64) {
        let system = &*self.system;
        let h = T::from_design(system.timing.h());
        let prepare = |program: &Program, workspace: &mut Workspace<T>| {
            let slow = workspace.slow_mut();
            slow[..theta.len()].copy_from_slice(theta);
            slow[theta.len()] = h;
            program.prepare(workspace);
        };
        prepare(&system.rates, &mut self.rates);
        prepare(&system.updates, &mut self.updates);
        prepare(&system.outputs, &mut self.outputs);
        if let (Some(control), Some(workspace)) = (&system.control, &mut self.control) {
            prepare(&control.program, workspace);
        }
        prepare(&system.delay_times, &mut self.delay_times);
        for (program, workspace) in system.delays.iter().zip(&mut self.delays) {
            prepare(program, workspace);
        }
        let times = &mut self.updated[..self.lines.len()];
        system.delay_times.run(&mut self.delay_times, times);
        for (line, time) in self.lines.iter_mut().zip(times) {
            line.start(*time / h);
        }
        self.x.copy_from_slice(x0);
        self.first = T::one();
        self.held.fill(T::zero());
        self.sample = first;
    }

    /// As [`Simulator::step`], for any scalar.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn advance(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [T]) {
        let inputs = self.system.inputs.len();
        load(&mut self.u[..inputs], &u[..inputs]);
        load(&mut self.u_next[..inputs], &u_next[..inputs]);
        load(&mut self.u[inputs..], f);
        load(&mut self.u_next[inputs..], f);

        let timing = self.system.timing;
        let h = timing.h();
        for substep in 0..timing.substeps {
            let number = self.sample * timing.substeps as u64 + substep as u64;
            let t = self.sample as f64 * timing.ts + substep as f64 * h;
            self.delay(t, substep, DelayLine::push);
            let acts = timing.control_period != 0 && number.is_multiple_of(timing.control_period);
            if acts || T::zero() < self.first {
                self.act(t, substep, acts);
                // The new signals may be delayed on their way.
                self.delay(t, substep, DelayLine::correct);
            }
            if substep == 0 {
                self.measure_at(t, y);
            }
            self.integrate(t, substep);
            self.first = T::zero();
        }
        self.sample += 1;
        if self.x.iter().any(|value| !value.is_finite()) {
            self.x.fill(T::from_design(f64::NAN));
        }
    }

    /// As [`Simulator::simulate`], for any scalar.
    ///
    /// # Panics
    ///
    /// Panics when the numbers of values are wrong.
    pub fn run(&mut self, theta: &[T], x0: &[T], u: &[f64], y: &mut [T]) -> Outcome {
        let (nu, ny) = (self.system.inputs.len(), self.system.channels.len());
        self.restart(theta, x0, 0);
        drive(nu, ny, u, y, |now, next, row| self.advance(now, next, &[], row))
    }
}

/// `from` may be shorter than `to`, which is then zero at the end: no forces are zero forces.
fn load<T: Scalar>(to: &mut [T], from: &[f64]) {
    to.fill(T::zero());
    to.iter_mut().zip(from).for_each(|(to, from)| *to = T::from_design(*from));
}

impl Simulator for EquationSimulator<f64> {
    fn ts(&self) -> SampleTime {
        self.system.ts
    }

    fn inputs(&self) -> &[Channel] {
        &self.system.inputs
    }

    fn outputs(&self) -> &[Channel] {
        &self.system.channels
    }

    fn parameters(&self) -> &[Parameter] {
        &self.system.parameters
    }

    fn initial(&self) -> &[Initial] {
        &self.system.initial
    }

    fn ports(&self) -> &[Port] {
        &self.system.ports
    }

    fn start(&mut self, theta: &[f64], x0: &[f64], first: u64) {
        self.restart(theta, x0, first);
    }

    fn step(&mut self, u: &[f64], u_next: &[f64], f: &[f64], y: &mut [f64]) {
        self.advance(u, u_next, f, y);
    }

    /// Not with delays or a sampled controller, which remember what they have seen.
    fn measure(&mut self, u: &[f64], y: &mut [f64]) -> bool {
        let inputs = self.system.inputs.len();
        load(&mut self.u[..inputs], &u[..inputs]);
        let is_plain = self.lines.is_empty() && self.system.control.is_none();
        if is_plain {
            self.measure_at(self.sample as f64 * self.system.timing.ts, y);
        }
        is_plain
    }

    fn state(&self) -> &[f64] {
        &self.x
    }

    fn go_on_from(&mut self, x: &[f64]) -> bool {
        self.x.copy_from_slice(x);
        true
    }

    fn boxed(&self) -> Box<dyn Simulator> {
        Box::new(self.clone())
    }

    fn simulate(&mut self, theta: &[f64], x0: &[f64], u: &[f64], y: &mut [f64]) -> Outcome {
        self.run(theta, x0, u, y)
    }
}
