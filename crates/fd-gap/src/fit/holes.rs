//! What a simulation cannot know of rows that have no inputs, and where it begins anew behind them.
//!
//! In a hole the last input is held, which is a guess; that it was as far above or below that as it ever moves in so long is
//! another. Outputs of which guesses differ by more than a part of the noise are no evidence of anything and are left out. A
//! plant that does not forget its guess before the middle of what follows begins anew behind the hole, with states that nobody
//! knows.
//!
//! *When not to use:* where inputs are missing as a rule and not by exception. Such a log says little, and what is left
//! out may be most of it.

use std::ops::Range;

use fd_sim::simulate::Simulator;

use super::{log::Log, plan::shortest_window};
use crate::quality::{grid_step, robust_third_difference_floor};

/// Difference of two guesses, in noise, from which an output is left out.
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

    /// Samples at which the guesses differ, each hole on its own.
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
        let guesses = self.guesses();
        let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        let (mut held, mut others) = (simulator.boxed(), Vec::<Box<dyn Simulator>>::new());
        let (mut y, mut y_other) = (vec![0.0; self.ny], vec![0.0; self.ny]);
        held.start(&theta, &x0, 0);
        let mut is_unknown = vec![false; self.samples];
        for (k, is_unknown) in is_unknown.iter_mut().enumerate() {
            if self.holes.iter().any(|hole| hole.start == k) {
                // Copies go on from here with all that it remembers, or else from these states.
                others = guesses.iter().map(|_| held.boxed()).collect();
                for copy in others.iter_mut().filter(|copy| copy.state() != held.state()) {
                    copy.start(&theta, held.state(), k as u64);
                }
            }
            held.step(self.input(k), self.input(k + 1), &[], &mut y);
            for (other, guess) in others.iter_mut().zip(&guesses) {
                other.step(guess.input(k), guess.input(k + 1), &[], &mut y_other);
                // What is not finite is not known either.
                let is_known = |((a, b), s): ((&f64, &f64), &f64)| (a - b).abs() <= UNKNOWN * s;
                *is_unknown |= !y.iter().zip(&y_other).zip(&noise).all(is_known);
            }
        }
        is_unknown
    }

    /// The same log with inputs that are in each hole above, or below, what is held by as much as they ever move in so long.
    fn guesses(&self) -> [Self; 2] {
        let mut guesses = [self.clone(), self.clone()];
        for hole in &self.holes {
            for c in 0..self.nu {
                let own = self.u.iter().skip(c).step_by(self.nu);
                let reach = largest_range(own.copied().collect(), hole.len() + 1);
                for (guess, reach) in guesses.iter_mut().zip([reach, -reach]) {
                    hole.clone().for_each(|k| guess.u[k * self.nu + c] += reach);
                }
            }
        }
        guesses
    }
}

/// Largest range of a signal within so many samples in a row.
fn largest_range(signal: Vec<f64>, samples: usize) -> f64 {
    let samples = samples.clamp(1, signal.len().max(1));
    let (mut high, mut low) = (signal.clone(), signal);
    // Of twice as many samples each time, and of as many as are left at last.
    let mut within = 1;
    while within < samples {
        let further = within.min(samples - within);
        let end = high.len() - further;
        for k in 0..end {
            (high[k], low[k]) = (high[k].max(high[k + further]), low[k].min(low[k + further]));
        }
        high.truncate(end);
        low.truncate(end);
        within += further;
    }
    high.iter().zip(&low).map(|(high, low)| high - low).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use fd_model::Record;
    use fd_sim::{model::Model, simulate::EquationSimulator};
    use proptest::prelude::*;

    use super::*;

    const ROOM: &str = r#"
version = 1
kind = "equations"
name = "room"
sample_time = 60.0
inputs = { heater = { unit = "kW" } }
outputs = { T = { unit = "degC", value = "x", noise = 0.1 } }
states = { x = { unit = "degC", initial = 20.0, derivative = "(5*heater - (x - 15))/7200" } }
"#;

    /// A thermostat is off before a hole of an hour and off behind it, and nobody knows how often it was on in between.
    #[test]
    fn what_switched_in_a_hole_is_unknown_behind_it() {
        let model: Model = ROOM.parse().unwrap();
        let simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let heater = |k: u32| if k == 239 { 0.0 } else { f64::from((k / 15) % 2) };
        let hole = 240..300;
        let rows = (0..600).map(|k| {
            let is_known = !hole.contains(&k);
            let y = 20.0 + f64::from(k % 7) / 70.0;
            ([if is_known { heater(k) } else { f64::NAN }], [if is_known { y } else { f64::NAN }])
        });
        let (inputs, outputs) = (model.external_inputs(), model.output_channels());
        let record = Record::from_rows(inputs, outputs, rows, model.sample_time().unwrap());
        assert_eq!((heater(239), heater(300)), (0.0, 0.0));
        let logs = Log::all(&[record.unwrap()], &simulator, &[]).unwrap();
        assert_eq!(logs[0].restarts, [300]);
    }

    proptest! {
        #[test]
        fn the_largest_range_is_that_of_some_window(
            signal in proptest::collection::vec(-9.0..9.0_f64, 1..60),
            samples in 1..70_usize,
        ) {
            let range = |part: &[f64]| {
                let high = part.iter().fold(f64::MIN, |a, b| a.max(*b));
                high - part.iter().fold(f64::MAX, |a, b| a.min(*b))
            };
            let windows = signal.windows(samples.min(signal.len()));
            let expected = windows.map(range).fold(0.0, f64::max);
            prop_assert_eq!(largest_range(signal.clone(), samples).to_bits(), expected.to_bits());
        }
    }
}
