//! What a running model consists of, for one run or for several in lanes.

use std::sync::Arc;

use fd_core::Scalar;

use super::{
    super::delay_line::{Course, DelayLine},
    signs::Signs,
    system::System,
};
use crate::{
    equation::{Program, Value, Workspace},
    model::Hold,
};

/// A running model.
#[derive(Clone, Debug)]
pub(in crate::simulate) struct Engine<V> {
    pub system: Arc<System>,
    pub(super) rates: Workspace<V>,
    pub(super) updates: Workspace<V>,
    pub(super) outputs: Workspace<V>,
    pub(super) control: Option<Workspace<V>>,
    pub x: Vec<V>,
    pub(super) u: Vec<V>,
    pub(super) u_next: Vec<V>,
    /// Signals of a sampled controller, then signs, then delayed values.
    pub(super) held: Vec<V>,
    pub(super) signs: Option<Box<Signs<V>>>,
    pub(super) lines: Vec<DelayLine<V>>,
    /// Delayed values over this step, of those that move within one.
    pub(super) courses: Vec<Course<V>>,
    /// States at the start of a step and their first slopes, and states in its middle.
    pub(super) start: Vec<V>,
    pub(super) first_slopes: Vec<V>,
    pub(super) middle: Vec<V>,
    pub(super) delays: Vec<Workspace<V>>,
    pub(super) delay_times: Workspace<V>,
    /// Whether this is the first integration step of a run.
    pub is_first: bool,
    /// The four slopes of Runge-Kutta.
    pub(super) k: [Vec<V>; 4],
    /// Results of update laws and of the controller, until they are stored.
    pub(super) updated: Vec<V>,
    /// Sample number.
    pub sample: u64,
}

impl<V: Value> Engine<V> {
    pub(in crate::simulate) fn new(system: Arc<System>) -> Self {
        let zeros = |n: usize| vec![V::constant(0.0); n];
        let (nx, nu) = (system.nx, system.inputs.len() + system.ports.len());
        let signals = system.control.as_ref().map_or(0, |control| control.signals);
        let acts = system.control.as_ref().map_or(0, |control| control.program.results());
        let count = system.velocities.results();
        let signs = || Box::new(Signs::new(signals, &system));
        Self {
            signs: (count != 0).then(signs),
            rates: system.rates.workspace(),
            updates: system.updates.workspace(),
            outputs: system.outputs.workspace(),
            control: system.control.as_ref().map(|control| control.program.workspace()),
            x: zeros(nx),
            u: zeros(nu),
            u_next: zeros(nu),
            held: zeros(signals + count + system.delays.len()),
            lines: system.delays.iter().map(|_| DelayLine::new()).collect(),
            courses: vec![[V::constant(0.0); 3]; system.delays.len()],
            start: zeros(nx),
            first_slopes: zeros(nx),
            middle: zeros(nx),
            delays: system.delays.iter().map(Program::workspace).collect(),
            delay_times: system.delay_times.workspace(),
            is_first: true,
            k: [zeros(nx), zeros(nx), zeros(nx), zeros(nx)],
            updated: zeros(nx.max(acts).max(system.delays.len())),
            sample: 0,
            system,
        }
    }

    /// Starts a run at a sample.
    pub(in crate::simulate) fn restart(&mut self, theta: &[V], x0: &[V], first: u64) {
        let system = &*self.system;
        let h = V::constant(system.timing.h());
        let prepare = |program: &Program, workspace: &mut Workspace<V>| {
            let slow = workspace.slow_mut();
            slow[..theta.len()].copy_from_slice(theta);
            slow[theta.len()] = h;
            program.prepare(workspace);
        };
        prepare(&system.rates, &mut self.rates);
        prepare(&system.updates, &mut self.updates);
        prepare(&system.outputs, &mut self.outputs);
        if let Some(signs) = &mut self.signs {
            prepare(&system.velocities, &mut signs.velocities);
            signs.restart();
        }
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
            line.start(time.zip(h, |time, h| time / h));
        }
        self.x.copy_from_slice(x0);
        self.is_first = true;
        self.held.fill(V::constant(0.0));
        self.sample = first;
    }

    /// Writes the outputs of a sample and moves on to the next.
    pub(in crate::simulate) fn advance(
        &mut self,
        u: &[f64],
        u_next: &[f64],
        f: &[f64],
        y: &mut [V],
    ) {
        let inputs = self.system.inputs.len();
        load(&mut self.u[..inputs], &u[..inputs]);
        load(&mut self.u[inputs..], f);
        if self.system.hold != Hold::Zero {
            load(&mut self.u_next[..inputs], &u_next[..inputs]);
            load(&mut self.u_next[inputs..], f);
        }

        let timing = self.system.timing;
        let h = timing.h();
        for substep in 0..timing.substeps {
            let number = self.sample * timing.substeps as u64 + substep as u64;
            let t = self.sample as f64 * timing.ts + substep as f64 * h;
            self.delay(t, substep, DelayLine::push);
            let acts = timing.control_period != 0 && number.is_multiple_of(timing.control_period);
            if acts || self.is_first {
                self.act(t, substep, acts);
                // The new signals may be delayed on their way.
                self.delay(t, substep, DelayLine::correct);
            }
            // What is seen of a sign is known after the step that begins here.
            let shows_signs = self.system.shows_signs;
            if substep == 0 && !shows_signs {
                self.measure(t, y);
            }
            self.integrate(t, substep);
            if substep == 0 && shows_signs {
                self.measure_before(t, y);
            }
            self.is_first = false;
        }
        self.sample += 1;
        self.spoil();
    }

    /// Writes the outputs of this sample without moving on; not with delays or a sampled
    /// controller, which remember what they have seen.
    pub(in crate::simulate) fn measure_now(&mut self, u: &[f64], y: &mut [V]) -> bool {
        let inputs = self.system.inputs.len();
        load(&mut self.u[..inputs], &u[..inputs]);
        let is_plain =
            self.lines.is_empty() && self.system.control.is_none() && !self.system.shows_signs;
        if is_plain {
            self.measure(self.sample as f64 * self.system.timing.ts, y);
        }
        is_plain
    }

    /// Writes the outputs at the start of the step that was made last, with its signs.
    fn measure_before(&mut self, t: f64, y: &mut [V]) {
        let Some(mut signs) = self.signs.take() else { return };
        std::mem::swap(&mut self.x, &mut signs.start);
        self.measure(t, y);
        std::mem::swap(&mut self.x, &mut signs.start);
        self.signs = Some(signs);
    }

    /// A lane in which one state is not finite is NaN from then on.
    fn spoil(&mut self) {
        if self.x.iter().all(Value::all_finite) {
            return;
        }
        for lane in 0..V::LANES {
            if self.x.iter().any(|value| !is_finite(value.lane(lane))) {
                let nan = V::Lane::from_design(f64::NAN);
                self.x.iter_mut().for_each(|value| value.set_lane(lane, nan));
            }
        }
    }
}

pub(super) fn is_finite<T: Scalar>(value: T) -> bool {
    value.is_finite()
}

/// `from` may be shorter than `to`, which is then zero at the end: no forces are zero forces.
fn load<V: Value>(to: &mut [V], from: &[f64]) {
    to.fill(V::constant(0.0));
    to.iter_mut().zip(from).for_each(|(to, from)| *to = V::constant(*from));
}
