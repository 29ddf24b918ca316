//! Long runs of a register full of estimators, next to a QR reference in double precision.
#![allow(dead_code, reason = "the test and the example each use their own part")]
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use fd_core::{Scalar, stage::GuardReport};
use fd_ident::{
    batch::{BatchRls, BatchScalar, SampleBlock},
    rls::{Forgetting, Guard, QrRls, RlsDesign, RlsKernel, Static},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// `y = 1.2 y₁ − 0.4 y₂ + 0.5 u + 0.2 u₁ + 0.1 u₂`, plus noise uniform within ±0.01.
pub(crate) const TRUTH: [f64; 5] = [-1.2, 0.4, 0.5, 0.2, 0.1];
const N: usize = TRUTH.len();
const NOISE: f64 = 0.01;
/// Samples between two looks, more than a forgetting factor of 0.99 remembers: 0.99⁵⁰⁰⁰ = 1e-22.
pub(crate) const LOOK: usize = 5000;
const PRIOR: f64 = 1e4;
/// Where the input stops to excite.
const LAST_EXCITATION: usize = 2000;

/// What drives the plant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    /// White noise.
    White,
    /// A constant and two sinusoids: just enough for five parameters.
    Paper,
    /// The same, but constant after 2000 samples.
    Stops,
}

/// How the first estimator stands against the reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// Samples so far.
    pub(crate) samples: usize,
    /// Largest distance of the estimate from the reference.
    pub(crate) from_reference: f64,
    /// Largest distance of the estimates of all lanes from the truth.
    pub(crate) from_truth: f64,
    /// Largest distance of the reference from the truth.
    pub(crate) reference_from_truth: f64,
    /// Largest and smallest variance of a parameter in any lane.
    pub(crate) variance: [f64; 2],
    /// Condition of the weighted regressors of the reference, `‖R‖ ‖R⁻¹‖` in Frobenius norms.
    pub(crate) condition: f64,
}

/// `n ε κ ‖θ‖`: by how much rounding alone may move an estimate that is made of square roots of the
/// information; so does the reference in `f64`, with its ε.
pub(crate) fn rounding<T: Scalar>(look: &Look) -> f64 {
    let size = TRUTH.iter().map(|theta| theta * theta).sum::<f64>().sqrt();
    N as f64 * T::default_epsilon().to_report() * look.condition * size
}

/// A plant with a noise of its own.
struct Plant {
    rng: Xoshiro256PlusPlus,
    y: [f64; 2],
    u: [f64; 2],
}

impl Plant {
    fn sample<T: Scalar>(&mut self, input: Input, common: f64) -> ([T; N], T) {
        let mut uniform = || self.rng.random_range(-1.0..1.0);
        let u = if input == Input::White { uniform() } else { common };
        let phi = [-self.y[0], -self.y[1], u, self.u[0], self.u[1]];
        let exact: f64 = phi.iter().zip(TRUTH).map(|(phi, theta)| phi * theta).sum();
        let y = exact + NOISE * uniform();
        (self.y, self.u) = ([y, self.y[0]], [u, self.u[0]]);
        (phi.map(T::from_design), T::from_design(y))
    }
}

/// The estimator by QR that has seen what the first lane has.
struct Reference {
    rls: QrRls<f64, Static<N>>,
    theta: [f64; N],
    /// What the guard watches: forgetting factor and largest trace.
    guard: Option<[f64; 2]>,
}

impl Reference {
    fn new(input: Input, design: &RlsDesign) -> Self {
        let rls = QrRls::new(N, design).unwrap();
        let largest_trace = N as f64 * design.prior_variance * design.guard.trace_limit;
        let guard = match design.forgetting {
            Forgetting::Exponential { lambda } if input == Input::Stops => {
                Some([lambda, largest_trace])
            }
            // Nothing winds up.
            _ => None,
        };
        Self { rls, theta: [0.0; N], guard }
    }

    /// Under the same guard as the estimators: forgetting pauses above the largest trace.
    fn update<T: Scalar>(&mut self, phi: &[T; N], y: T) {
        if let Some([lambda, largest_trace]) = self.guard {
            let forgets = self.rls.trace() <= largest_trace * lambda;
            self.rls.set_memory(if forgets { lambda.sqrt() } else { 1.0 });
        }
        self.rls.update(&phi.map(Scalar::to_report), y.to_report(), &mut self.theta);
    }
}

/// Takes one register of estimators through so many samples and looks at it now and then. While
/// excitation lasts and forgetting is exponential, the reference is a QR factorisation of the last
/// [`LOOK`] samples; else something is never forgotten, and it has to see all of them.
pub(crate) fn run<T: BatchScalar>(
    input: Input,
    forgetting: Forgetting,
    samples: usize,
    mut look: impl FnMut(Look),
) -> GuardReport {
    let design = RlsDesign { prior_variance: PRIOR, forgetting, guard: Guard::default() };
    let forgets_all = input != Input::Stops && matches!(forgetting, Forgetting::Exponential { .. });
    let lanes = T::WIDTH;
    let mut batch = BatchRls::<T>::new(N, lanes, &design).unwrap();
    let mut block = SampleBlock::new(N, lanes, LOOK);
    let mut reference = Reference::new(input, &design);
    let plant = |lane| Plant {
        rng: Xoshiro256PlusPlus::seed_from_u64(lane as u64),
        y: [0.0; 2],
        u: [0.0; 2],
    };
    let mut plants: Vec<Plant> = (0..lanes).map(plant).collect();
    let mut next_look = LOOK;
    for start in (0..samples).step_by(LOOK) {
        let last = start + LOOK >= next_look || start + LOOK >= samples;
        if forgets_all && last {
            reference = Reference::new(input, &design);
        }
        for step in 0..LOOK {
            let common = common(input, start + step);
            for (lane, plant) in plants.iter_mut().enumerate() {
                let (phi, y) = plant.sample::<T>(input, common);
                block.set(lane, step, &phi, y);
                if lane == 0 && (last || !forgets_all) {
                    reference.update(&phi, y);
                }
            }
        }
        batch.update(&block).unwrap();
        if last {
            look(seen(&batch, &reference, start + LOOK));
            next_look = 10 * (start + LOOK);
        }
    }
    batch.guard(0)
}

fn common(input: Input, k: usize) -> f64 {
    if input == Input::White || (input == Input::Stops && k >= LAST_EXCITATION) {
        return 1.0;
    }
    let k = k as f64;
    1.0 + 0.5 * (0.05 * k).sin() + 0.3 * (0.31 * k).sin()
}

fn distance(a: &[f64; N], b: &[f64; N]) -> f64 {
    let worst = |worst: f64, (a, b): (&f64, &f64)| {
        let error = (a - b).abs();
        // Not `max`, which would lose what is not a number.
        if error <= worst { worst } else { error }
    };
    a.iter().zip(b).fold(0.0, worst)
}

fn seen<T: BatchScalar>(batch: &BatchRls<T>, reference: &Reference, samples: usize) -> Look {
    let (mut theta, mut variance) = ([T::zero(); N], [T::zero(); N]);
    let mut look = Look {
        samples,
        from_reference: 0.0,
        from_truth: 0.0,
        reference_from_truth: distance(&reference.theta, &TRUTH),
        variance: [f64::INFINITY, 0.0],
        condition: reference.rls.condition(),
    };
    for lane in 0..batch.estimators() {
        batch.theta_into(lane, &mut theta);
        batch.variance_into(lane, &mut variance);
        let theta = theta.map(Scalar::to_report);
        if lane == 0 {
            look.from_reference = distance(&theta, &reference.theta);
        }
        let error = distance(&theta, &TRUTH);
        look.from_truth = if error <= look.from_truth { look.from_truth } else { error };
        for variance in variance.map(Scalar::to_report) {
            let [least, most] = look.variance;
            look.variance = [least.min(variance), if variance <= most { most } else { variance }];
        }
    }
    look
}
