//! One integration step.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use fd_core::Scalar;

use super::{
    engine::{Engine, is_finite},
    system::System,
};
use crate::{
    equation::{Kernel, Value, Work, Workspace},
    model::Hold,
    simulate::{
        delay_line::{Course, DelayLine, along},
        flat::FIRST_STATE,
    },
};

impl<V: Value> Engine<V> {
    /// Writes the outputs.
    pub(super) fn measure(&mut self, t: f64, y: &mut [V]) {
        V::vectorized(Measurement { engine: self, t, y });
    }

    /// Stores what is to be delayed, and sets the delayed values.
    pub(super) fn delay(&mut self, t: f64, substep: usize, store: impl Fn(&mut DelayLine<V>, V)) {
        let system = &*self.system;
        let first_delay = self.held.len() - self.lines.len();
        for (i, (program, workspace)) in system.delays.iter().zip(&mut self.delays).enumerate() {
            let now = (t, self.is_first);
            fill(workspace, now, &self.x, &self.u, &self.held);
            interpolate(system, workspace, &self.u, &self.u_next, substep as f64);
            let mut value = [V::constant(0.0)];
            program.run(workspace, &mut value);
            let line = &mut self.lines[i];
            store(line, value[0]);
            self.held[first_delay + i] = line.value();
            if system.moving[i] {
                self.courses[i] = line.course();
            }
        }
    }

    /// The sampled controller measures, sets its signals and moves its states. In a run that
    /// starts between two of its actions, it holds the signals that its states give.
    pub(super) fn act(&mut self, t: f64, substep: usize, moves: bool) {
        let system = &*self.system;
        let (Some(control), Some(workspace)) = (&system.control, &mut self.control) else { return };
        fill(workspace, (t, self.is_first), &self.x, &self.u, &self.held);
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

    /// Moves all states on by one integration step with signs that are held; update laws use the values at its start.
    pub(super) fn run_step(&mut self, t: f64, substep: usize) {
        let at = substep as f64;
        if !self.system.updated.is_empty() {
            let system = &*self.system;
            fill(&mut self.updates, (t, self.is_first), &self.x, &self.u, &self.held);
            interpolate(system, &mut self.updates, &self.u, &self.u_next, at);
            system.updates.run(&mut self.updates, &mut self.updated[..system.updated.len()]);
        }
        if self.system.is_continuous {
            self.run_pieces(t, at);
            self.finish(t, at);
        }
        for (index, value) in self.system.updated.iter().zip(&self.updated) {
            self.x[*index] = *value;
        }
    }

    /// The velocities of the signs, `at` integration steps after the sample.
    pub(super) fn velocities(
        &self,
        (t, at): (f64, f64),
        workspace: &mut Workspace<V>,
        to: &mut [V],
    ) {
        if let Some(states) = &self.system.rubbing {
            to.iter_mut().zip(states).for_each(|(to, state)| *to = self.x[*state]);
            return;
        }
        fill(workspace, (t, self.is_first), &self.x, &self.u, &self.held);
        interpolate(&self.system, workspace, &self.u, &self.u_next, at);
        self.system.velocities.run(workspace, to);
    }

    /// The rates of the states, `at` integration steps after the sample, as one of the four slopes.
    pub(super) fn rates_at(&mut self, (t, at): (f64, f64), slope: usize) {
        fill(&mut self.rates, (t, self.is_first), &self.x, &self.u, &self.held);
        interpolate(&self.system, &mut self.rates, &self.u, &self.u_next, at);
        self.system.rates.run(&mut self.rates, &mut self.k[slope]);
    }

    /// Moves time, inputs and delayed values on, in each lane, to a place in the step from `t` on.
    fn move_to(&mut self, reached: V, t: f64, at: f64) {
        let system = &*self.system;
        let of = V::Lane::from_design;
        let h = of(system.timing.h());
        let fast = self.rates.fast_mut();
        fast[0] = reached.map(|reached| of(t) + h * reached);
        let first = fast.len() - self.courses.len();
        for ((to, course), moves) in fast[first..].iter_mut().zip(&self.courses).zip(&system.moving)
        {
            if *moves {
                *to = along(course, reached);
            }
        }
        if system.hold != Hold::Zero {
            let substeps = of(system.timing.substeps as f64);
            let fast = &mut fast[FIRST_STATE + system.nx..];
            for ((to, u), next) in fast.iter_mut().zip(&self.u).zip(&self.u_next) {
                *to = u.zip3(*next, reached, |u, next, reached| {
                    u + (next - u) * ((of(at) + reached) / substeps)
                });
            }
        }
    }

    /// Stores where the delayed expressions that move within a step went in this one.
    fn finish(&mut self, t: f64, at: f64) {
        let system = &*self.system;
        if !system.moving.contains(&true) {
            return;
        }
        let h = system.timing.h();
        // By the parabola with the slopes at both ends: h/8 (k₁ - k₄) from the chord.
        let [half, eighth] = [0.5, 0.125 * h].map(V::Lane::from_design);
        for (i, middle) in self.middle.iter_mut().enumerate() {
            let bend =
                self.first_slopes[i].zip(self.k[3][i], |first, last| eighth * (first - last));
            *middle = self.x[i].zip3(self.start[i], bend, |end, start, b| half * (start + end) + b);
        }
        for i in (0..self.lines.len()).filter(|i| system.moving[*i]) {
            let workspace = &mut self.delays[i];
            let mut of = |place: usize, x: &[V]| {
                let fraction = 0.5 * place as f64;
                fill(workspace, (t + fraction * h, self.is_first), x, &self.u, &self.held);
                move_delayed(system, workspace, &self.courses, place);
                interpolate(system, workspace, &self.u, &self.u_next, at + fraction);
                let mut value = [V::constant(0.0)];
                system.delays[i].run(workspace, &mut value);
                value[0]
            };
            let (middle, end) = (of(1, &self.middle), of(2, &self.x));
            self.lines[i].finish(middle, end);
        }
    }

    /// One step of Runge-Kutta of order 4. Loops are written out: an iterator that is not inlined is
    /// compiled for the smallest machine.
    #[inline(always)]
    fn runge_kutta(&mut self, kernel: impl Kernel<V>, t: f64, at: f64, piece: Option<[V; 2]>) {
        let (h, nx) = (self.system.timing.h(), self.system.nx);
        let part_of = |length: f64| match piece {
            None => V::constant(length),
            Some([_, share]) => share.map(|share| share * V::Lane::from_design(length)),
        };
        fill(&mut self.rates, (t, self.is_first), &self.x, &self.u, &self.held);
        for (stage, place) in [0, 1, 1, 2].into_iter().enumerate() {
            let fraction = 0.5 * place as f64;
            match piece {
                None => {
                    let system = &*self.system;
                    move_delayed(system, &mut self.rates, &self.courses, place);
                    interpolate(system, &mut self.rates, &self.u, &self.u_next, at + fraction);
                    self.rates.fast_mut()[0] = V::constant(t + fraction * h);
                }
                Some([from, share]) => {
                    let part = V::Lane::from_design(fraction);
                    let reached = from.zip(share, |from, share| from + part * share);
                    self.move_to(reached, t, at);
                }
            }
            if stage != 0 {
                let length = part_of(fraction * h);
                let fast = self.rates.fast_mut();
                let (to, slope) = (&mut fast[FIRST_STATE..], &self.k[stage - 1]);
                for i in 0..nx {
                    kernel.mul_add(&mut to[i], &length, &slope[i], &self.x[i]);
                }
            }
            self.system.rates.run_with(kernel, &mut self.rates, &mut self.k[stage]);
        }
        let (sixth, two) = (part_of(h / 6.0), V::constant(2.0));
        let [k1, k2, k3, k4] = &self.k;
        for i in 0..nx {
            let (before, mut sum, mut more) = (self.x[i], k1[i], k1[i]);
            kernel.add(&mut more, &k2[i], &k3[i]);
            kernel.mul_add(&mut sum, &two, &more, &k1[i]);
            kernel.add(&mut more, &sum, &k4[i]);
            kernel.mul_add(&mut self.x[i], &sixth, &more, &before);
        }
    }
}

/// A step of Runge-Kutta from a time on, `at` integration steps after the sample.
pub(super) struct RungeKutta<'a, V> {
    pub engine: &'a mut Engine<V>,
    pub t: f64,
    pub at: f64,
    /// Where a part of a step begins, and how long it is, in steps; nothing for all of it.
    pub piece: Option<[V; 2]>,
}

impl<V: Value> Work<V> for RungeKutta<'_, V> {
    #[inline(always)]
    fn run(self, kernel: impl Kernel<V>) {
        self.engine.runge_kutta(kernel, self.t, self.at, self.piece);
    }
}

/// The outputs at a time.
struct Measurement<'a, V> {
    engine: &'a mut Engine<V>,
    t: f64,
    y: &'a mut [V],
}

impl<V: Value> Work<V> for Measurement<'_, V> {
    #[inline(always)]
    fn run(self, kernel: impl Kernel<V>) {
        let Self { engine, t, y } = self;
        fill(&mut engine.outputs, (t, engine.is_first), &engine.x, &engine.u, &engine.held);
        engine.system.outputs.run_with(kernel, &mut engine.outputs, y);
        for x in engine.x.iter().filter(|x| !x.all_finite()) {
            for y in &mut *y {
                *y =
                    y.zip(*x, |y, x| if is_finite(x) { y } else { V::Lane::from_design(f64::NAN) });
            }
        }
    }
}

/// Sets all fast inputs; `now` is the time and whether it is the first step.
#[inline(always)]
fn fill<V: Value>(
    workspace: &mut Workspace<V>,
    (t, is_first): (f64, bool),
    x: &[V],
    u: &[V],
    held: &[V],
) {
    let (to_now, rest) = workspace.fast_mut().split_at_mut(FIRST_STATE);
    let (to_x, rest) = rest.split_at_mut(x.len());
    let (to_u, to_held) = rest.split_at_mut(u.len());
    to_now[0] = V::constant(t);
    to_now[1] = V::constant(f64::from(u8::from(is_first)));
    to_x.copy_from_slice(x);
    to_u.copy_from_slice(u);
    to_held.copy_from_slice(held);
}

/// Moves the delayed values on to the start, the middle or the end of a step: to a `place` in their courses.
#[inline(always)]
fn move_delayed<V: Value>(
    system: &System,
    workspace: &mut Workspace<V>,
    courses: &[Course<V>],
    place: usize,
) {
    let fast = workspace.fast_mut();
    let first = fast.len() - courses.len();
    for ((to, course), moves) in fast[first..].iter_mut().zip(courses).zip(&system.moving) {
        if *moves {
            *to = course[place];
        }
    }
}

/// Moves the inputs on to `at` integration steps after the sample, if they are interpolated.
#[inline(always)]
fn interpolate<V: Value>(
    system: &System,
    workspace: &mut Workspace<V>,
    u: &[V],
    u_next: &[V],
    at: f64,
) {
    if system.hold == Hold::Zero {
        return;
    }
    let fraction = V::Lane::from_design(at / system.timing.substeps as f64);
    let fast = &mut workspace.fast_mut()[FIRST_STATE + system.nx..];
    for ((to, u), next) in fast.iter_mut().zip(u).zip(u_next) {
        *to = u.zip(*next, |u, next| u + (next - u) * fraction);
    }
}
