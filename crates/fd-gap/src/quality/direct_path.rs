//! Does an output show an input at the sample at which that is given?

use fd_sim::simulate::Simulator;

use crate::fit::Log;

/// Part of the size of an input by which it is moved.
const NUDGE: f64 = 1e-3;

/// Whether each output shows an input at the sample at which that is given.
pub(crate) fn passes_at_once(simulator: &dyn Simulator, log: &Log) -> Vec<bool> {
    let mut simulator = simulator.boxed();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let f = vec![0.0; simulator.ports().len()];
    let mut shown = |u: &[f64]| -> Vec<f64> {
        let mut y = vec![0.0; log.ny];
        simulator.start(&theta, &x0, 0);
        simulator.step(u, u, &f, &mut y);
        y
    };
    let u = log.input(0).to_vec();
    let before = shown(&u);
    let mut at_once = vec![false; log.ny];
    for i in 0..log.nu {
        let largest = (0..log.samples()).map(|k| log.input(k)[i].abs()).fold(0.0, f64::max);
        let mut moved = u.clone();
        moved[i] += NUDGE * largest.max(f64::MIN_POSITIVE);
        for (at_once, (a, b)) in at_once.iter_mut().zip(shown(&moved).iter().zip(&before)) {
            *at_once |= a.to_bits() != b.to_bits();
        }
    }
    at_once
}
