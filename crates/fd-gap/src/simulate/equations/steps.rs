//! What happens in one integration step.

use fd_core::Scalar;

use super::{EquationSimulator, System};
use crate::{
    equation::Workspace,
    model::Hold,
    simulate::{delay_line::DelayLine, flat::FIRST_STATE},
};

impl<T: Scalar> EquationSimulator<T> {
    /// Writes the outputs.
    pub(super) fn measure_at(&mut self, t: f64, y: &mut [T]) {
        if self.x.iter().any(|value| !value.is_finite()) {
            y.fill(T::from_design(f64::NAN));
            return;
        }
        fill(&mut self.outputs, [T::from_design(t), self.first], &self.x, &self.u, &self.held);
        self.system.outputs.run(&mut self.outputs, y);
    }

    /// Stores what is to be delayed, and sets the delayed values.
    pub(super) fn delay(&mut self, t: f64, substep: usize, store: impl Fn(&mut DelayLine<T>, T)) {
        let system = &*self.system;
        let first_delay = self.held.len() - self.lines.len();
        for (i, (program, workspace)) in system.delays.iter().zip(&mut self.delays).enumerate() {
            let now = [T::from_design(t), self.first];
            fill(workspace, now, &self.x, &self.u, &self.held);
            interpolate(system, workspace, &self.u, &self.u_next, substep as f64);
            let mut value = [T::zero()];
            program.run(workspace, &mut value);
            store(&mut self.lines[i], value[0]);
            self.held[first_delay + i] = self.lines[i].value();
        }
    }

    /// The sampled controller measures, sets its signals and moves its states. In a run that
    /// starts between two of its actions, it holds the signals that its states give.
    pub(super) fn act(&mut self, t: f64, substep: usize, moves: bool) {
        let system = &*self.system;
        let (Some(control), Some(workspace)) = (&system.control, &mut self.control) else { return };
        fill(workspace, [T::from_design(t), self.first], &self.x, &self.u, &self.held);
        interpolate(system, workspace, &self.u, &self.u_next, substep as f64);
        let results = &mut self.updated[..control.program.results()];
        control.program.run(workspace, results);
        let (signals, states) = results.split_at(control.signals);
        self.held[..signals.len()].copy_from_slice(signals);
        if moves {
            for (index, value) in control.updates.iter().zip(states) {
                self.x[*index] = *value;
            }
        }
    }

    /// Moves all states on by one integration step; update laws use the values at its start.
    pub(super) fn integrate(&mut self, t: f64, substep: usize) {
        let at = substep as f64;
        if !self.system.updated.is_empty() {
            let system = &*self.system;
            fill(&mut self.updates, [T::from_design(t), self.first], &self.x, &self.u, &self.held);
            interpolate(system, &mut self.updates, &self.u, &self.u_next, at);
            system.updates.run(&mut self.updates, &mut self.updated[..system.updated.len()]);
        }
        if self.system.is_continuous {
            self.runge_kutta(t, at);
        }
        for (index, value) in self.system.updated.iter().zip(&self.updated) {
            self.x[*index] = *value;
        }
    }

    /// One step of Runge-Kutta of order 4.
    fn runge_kutta(&mut self, t: f64, at: f64) {
        let system = &*self.system;
        let h = system.timing.h();
        fill(&mut self.rates, [T::from_design(t), self.first], &self.x, &self.u, &self.held);
        for (stage, fraction) in [0.0, 0.5, 0.5, 1.0].into_iter().enumerate() {
            interpolate(system, &mut self.rates, &self.u, &self.u_next, at + fraction);
            if stage != 0 {
                let length = T::from_design(fraction * h);
                let fast = self.rates.fast_mut();
                fast[0] = T::from_design(t + fraction * h);
                for ((to, x), slope) in
                    fast[FIRST_STATE..].iter_mut().zip(&self.x).zip(&self.k[stage - 1])
                {
                    *to = *x + length * *slope;
                }
            }
            system.rates.run(&mut self.rates, &mut self.k[stage]);
        }
        let (sixth, two) = (T::from_design(h / 6.0), T::from_design(2.0));
        let [k1, k2, k3, k4] = &self.k;
        for (i, x) in self.x.iter_mut().enumerate() {
            *x += sixth * (k1[i] + two * (k2[i] + k3[i]) + k4[i]);
        }
    }
}

/// Sets all fast inputs; `now` is the time and whether it is the first step.
fn fill<T: Scalar>(
    workspace: &mut Workspace<T>,
    now: [T; FIRST_STATE],
    x: &[T],
    u: &[T],
    held: &[T],
) {
    let (to_now, rest) = workspace.fast_mut().split_at_mut(FIRST_STATE);
    let (to_x, rest) = rest.split_at_mut(x.len());
    let (to_u, to_held) = rest.split_at_mut(u.len());
    to_now.copy_from_slice(&now);
    to_x.copy_from_slice(x);
    to_u.copy_from_slice(u);
    to_held.copy_from_slice(held);
}

/// Moves the inputs on to `at` integration steps after the sample, if they are interpolated.
fn interpolate<T: Scalar>(
    system: &System,
    workspace: &mut Workspace<T>,
    u: &[T],
    u_next: &[T],
    at: f64,
) {
    if system.hold == Hold::Zero {
        return;
    }
    let fraction = T::from_design(at / system.timing.substeps as f64);
    let fast = &mut workspace.fast_mut()[FIRST_STATE + system.nx..];
    for ((to, u), next) in fast.iter_mut().zip(u).zip(u_next) {
        *to = *u + (*next - *u) * fraction;
    }
}
