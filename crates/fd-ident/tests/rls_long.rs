//! Long runs side by side, next to a QR reference; `examples/rls_stability.rs` makes them longer.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

#[path = "common/long_run.rs"]
mod long_run;

use fd_ident::batch::LaneScalar;
use long_run::{Input, LOOK, TRUTH, run};

/// Samples of each estimator: more than a hundred times what makes the textbook form diverge.
const SAMPLES: usize = 80 * LOOK;

/// A square root form is off by some `n ε κ ‖θ‖`: so is the reference in `f64`, with its ε.
fn follows_the_reference<T: LaneScalar>(input: Input) {
    let n = TRUTH.len() as f64;
    let guard = run::<T>(input, 0.99, SAMPLES, |look| {
        let allowed = n * T::default_epsilon().to_report() * look.condition * 1.5;
        assert!(look.from_reference < allowed, "{look:?}, allowed {allowed:e}");
        assert!(0.0 < look.variance[0] && look.variance[1] < 1e5);
        // Scatter of the estimator, in any lane: with noise of variance σ² the standard error is
        // σ √P, and six of them are exceeded once in 10⁹.
        let scatter = 6.0 * 0.01 / 3.0_f64.sqrt() * look.variance[1].sqrt();
        assert!(look.from_truth < scatter, "{look:?}, scatter {scatter}");
    });
    assert!(!guard.acted());
}

#[test]
fn white_noise_in_either_precision() {
    follows_the_reference::<f64>(Input::White);
    follows_the_reference::<f32>(Input::White);
}

#[test]
fn few_frequencies_in_either_precision() {
    follows_the_reference::<f64>(Input::Paper);
    follows_the_reference::<f32>(Input::Paper);
}

/// The guard holds `P`: nothing overflows, and in double precision the estimate stays where QR
/// with the same guard has it. In single precision `ε κ` comes near one, and an unexcited
/// direction wanders: only directional forgetting keeps it (see `rls_stability.rs`).
#[test]
fn excitation_stops() {
    let n = TRUTH.len() as f64;
    // Ten times the trace of P₀ = 1e4 I, plus rounding.
    let largest = 1.01 * 10.0 * n * 1e4;
    for lambda in [0.99, 0.999] {
        let guard = run::<f64>(Input::Stops, lambda, SAMPLES / 4, |look| {
            let allowed = 10.0 * n * f64::EPSILON * look.condition;
            assert!(look.from_reference < allowed, "{look:?}, allowed {allowed:e}");
            assert!(look.variance[1] < largest && look.from_truth < 1.0);
        });
        assert!(guard.bounded > 1000);
        let guard = run::<f32>(Input::Stops, lambda, SAMPLES / 4, |look| {
            assert!(look.from_truth.is_finite() && look.variance[1] < largest, "{look:?}");
        });
        assert!(guard.bounded > 1000);
    }
}
