//! What five states keep of seventeen: the step errors that the specification prints.

#![allow(clippy::unwrap_used, reason = "tests stop at the first broken fixture")]

use fd_core::{Heap, stage::Plant};
use fd_jetengine::engine17::{Engine17, MEASURED, Parameters};
use fd_model::{Continuous, SampleTime, StateSpace, reduce};

/// Samples of 5 ms in 15 s; errors count from 50 ms on.
const SAMPLES: usize = 3000;
const FIRST: usize = 10;

/// Outputs after a unit step of the fuel, sampled exactly.
fn step_response(model: &StateSpace<Continuous>) -> Vec<[f64; 5]> {
    let plant = model.sample_zoh(SampleTime::new(0.005).unwrap()).unwrap();
    let plant = plant.freeze::<f64, Heap>().unwrap();
    let mut x = vec![0.0; model.nx()];
    let mut next = x.clone();
    (0..SAMPLES)
        .map(|_| {
            let mut y = [0.0; 5];
            plant.output(&x, &[1.0], &mut y);
            plant.advance(&x, &[1.0], &mut next);
            std::mem::swap(&mut x, &mut next);
            y
        })
        .collect()
}

/// Largest errors of the unit-step response in percent of its peak, per output, at the reference
/// point, within half a unit of the last printed digit.
#[test]
fn step_errors_of_fifth_order_models() {
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    let full = engine.linearise(&engine.trim(0.712).unwrap()).unwrap().per_unit().unwrap().model;
    let exact = step_response(&full);
    let percent = |reduced: &StateSpace<Continuous>| -> [f64; 5] {
        let response = step_response(reduced);
        std::array::from_fn(|i| {
            let peak = exact.iter().map(|y| y[i].abs()).fold(0.0, f64::max);
            let errors = exact.iter().zip(&response).skip(FIRST).map(|(a, b)| (a[i] - b[i]).abs());
            100.0 * errors.fold(0.0, f64::max) / peak
        })
    };
    for (name, reduced, want) in [
        (
            "balanced truncation",
            reduce::balanced_truncation(&full, 5).unwrap().model,
            [(3.7, 1), (22.0, 0), (3.0, 1), (2.5, 1), (7.3, 1)],
        ),
        (
            "balanced residualisation",
            reduce::balanced_residualisation(&full, 5).unwrap().model,
            [(5.3, 1), (6.6, 1), (1.6, 1), (3.9, 1), (6.9, 1)],
        ),
        (
            "residualisation onto the measured states",
            reduce::residualise_onto(&full, &MEASURED).unwrap(),
            [(3.1, 1), (1.3, 1), (8.1, 1), (7.4, 1), (9.7, 1)],
        ),
    ] {
        let got = percent(&reduced);
        println!("{name}: {got:.2?}");
        for (got, (want, digits)) in got.iter().zip(want) {
            let half_unit = 0.5 * 10.0_f64.powi(-digits);
            assert!((got - want).abs() <= 1.02 * half_unit, "{name}: {got} {want}");
        }
    }
}
