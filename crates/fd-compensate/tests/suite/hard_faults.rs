//! The test for hard faults in training: laws of its limit, its warm-up and its recovery, where the bias is known.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use fd_compensate::residual_compensation::{
    CompensationPlan, FixedParameters, HardFault, ResidualCompensator,
};
use fd_core::{
    EventKind, Frame, IoDims, StateVisitor,
    stage::{BiasModel, Compensator, Stage},
};
use proptest::prelude::*;

use EventKind::{HardFaultWhileTraining, TrainingStarted};

/// There is no bias: every innovation is the residual itself.
#[derive(Clone, Debug)]
struct NoBias;

impl Stage for NoBias {
    fn reset(&mut self) {}
    fn visit_state(&mut self, _: &mut dyn StateVisitor<f64>) {}
}

impl BiasModel for NoBias {
    fn nu(&self) -> usize {
        1
    }
    fn residual_len(&self) -> usize {
        2
    }
    fn theta_len(&self) -> usize {
        1
    }
    fn load(&mut self, _: &[f64]) {}
    fn observe(&mut self, _: &[f64], _: &[f64]) {}
    fn simulate(&mut self, _: &[f64], mu_hat: &mut [f64]) {
        mu_hat.fill(0.0);
    }
    fn predict(&mut self, u: &[f64], _: &[f64], mu_hat: &mut [f64]) {
        self.simulate(u, mu_hat);
    }
}

/// What a training that never ends tells of samples `(u, r)`, after its start.
fn told(
    hard_fault: HardFault,
    samples: impl IntoIterator<Item = (f64, [f64; 2])>,
) -> Vec<(u64, EventKind)> {
    let mut plan = CompensationPlan { hard_fault, ..CompensationPlan::default() };
    plan.convergence.least_samples = u64::MAX;
    let identifier = FixedParameters::new(1, 2, &[0.0]);
    let mut compensator = ResidualCompensator::new(identifier, NoBias, &plan).unwrap();
    let mut told = Vec::new();
    for (k, (u, r)) in (0..).zip(samples) {
        let (u, mut star) = ([u], [0.0; 2]);
        let frame = Frame::new(IoDims { nu: 1, ny: 0 }, k, &u, &[]).unwrap();
        let outcome = compensator.step(frame, &r, &mut star);
        told.extend(outcome.events.iter().map(|kind| (k, kind)));
    }
    assert_eq!(told.remove(0), (0, TrainingStarted));
    told
}

/// Samples of two channels with these amplitudes and changing signs, so that the scales are the amplitudes.
fn healthy(amplitudes: [f64; 2], samples: usize) -> Vec<(f64, [f64; 2])> {
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    (0..samples).map(|k| (0.0, amplitudes.map(|a| a * sign(k)))).collect()
}

/// Multiples of a sixteenth, exact in binary.
fn sixteenths(range: std::ops::Range<i32>) -> impl Strategy<Value = f64> {
    range.prop_map(|n| f64::from(n) / 16.0)
}

proptest! {
    /// A jump is what exceeds `factor` times the scale of its own channel and `least_jump` times the largest
    /// residual of all. A sample where the model has no answer changes neither.
    #[test]
    fn the_limit_is_the_larger_of_two(
        amplitudes in prop::array::uniform2(sixteenths(1..160)),
        channel in 0..2_usize,
        lost in prop::option::of(1..20_usize),
        factor in 1..12_i32,
        least_jump in sixteenths(0..80),
        over in prop::sample::select(vec![-0.0625, 0.0, 0.0625]),
    ) {
        let factor = f64::from(factor);
        let plan = HardFault { factor, least_jump, warm_up: 10, ..HardFault::default() };
        let limit = (factor * amplitudes[channel]).max(least_jump * amplitudes[0].max(amplitudes[1]));
        let mut samples = healthy(amplitudes, 20);
        if let Some(k) = lost {
            samples[k].1 = [f64::NAN; 2];
        }
        samples.push((0.0, amplitudes));
        samples[20].1[channel] = -(limit + over);
        let expected = if over > 0.0 { vec![(20, HardFaultWhileTraining)] } else { Vec::new() };
        prop_assert_eq!(told(plan, samples), expected);
    }

    /// Nothing is a jump until `warm_up` samples have followed the last input of a new kind.
    #[test]
    fn a_jump_needs_a_scale(warm_up in 1..20_u64, new_at in 1..10_usize, at in 10..40_usize) {
        let plan = HardFault { warm_up, ..HardFault::default() };
        let mut samples = healthy([1.0, 1.0], 40);
        samples[new_at..].iter_mut().for_each(|sample| sample.0 = 5.0);
        samples[at].1[0] = 1e3;
        let is_jump = warm_up <= (at - new_at) as u64;
        let first = told(plan, samples).first().copied();
        prop_assert_eq!(first, is_jump.then_some((at as u64, HardFaultWhileTraining)));
    }

    /// However loud a sample below the limit is, it moves the scale as three times the scale would.
    #[test]
    fn the_scale_is_deaf_to_what_is_loud(loud in 3.0..10.0_f64, over in any::<bool>()) {
        let plan = HardFault { memory: 4.0, warm_up: 10, ..HardFault::default() };
        let mut samples = healthy([1.0, 1.0], 20);
        // From 1 to 1 + (3 − 1)/4.
        samples.push((0.0, [loud, 1.0]));
        samples.push((0.0, [if over { 15.1 } else { 14.9 }, 1.0]));
        let expected = if over { vec![(21, HardFaultWhileTraining)] } else { Vec::new() };
        prop_assert_eq!(told(plan, samples), expected);
    }

    /// Training begins anew when every channel that jumped has been back below half its jump for `resume_after`
    /// samples in a row; what the others do does not matter.
    #[test]
    fn recovered_is_below_half_the_jump(
        jumped in prop::sample::select(vec![[true, false], [false, true], [true, true]]),
        jumps in prop::array::uniform2((2..64_i32).prop_map(|n| 16.0 * f64::from(n))),
        shares in prop::collection::vec(prop::array::uniform2(sixteenths(-12..13)), 1..20),
        resume_after in 1..5_u64,
    ) {
        let plan = HardFault { warm_up: 30, resume_after, ..HardFault::default() };
        let mut samples = healthy([1.0, 1.0], 40);
        samples.push((0.0, std::array::from_fn(|c| if jumped[c] { jumps[c] } else { 1.0 })));
        samples.extend(shares.iter().map(|s| (0.0, std::array::from_fn(|c| s[c] * jumps[c]))));
        samples.push((0.0, [0.0; 2]));
        let mut quiet = 0;
        let recovered = shares.iter().position(|shares| {
            let back = (0..2).all(|c| !jumped[c] || shares[c].abs() <= 0.5);
            quiet = if back { quiet + 1 } else { 0 };
            quiet == resume_after
        });
        let mut expected = vec![(40, HardFaultWhileTraining)];
        expected.extend(recovered.map(|k| (k as u64 + 42, TrainingStarted)));
        prop_assert_eq!(told(plan, samples), expected);
    }
}
