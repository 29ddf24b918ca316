//! What a simulation cannot know of rows that have no inputs, and where it begins anew behind them.
//!
//! In a hole the last input is held, which is a guess; that the next one came at once is another. Outputs of which the
//! two guesses differ by more than a part of the noise are no evidence of anything and are left out. A plant that does
//! not forget its guess before the middle of what follows begins anew behind the hole, with states that nobody knows.
//!
//! *When not to use:* where inputs are missing as a rule and not by exception. Such a log says little, and what is left
//! out may be most of it.

use std::ops::Range;

use fd_sim::simulate::Simulator;

use super::{log::Log, plan::shortest_window};
use crate::quality::{grid_step, robust_third_difference_floor};

/// Difference of the two guesses, in noise, from which an output is left out.
const UNKNOWN: f64 = 0.5;
/// Smallest noise that is reckoned with, in the range of the output: outputs without noise are no more exact than that.
const EXACT: f64 = 1e-4;

impl Log {
    /// Rows in which an input is missing: those between two that have it.
    pub(super) fn holes(u: &[f64], nu: usize) -> Vec<Range<usize>> {
        let is_whole = |row: &[f64]| row.iter().all(|value| value.is_finite());
        let mut holes: Vec<Range<usize>> = Vec::new();
        for (k, _) in u.chunks_exact(nu.max(1)).enumerate().filter(|(_, row)| !is_whole(row)) {
            match holes.last_mut().filter(|hole| hole.end == k) {
                Some(hole) => hole.end = k + 1,
                None => holes.push(k..k + 1),
            }
        }
        holes.retain(|hole| 0 < hole.start && hole.end < u.len() / nu.max(1));
        holes
    }

    /// The same log without the outputs that its holes leave unknown, as far as the nominal `simulator` can say. A
    /// simulator of which no state can be set sees the log as it is.
    pub(super) fn without_unknown_outputs(mut self, simulator: &dyn Simulator) -> Self {
        if self.holes.is_empty() || simulator.initial().is_empty() {
            return self;
        }
        let is_unknown = self.unknown(simulator);
        let least = shortest_window(simulator.initial().len());
        for i in 0..self.holes.len() {
            let hole = self.holes[i].clone();
            let next = self.holes.get(i + 1).map_or(self.samples, |next| next.start);
            let last = (hole.start..next).rev().find(|k| is_unknown[*k]);
            let Some(last) = last else { continue };
            let is_forgotten = 2 * (last + 1).saturating_sub(hole.end) <= next - hole.end;
            let to = if is_forgotten {
                hole.end.max(last + 1)
            } else if least <= next - hole.end {
                self.restarts.push(hole.end);
                hole.end
            } else {
                next
            };
            self.y[hole.start * self.ny..to * self.ny].fill(f64::NAN);
        }
        self
    }

    /// Samples at which the two guesses differ, each hole on its own.
    fn unknown(&self, simulator: &dyn Simulator) -> Vec<bool> {
        let noise: Vec<f64> = (0..self.ny)
            .map(|c| {
                let values: Vec<f64> = self.y.iter().skip(c).step_by(self.ny).copied().collect();
                let finite = || values.iter().filter(|value| value.is_finite());
                let range = finite().fold(f64::NEG_INFINITY, |a, b| a.max(*b))
                    - finite().fold(f64::INFINITY, |a, b| a.min(*b));
                let floor = robust_third_difference_floor(&values).unwrap_or(0.0);
                let rounding = grid_step(&values).unwrap_or(0.0) / 12.0_f64.sqrt();
                floor.max(rounding).max(EXACT * range).max(f64::MIN_POSITIVE)
            })
            .collect();
        let mut at_once = self.u.clone();
        for hole in &self.holes {
            let next = self.input(hole.end).to_vec();
            hole.clone().for_each(|k| {
                at_once[k * self.nu..(k + 1) * self.nu].copy_from_slice(&next);
            });
        }
        let at_once = |k: usize| {
            let k = k.min(self.samples - 1);
            &at_once[k * self.nu..(k + 1) * self.nu]
        };
        let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        let (mut held, mut other) = (simulator.boxed(), None::<Box<dyn Simulator>>);
        let (mut y, mut y_other) = (vec![0.0; self.ny], vec![0.0; self.ny]);
        held.start(&theta, &x0, 0);
        let mut is_unknown = vec![false; self.samples];
        for (k, is_unknown) in is_unknown.iter_mut().enumerate() {
            if self.holes.iter().any(|hole| hole.start == k) {
                // A copy goes on from here with all that it remembers, or else from these states.
                let mut copy = held.boxed();
                if copy.state() != held.state() {
                    copy.start(&theta, held.state(), k as u64);
                }
                other = Some(copy);
            }
            held.step(self.input(k), self.input(k + 1), &[], &mut y);
            let Some(other) = &mut other else { continue };
            other.step(at_once(k), at_once(k + 1), &[], &mut y_other);
            // What is not finite is not known either.
            let is_known = |((a, b), s): ((&f64, &f64), &f64)| (a - b).abs() <= UNKNOWN * s;
            *is_unknown = !y.iter().zip(&y_other).zip(&noise).all(is_known);
        }
        is_unknown
    }
}
