//! Long runs: round-off under forgetting, and excitation that stops.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::{noise, paper_like_input};
use fd_core::{
    Scalar,
    stage::{Identifier, Stage},
};
use fd_ident::{
    arx::{ArxOrders, RecursiveArx},
    rls::{
        ConventionalRls, Forgetting, Guard, RlsDesign, RlsKernel, UdRls, WindowDesign, WindowRls,
    },
};

const ORDERS: ArxOrders = ArxOrders::paper(2);
const TRUTH: [f64; 5] = [-1.2, 0.4, 0.5, 0.2, 0.1];

/// `(u, μ)` of the true equation with white equation noise of size 0.01.
fn data(input: impl Fn(u32) -> f64, len: u32) -> Vec<(f64, f64)> {
    let (mut mu, mut u) = ([0.0; 2], [0.0; 2]);
    let noise = noise(11, len as usize);
    let step = |(k, noise): (u32, f64)| {
        let now = input(k);
        let next = -TRUTH[0] * mu[0] - TRUTH[1] * mu[1]
            + TRUTH[2] * now
            + TRUTH[3] * u[0]
            + TRUTH[4] * u[1]
            + 0.01 * noise;
        (mu, u) = ([next, mu[0]], [now, u[0]]);
        (now, next)
    };
    (0..).zip(noise).map(step).collect()
}

/// Largest distance of θ from the truth after the first 2000 samples; infinite when not finite.
fn worst<T: Scalar, K: RlsKernel<T>>(kernel: K, data: &[(f64, f64)]) -> (f64, RecursiveArx<T, K>) {
    let mut arx = RecursiveArx::new(ORDERS, 1, 1, kernel).unwrap();
    let mut worst = 0.0_f64;
    for (k, &(u, mu)) in data.iter().enumerate() {
        arx.update(&[T::from_design(u)], &[T::from_design(mu)]);
        for (theta, truth) in arx.theta().iter().zip(TRUTH) {
            let distance = (theta.to_report() - truth).abs();
            if !distance.is_finite() {
                return (f64::INFINITY, arx);
            }
            if k >= 2000 {
                worst = worst.max(distance);
            }
        }
    }
    (worst, arx)
}

fn exponential(lambda: f64, guard: Guard) -> RlsDesign {
    RlsDesign { prior_variance: 1e4, forgetting: Forgetting::Exponential { lambda }, guard }
}

fn variances<T: Scalar, K: RlsKernel<T>>(arx: &RecursiveArx<T, K>) -> Vec<f64> {
    let mut variance = vec![T::zero(); 5];
    arx.variance_into(&mut variance);
    variance.iter().map(|v| v.to_report()).collect()
}

#[test]
fn f32_follows_f64_for_an_input_of_few_frequencies() {
    let data = data(paper_like_input, 100_000);
    for lambda in [0.9, 0.98, 0.99, 0.999, 0.9999] {
        let forgetting = Forgetting::Exponential { lambda };
        let design = RlsDesign { guard: Guard::off(), ..RlsDesign::forgetting(forgetting) };
        let (single, arx32) = worst(UdRls::<f32>::new(5, &design).unwrap(), &data);
        let (double, arx64) = worst(UdRls::<f64>::new(5, &design).unwrap(), &data);
        let (plain, _) = worst(ConventionalRls::<f32>::new(5, &design).unwrap(), &data);
        println!("lambda {lambda}: UD f32 {single:.4}, UD f64 {double:.4}, plain f32 {plain:.4}");
        assert!(variances(&arx32).iter().all(|&v| v > 0.0 && v.is_finite()));
        // What is left is the scatter of the estimator: f32 and f64 have the same to two digits.
        assert!((single - double).abs() < 0.05 * double.max(0.01), "{lambda}: {single} {double}");
        assert!(variances(&arx64).iter().all(|&v| v > 0.0));
        // The conventional form loses definiteness in f32, even in its exactly symmetric shape.
        assert!(plain > 10.0 * single, "{lambda}: {plain} {single}");
    }
}

#[test]
fn every_guarded_estimator_survives_a_million_samples_without_excitation() {
    let data = data(|k| if k < 2000 { paper_like_input(k) } else { 1.0 }, 1_000_000);
    let designs = [0.9, 0.99, 0.999].into_iter().flat_map(|lambda| {
        [
            Forgetting::Exponential { lambda },
            Forgetting::Directional { lambda },
            Forgetting::Bounded { lambda, variance: 1e4 },
            Forgetting::Resetting { lambda, floor: 1e-6 },
        ]
    });
    let mut of_exponential = f64::INFINITY;
    for forgetting in designs {
        let design = RlsDesign { prior_variance: 1e4, ..RlsDesign::forgetting(forgetting) };
        let (distance, arx) = worst(UdRls::<f32>::new(5, &design).unwrap(), &data);
        let largest = variances(&arx).into_iter().fold(0.0, f64::max);
        println!(
            "{forgetting:?}: distance {distance:.3}, variance {largest:.2e}, {:?}",
            arx.guard()
        );
        assert!(distance.is_finite());
        // Trace limit: ten times that of P₀ = 1e4 I for 5 parameters, plus rounding.
        assert!(largest <= 5.1e5, "{forgetting:?}: {largest}");
        match forgetting {
            // At the guard the condition κ of the weighted regressors is 1.3e7, where rounding may
            // move an estimate by n ε κ ‖θ‖ = 11 in f32.
            Forgetting::Exponential { .. } => {
                assert!(distance < 11.0, "{distance}");
                of_exponential = distance;
            }
            // Only directional forgetting keeps it where it was: within some standard errors
            // 0.01/√3 √P, P the variance of parameters that are not seen any more.
            Forgetting::Directional { .. } => {
                let scatter = 0.01 / 3.0_f64.sqrt() * largest.sqrt();
                println!("  standard error {scatter:.3}");
                assert!(distance < 1.0 && distance < of_exponential, "{distance}");
            }
            _ => {}
        }
    }
    let window = WindowDesign { samples: 200, prior_variance: 1e4 };
    let (distance, arx) = worst(WindowRls::<f32>::new(5, &window).unwrap(), &data);
    let largest = variances(&arx).into_iter().fold(0.0, f64::max);
    println!("window: distance {distance:.3}, variance {largest:.2e}, {:?}", arx.guard());
    assert!(distance.is_finite() && largest <= 1.01e4);
}

#[test]
fn without_guard_the_covariance_winds_up_and_with_guard_it_is_reported() {
    let data = data(|k| if k < 2000 { paper_like_input(k) } else { 1.0 }, 60_000);
    let (_, off) = worst(UdRls::<f64>::new(5, &exponential(0.999, Guard::off())).unwrap(), &data);
    let (_, on) =
        worst(UdRls::<f64>::new(5, &exponential(0.999, Guard::default())).unwrap(), &data);
    let largest = |arx: &RecursiveArx<f64>| variances(arx).into_iter().fold(0.0, f64::max);
    println!("variance without guard {:.2e}, with guard {:.2e}", largest(&off), largest(&on));
    assert!(largest(&off) > 1e3 * largest(&on));
    assert!(on.guard().bounded > 0 && !off.guard().acted());
}

#[test]
fn silence_is_skipped_and_counted() {
    let mut kernel = UdRls::<f64>::new(2, &exponential(0.9, Guard::default())).unwrap();
    let mut theta = [1.0, 2.0];
    (0..100).for_each(|_| kernel.update(&[0.0, 0.0], 5.0, &mut theta));
    let mut variance = [0.0; 2];
    kernel.variance_into(&mut variance);
    assert_eq!(kernel.guard().skipped, 100);
    assert!((variance[0] - 1e4).abs() < 1e-9 && (theta[0] - 1.0).abs() < 1e-15);
    // What overflows is not learned from either.
    kernel.update(&[1e200, 0.0], 5.0, &mut theta);
    assert_eq!(kernel.guard().skipped, 101);
    kernel.reset();
    assert_eq!(kernel.guard().skipped, 0);
}

#[test]
fn the_bounded_covariance_keeps_its_bound_without_any_excitation() {
    let (lambda, variance) = (0.9, 50.0);
    let forgetting = Forgetting::Bounded { lambda, variance };
    let design = RlsDesign { prior_variance: 50.0, forgetting, guard: Guard::default() };
    let mut kernel = UdRls::<f64>::new(4, &design).unwrap();
    let (mut theta, mut found) = ([0.0; 4], [0.0; 4]);
    for _ in 0..100_000 {
        kernel.update(&[1.0, 0.0, 0.0, 0.0], 1.0, &mut theta);
        kernel.variance_into(&mut found);
        // λ^{1−n} c, the bound stated in the docs.
        assert!(found.iter().all(|&p| p <= 50.0 / lambda.powi(3) * (1.0 + 1e-9)), "{found:?}");
    }
    // The excited parameter forgets as without bound: P → 1 − λ.
    assert!((found[0] - 0.1).abs() < 0.01, "{found:?}");
}

#[test]
fn a_small_covariance_is_reset_and_counted() {
    let forgetting = Forgetting::Resetting { lambda: 1.0, floor: 0.01 };
    let design = RlsDesign { prior_variance: 1.0, ..RlsDesign::forgetting(forgetting) };
    let mut kernel = UdRls::<f64>::new(1, &design).unwrap();
    let mut theta = [0.0];
    // P = 1/(1 + k) falls below 0.01 with the 100th sample.
    (0..99).for_each(|_| kernel.update(&[1.0], 2.0, &mut theta));
    assert_eq!(kernel.guard().bounded, 0);
    kernel.update(&[1.0], 2.0, &mut theta);
    let mut variance = [0.0];
    kernel.variance_into(&mut variance);
    assert_eq!(kernel.guard().bounded, 1);
    assert!((variance[0] - 1.0).abs() < 1e-15);
}
