//! Long runs side by side, next to a QR reference; `examples/rls_stability.rs` makes them longer.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::long_run::{Input, LOOK, rounding, run};
use fd_ident::{batch::BatchScalar, rls::Forgetting};

/// Samples of each estimator: more than a hundred times what makes the textbook form diverge.
const SAMPLES: usize = 80 * LOOK;

/// A square root form is off by some `n ε κ ‖θ‖`: so is the reference in `f64`, with its ε.
fn follows_the_reference<T: BatchScalar>(input: Input, forgetting: Forgetting) {
    let guard = run::<T>(input, forgetting, SAMPLES / 2, |look| {
        let allowed = rounding::<T>(&look);
        assert!(look.from_reference < allowed, "{look:?}, allowed {allowed:e}");
        assert!(0.0 < look.variance[0] && look.variance[1] < 1e5);
        // Scatter of the estimator, in any lane: with noise of variance σ² the standard error is
        // σ √P, and six of them are exceeded once in 10⁹. Directional forgetting gives up less
        // than it takes in, so that its P is too small for its scatter.
        let scatter = 6.0 * 0.01 / 3.0_f64.sqrt() * look.variance[1].sqrt();
        if matches!(forgetting, Forgetting::Exponential { .. }) {
            assert!(look.from_truth < scatter, "{look:?}, scatter {scatter}");
        }
    });
    assert!(!guard.acted());
}

#[test]
fn white_noise_in_either_precision() {
    for forgetting in kinds(0.99) {
        follows_the_reference::<f64>(Input::White, forgetting);
        follows_the_reference::<f32>(Input::White, forgetting);
    }
}

#[test]
fn few_frequencies_in_either_precision() {
    for forgetting in kinds(0.99) {
        follows_the_reference::<f64>(Input::Paper, forgetting);
        follows_the_reference::<f32>(Input::Paper, forgetting);
    }
}

fn kinds(lambda: f64) -> [Forgetting; 2] {
    [Forgetting::Exponential { lambda }, Forgetting::Directional { lambda }]
}

/// The guard holds `P`, and what is only rounding moves nothing: the estimate stays where QR with the
/// same guard has it, as far as a condition of 1e7 allows.
#[test]
fn excitation_stops_under_exponential_forgetting() {
    // Rounding of single samples adds up in directions that are not seen again.
    fn stays<T: BatchScalar>(lambda: f64, shares: f64, from_truth: f64) {
        // Ten times the trace of P₀ = 1e4 I, plus rounding.
        let largest = 1.01 * 10.0 * 5.0 * 1e4;
        let forgetting = Forgetting::Exponential { lambda };
        let guard = run::<T>(Input::Stops, forgetting, SAMPLES / 4, |look| {
            let allowed = shares * rounding::<T>(&look);
            assert!(look.from_reference < allowed, "{look:?}, allowed {allowed:e}");
            assert!(look.variance[1] < largest && look.from_truth < from_truth, "{look:?}");
        });
        assert!(guard.bounded > 1000);
    }
    for lambda in [0.99, 0.999] {
        stays::<f64>(lambda, 10.0, 1.0);
        // In f32 an estimate of no use, but a finite one.
        stays::<f32>(lambda, 20.0, f64::INFINITY);
    }
}

/// What directional forgetting is for: no wind-up, hence no pause, and single precision stays as
/// near to QR in double precision as its rounding allows.
#[test]
fn excitation_stops_under_directional_forgetting() {
    fn stays<T: BatchScalar>(lambda: f64) {
        let forgetting = Forgetting::Directional { lambda };
        let guard = run::<T>(Input::Stops, forgetting, SAMPLES / 4, |look| {
            let allowed = rounding::<T>(&look);
            assert!(look.from_reference < allowed, "{look:?}, allowed {allowed:e}");
            assert!(look.variance[1] < 10.0 && look.condition < 1e4, "{look:?}");
            assert!(look.from_truth < 0.1, "{look:?}");
        });
        assert!(!guard.acted());
    }
    for lambda in [0.99, 0.999] {
        stays::<f64>(lambda);
        stays::<f32>(lambda);
    }
}

/// Nothing is forgotten, and the rounding of samples that tell nothing is not learned either: without that dead band the
/// `f32` estimate was .25 from QR after 10⁷ samples, and 7e-3 after 10⁶.
#[test]
fn excitation_stops_and_nothing_is_forgotten() {
    for forgetting in [Forgetting::None, Forgetting::Directional { lambda: 1.0 }] {
        let guard = run::<f32>(Input::Stops, forgetting, 4 * SAMPLES, |look| {
            // Standard errors after 2000 samples are 5e-3 and more.
            assert!(look.from_reference < 1e-2 && look.from_truth < 0.1, "{look:?}");
        });
        assert!(0 < guard.skipped, "{guard:?}");
        run::<f64>(Input::Stops, forgetting, SAMPLES / 4, |look| {
            assert!(look.from_reference < 1e-9, "{look:?}");
        });
    }
}
