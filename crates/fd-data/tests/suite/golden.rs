//! Against scikit-learn, numpy and scipy; `golden/golden.py` made the numbers.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use std::collections::HashMap;

use fd_data::{
    cva::{CvaDesign, States},
    monitor::{MonitorDesign, Statistics},
    pca::{Components, PcaDesign},
};
use fd_model::{Channel, Record, SampleTime};

fn log() -> Record {
    let (mut u, mut y) = (Vec::new(), Vec::new());
    for line in include_str!("../golden/log.csv").lines() {
        let row: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        u.push(row[0]);
        y.extend(&row[1..]);
    }
    let (inputs, outputs) = (Channel::numbered("u", 1), Channel::numbered("y", 3));
    Record::new(inputs, outputs, u, y, SampleTime::new(1.0).unwrap()).unwrap()
}

fn expected() -> HashMap<&'static str, Vec<f64>> {
    let line = |line: &'static str| {
        let mut cells = line.split(',');
        (cells.next().unwrap(), cells.map(|cell| cell.parse().unwrap()).collect())
    };
    include_str!("../golden/expected.csv").lines().map(line).collect()
}

/// Both sides round eigenvalues of order 1 in f64; small eigenvalues amplify that in T².
#[track_caller]
fn near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found} {expected}");
    }
}

fn first_20(design: &MonitorDesign, of: impl Fn(Statistics<f64>) -> f64) -> Vec<f64> {
    design.statistics(&log()).unwrap().into_iter().flatten().take(20).map(of).collect()
}

#[test]
fn principal_components_are_those_of_scikit_learn() {
    let expected = expected();
    for (name, lags, count) in [("pca", 0, 2), ("dpca", 2, 5)] {
        let components = Components::Count(count);
        let pca = PcaDesign { lags, components, ..PcaDesign::default() }.learn(&[log()]).unwrap();
        let of = |what: &str| &expected[format!("{name}.{what}").as_str()];
        near(pca.eigenvalues(), of("eigenvalues"));
        let monitor = pca.monitor();
        near(&first_20(monitor, |s| s.t2), of("t2"));
        near(&first_20(monitor, |s| s.q), of("q"));
        // Quantiles of F by iteration, to eight digits.
        let limits = monitor.limits();
        assert!((limits.t2 / of("t2_limit")[0] - 1.0).abs() < 1e-8, "{limits:?}");
        assert!((limits.q / of("q_limit")[0] - 1.0).abs() < 1e-8, "{limits:?}");
    }
}

#[test]
fn canonical_variates_are_those_of_numpy() {
    let expected = expected();
    let cva = CvaDesign { past: 3, future: 2, states: States::Count(2) }.learn(&[log()]).unwrap();
    near(cva.correlations(), &expected["cva.correlations"]);
    // Another algorithm altogether, iterated to six digits.
    assert!((cva.correlations()[0] - expected["cva.first_by_cca"][0]).abs() < 1e-6);
    // The reference leaves out the last window of the past, which has no future yet: the first 20 are the same.
    near(&first_20(cva.monitor(), |s| s.t2), &expected["cva.t2"]);
    near(&first_20(cva.monitor(), |s| s.rest.unwrap()), &expected["cva.rest"]);
}
