//! Findings about logs, and what noise is.

use fd_gap::quality::{Autoregression, Defect, inspect, noise_floor, third_difference_floor};
use fd_model::{
    Channel, Record,
    signal::{ArNoise, WhiteNoise},
};
use fd_sim::simulate::EquationSimulator;

use crate::diagnosis::bench_cases::{Reality, example, record};

const REALITY: Reality =
    Reality { samples: 1000, amplitude: 20.0, parameter_error: 0.02, colour: 0.0, seed: 4 };

fn problems(log: &Record, errors: Option<&[Vec<f64>]>) -> Vec<(String, Defect)> {
    let model = example("dc_drive");
    let simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let noise: Vec<_> = model.outputs.iter().map(|output| output.noise).collect();
    let found = inspect(log, &simulator, model.external_inputs().len(), &noise, errors, 1).unwrap();
    for finding in &found {
        println!("{finding}");
    }
    found.into_iter().map(|finding| (finding.channel, finding.defect)).collect()
}

fn rebuilt(log: &Record, change: impl Fn(usize, &[f64]) -> Vec<f64>) -> Record {
    let y = (0..log.len()).flat_map(|k| change(k, log.y(k))).collect();
    let u = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    Record::new(log.inputs().to_vec(), log.outputs().to_vec(), u, y, log.ts()).unwrap()
}

#[test]
fn a_good_log_has_no_findings() {
    for seed in 0..5 {
        let log = record(&example("dc_drive"), Reality { seed, ..REALITY }, seed);
        assert_eq!(problems(&log, None), vec![]);
    }
}

#[test]
fn faults_of_a_log_are_found() {
    let log = record(&example("dc_drive"), REALITY, 1);
    let single = |change: &dyn Fn(usize, &[f64]) -> Vec<f64>| {
        let mut found = problems(&rebuilt(&log, change), None);
        assert_eq!(found.len(), 1, "{found:?}");
        found.remove(0)
    };
    let (channel, problem) = single(&|_, y| vec![y[1], y[0]]);
    assert_eq!((channel.as_str(), problem), ("current", Defect::Swapped { with: "speed".into() }));
    let (channel, problem) = single(&|_, y| vec![y[0], 1e-3 * y[1]]);
    assert_eq!((channel.as_str(), problem), ("speed", Defect::WrongUnit { factor: 1000.0 }));
    let (_, problem) = single(&|_, y| vec![y[0].min(4.0), y[1]]);
    assert!(matches!(problem, Defect::Clipped { .. }), "{problem:?}");
    let (_, problem) = single(&|_, y| vec![(y[0] / 0.1).round() * 0.1, y[1]]);
    let Defect::Quantised { step } = problem else { panic!("{problem:?}") };
    // Rounding of multiples of 0.1 up to 20.
    assert!((step - 0.1).abs() < 1e-12);
    let (channel, problem) = single(&|_, y| vec![y[0], 7.0 + 0.0 * y[1]]);
    assert_eq!((channel.as_str(), problem), ("speed", Defect::Constant));
    let white = WhiteNoise::new(0.2, 3).values(1000).unwrap();
    let (channel, problem) = single(&|k, y| vec![y[0], white[k]]);
    assert_eq!((channel.as_str(), problem), ("speed", Defect::NotExcited));
    let (_, problem) = single(&|k, y| vec![y[0], if k % 10 == 0 { f64::NAN } else { y[1] }]);
    assert!(matches!(problem, Defect::Missing { .. }));
}

#[test]
fn errors_that_foretell_the_input_are_feedback() {
    let log = record(&example("dc_drive"), REALITY, 1);
    let noise = WhiteNoise::new(1.0, 5).values(1000).unwrap();
    assert_eq!(problems(&log, Some(&[noise.clone(), noise.clone()])), vec![]);
    // A controller outside: the input answers the error of the sample before.
    let mut u = vec![0.0];
    for k in 0..999 {
        u.push(0.5 * u[k] - noise[k]);
    }
    let y = (0..1000).flat_map(|k| log.y(k).to_vec()).collect();
    let inputs = vec![Channel::new("u", "V")];
    let closed = Record::new(inputs, log.outputs().to_vec(), u, y, log.ts()).unwrap();
    let found = problems(&closed, Some(&[noise.clone(), noise]));
    assert!(found.iter().any(|(_, problem)| matches!(problem, Defect::Feedback { .. })));
}

#[test]
fn noise_is_measured_under_a_slow_signal() {
    let n = 20_000;
    let white = WhiteNoise::new(0.3, 1).values(n).unwrap();
    let slow: Vec<f64> = (0..n).map(|k| 5.0 * (k as f64 * 0.01).sin() + white[k]).collect();
    let floor = third_difference_floor(&slow).unwrap();
    // The standard error of such a mean of squares is about 1.5/√n of it: 1 %.
    assert!((floor / 0.3 - 1.0).abs() < 0.03, "{floor}");
    // What autoregression foretells is not noise: the innovation of AR(0.95) is 0.31 of it, and
    // third differences, made for white noise on slow signals, show less still.
    let coloured = ArNoise::new(vec![0.95], 1.0, 2).values(n).unwrap();
    assert!(noise_floor(&coloured, None).unwrap() < 0.33);
}

#[test]
fn an_autoregression_is_found_and_whitened() {
    let truth = [1.2, -0.5];
    let signal = ArNoise::new(truth.to_vec(), 2.0, 8).values(20_000).unwrap();
    let (first, second) = signal.split_at(7000);
    let model = Autoregression::fit(&[first, second], 12);
    assert_eq!(model.order(), 2);
    // Variance left: (1 − k₁²)(1 − k₂²) with k₂ = −0.5, k₁ = 1.2/1.5.
    let g = f64::sqrt((1.0 - 0.64) * (1.0 - 0.25));
    assert!((model.innovation() / g - 1.0).abs() < 0.02);
    let unit: Vec<f64> = signal.iter().map(|v| v / 2.0).collect();
    let mut e = vec![0.0; unit.len()];
    model.whiten(&unit, &mut e);
    let n = e.len() as f64;
    let power = e.iter().map(|e| e * e).sum::<f64>() / n;
    let next = e.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / n;
    // Standard errors √(2/n) = 1 % and 1/√n = 0.7 %.
    assert!((power - 1.0).abs() < 0.04 && next.abs() < 0.03, "{power} {next}");
}
