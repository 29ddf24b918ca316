//! The two tests that end a training.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use crate::support::{Rls, kinds, paper_input, response, run, subject};
use fd_compensate::residual_compensation::{CompensationPlan, ConvergenceRule};
use fd_core::{EventKind, stage::Identifier};
use proptest::prelude::*;

const THETA: [f64; 5] = [-1.3, 0.4, 0.05, -0.02, 0.01];

fn plan(epsilon: f64, mu: f64) -> CompensationPlan {
    let mut plan = CompensationPlan::default();
    plan.convergence.rule = ConvergenceRule::TwoConstants { epsilon, mu };
    // The identifier fills its regressor with two samples, which move no parameter.
    plan.convergence.least_samples = 3;
    // So that the switch opens in the sample that passes.
    plan.trial.samples = 0;
    plan
}

/// A bias with white-looking noise of some per cent.
fn noisy(u: &[f64]) -> Vec<f64> {
    let mut noise = 0.3_f64;
    let bias = response::<2>(&THETA, u);
    bias.iter()
        .map(|r| {
            noise = 3.99 * noise * (1.0 - noise);
            r + 0.01 * (noise - 0.5)
        })
        .collect()
}

/// By how much each sample moves `θ`, and its norm before.
fn moves(u: &[f64], r: &[f64]) -> Vec<(f64, f64)> {
    let norm = |theta: &[f64]| theta.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut identifier = Rls::<f64, 2>::new();
    u.iter()
        .zip(r)
        .map(|(&u, &r)| {
            let before = identifier.theta().to_vec();
            identifier.update(&[u], &[r]);
            let difference: Vec<f64> =
                identifier.theta().iter().zip(&before).map(|(new, old)| new - old).collect();
            (norm(&difference), norm(&before))
        })
        .collect()
}

fn frozen_at(plan: &CompensationPlan, u: &[f64], r: &[f64]) -> Option<usize> {
    let log = run(&mut subject::<f64>(plan), u, r).1;
    log.iter().find(|(_, kind)| *kind == EventKind::Frozen).map(|(k, _)| *k)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, ..Default::default() })]

    /// The switch opens in the first sample in which both inequalities hold, and in no other.
    #[test]
    fn opens_when_both_inequalities_hold(epsilon in -5.0..-1.0_f64, mu in -5.0..-1.0_f64) {
        let (epsilon, mu) = (10.0_f64.powf(epsilon), 10.0_f64.powf(mu));
        let u = paper_input(3000);
        let r = noisy(&u);
        let passes = |&(moved, size): &(f64, f64)| moved <= epsilon * size && moved <= mu;
        let expected = moves(&u, &r).iter().skip(2).position(passes).map(|k| k + 2);
        prop_assert!(expected.is_none_or(|k| k > 2), "from zero every move is too large");
        prop_assert_eq!(frozen_at(&plan(epsilon, mu), &u, &r), expected);
    }

    /// Neither constant alone is the test: a smaller one of either never opens earlier.
    #[test]
    fn either_constant_may_hold_it_back(epsilon in -4.0..-1.0_f64, mu in -4.0..-1.0_f64, less in 0.0..2.0_f64) {
        let u = paper_input(3000);
        let r = noisy(&u);
        let at = |epsilon: f64, mu: f64| {
            frozen_at(&plan(10.0_f64.powf(epsilon), 10.0_f64.powf(mu)), &u, &r).unwrap_or(usize::MAX)
        };
        let both = at(epsilon, mu);
        prop_assert!(at(epsilon - less, mu) >= both && at(epsilon, mu - less) >= both);
    }
}

/// `√(Σ var θᵢ) σ / ‖θ‖` with `σ` the rms innovation so far, against its definition.
#[test]
fn a_demand_on_the_standard_error_is_met_before_the_switch_opens() {
    let u = paper_input(3000);
    let r = noisy(&u);
    // Large steps pass, so that the standard error decides.
    let demanding = |bound: f64| {
        let mut plan = plan(0.5, 1e3);
        plan.convergence.relative_standard_error = Some(bound);
        plan
    };
    let (innovations, log) = run(&mut subject::<f64>(&demanding(1e-300)), &u, &r);
    assert_eq!(kinds(&log), [EventKind::TrainingStarted]);
    let (mut identifier, mut squares, mut variance) = (Rls::<f64, 2>::new(), 0.0, [0.0; 5]);
    let course: Vec<(f64, f64)> = (1..)
        .zip(u.iter().zip(&r).zip(&innovations))
        .map(|(learned, ((&u, &r), &innovation))| {
            identifier.update(&[u], &[r]);
            identifier.variance_into(&mut variance);
            squares += innovation * innovation;
            let size = identifier.theta().iter().map(|v| v * v).sum::<f64>().sqrt();
            (variance.iter().sum::<f64>() * squares / f64::from(learned), size)
        })
        .collect();
    let moves = moves(&u, &r);
    let mut earlier = 0;
    for bound in [0.4, 0.2, 0.1] {
        let opens = |k: &usize| {
            let ((squared, size), (moved, before)) = (course[*k], moves[*k]);
            squared.sqrt() <= bound * size && moved <= 0.5 * before && moved <= 1e3
        };
        let expected = (1..u.len()).find(opens);
        assert_eq!(frozen_at(&demanding(bound), &u, &r), expected, "{bound}");
        assert!(expected.is_some_and(|k| k > earlier), "{bound}: {expected:?} after {earlier}");
        earlier = expected.unwrap_or(0);
    }
}

/// A single sample that happens to fit passes the paper's test; a row of them does not come so soon.
#[test]
fn samples_in_a_row_are_the_stricter_rule() {
    let u = paper_input(20_000);
    let r = noisy(&u);
    let mut in_a_row = plan(1e-2, 1.0);
    in_a_row.convergence.rule = ConvergenceRule::InARow;
    in_a_row.convergence.tolerance = 1e-2;
    let (paper, row) = (frozen_at(&plan(1e-2, 1.0), &u, &r), frozen_at(&in_a_row, &u, &r));
    assert!(paper.unwrap() + 50 <= row.unwrap(), "{paper:?} {row:?}");
}

/// The other demands hold for both rules.
#[test]
fn a_constant_input_ends_no_training_by_either_rule() {
    let (u, r) = (vec![1.0; 1000], vec![0.3; 1000]);
    let log = run(&mut subject::<f64>(&plan(1e-2, 1.0)), &u, &r).1;
    assert_eq!(kinds(&log), [EventKind::TrainingStarted]);
    let mut late = plan(1e-2, 1.0);
    late.convergence.least_samples = 500;
    let u = paper_input(1000);
    let frozen = frozen_at(&late, &u, &response::<2>(&THETA, &u));
    assert!(frozen.is_some_and(|k| k >= 499), "{frozen:?}");
}

#[test]
fn a_spec_names_the_rule() {
    let parse = |text: &str| serde_json::from_str::<ConvergenceRule>(text);
    assert_eq!(parse(r#"{"kind":"in-a-row"}"#).unwrap(), ConvergenceRule::InARow);
    let rule = parse(r#"{"kind":"two-constants","epsilon":1e-3,"mu":1e-2}"#).unwrap();
    assert_eq!(rule, ConvergenceRule::TwoConstants { epsilon: 1e-3, mu: 1e-2 });
    let unknown = parse(r#"{"kind":"one-constant"}"#).unwrap_err().to_string();
    assert!(unknown.contains("in-a-row") && unknown.contains("two-constants"), "{unknown}");
    for (epsilon, mu, name) in
        [(0.0, 1.0, "epsilon"), (1.0, -1.0, "mu"), (f64::NAN, 1.0, "epsilon")]
    {
        let error = plan(epsilon, mu).check().unwrap_err().to_string();
        assert!(error.starts_with(&format!("convergence.rule.{name} must be positive")), "{error}");
    }
}
