//! Published filters for plants with noise. Sources: `docs/results/published.md`. All in continuous time.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{
    problems::Problem,
    transfer::{ONE, Ratio, System, ZERO, assert_close, assert_equal, realise},
};
use faer::{Mat, c64, mat};
use fd_core::IoDims;
use fd_model::{Continuous, ModelError, StateSpace};
use fd_residual::{
    DesignError, ResidualForm,
    analysis::{UnknownInputs, achievable_signatures, fault_to_noise_gap, weak_structure},
    matching::{ApproximateMatching, MatchingNorm},
    observer::ErrorPoles,
    optimal::{Exposure, OptimalDesign},
};
use std::f64::consts::{FRAC_1_SQRT_2, SQRT_2};

const U1: Ratio = (&[1.0, 1.0], &[1.0, 2.0]);
const U2: Ratio = (&[1.0, 2.0], &[1.0, 3.0]);

fn signatures(p: &Problem) -> Vec<String> {
    let found = achievable_signatures(&p.plant, &p.faults, &p.disturbances, &[], 4).unwrap();
    found.iter().map(|one| one.signature.to_string()).collect()
}

/// One row of a form.
fn row(form: &ResidualForm<Continuous>, of: usize) -> ResidualForm<Continuous> {
    let weights = Mat::from_fn(1, form.residual_len(), |_, j| if j == of { 1.0 } else { 0.0 });
    form.weighted(weights.as_ref()).unwrap()
}

/// User's guide of FDITOOLS, example 11: a bank of three residuals, each blind to one fault, as far above the noise as can be.
#[test]
fn a_bank_as_far_above_the_noise_as_can_be() {
    let noise: Ratio = (&[1.0, -1.0], &[1.0, 2.0]);
    let p = Problem::realised(&[[U1, U1, ONE, ZERO, noise], [U2, U2, ZERO, ONE, ZERO]], [0, 3, 1]);
    assert_eq!(signatures(&p), ["011", "101", "110", "111"]);
    let gw = p.noise.system(&p.plant).unwrap();
    let gf = p.faults.system(&p.plant).unwrap();
    let (y1, y2): (Ratio, Ratio) = ((&[1.0, 2.0], &[1.0, 1.0]), (&[-1.0, -3.0], &[1.0, 2.0]));
    let quiet: Ratio = (&[-1.0, -2.0], &[1.0, 3.0]);
    let minus: Ratio = (&[-1.0], &[1.0]);
    // Columns u, y1, y2; the fault by whose gain at rest the sign and the gain of a row are fixed, and that gain.
    let published = [
        (1.5, [ZERO, y1, y2], 1, 2.0),
        (f64::INFINITY, [quiet, ZERO, ONE], 2, 1.0),
        (1.0, [minus, y1, ZERO], 1, 2.0),
    ];
    for (blind, (gap, q, fault, gain)) in published.into_iter().enumerate() {
        let others: Vec<usize> = (0..3).filter(|&j| j != blind).collect();
        let seen = p.faults.select(&others).unwrap();
        let ignored = p.faults.select(&[blind]).unwrap();
        let exposure = Exposure { faults: &seen, disturbances: &ignored, noise: &p.noise };
        // The pole of the row without noise is free, published at −3.
        let pole = ErrorPoles::Given(vec![c64::new(-3.0, 0.0)]);
        let design = OptimalDesign::placed(&p.plant, &exposure, 3.0, &pole).unwrap();
        let form = design.form();
        let found = fault_to_noise_gap(form, &seen.system(&p.plant).unwrap(), &gw).unwrap();
        if gap.is_finite() {
            assert_close(found.ratio, gap);
            assert_close(found.noise.norm, 1.0);
        } else {
            // No noise at all, up to rounding.
            assert!(design.noisy() == 0 && found.ratio > 1e12, "{}", found.ratio);
        }
        // The gain of a row with noise is fixed by that of the noise, one, as published.
        let rest = form.residual_of(&gf).unwrap().dc_gain().unwrap()[(0, fault)];
        if gap.is_finite() {
            assert_close(rest.abs(), gain);
        }
        let form = form.weighted(mat![[gain / rest]].as_ref()).unwrap();
        assert_equal(form.system(), &realise(&[q]));
        let expected: String = (0..3).map(|j| if j == blind { '0' } else { '1' }).collect();
        assert_eq!(weak_structure(&form, &gf).unwrap()[0].to_string(), expected);
    }
}

/// Example 5.11 of Varga (2017) and example 14 of the user's guide of FDITOOLS: residuals as near to the two faults as noise allows.
/// The least distance `√½` is that of the first row at rest; the filter that has it is not unique.
#[test]
fn as_near_to_both_faults_as_noise_allows() {
    let lag: Ratio = (&[1.0], &[1.0, 2.0]);
    let p = Problem::realised(&[[U1, U1, ZERO, lag], [U2, ZERO, ONE, ZERO]], [0, 2, 1]);
    assert_eq!(signatures(&p), ["01", "10", "11"]);
    let none = UnknownInputs::none(&p.plant);
    let exposure = Exposure { faults: &p.faults, disturbances: &none, noise: &p.noise };
    let wanted = StateSpace::gain(Mat::identity(2, 2), Continuous).unwrap();
    let gaps = |form: &ResidualForm<Continuous>| {
        [0, 1].map(|fault| {
            let gf = p.faults.select(&[fault]).unwrap().system(&p.plant).unwrap();
            let gw = p.noise.system(&p.plant).unwrap();
            fault_to_noise_gap(&row(form, fault), &gf, &gw).unwrap().ratio
        })
    };
    let structure = |form: &ResidualForm<Continuous>| {
        let rows = weak_structure(form, &p.faults.system(&p.plant).unwrap()).unwrap();
        rows.iter().map(ToString::to_string).collect::<Vec<_>>()
    };

    // The published filter, with its four digits.
    let to_u: [Ratio; 2] =
        [(&[-0.7072, -0.7072], &[1.0, SQRT_2]), (&[-0.7072, -1.4144], &[1.0, 3.0])];
    let to_y1: Ratio = (&[0.7072, 1.4144], &[1.0, SQRT_2]);
    let to_y2: Ratio = (&[0.7072], &[1.0]);
    let q = realise(&[[to_u[0], to_y1, ZERO], [to_u[1], ZERO, to_y2]]);
    let printed = ResidualForm::new(IoDims { nu: 1, ny: 2 }, q).unwrap();
    assert!(printed.consistency(&p.plant).unwrap() < 1e-12);
    let made = printed.residual_of(&p.faults.and(&p.noise).unwrap().system(&p.plant).unwrap());
    let ideal = wanted.beside(&StateSpace::gain(Mat::zeros(2, 1), Continuous).unwrap()).unwrap();
    let distance = ideal.difference(&made.unwrap()).unwrap().hinf_norm(1e-8).unwrap().norm;
    assert!((distance - FRAC_1_SQRT_2).abs() < 1e-4, "{distance}");
    let [first, second] = gaps(&printed);
    assert_close(first, SQRT_2);
    assert!(second > 1e12 && structure(&printed) == ["10", "01"]);

    // Designed: as near, to the accuracy of the search (1e-4 relative), and farther above the noise.
    let design =
        ApproximateMatching::new(&p.plant, &exposure, &wanted, 1.0, MatchingNorm::Peak).unwrap();
    let error = design.error(&p.plant, &exposure, &wanted).unwrap();
    let distance = error.hinf_norm(1e-8).unwrap().norm;
    assert_eq!(design.lags(), 0);
    assert!((distance / FRAC_1_SQRT_2 - 1.0).abs() < 2e-4, "{distance}");
    assert!(design.bound() <= FRAC_1_SQRT_2 * (1.0 + 1e-9));
    let [first, second] = gaps(design.form());
    assert!(first > SQRT_2 && second > 1e12, "{first} {second}");
    assert_eq!(structure(design.form()), ["10", "01"]);
    // Four states before and two after cancellation, as the published one.
    assert_eq!(design.form().system().minimal(1e-6).unwrap().nx(), 2);
}

/// One output that shows faults and noise, and no input.
fn watched<const N: usize>(columns: [Ratio; N]) -> (System, UnknownInputs, UnknownInputs) {
    let all = realise(&[columns]);
    let of = |inputs: &[usize]| {
        let part = all.select(&[0], inputs).unwrap();
        UnknownInputs::new("f", part.b().to_owned(), part.d().to_owned()).unwrap()
    };
    let faults: Vec<usize> = (0..N - 1).collect();
    (all.select(&[0], &[]).unwrap(), of(&faults), of(&[N - 1]))
}

/// Tests of `afdredsyn` of Varga: noise that vanishes at infinity. The best filter would differentiate; with the pole −α it leaves
/// the gap α.
#[test]
fn noise_that_vanishes_at_infinity() {
    let lag: Ratio = (&[1.0], &[1.0, 2.0]);
    let one = watched([U1, lag]);
    let two = watched([U1, ONE, lag]);
    for (plant, faults, noise) in [one, two] {
        let none = UnknownInputs::none(&plant);
        let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
        let design = OptimalDesign::new(&plant, &exposure, 3.0).unwrap();
        let (gf, gw) = (faults.system(&plant).unwrap(), noise.system(&plant).unwrap());
        let gap = fault_to_noise_gap(design.form(), &gf, &gw).unwrap();
        assert_close(gap.ratio, 3.0);
        assert_close(gap.noise.norm, 1.0);
        let poles = design.form().system().minimal(1e-7).unwrap().poles().unwrap();
        assert!(poles.len() == 1 && (poles[0] + 3.0).norm() < 1e-6, "{poles:?}");
    }
}

/// The same with noise that vanishes at rest: a filter with an integrator would have no bound, one with the pole −ε leaves the gap 1/ε.
/// The published filter is weighed, but not found: zeros of the noise on the frequency axis are refused.
#[test]
fn noise_that_vanishes_at_rest_is_refused() {
    let (plant, faults, noise) = watched([U1, (&[1.0, 0.0], &[1.0, 2.0])]);
    let none = UnknownInputs::none(&plant);
    let exposure = Exposure { faults: &faults, disturbances: &none, noise: &noise };
    let refusal = OptimalDesign::new(&plant, &exposure, 0.3).unwrap_err();
    let unsolved = matches!(refusal, DesignError::Model(ModelError::NoConvergence { .. }));
    assert!(unsolved, "{refusal:?}");

    let q = realise(&[[(&[1.0, 2.0], &[1.0, 0.3])]]);
    let printed = ResidualForm::new(IoDims { nu: 0, ny: 1 }, q).unwrap();
    let (gf, gw) = (faults.system(&plant).unwrap(), noise.system(&plant).unwrap());
    let gap = fault_to_noise_gap(&printed, &gf, &gw).unwrap();
    assert_close(gap.ratio, 1.0 / 0.3);
    assert_close(gap.noise.norm, 1.0);
}
