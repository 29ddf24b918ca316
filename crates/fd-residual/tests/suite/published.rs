//! Published residual generators, checked through the general form.
//!
//! Varga (2017), Solving Fault Diagnosis Problems, and the user's guide of FDITOOLS; Niemann
//! (1998); Yuan et al. (1997). All in continuous time.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]
#![allow(clippy::unreadable_literal, reason = "numbers as printed in the sources")]

use crate::common::{
    problems::{Problem, niemann, varga_7_3, yuan},
    transfer::{ONE, Ratio, System, ZERO, assert_close, assert_equal, realise},
};
use faer::{Mat, mat};
use fd_core::IoDims;
use fd_model::{Continuous, Discrete, SampleTime, StateSpace};
use fd_residual::{
    GeneratorDesign, ResidualForm,
    analysis::{
        UnknownInputs, achievable_signatures, fault_effects, fault_to_noise_gap, strong_structure,
        weak_structure,
    },
    parity::ParityDesign,
};

fn form_of(nu: usize, ny: usize, system: System) -> ResidualForm<Continuous> {
    ResidualForm::new(IoDims { nu, ny }, system).unwrap()
}

/// `[(s+1)/(s+2); (s+2)/(s+3)]`.
fn stable_plant() -> System {
    realise(&[[(&[1.0, 1.0], &[1.0, 2.0])], [(&[1.0, 2.0], &[1.0, 3.0])]])
}

#[test]
fn varga_5_4_unstable_plant_exact_decoupling() {
    let first: Ratio = (&[1.0, 1.0], &[1.0, -2.0]);
    let second: Ratio = (&[1.0, 2.0], &[1.0, -3.0]);
    let gu = realise(&[[first], [second]]);
    let gd = realise(&[[(&[1.0, -1.0], &[1.0, 2.0])], [ZERO]]);
    let gf = realise(&[[first, ZERO], [second, ONE]]);
    let to_u: Ratio = (&[-1.0, -2.0], &[1.0, 3.0]);
    let to_y: Ratio = (&[1.0, -3.0], &[1.0, 3.0]);
    let form = form_of(1, 2, realise(&[[to_u, ZERO, to_y]]));

    assert!(form.consistency(&gu).unwrap() < 1e-14);
    assert_equal(&form.residual_of(&gd).unwrap(), &realise(&[[ZERO]]));
    let rf = realise(&[[(&[1.0, 2.0], &[1.0, 3.0]), to_y]]);
    assert_equal(&form.residual_of(&gf).unwrap(), &rf);
    let effects = fault_effects(&form, &gf).unwrap();
    for (effect, steady) in effects.iter().zip([2.0 / 3.0, 1.0]) {
        assert!(effect.detectable && effect.lasting);
        assert_close(effect.steady.unwrap(), steady);
        assert_close(effect.peak.norm, 1.0);
    }
    assert_eq!(weak_structure(&form, &gf).unwrap()[0].to_string(), "11");
    assert!(fault_effects(&form, &gd).unwrap().iter().all(|effect| !effect.detectable));
    // No noise reaches a decoupled residual.
    assert!(fault_to_noise_gap(&form, &gf, &gd).unwrap().ratio > 1e12);
}

#[test]
fn varga_5_3_stable_variant() {
    let gd = realise(&[[(&[1.0, -1.0], &[1.0, 2.0])], [ZERO]]);
    let (first, second): (Ratio, Ratio) = ((&[1.0, 1.0], &[1.0, 2.0]), (&[1.0, 2.0], &[1.0, 3.0]));
    let gf = realise(&[[first, ZERO], [second, ONE]]);
    let form = form_of(1, 2, realise(&[[(&[-1.0, -2.0], &[1.0, 3.0]), ZERO, ONE]]));
    assert!(form.consistency(&stable_plant()).unwrap() < 1e-14);
    assert_equal(&form.residual_of(&gd).unwrap(), &realise(&[[ZERO]]));
    assert_equal(&form.residual_of(&gf).unwrap(), &realise(&[[second, ONE]]));
    let strong = strong_structure(&form, &gf, &[0.0, 1.0, 100.0]).unwrap();
    assert_eq!(strong[0].to_string(), "11");
}

#[test]
fn varga_5_6_optimal_gap() {
    let gw = realise(&[[(&[1.0], &[1.0, 2.0])], [ZERO]]);
    let gf = realise(&[[(&[1.0, 1.0], &[1.0, 2.0]), ZERO], [ZERO, ONE]]);
    // H_y = 3 (s+2)/(s+3) [1 1] gives the published R_f and R_w; H_u = -H_y G_u.
    let to_y: Ratio = (&[3.0, 6.0], &[1.0, 3.0]);
    let to_u: Ratio = (&[-6.0, -24.0, -21.0], &[1.0, 6.0, 9.0]);
    let form = form_of(1, 2, realise(&[[to_u, to_y, to_y]]));
    assert!(form.consistency(&stable_plant()).unwrap() < 1e-14);
    let rf = realise(&[[(&[3.0, 3.0], &[1.0, 3.0]), (&[3.0, 6.0], &[1.0, 3.0])]]);
    assert_equal(&form.residual_of(&gf).unwrap(), &rf);
    assert_equal(&form.residual_of(&gw).unwrap(), &realise(&[[(&[3.0], &[1.0, 3.0])]]));
    let gap = fault_to_noise_gap(&form, &gf, &gw).unwrap();
    assert_close(gap.ratio, 3.0);
    assert_close(gap.noise.norm, 1.0);
}

#[test]
fn fditools_example_8() {
    let (first, second): (Ratio, Ratio) = ((&[1.0, 1.0], &[1.0, 2.0]), (&[1.0, 2.0], &[1.0, 3.0]));
    let gw = realise(&[[(&[1.0, -1.0], &[1.0, 2.0])], [ZERO]]);
    let gf = realise(&[[first, ONE, ZERO], [second, ZERO, ONE]]);
    let (y1, y2): (Ratio, Ratio) = ((&[1.0, 2.0], &[1.0, 1.0]), (&[1.0, 3.0], &[1.0, 1.0]));
    let form = form_of(1, 2, realise(&[[(&[-2.0, -3.0], &[1.0, 1.0]), y1, y2]]));
    assert!(form.consistency(&stable_plant()).unwrap() < 1e-14);
    let rf = realise(&[[(&[2.0, 3.0], &[1.0, 1.0]), y1, y2]]);
    assert_equal(&form.residual_of(&gf).unwrap(), &rf);
    let rw = realise(&[[(&[1.0, -1.0], &[1.0, 1.0])]]);
    assert_equal(&form.residual_of(&gw).unwrap(), &rw);
    let gap = fault_to_noise_gap(&form, &gf, &gw).unwrap();
    for (peak, expected) in gap.faults.iter().zip([3.0, 2.0, 3.0]) {
        assert_close(peak.norm, expected);
    }
    assert_close(gap.noise.norm, 1.0);
    assert_close(gap.ratio, 2.0);
}

#[test]
fn strong_and_weak_structure() {
    // The outputs themselves as the residual: H_y = I, no inputs.
    let form = form_of(0, 2, StateSpace::gain(Mat::identity(2, 2), Continuous).unwrap());
    let gf =
        realise(&[[(&[1.0, 0.0], &[1.0, 1.0]), ZERO], [(&[1.0, 0.0, 4.0], &[1.0, 6.0, 9.0]), ONE]]);
    let rf = form.residual_of(&gf).unwrap();
    let gain =
        |omega: f64, i: usize, j: usize| rf.frequency_response(omega).unwrap()[(i, j)].norm();
    assert_close(gain(0.0, 1, 0), 4.0 / 9.0);
    assert_close(gain(2.0, 0, 0), 2.0 / 5.0_f64.sqrt());
    let bits = |s: Vec<fd_residual::analysis::Signature>| -> Vec<String> {
        s.iter().map(ToString::to_string).collect()
    };
    assert_eq!(bits(weak_structure(&form, &gf).unwrap()), ["10", "11"]);
    assert_eq!(bits(strong_structure(&form, &gf, &[0.0]).unwrap()), ["00", "11"]);
    assert_eq!(bits(strong_structure(&form, &gf, &[2.0]).unwrap()), ["10", "01"]);
    assert_eq!(bits(strong_structure(&form, &gf, &[0.0, 2.0]).unwrap()), ["00", "01"]);

    // The first residual sees the first fault, s/(s+1), until it dies away, and never the second.
    let first = form_of(0, 2, StateSpace::gain(mat![[1.0, 0.0]], Continuous).unwrap());
    let [dying, absent] = fault_effects(&first, &gf).unwrap()[..] else { panic!("two faults") };
    assert!(dying.detectable && !dying.lasting);
    assert_close(dying.steady.unwrap(), 0.0);
    assert_close(dying.peak.norm, 1.0);
    assert!(!absent.detectable && !absent.lasting);
    // Of both together, one is enough for a fault to last: 4/9 of the first, all of the second.
    let effects = fault_effects(&form, &gf).unwrap();
    for (effect, steady) in effects.iter().zip([4.0 / 9.0, 1.0]) {
        assert!(effect.detectable && effect.lasting);
        assert_close(effect.steady.unwrap(), steady);
    }
}

/// A tank that integrates, under its parity relation `y(k) − y(k−1) − u(k−1)`: a constant error of
/// the level sensor is seen once and forgotten; one of the pump fills the tank and is seen for
/// ever, although no steady gain of it exists.
#[test]
fn a_constant_fault_of_an_integrator_may_be_forgotten() {
    let domain = Discrete { ts: SampleTime::new(1.0).unwrap() };
    let tank = StateSpace::new(mat![[1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain).unwrap();
    let form = ParityDesign::all(&tank, 1).unwrap().form().unwrap();
    let sensor = StateSpace::gain(mat![[1.0]], domain).unwrap();
    let sensor = fault_effects(&form, &sensor).unwrap()[0];
    assert!(sensor.detectable && !sensor.lasting);
    assert!(sensor.steady.unwrap() < 1e-12);
    let pump = UnknownInputs::none(&tank).actuator(&tank, 0).unwrap().system(&tank).unwrap();
    let pump = fault_effects(&form, &pump).unwrap()[0];
    assert!(pump.detectable && pump.lasting && pump.steady.is_none());
}

#[test]
fn varga_7_3_state_space_realisation() {
    let Problem { plant: gu, faults: gf, disturbances, .. } = varga_7_3();
    let gd = disturbances.system(&gu).unwrap();
    assert_equal(&gu, &stable_plant());
    assert_equal(&gd, &realise(&[[(&[1.0, -1.0], &[1.0, 1.0])], [ZERO]]));
    let (first, second): (Ratio, Ratio) =
        ((&[1.0, 1.0], &[1.0, -2.0]), (&[1.0, 2.0], &[1.0, -3.0]));
    assert_equal(&gf.system(&gu).unwrap(), &realise(&[[first, ZERO], [second, ONE]]));
}

/// Yuan, Vansteenkiste and Wen (1997): eight faults, eighteen signatures.
#[test]
fn yuan_signatures_and_least_orders() {
    let Problem { plant, faults, disturbances: none, .. } = yuan();
    let found = |frequencies: &[f64]| {
        let found = achievable_signatures(&plant, &faults, &none, frequencies, 4).unwrap();
        let found = found.iter().map(|a| format!("{}:{}", a.signature, a.least_order));
        found.collect::<Vec<_>>()
    };
    let weak = "00010011:1 01101110:2 01111101:2 01111111:2 10101110:1 10111101:1 10111111:1 \
                11001100:2 11011111:2 11100110:2 11101010:2 11101110:2 11110101:2 11110111:2 \
                11111001:2 11111011:2 11111101:2 11111111:2";
    assert_eq!(found(&[]).join(" "), weak);

    // Six of them cannot be had for faults that are constant or oscillate at 1 rad/s.
    let lost = ["11100110", "11101010", "11110101", "11110111", "11111001", "11111011"];
    let kept = weak.split(' ').filter(|a| !lost.contains(&&a[..8]));
    let strong = found(&[0.0, 1.0]);
    assert_eq!(
        strong.iter().map(|a| &a[..8]).collect::<Vec<_>>(),
        kept.map(|a| &a[..8]).collect::<Vec<_>>()
    );
}

/// Niemann (1998): three signatures in badly scaled units.
#[test]
fn niemann_signatures_and_orders() {
    let Problem { plant, faults, disturbances: disturbance, .. } = niemann();
    let found = achievable_signatures(&plant, &faults, &disturbance, &[], 4).unwrap();
    let summary: Vec<_> = found
        .iter()
        .map(|a| {
            let full: usize = a.basis_orders.iter().sum();
            (a.signature.to_string(), a.least_order, a.dimension, full)
        })
        .collect();
    let published = [("01", 1, 3, 3), ("10", 1, 3, 3), ("11", 1, 4, 4)];
    assert_eq!(summary, published.map(|(s, least, dim, full)| (s.to_owned(), least, dim, full)));
}
