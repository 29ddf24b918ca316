//! What the methods owe whatever the data are.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{Plant, Source, through};
use faer::Mat;
use fd_core::{
    Frame,
    stage::ResidualGenerator,
    testing::{nonsense, reset_and_restore},
};
use fd_data::{
    Scaling,
    cva::{CvaDesign, States},
    monitor::{MonitorDesign, Statistic, Statistics},
    parity::DataParityDesign,
    pca::{Components, PcaDesign},
};
use fd_model::Record;
use proptest::prelude::*;

fn pca(log: &Record, lags: usize, count: usize, scaling: Scaling) -> MonitorDesign {
    let components = Components::Count(count);
    let learned = PcaDesign { lags, components, scaling }.learn(std::slice::from_ref(log)).unwrap();
    learned.monitor().clone()
}

fn cva(log: &Record) -> fd_data::cva::Cva {
    let design = CvaDesign { past: 3, future: 2, states: States::Count(2) };
    design.learn(std::slice::from_ref(log)).unwrap()
}

fn all(design: &MonitorDesign, log: &Record) -> Vec<Statistics<f64>> {
    design.statistics(log).unwrap().into_iter().flatten().collect()
}

/// Covariances of condition up to 1e4 or so lose as many of sixteen digits.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-8 * (1.0 + a.abs().max(b.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// What is a direction of large variance does not depend on the axes.
    #[test]
    fn statistics_of_components_do_not_depend_on_rotations(seed in 0_u64..1 << 40, count in 1_usize..4) {
        let log = Plant::random(2, 0, 4, seed).log(150, 0.4, seed + 1);
        let turned = through(&log, &Mat::new(), &Source::new(seed + 2).rotation(4));
        let (before, after) = (pca(&log, 1, count, Scaling::None), pca(&turned, 1, count, Scaling::None));
        for (a, b) in all(&before, &log).iter().zip(&all(&after, &turned)) {
            prop_assert!(near(a.t2, b.t2) && near(a.q, b.q), "{a:?} {b:?}");
        }
    }

    #[test]
    fn statistics_of_scaled_components_do_not_depend_on_units(seed in 0_u64..1 << 40) {
        let log = Plant::random(2, 1, 3, seed).log(150, 0.3, seed + 1);
        let unit = |n: usize| {
            Mat::from_fn(n, n, |i, j| if i == j { 1000.0_f64.powf(i as f64 - 1.0) } else { 0.0 })
        };
        let other = through(&log, &unit(1), &unit(3));
        let (before, after) = (pca(&log, 0, 2, Scaling::Standard), pca(&other, 0, 2, Scaling::Standard));
        for (a, b) in all(&before, &log).iter().zip(&all(&after, &other)) {
            prop_assert!(near(a.t2, b.t2) && near(a.q, b.q), "{a:?} {b:?}");
        }
    }

    #[test]
    fn contributions_sum_to_their_statistic(seed in 0_u64..1 << 40) {
        let log = Plant::random(2, 1, 3, seed).log(200, 0.3, seed + 1);
        for design in [pca(&log, 0, 2, Scaling::Standard), pca(&log, 2, 5, Scaling::Standard), cva(&log).monitor().clone()] {
            let mut monitor = design.freeze::<f64>().unwrap();
            let mut parts = [0.0; 4];
            for k in 0..50 {
                let frame = Frame::new(design.io(), k as u64, log.u(k), log.y(k)).unwrap();
                let Some(Statistics { t2, rest, q }) = monitor.observe(frame) else { continue };
                for (of, whole) in [(Statistic::T2, t2), (Statistic::Q, q), (Statistic::Rest, rest.unwrap_or(0.0))] {
                    monitor.contributions(of, &mut parts);
                    prop_assert!(parts.iter().all(|&part| part >= 0.0));
                    prop_assert!(near(parts.iter().sum(), whole), "{of:?}: {parts:?} {whole}");
                }
            }
        }
    }

    #[test]
    fn canonical_variates_do_not_depend_on_coordinates(seed in 0_u64..1 << 40) {
        let log = Plant::random(2, 2, 2, seed).log(400, 0.5, seed + 1);
        let mut source = Source::new(seed + 2);
        let other = through(&log, &source.invertible(2), &source.invertible(2));
        let (before, after) = (cva(&log), cva(&other));
        prop_assert!(before.correlations().iter().all(|c| (0.0..=1.0).contains(c)));
        for (a, b) in before.correlations().iter().zip(after.correlations()) {
            prop_assert!((a - b).abs() < 1e-8, "{a} {b}");
        }
        // Which variates are states is told apart only where correlations differ.
        if before.correlations()[1] - before.correlations()[2] > 1e-3 {
            for (a, b) in all(before.monitor(), &log).iter().zip(&all(after.monitor(), &other)) {
                prop_assert!((a.t2 - b.t2).abs() < 1e-5 * (1.0 + a.t2), "{a:?} {b:?}");
            }
        }
    }

    /// Relations of one log hold for every other one.
    #[test]
    fn parity_relations_hold_on_fresh_inputs(seed in 0_u64..1 << 40, n in 1_usize..4, nu in 1_usize..3, ny in 1_usize..4) {
        let plant = Plant::random(n, nu, ny, seed);
        let parity = DataParityDesign { order: n, states: None }.learn(&[plant.log(500, 0.0, seed + 1)]).unwrap();
        prop_assert_eq!(parity.states(), n);
        prop_assert_eq!(parity.map().map().nrows(), (n + 1) * ny - n);
        let mut relations = parity.map().freeze::<f64>().unwrap();
        let fresh = plant.log(60, 0.0, seed + 2);
        let mut r = vec![1.0; relations.residual_len()];
        for k in 0..fresh.len() {
            let frame = Frame::new(relations.io(), k as u64, fresh.u(k), fresh.y(k)).unwrap();
            relations.step(frame, &mut r);
            let size = fresh.y(k).iter().fold(1.0_f64, |size, y| size.max(y.abs()));
            // Vectors are known to the rounding of the factorisation over the smallest singular value kept, and
            // fresh signals are as large as those that were learned from: nine digits of sixteen are left.
            prop_assert!(r.iter().all(|r| r.abs() < 1e-7 * size), "{k}: {r:?}");
        }
    }
}

#[test]
fn memory_is_shown_whole_and_no_memory_panics() {
    let log = Plant::random(2, 1, 2, 3).log(200, 0.2, 4);
    let samples: Vec<_> = log.samples().take(40).map(|(u, y)| (u.to_vec(), y.to_vec())).collect();
    let step = |generator: &mut dyn ResidualGenerator, k: usize| {
        let mut r = vec![0.0; generator.residual_len()];
        let frame = Frame::new(generator.io(), k as u64, &samples[k].0, &samples[k].1).unwrap();
        generator.step(frame, &mut r);
        r.iter().map(|r: &f64| r.to_bits()).collect::<Vec<_>>()
    };
    for design in [pca(&log, 2, 3, Scaling::Standard), cva(&log).monitor().clone()] {
        let mut monitor = design.freeze::<f64>().unwrap();
        reset_and_restore(&mut monitor, &samples);
        nonsense(&mut monitor, 20, |monitor, k| step(monitor, k));
        let mut map = design.residual().unwrap().freeze::<f64>().unwrap();
        reset_and_restore(&mut map, &samples);
        nonsense(&mut map, 20, |map, k| step(map, k));
    }
}

/// Squares of the maps are the statistics that they stand for.
#[test]
fn maps_are_the_statistics() {
    let log = Plant::random(2, 1, 2, 5).log(200, 0.2, 6);
    let squares = |map: fd_data::window::WindowMapDesign| -> Vec<f64> {
        let mut map = map.freeze::<f64>().unwrap();
        let mut r = vec![0.0; map.residual_len()];
        let mut square = |(k, (u, y)): (usize, (&[f64], &[f64]))| {
            map.step(Frame::new(map.io(), k as u64, u, y).unwrap(), &mut r);
            r.iter().map(|r| r * r).sum()
        };
        log.samples().enumerate().map(&mut square).skip(2).collect()
    };
    for (design, is_q) in
        [(pca(&log, 2, 4, Scaling::Standard), true), (cva(&log).monitor().clone(), false)]
    {
        let (scores, left) =
            (squares(design.scores().unwrap()), squares(design.residual().unwrap()));
        for (statistics, (t2, rest)) in all(&design, &log).iter().zip(scores.iter().zip(&left)) {
            assert!(near(statistics.t2, *t2), "{statistics:?} {t2}");
            let other = if is_q { statistics.q } else { statistics.rest.unwrap() };
            assert!(near(other, *rest), "{statistics:?} {rest}");
        }
    }
}
