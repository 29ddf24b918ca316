//! Noise that is slow and of which nobody states the size.

use fd_effect::{EverySite, library};
use fd_gap::diagnose::{Case, Diagnosis, Settings, Verdict, diagnose};
use fd_model::{Record, signal::ArNoise};
use fd_sim::{
    model::{Model, Output},
    patch::Patch,
    scales::ReplayScales,
};

use crate::diagnosis::bench_cases::{Reality, example, expr, record};

const SAMPLES: usize = 600;

/// The carriage with its speed measured as well.
fn carriage(noise: Option<f64>) -> Model {
    let mut draft = example("mass_spring_damper").into_draft();
    let speed = Output { noise, ..Output::new("speed", "m/s", expr("v")) };
    draft.outputs.push(speed);
    for output in &mut draft.outputs {
        output.noise = noise;
    }
    Model::try_from(draft).unwrap()
}

/// A log with noise of the position that wanders over a second, ten times stronger than what differences of
/// neighbours show, and with white noise of the speed.
fn wandering(truth: &Model, seed: u64) -> Record {
    with_noise(truth, 0.99, seed)
}

/// The same with noise of the position of this colour.
fn with_noise(truth: &Model, colour: f64, seed: u64) -> Record {
    let reality =
        Reality { samples: SAMPLES, amplitude: 10.0, parameter_error: 0.03, colour: 0.0, seed };
    let clean = record(truth, reality, seed);
    let slow = ArNoise::new(vec![colour], 0.005, seed + 50).values(SAMPLES).unwrap();
    let white = ArNoise::new(vec![], 0.01, seed + 80).values(SAMPLES).unwrap();
    let u = (0..SAMPLES).flat_map(|k| clean.u(k).to_vec()).collect();
    let y =
        (0..SAMPLES).flat_map(|k| [clean.y(k)[0] + slow[k], clean.y(k)[1] + white[k]]).collect();
    Record::new(clean.inputs().to_vec(), clean.outputs().to_vec(), u, y, clean.ts()).unwrap()
}

fn run(log: Record) -> Diagnosis {
    // Not a word about noise.
    let model = carriage(None);
    let u: Vec<f64> = (0..log.len()).flat_map(|k| log.u(k).to_vec()).collect();
    let scales = ReplayScales::of(&model, log.ts(), &u, log.len()).unwrap();
    let few = [
        "coulomb-friction",
        "input-dead-zone",
        "input-gain",
        "input-delay",
        "sensor-bias",
        "sensor-drift",
    ];
    let effects = library().into_iter().filter(|e| few.contains(&e.label())).collect();
    let suspects = EverySite::new(effects, &model, scales);
    let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
    diagnose(&case, &Settings::default(), &()).unwrap()
}

#[test]
fn it_is_no_gap() {
    for seed in 1..=10 {
        let diagnosis = run(wandering(&carriage(Some(1e-9)), seed));
        assert_eq!(diagnosis.verdict, Verdict::NoGap, "seed {seed}: {:?}", diagnosis.causes[0]);
    }
}

/// Whether an answer rests on it is said from twice on what neighbouring samples show: their differences show sqrt(1 - .9) of
/// noise with a correlation of .9, a third, and all of white noise.
#[test]
fn it_is_told_where_it_is_twice_what_neighbours_show() {
    for seed in 1..=5 {
        let told = |colour| run(with_noise(&carriage(Some(1e-9)), colour, seed)).slow_noise;
        assert_eq!(told(0.9), [true, false], "seed {seed}");
        assert_eq!(told(0.0), [false, false], "seed {seed}");
    }
}

#[test]
fn it_hides_no_effect_that_another_output_shows() {
    for seed in 1..=10 {
        let mut patch = Patch::of(&carriage(Some(1e-9)));
        patch.wrap_input("force", "applied", expr("force - clamp(force, -1, 1)")).unwrap();
        let diagnosis = run(wandering(&patch.finish().unwrap(), seed));
        let first = &diagnosis.causes[0];
        assert_eq!(
            (diagnosis.verdict, first.label),
            (Verdict::Cause, "input-dead-zone"),
            "seed {seed}"
        );
        let width = &first.parameters[0];
        assert!((width.value - 1.0).abs() < 4.0 * width.standard_error, "seed {seed}: {width:?}");
    }
}
