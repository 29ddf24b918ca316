//! Whether runs that should be the same are, and what is still where they are not.

use super::{super::spread::Spread, Bench, Grade, ROUNDING, TRIAL, apart};
use crate::simulate::Run;

/// Spread in parts of an output up to which a diagnosis is worth its runs.
const WORTH_IT: f64 = 0.1;
/// Two runs that differ by no more than this many times what equal runs do may be equal.
const EQUAL: f64 = 1.5;

impl Bench<'_> {
    /// Whether a run is no other than `base`: the same to the bit or, where equal runs differ, as far as they do.
    pub(super) fn is_still(&self, base: &[f64], y: &[f64]) -> bool {
        let Some(spread) = &self.spread else { return apart(base, y) == 0.0 };
        let Some(now) = Spread::among(&[base.to_vec(), y.to_vec()], spread.deviation.len()) else {
            return apart(base, y) == 0.0;
        };
        now.deviation.iter().zip(&spread.deviation).all(|(now, equal)| *now <= EQUAL * equal)
    }

    /// What is added where only large changes can be seen.
    pub(super) fn beyond(&self) -> &'static str {
        if self.spread.is_some() { " by more than equal runs differ" } else { "" }
    }

    /// How bad it is that nothing moves: where equal runs differ it may be just too little.
    pub(super) fn of_still(&self) -> Grade {
        if self.spread.is_some() { Grade::Doubt } else { Grade::Broken }
    }

    pub(super) fn repeats(&mut self, base: &[f64], again: &[f64]) {
        // Something else in between, so that what is left of it shows.
        let other: Vec<f64> = self.theta.iter().map(|p| p * (1.0 + TRIAL)).collect();
        let x0 = self.x0.clone();
        self.run(&other, &x0);
        let theta = self.theta.clone();
        let later = self.run(&theta, &x0);
        let [now, then] = [apart(base, again), apart(base, &later)];
        if now == 0.0 && then == 0.0 {
            let text = "the same run three times gives the same bits".to_owned();
            self.say("repeatability", Grade::Fine, text);
        } else if now == 0.0 {
            let text = format!("something is left of the run before: {then:.1e} of the outputs");
            self.say("repeatability", Grade::Broken, text);
        } else {
            let runs = [base, again, &later].map(<[f64]>::to_vec);
            self.spread = Spread::among(&runs, self.simulator.outputs().len());
            self.say_spread();
        }
        // Both at once.
        let mut both = [base.to_vec(), base.to_vec()];
        let [y, second] = &mut both;
        let mut runs = [Run::new(&theta, &x0, y), Run::new(&other, &x0, second)];
        self.simulator.simulate_many(0, &self.u, &mut runs);
        let side_by_side = apart(base, &both[0]);
        if !self.is_still(base, &both[0]) {
            let grade = if side_by_side <= ROUNDING { Grade::Doubt } else { Grade::Broken };
            let text = format!("a run by itself and beside another differ by {side_by_side:.1e}");
            self.say("several runs at once", grade, text);
        }
    }

    /// Says by how much equal runs differ: a doubt where a diagnosis can make it part of the noise.
    fn say_spread(&mut self) {
        let Some(spread) = &self.spread else {
            let text = "equal runs differ, and one of them is not finite".to_owned();
            self.say("repeatability", Grade::Broken, text);
            return;
        };
        let outputs = self.simulator.outputs().iter().zip(&spread.deviation);
        let each = outputs.filter(|(_, deviation)| 0.0 < **deviation);
        let each = each.map(|(output, deviation)| {
            let unit = if output.unit == "1" { String::new() } else { format!(" {}", output.unit) };
            format!("`{}` by {deviation:.2e}{unit}", output.name)
        });
        let each: Vec<String> = each.collect();
        let (differ, part) = (each.join(", "), 100.0 * spread.relative);
        let (grade, what) = if spread.relative <= WORTH_IT {
            (Grade::Doubt, "a diagnosis makes that part of the noise")
        } else {
            (Grade::Broken, "too much for a diagnosis")
        };
        let text = format!(
            "the simulator does not repeat itself: equal runs differ in {differ}, up to {part:.2} % of the output: \
             {what}"
        );
        self.say("repeatability", grade, text);
    }

    pub(super) fn is_the_same_by_steps(&mut self, base: &[f64], stepped: &[f64]) {
        let (grade, text) = match apart(base, stepped) {
            0.0 => (Grade::Fine, "whole runs, steps and measurements agree to the bit".to_owned()),
            d if d <= ROUNDING => {
                (Grade::Doubt, format!("whole runs and steps differ by rounding, {d:.1e}"))
            }
            d if d.is_nan() => {
                let text = "what is measured before a step is not what the step gives".to_owned();
                (Grade::Broken, text)
            }
            _ if self.is_still(base, stepped) => {
                (Grade::Fine, "whole runs and steps differ no more than equal runs do".to_owned())
            }
            d => (Grade::Broken, format!("whole runs and steps differ by {d:.1e} of the outputs")),
        };
        self.say("steps", grade, text);
    }
}
