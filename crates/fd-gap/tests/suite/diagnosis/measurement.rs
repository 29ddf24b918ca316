//! Effects of the measurement, and gaps that nothing in the library explains.

use fd_effect::{EverySite, library};
use fd_gap::{
    diagnose::{Case, Diagnosis, Settings, Verdict, diagnose},
    quality::Defect,
};
use fd_model::{Record, signal::WhiteNoise};
use fd_sim::{model::Model, patch::Patch, scales::ReplayScales};

use crate::diagnosis::bench_cases::{Reality, example, expr, record};

const FEW: [&str; 6] = [
    "coulomb-friction",
    "sensor-bias",
    "input-gain",
    "sensor-outliers",
    "sensor-noise",
    "sensor-jitter",
];

fn run(log: Record) -> Diagnosis {
    run_of(&example("mass_spring_damper"), log)
}

fn run_of(model: &Model, log: Record) -> Diagnosis {
    let u: Vec<f64> = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let scales = ReplayScales::of(model, log.ts(), &u, log.len()).unwrap();
    let effects = library().into_iter().filter(|e| FEW.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, model, scales);
    let case = Case { nominal: model, suspects: &suspects, logs: &[log], held_out: &[] };
    diagnose(&case, &Settings::default(), &()).unwrap()
}

fn log(truth: &Model) -> Record {
    coloured_log(truth, 0.0)
}

fn coloured_log(truth: &Model, colour: f64) -> Record {
    let reality =
        Reality { samples: 600, amplitude: 10.0, parameter_error: 0.03, colour, seed: 12 };
    record(truth, reality, 1)
}

fn measured(log: &Record, change: impl Fn(usize, f64) -> f64) -> Record {
    let u = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let y = (0..log.len()).map(|k| change(k, log.y(k)[0])).collect();
    Record::new(log.inputs().to_vec(), log.outputs().to_vec(), u, y, log.ts()).unwrap()
}

/// The noise of the model is 0.5 mm.
#[test]
fn effects_of_the_measurement_are_named() {
    let clean = log(&example("mass_spring_damper"));
    let extra = WhiteNoise::new(0.001, 5).values(600).unwrap();
    let cases: [(&str, f64, Record); 2] = [
        ("sensor-noise", 0.001, measured(&clean, |k, y| y + extra[k])),
        (
            "sensor-outliers",
            0.02,
            measured(
                &clean,
                |k, y| if k % 50 == 7 { y + 0.02 * f64::from(k % 3 == 0) - 0.01 } else { y },
            ),
        ),
    ];
    for (label, value, log) in cases {
        let diagnosis = run(log);
        let first = &diagnosis.causes[0];
        assert_eq!((diagnosis.verdict, first.label), (Verdict::Cause, label));
        let estimate = &first.parameters[0];
        let tolerance = 4.0 * estimate.standard_error + 1e-9;
        assert!((estimate.value - value).abs() < tolerance, "{label}: {estimate:?}");
    }
    let diagnosis = run(clean);
    assert_eq!(diagnosis.verdict, Verdict::NoGap);
    assert_eq!(diagnosis.steps, [None]);
}

/// Neither hides in slow noise: a wrong sample has neighbours that are right, and what is white does not
/// go on to the next sample.
#[test]
fn effects_of_the_measurement_are_named_in_slow_noise() {
    let slow = coloured_log(&example("mass_spring_damper"), 0.8);
    let extra = WhiteNoise::new(0.001, 5).values(600).unwrap();
    let wrong = |k: usize| if k % 60 == 7 { 0.01 } else { 0.0 };
    let cases = [
        ("sensor-noise", measured(&slow, |k, y| y + extra[k])),
        (
            "sensor-outliers",
            measured(&slow, |k, y| y + wrong(k) * if k % 24 == 7 { -1.0 } else { 1.0 }),
        ),
    ];
    for (label, log) in cases {
        let diagnosis = run(log);
        let first = &diagnosis.causes[0];
        assert_eq!((diagnosis.verdict, first.label), (Verdict::Cause, label));
    }
    assert_eq!(run(slow).verdict, Verdict::NoGap);
}

/// Twelve times the noise, and yet the motion hides it from its neighbours: what is wrong once is named with its row.
#[test]
fn a_single_wrong_sample_is_no_property_of_the_sensor() {
    let clean = log(&example("mass_spring_damper"));
    let diagnosis = run(measured(&clean, |k, y| if k == 300 { y + 0.006 } else { y }));
    assert_eq!(diagnosis.verdict, Verdict::NoGap, "{:?}", diagnosis.causes[0]);
    let wrong = diagnosis.findings.iter().find_map(|finding| match finding.defect {
        Defect::WrongSample { row, .. } => Some((finding.log, finding.channel.as_str(), row)),
        _ => None,
    });
    assert_eq!(wrong, Some((1, "position", 300)));
}

/// A log of which the samples were taken a little early or late.
fn jittered(log: &Record, deviation: f64) -> Record {
    let off = WhiteNoise::new(deviation, 9).values(log.len()).unwrap();
    let y: Vec<f64> = (0..log.len()).map(|k| log.y(k)[0]).collect();
    let slope = |k: usize| {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(y.len() - 1));
        (y[after] - y[before]) / (0.01 * (after - before) as f64)
    };
    measured(log, |k, y| y + off[k] * slope(k))
}

/// The faster the carriage moves, the more a clock that is 3 ms off is wrong; noise of one size has heavy tails then.
/// Slow noise does not hide it: what a clock does is gone with the next sample.
#[test]
fn a_clock_that_jitters_is_no_noise_of_the_sensor() {
    for colour in [0.0, 0.8] {
        let log = coloured_log(&example("mass_spring_damper"), colour);
        let diagnosis = run(jittered(&log, 0.003));
        let first = &diagnosis.causes[0];
        assert_eq!((diagnosis.verdict, first.label), (Verdict::Cause, "sensor-jitter"), "{colour}");
        let jitter = &first.parameters[0];
        // The standard deviation of 600 numbers is known to 1/√1200, and the grid of jitters is as coarse as 15 %.
        assert!((jitter.value - 0.003).abs() < 5e-4, "{jitter:?}");
    }
}

/// Steps of eight times the noise: a staircase that nothing has to draw, with or without a cause beside it.
#[test]
fn rounding_is_no_gap_and_hides_no_cause() {
    let model = example("mass_spring_damper");
    let step = 0.004;
    let rounded = |log: &Record| measured(log, |_, y| step * (y / step).round());
    let nothing = run(rounded(&log(&model)));
    assert_eq!(nothing.verdict, Verdict::NoGap);
    assert!(
        matches!(nothing.steps[..], [Some(found)] if (found - step).abs() < 1e-12),
        "{nothing:?}"
    );
    let mut friction = Patch::of(&model);
    friction.add_force("carriage", "rail", expr("-0.4*sign(v)")).unwrap();
    let named = run(rounded(&log(&friction.finish().unwrap())));
    assert_eq!((named.verdict, named.causes[0].label), (Verdict::Cause, "coulomb-friction"));
}

/// A sensor that is wrong by accident is wrong now and then, not ten times in a row.
#[test]
fn wrong_samples_in_bursts_are_none_of_these() {
    let clean = log(&example("mass_spring_damper"));
    let sign = |k: usize| if k.is_multiple_of(3) { -1.0 } else { 1.0 };
    let bursts = measured(&clean, |k, y| if k % 120 < 10 { y + 0.01 * sign(k) } else { y });
    let diagnosis = run(bursts);
    assert_eq!(diagnosis.verdict, Verdict::NoneOfThese, "{:?}", diagnosis.causes[0]);
}

/// All errors from one distribution with heavy tails are no outliers among good ones.
#[test]
fn heavy_tails_are_told_from_outliers() {
    let clean = log(&example("mass_spring_damper"));
    let normal = WhiteNoise::new(1.0, 6).values(4 * 600).unwrap();
    // Student's distribution with three degrees of freedom.
    let heavy = |k: usize| {
        let [z, rest @ ..] = [0, 1, 2, 3].map(|i| normal[4 * k + i]);
        z / (rest.iter().map(|z| z * z).sum::<f64>() / 3.0).sqrt()
    };
    let diagnosis = run(measured(&clean, |k, y| y + 0.001 * heavy(k)));
    let first = &diagnosis.causes[0];
    assert_eq!(diagnosis.verdict, Verdict::Cause);
    assert_eq!((first.label, first.law), ("sensor-noise", "heavy-tailed"));
    let freedom = &first.parameters[1];
    assert!(freedom.value < 6.0, "{freedom:?}");
}

#[test]
fn a_cause_that_the_library_lacks_is_none_of_these() {
    let mut patch = Patch::of(&example("mass_spring_damper"));
    let force = expr("0.5*sin(2*pi*1.7*t) + 0.4*sin(2*pi*0.45*t)");
    patch.add_force("carriage", "shaking", force).unwrap();
    let diagnosis = run(log(&patch.finish().unwrap()));
    assert_eq!(diagnosis.verdict, Verdict::NoneOfThese);
    assert!(0.9 < diagnosis.none_of_these && diagnosis.is_unexplained);
}

/// A large and a small cause in a lag of a second, and one sample of twelve with five times the noise, which counts for more than the
/// small one: what explains most are three, of which
/// an answer names two at most.
#[test]
fn two_causes_are_named_beside_noise_of_heavy_tails() {
    let lag: Model = r#"
        version = 1
        kind = "equations"
        name = "lag"
        sample_time = 0.1
        inputs = { u = { unit = "V" } }
        outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
        states = { x = { unit = "V", initial = 0.0, derivative = "u - x" } }
    "#
    .parse()
    .unwrap();
    let noise = WhiteNoise::new(0.01, 3).values(600).unwrap();
    let ts = lag.sample_time().unwrap();
    let (mut x, mut rows) = (0.0, Vec::new());
    for (k, noise) in (0_u32..).zip(noise) {
        let t = f64::from(k);
        let u = (0.05 * t).sin() + 0.5 * (0.23 * t).sin() + 0.3;
        rows.push(([u], [x + 0.004 + if k % 12 == 7 { 5.0 * noise } else { noise }]));
        x = 0.95 * u + (-0.1_f64).exp() * (x - 0.95 * u);
    }
    let log = Record::from_rows(lag.external_inputs(), lag.output_channels(), rows, ts).unwrap();
    let found = run_of(&lag, log);
    assert_eq!(found.verdict, Verdict::Pair);
    let mut labels = found.pairs[0].causes.each_ref().map(|cause| cause.label);
    labels.sort_unstable();
    assert_eq!(labels, ["input-gain", "sensor-bias"]);
}
