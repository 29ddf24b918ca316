//! An integration step with the signs that belong to it.

use fd_core::Scalar;

use super::{super::engine::Engine, ROUNDS, Signs, direction};
use crate::equation::Value;

impl<V: Value> Engine<V> {
    /// Moves all states on by one integration step, with the signs that belong to it.
    pub(in super::super) fn integrate(&mut self, t: f64, substep: usize) {
        // Taken out, so that the engine can run steps meanwhile.
        let Some(mut signs) = self.signs.take() else { return self.run_step(t, substep) };
        signs.start.copy_from_slice(&self.x);
        let now = (t, substep as f64);
        self.velocities(now, &mut signs.velocities, &mut signs.before);
        self.guess(&signs);
        signs.missing.fill(V::constant(0.0));
        self.run_step(t, substep);
        self.find(&mut signs, t, substep);
        self.signs = Some(signs);
    }

    /// A place that slid goes on as it moves, one that stuck is held as before.
    fn guess(&mut self, signs: &Signs<V>) {
        let held = &mut self.held[signs.first..][..signs.count];
        for (sign, velocity) in held.iter_mut().zip(&signs.before) {
            *sign = sign.zip(*velocity, |sign, velocity| {
                let slid = self.is_first || 1.0 <= sign.to_report().abs();
                if slid { direction(velocity) } else { sign }
            });
        }
    }

    /// Runs a step again until its signs are those of the velocities.
    fn find(&mut self, signs: &mut Signs<V>, t: f64, substep: usize) {
        let range = signs.first..signs.first + signs.count;
        let end = (t + self.system.timing.h(), substep as f64 + 1.0);
        for round in 0..ROUNDS {
            self.velocities(end, &mut signs.velocities, &mut signs.after);
            let held = &self.held[range.clone()];
            if round == 0 {
                signs.look(held);
            } else {
                signs.follow(held);
            }
            for lane in 0..V::LANES {
                signs.unsure[lane] = signs.open[lane] && !signs.is_known(lane);
            }
            if signs.unsure.contains(&true) {
                self.measure_slopes(signs, t, substep);
            }
            signs.next.copy_from_slice(&self.held[range.clone()]);
            signs.next_missing.copy_from_slice(&signs.missing);
            for lane in 0..V::LANES {
                signs.open[lane] = signs.open[lane] && signs.solve(&self.held[range.clone()], lane);
            }
            if !signs.open.contains(&true) {
                return;
            }
            signs.last.copy_from_slice(&self.held[range.clone()]);
            std::mem::swap(&mut signs.other, &mut signs.after);
            self.held[range.clone()].copy_from_slice(&signs.next);
            signs.missing.copy_from_slice(&signs.next_missing);
            self.run_again(signs, t, substep);
        }
    }

    /// Runs the step again, with what is missing of the ways: a sign pushes the states by so much a step and the velocity by
    /// its slope, and the rates say where the push that gives the missing velocity moves the states.
    fn run_again(&mut self, signs: &Signs<V>, t: f64, substep: usize) {
        self.x.copy_from_slice(&signs.start);
        self.run_step(t, substep);
        let h = self.system.timing.h();
        let end = (t + h, substep as f64 + 1.0);
        let is_zero = |way: &V| (0..V::LANES).all(|lane| way.lane(lane).to_report() == 0.0);
        for (i, missing) in signs.missing.iter().enumerate().filter(|(_, way)| !is_zero(way)) {
            self.rates_at(end, 0);
            let held = self.held[signs.first + i];
            self.held[signs.first + i] = held.map(|s| s + V::Lane::from_design(1.0));
            self.rates_at(end, 1);
            self.held[signs.first + i] = held;
            let [at_end, pushed, ..] = &self.k;
            for (i, x) in self.middle.iter_mut().enumerate() {
                let push = pushed[i].zip(at_end[i], |pushed, at_end| pushed - at_end);
                *x = self.x[i].zip3(*missing, push, |x, missing, push| x + missing * push);
            }
            std::mem::swap(&mut self.x, &mut self.middle);
            self.rates_at(end, 1);
            std::mem::swap(&mut self.x, &mut self.middle);
            let h = V::constant(h);
            let [at_end, moved, ..] = &self.k;
            for ((x, moved), at_end) in self.x.iter_mut().zip(moved).zip(at_end) {
                let rate = moved.zip(*at_end, |moved, at_end| moved - at_end);
                *x = x.zip3(rate, h, |x, rate, h| x + h * rate);
            }
        }
    }

    /// Slopes of the velocities at the end of the step, by a step for each sign with that sign changed: not beyond zero,
    /// where friction may depend on the direction.
    fn measure_slopes(&mut self, signs: &mut Signs<V>, t: f64, substep: usize) {
        let half = V::Lane::from_design(0.5);
        let end = (t + self.system.timing.h(), substep as f64 + 1.0);
        let count = signs.count;
        for j in 0..count {
            let held = self.held[signs.first + j];
            let changed = held.map(|s| {
                if s.to_report().abs() > 0.5 { half * s } else { s + half * direction(s) }
            });
            self.held[signs.first + j] = changed;
            self.run_again(signs, t, substep);
            self.velocities(end, &mut signs.velocities, &mut signs.other);
            self.held[signs.first + j] = held;
            for lane in (0..V::LANES).filter(|lane| signs.unsure[*lane]) {
                let step = changed.lane(lane) - held.lane(lane);
                for i in 0..count {
                    let change = signs.other[i].lane(lane) - signs.after[i].lane(lane);
                    signs.slopes[i * count + j].set_lane(lane, change / step);
                }
            }
        }
        self.run_again(signs, t, substep);
    }
}
