//! Integration steps in which a delayed value jumps.
//!
//! What is delayed and held for steps, as an input is, jumps where its delay ends within a step. Runge-Kutta then runs
//! once for the piece of the step before the jump and once for that after it; the pieces have other lengths in each
//! lane. So a delay by a fraction of a step switches exactly, and costs a second run only in steps with a jump.

use fd_core::Scalar;

use super::{engine::Engine, steps::RungeKutta};
use crate::equation::Value;

impl<V: Value> Engine<V> {
    /// Integrates over one step, piece by piece.
    pub(super) fn run_pieces(&mut self, t: f64, at: f64) {
        let [zero, one] = [0.0, 1.0].map(V::constant);
        let first_delay = self.held.len() - self.lines.len();
        if self.lines.is_empty() {
            return V::vectorized(RungeKutta { engine: self, t, at, piece: None });
        }
        self.start.copy_from_slice(&self.x);
        let mut end = self.next_jump(zero);
        if end.is_none() {
            V::vectorized(RungeKutta { engine: self, t, at, piece: None });
            return self.first_slopes.copy_from_slice(&self.k[0]);
        }
        let (mut from, mut is_first) = (zero, true);
        loop {
            let to = end.unwrap_or(one);
            for i in (0..self.lines.len()).filter(|i| !self.system.moving[*i]) {
                let [older, newer, jump] = self.lines[i].jump();
                let is_before = from.zip(jump, |from, jump| from - jump);
                self.held[first_delay + i] =
                    is_before.zip3(older, newer, |before, older, newer| {
                        if before.to_report() < 0.0 { older } else { newer }
                    });
            }
            let share = to.zip(from, |to, from| to - from);
            V::vectorized(RungeKutta { engine: self, t, at, piece: Some([from, share]) });
            if is_first {
                self.first_slopes.copy_from_slice(&self.k[0]);
            }
            is_first = false;
            if end.is_none() {
                break;
            }
            (from, end) = (to, self.next_jump(to));
        }
        for i in (0..self.lines.len()).filter(|i| !self.system.moving[*i]) {
            self.held[first_delay + i] = self.lines[i].value();
        }
    }

    /// The first jump after this place in the step, in each lane; the end of the step in a lane without one. `None` where
    /// no lane has one.
    fn next_jump(&self, from: V) -> Option<V> {
        let one = V::constant(1.0);
        let held = self.lines.iter().zip(&self.system.moving).filter(|(_, moves)| !**moves);
        let next = held.fold(one, |next, (line, _)| {
            let [.., jump] = line.jump();
            next.zip3(jump, from, |next, jump, from| {
                let is_sooner = (jump - from).to_report() > 0.0 && (next - jump).to_report() > 0.0;
                if is_sooner { jump } else { next }
            })
        });
        (0..V::LANES).any(|lane| next.lane(lane) != one.lane(lane)).then_some(next)
    }
}
