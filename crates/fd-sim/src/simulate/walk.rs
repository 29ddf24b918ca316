//! A run through the inputs of a log, with a look at the states on the way.

use super::{
    run::{Outcome, Run, rows},
    simulator::Simulator,
};

/// Runs through inputs `u`, row by row from sample number `first` on, and writes the outputs to `y`, NaN from a
/// divergence on. Before each sample, `seen` gets its number in the run and the states there.
///
/// The number of samples is that of the outputs; an input after the last one is that row of `u`, or the last one held.
/// A simulator that makes whole runs only makes one, and its states are those that the run begins with; so does one without
/// states.
///
/// ```
/// use fd_sim::{
///     model::Model,
///     simulate::{EquationSimulator, Outcome, walk},
/// };
///
/// let tank: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 1.0
/// inputs = { u = { unit = "m/s" } }
/// outputs = { y = { unit = "m", value = "2*h" } }
/// states = { h = { unit = "m", initial = 0.0, derivative = "u" } }
/// "#.parse()?;
/// let mut simulator = EquationSimulator::<f64>::at(&tank, tank.sample_time()?)?;
/// let (mut y, mut levels) = ([0.0; 3], Vec::new());
/// let outcome = walk(&mut simulator, &[], &[0.0], 0, &[1.0; 3], &mut y, |_, x| levels.push(x[0]));
/// assert_eq!(outcome, Outcome::Complete);
/// assert_eq!((levels, y), (vec![0.0, 1.0, 2.0], [0.0, 2.0, 4.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
///
/// May panic when the numbers of values are wrong.
pub fn walk<S: Simulator + ?Sized>(
    simulator: &mut S,
    theta: &[f64],
    x0: &[f64],
    first: u64,
    u: &[f64],
    y: &mut [f64],
    mut seen: impl FnMut(usize, &[f64]),
) -> Outcome {
    let (nu, ny) = (simulator.inputs().len(), simulator.outputs().len());
    let samples = y.len() / ny.max(1);
    let mut run = Run::new(theta, x0, y);
    if !simulator.makes_steps() || x0.is_empty() {
        simulator.simulate_many(first, u, std::slice::from_mut(&mut run));
        let known = match run.outcome {
            Outcome::Complete => samples,
            Outcome::Diverged { sample } => sample + 1,
        };
        (0..known).for_each(|k| seen(k, x0));
        return run.outcome;
    }
    let inputs = rows(u, nu);
    simulator.start(theta, x0, first);
    run.make(ny, |k, y| {
        seen(k, simulator.state());
        let [now, next] = inputs(k);
        simulator.step(now, next, &[], y);
    });
    simulator.rest();
    run.outcome
}
