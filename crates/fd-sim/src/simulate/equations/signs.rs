//! Set-valued signs: what dry friction holds, and how it lets go.
//!
//! A sign `s ∈ Sgn(v)` is 1 or -1 where its velocity is positive or negative, and at rest whatever keeps the velocity at
//! zero, within [-1, 1]. It is found implicitly, as by Moreau and Jean: an integration step is run with signs that are
//! held, and these are then changed such that the velocities at its end are right. Those at the end depend on the signs
//! through the mass matrix of the places that rub, `W = ∂v/∂s`. Where a velocity passes zero in the step, the sign is the
//! mean over what comes before the stop and what comes after it,
//!
//! `s = ±1 + (1 - τ) (clamp(±1 + (v₀ - v₁)/W, -1, 1) ∓ 1)`, with the stop at `τ = v₀/(v₀ - v₁)` of the step,
//!
//! where `v₁` is the velocity at the end with the sign of `v₀`. It is exact for a constant acceleration, continuous in
//! all parameters, and zero velocity at the end where the place sticks. Several places are solved by projected
//! Gauss-Seidel sweeps (Jean 1999, "The non-smooth contact dynamics method").
//!
//! `W` is measured once in a run, by steps with one sign changed, and then follows what changed signs do by Broyden's
//! rank-one changes (1965), which for one place are the secant: a change costs one step run again.
//!
//! The mean force gives the right velocity, but not the way: the velocity goes straight from `v₀` to the end instead of
//! by way of zero. What is missing, `δ = -h ((1 - τ) v₀ + τ v_end)/2`, moves the states as that velocity would. A step in
//! which all places slide on costs nothing beside the look at the velocities; one in which a place stays at rest under a
//! constant load neither.

mod step;

use fd_core::Scalar;

use super::system::System;
use crate::equation::{Value, Workspace};

/// Newton steps for the signs of one integration step; the first is exact where the plant is linear. After the last, the
/// signs are within [-1, 1] and the states are those that they give.
const ROUNDS: usize = 8;
/// Sweeps over the places for one Newton step.
const SWEEPS: usize = 200;
/// Change of a sign that is rounding: an ulp of a velocity is so much of what the sign does to it in the shortest of steps.
const ROUNDING: f64 = 1e-11;

/// What a model with signs needs beside the rest of an engine.
#[derive(Clone, Debug)]
pub(super) struct Signs<V> {
    /// Places of the signs among the held values.
    first: usize,
    count: usize,
    /// Length of a step.
    h: f64,
    pub velocities: Workspace<V>,
    /// States at the start of the step.
    pub start: Vec<V>,
    /// Velocities at the start and at the end.
    before: Vec<V>,
    after: Vec<V>,
    /// Those at the end with other signs, or with those of the round before.
    other: Vec<V>,
    /// Slopes `∂v_i/∂s_j`, row by row, as they were found last; not a number before.
    pub slopes: Vec<V>,
    /// Signs of the round before, and those that are tried next.
    last: Vec<V>,
    next: Vec<V>,
    /// What is missing of the way of each place, as a change of the sign that would move it so far in a step, and what is
    /// tried next.
    missing: Vec<V>,
    next_missing: Vec<V>,
    /// Lanes of which the signs are not found yet.
    open: Vec<bool>,
    /// Open lanes of which the slopes are not known yet.
    unsure: Vec<bool>,
}

impl<V: Value> Signs<V> {
    pub(super) fn new(first: usize, system: &System) -> Self {
        let (count, states) = (system.velocities.results(), system.nx);
        let zeros = |n: usize| vec![V::constant(0.0); n];
        Self {
            first,
            count,
            h: system.timing.h(),
            velocities: system.velocities.workspace(),
            start: zeros(states),
            before: zeros(count),
            after: zeros(count),
            other: zeros(count),
            slopes: vec![V::constant(f64::NAN); count * count],
            last: zeros(count),
            next: zeros(count),
            missing: zeros(count),
            next_missing: zeros(count),
            open: vec![false; V::LANES],
            unsure: vec![false; V::LANES],
        }
    }

    /// Forgets the run before.
    pub(super) fn restart(&mut self) {
        self.slopes.fill(V::constant(f64::NAN));
    }
}

impl<V: Value> Signs<V> {
    /// Opens the lanes in which not all places slide on, or rest under the load before. What has diverged is not searched
    /// for.
    fn look(&mut self, held: &[V]) {
        self.open.fill(false);
        for (i, sign) in held.iter().enumerate() {
            let slope = &self.slopes[i * self.count + i];
            let values = [sign, &self.before[i], &self.after[i], slope];
            for (lane, open) in self.open.iter_mut().enumerate() {
                let [sign, before, after, slope] = values.map(|v| v.lane(lane).to_report());
                let slides_on = (1.0 <= sign.abs()) && (0.0 <= sign * after);
                let rests =
                    (sign.abs() < 1.0) && (before.abs().max(after.abs()) <= -ROUNDING * slope);
                *open |= !(slides_on | rests) & after.is_finite();
            }
        }
    }

    /// Slopes that agree with what the change of the signs of the round before has done.
    fn follow(&mut self, held: &[V]) {
        let zero = V::Lane::from_design(0.0);
        for lane in (0..V::LANES).filter(|lane| self.open[*lane]) {
            let by = |j: usize| held[j].lane(lane) - self.last[j].lane(lane);
            let square = (0..self.count).fold(zero, |sum, j| sum + by(j) * by(j));
            for i in 0..self.count {
                let row = &mut self.slopes[i * self.count..(i + 1) * self.count];
                let change = self.after[i].lane(lane) - self.other[i].lane(lane);
                let known = row.iter().enumerate();
                let rest = known.fold(change, |rest, (j, w)| rest - w.lane(lane) * by(j)) / square;
                // A place that pushed itself on would not be friction.
                let own = row[i].lane(lane) + rest * by(i);
                if (own < zero) == (row[i].lane(lane) < zero) {
                    for (j, slope) in row.iter_mut().enumerate() {
                        slope.set_lane(lane, slope.lane(lane) + rest * by(j));
                    }
                }
            }
        }
    }

    /// Finds the signs of a lane that follow from the step with signs `held`, for velocities that are linear in them;
    /// whether they are others.
    fn solve(&mut self, held: &[V], lane: usize) -> bool {
        let sweeps = if self.count == 1 { 1 } else { SWEEPS };
        for _ in 0..sweeps {
            let mut change = 0.0_f64;
            for i in 0..self.count {
                let (new, missing) = self.sign(i, held, lane);
                self.next_missing[i].set_lane(lane, missing);
                change = change.max((new - self.next[i].lane(lane)).to_report().abs());
                self.next[i].set_lane(lane, new);
            }
            if change <= 0.01 * ROUNDING {
                break;
            }
        }
        let pairs = self.next.iter().zip(held);
        let change = |(new, held): (&V, &V)| (new.lane(lane) - held.lane(lane)).to_report().abs();
        let is_other = pairs.map(change).fold(0.0, f64::max) > ROUNDING;
        if !is_other {
            // A lane that needs no other step is not to change because another one does.
            let put = |to: &mut [V], from: &[V]| {
                to.iter_mut().zip(from).for_each(|(to, from)| to.set_lane(lane, from.lane(lane)));
            };
            put(&mut self.next, held);
            put(&mut self.next_missing, &self.missing);
        }
        is_other
    }

    /// Whether the slopes of a lane were measured in this run.
    fn is_known(&self, lane: usize) -> bool {
        self.slopes.iter().all(|slope| !slope.lane(lane).to_report().is_nan())
    }

    /// The sign of one place, given those of the others, and what is missing of its way.
    fn sign(&self, i: usize, held: &[V], lane: usize) -> (V::Lane, V::Lane) {
        let slope = |j: usize| self.slopes[i * self.count + j].lane(lane);
        let moved = |j: usize| self.next[j].lane(lane) - held[j].lane(lane);
        let others = (0..self.count).filter(|j| *j != i);
        let by_others = others.fold(self.after[i].lane(lane), |end, j| end + slope(j) * moved(j));
        let (start, one) = (self.before[i].lane(lane), V::Lane::from_design(1.0));
        let way_on = direction(start);
        let end = by_others + slope(i) * (way_on - held[i].lane(lane));
        if (way_on * end).to_report() >= 0.0 {
            return (way_on, V::Lane::from_design(0.0));
        }
        let slower = start - end;
        let hold = slope(i);
        let after_stop = if hold.to_report() < 0.0 {
            way_on + slower / hold
        } else {
            // Nothing depends on it.
            return (way_on, V::Lane::from_design(0.0));
        };
        let after_stop = clamp(after_stop, -one, one);
        // The stop is at `start/slower` of the step.
        let rest = -end / slower;
        let new = way_on + rest * (after_stop - way_on);
        let after = by_others + slope(i) * (new - held[i].lane(lane));
        let half_step = V::Lane::from_design(-0.5 * self.h);
        let missing = half_step * (rest * start + start / slower * after);
        (new, if hold.to_report() < 0.0 { missing / hold } else { V::Lane::from_design(0.0) })
    }
}

fn direction<T: Scalar>(velocity: T) -> T {
    T::from_design(if velocity.to_report() < 0.0 { -1.0 } else { 1.0 })
}

fn clamp<T: Scalar>(x: T, low: T, high: T) -> T {
    if x.to_report() < low.to_report() {
        low
    } else if high.to_report() < x.to_report() {
        high
    } else {
        x
    }
}
