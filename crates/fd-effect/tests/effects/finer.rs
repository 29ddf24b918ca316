//! Runs of a law with finer integration steps.

use fd_effect::Candidate;
use fd_sim::simulate::{EquationSimulator, Simulator};

use crate::cases::Case;

/// A run of a candidate from one of its starts, with steps divided by a factor.
pub(crate) fn run(case: &Case, candidate: &Candidate, start: &[f64], factor: usize) -> Vec<f64> {
    let mut theta = case.model.nominal();
    theta.extend(start);
    let mut simulator = EquationSimulator::<f64>::new(&candidate.model).unwrap().refined(factor);
    let mut y = vec![0.0; case.samples * candidate.model.outputs.len()];
    Simulator::simulate(&mut simulator, &theta, &candidate.model.initial(), &case.u, &mut y);
    y
}

/// Root of the mean square of a difference, in standard deviations of the outputs: a sample at which something switches in
/// the one and not yet in the other is no error of a law.
pub(crate) fn error(case: &Case, a: &[f64], b: &[f64]) -> f64 {
    let ny = case.scales.outputs.len();
    let squares = a.iter().zip(b).enumerate();
    let squares = squares.map(|(i, (a, b))| ((a - b) / case.scales.outputs[i % ny].std).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}
