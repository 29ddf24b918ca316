//! The law of memory, for every decision rule and every compensator.
#![allow(clippy::unwrap_used, reason = "helpers of tests fail by panicking")]

use crate::support::{Arx2, Rls, paper_input, response};
use fd_compensate::{
    SampleRows,
    testing::{every_compensator, every_rule},
};
use fd_core::{
    Frame, IoDims,
    stage::{Compensator, Evidence, Identifier, Phase, Verdict},
    testing::memory,
};

/// Quiet, a fault, an outlier, training, a fault again: every counter of a rule moves.
#[test]
fn every_rule_obeys_the_law_of_memory() {
    let noise: Vec<f64> = (0..200).map(|k| (f64::from(k).powi(2) * 0.618).sin()).collect();
    let healthy = SampleRows::new(2, &noise).unwrap();
    let r_star = |k: usize| {
        let fault = if (20..45).contains(&k) || k == 60 || k >= 80 { 8.0 } else { 0.0 };
        [noise[2 * k] + fault, noise[2 * k + 1]]
    };
    for samples in [30, 62, 100] {
        let twins = every_rule::<f64>(healthy).unwrap();
        for ((name, mut rule), (_, mut twin)) in
            every_rule::<f64>(healthy).unwrap().into_iter().zip(twins)
        {
            let mut faults = 0;
            memory(&mut rule, &mut twin, samples, |rule, k| {
                let r_star = r_star(k);
                let statistic = r_star[0].abs();
                let phase = if (50..55).contains(&k) {
                    Phase::Training { samples: 0 }
                } else {
                    Phase::Compensating
                };
                let verdict = Verdict { statistic, threshold: 3.0 };
                let decision =
                    rule.decide(Evidence { k: k as u64, phase, verdict, r_star: &r_star });
                faults += u32::from(decision.is_fault());
                format!("{decision:?}")
            });
            assert!(faults > 0, "{name}");
        }
    }
}

/// Cut in the training, in the trial and while compensating.
#[test]
fn every_compensator_obeys_the_law_of_memory() {
    let u = paper_input(1500);
    let r = response::<2>(&[-1.3, 0.4, 0.05, -0.02, 0.01], &u);
    let mut learned = Rls::<f64, 2>::new();
    u.iter().zip(&r).for_each(|(u, r)| learned.update(&[*u], &[*r]));
    let model = Arx2::<f64>::new();
    for samples in [6, 100, 1200, 1500] {
        let twins = every_compensator(&learned, &model).unwrap();
        for ((name, mut one), (_, mut two)) in
            every_compensator(&learned, &model).unwrap().into_iter().zip(twins)
        {
            let mut compensated = 0;
            memory(&mut one, &mut two, samples, |compensator, k| {
                let (u, r, mut star) = ([u[k]], [r[k]], [0.0]);
                let frame = Frame::new(IoDims { nu: 1, ny: 1 }, k as u64, &u, &r).unwrap();
                let outcome = compensator.step(frame, &r, &mut star);
                compensated += u32::from(outcome.phase == Phase::Compensating);
                (star[0].to_bits(), outcome)
            });
            assert!(samples < 1200 || compensated > 100, "{name}: {compensated}");
        }
    }
}
