//! What is known at a sample, and may be a cause of a residual there.

use crate::{
    fit::{Problem, Segment},
    quality::{Signal, passes_at_once},
};

/// Signals that residuals may depend on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known<'a> {
    /// Its logs have the inputs, cut as the errors are.
    pub problem: &'a Problem,
    /// How many of them, from the first, come from outside.
    pub inputs: usize,
    /// Simulated outputs of each log.
    pub outputs: &'a [Vec<f64>],
}

/// How fast a simulated output moves in each segment, in sigma per second: the difference of its neighbours.
pub(super) fn slopes(problem: &Problem, outputs: &[Vec<f64>], output: usize) -> Vec<Vec<f64>> {
    let plan = problem.plan();
    let (ts, sigma) = (problem.simulator().ts().seconds(), problem.weights().sigma[output]);
    let of = |segment: &Segment| -> Vec<f64> {
        let (log, width) = (&plan.logs[segment.log], plan.logs[segment.log].ny);
        let value = |k: usize| outputs[segment.log][k * width + output];
        let slope = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(log.samples() - 1));
            (value(after) - value(before)) / ((after - before).max(1) as f64 * ts * sigma)
        };
        (segment.from..segment.to).map(slope).collect()
    };
    plan.segments().iter().map(of).collect()
}

/// Inputs of the logs and outputs of the simulation, cut as the errors are.
///
/// A logged command may have been made from the measurement of its own sample, by a controller that nobody
/// knows: it is a cause of nothing before the next sample. Nor is an output that passes it on at once.
pub(super) fn signals(Known { problem, inputs, outputs }: Known<'_>) -> Vec<Signal> {
    let plan = problem.plan();
    let (Some(first), segments) = (plan.logs.first(), plan.segments()) else { return Vec::new() };
    let column = |rows: &[f64], width: usize, i: usize, from: usize, to: usize| -> Vec<f64> {
        (from..to).map(|k| rows[k * width + i]).collect()
    };
    let of_all = |rows: &dyn Fn(&Segment) -> Vec<f64>| segments.iter().map(rows).collect();
    // A controller on logged outputs is such a way at once, too.
    let is_logged_loop = inputs < first.nu;
    let at_once = passes_at_once(problem.simulator(), first);
    let inputs = (0..inputs.min(first.nu)).map(|i| {
        let values = of_all(&|s: &Segment| column(&plan.logs[s.log].u, first.nu, i, s.from, s.to));
        Signal { values, earliest: 1 }
    });
    let outputs = (0..first.ny).map(|i| {
        let values = of_all(&|s: &Segment| column(&outputs[s.log], first.ny, i, s.from, s.to));
        Signal { values, earliest: usize::from(is_logged_loop || at_once[i]) }
    });
    inputs.chain(outputs).collect()
}
