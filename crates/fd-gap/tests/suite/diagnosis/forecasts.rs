//! Horizons from the memory of a plant, memories across windows, and contests of forecasts.

use fd_effect::{Candidate, library, offers};
use fd_gap::{
    fit::{Horizon, Log, Variable},
    shrink::{
        Forecasts, Paths, Rules, Settled, dominant_time_constant, forecast_errors, gap, horizons,
    },
};
use fd_model::{Channel, Record, SampleTime};
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{EquationSimulator, Simulator},
};
use proptest::prelude::*;

/// A lag behind an actuator, sampled every 0.1 s.
fn lag() -> Model {
    lag_of("u", "x")
}

/// The same with something else that drives it, or that is measured.
fn lag_of(drive: &str, measured: &str) -> Model {
    format!(
        r#"
    version = 1
    kind = "equations"
    name = "lag"
    sample_time = 0.1
    parameters = {{ T = {{ unit = "s", value = 0.5, tolerance = 0.0 }} }}
    inputs = {{ u = {{ unit = "V" }} }}
    states = {{ x = {{ unit = "V", initial = 0.0, tolerance = 0.1, derivative = "({drive} - x)/T" }} }}
    outputs = {{ y = {{ unit = "V", value = "{measured}", noise = 0.001 }} }}
    "#
    )
    .parse()
    .unwrap()
}

/// Steps of many sizes, 1 s to 6 s apart.
fn input(samples: usize) -> Vec<f64> {
    let (mut level, mut left) = (0.0, 0);
    let value = |k: usize| {
        if left == 0 {
            left = 10 + 7 * k % 50;
            level = f64::from(u32::try_from(13 * k % 17).unwrap()) / 4.0 - 2.0;
        }
        left -= 1;
        level
    };
    (0..samples).map(value).collect()
}

fn record(u: &[f64], y: Vec<f64>) -> Record {
    let ts = SampleTime::new(0.1).unwrap();
    Record::new(vec![Channel::new("u", "V")], vec![Channel::new("y", "V")], u.to_vec(), y, ts)
        .unwrap()
}

/// The answer of a simulator to the input.
fn answer(simulator: &EquationSimulator, theta: &[f64], u: &[f64]) -> Record {
    let mut simulator = simulator.clone();
    let x0: Vec<f64> = Simulator::initial(&simulator).iter().map(|state| state.value).collect();
    let mut y = vec![0.0; u.len()];
    let _ = Simulator::simulate(&mut simulator, theta, &x0, u, &mut y);
    record(u, y)
}

/// Simulator and parameters of an effect of the library.
fn effect(model: &Model, u: &[f64], label: &str, values: &[f64]) -> (EquationSimulator, Known) {
    let scales = ReplayScales::of(model, model.sample_time().unwrap(), u, u.len()).unwrap();
    let mut all = offers(&library(), model, &scales).into_iter().flatten();
    let candidate: Candidate = all.find(|candidate| candidate.label == label).unwrap();
    let variable = |name: &str, value: f64| Variable {
        is_native: false,
        name: name.to_owned(),
        unit: String::new(),
        start: value,
        scale: 1.0,
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
        prior: None,
        in_another_run: fd_effect::InAnotherRun::Same,
    };
    let pairs = candidate.parameters.iter().zip(values);
    let known = pairs.map(|(p, value)| (variable(&p.name, *value), *value)).collect();
    (EquationSimulator::new(&candidate.model).unwrap(), known)
}

type Known = Vec<(Variable, f64)>;

fn theta(simulator: &EquationSimulator, known: &Known) -> Vec<f64> {
    let value = |p: &fd_sim::model::Parameter| {
        let known = known.iter().find(|(variable, _)| variable.name == p.name);
        known.map_or(p.value, |(_, value)| *value)
    };
    Simulator::parameters(simulator).iter().map(value).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// An oscillator with an integrator behind it forgets with 2/d; the integrator never does.
    #[test]
    fn the_slowest_decay_is_the_memory(d in 0.2..1.5_f64, k in 4.0..50.0_f64, gain in 0.01..100.0_f64) {
        let text = format!(r#"
        version = 1
        kind = "equations"
        name = "oscillator"
        sample_time = 0.05
        parameters = {{ d = {{ unit = "1/s", value = 100.0 }} }}
        inputs = {{ u = {{ unit = "m/s^2" }} }}
        outputs = {{ y = {{ unit = "m", value = "x" }} }}
        [states]
        x = {{ unit = "m", initial = 0.0, derivative = "v" }}
        v = {{ unit = "m/s", initial = 0.0, derivative = "u - d*v - {k}*x" }}
        total = {{ unit = "m s", initial = 0.0, derivative = "{gain}*x" }}
        "#);
        let model: Model = text.parse().unwrap();
        let simulator = EquationSimulator::new(&model).unwrap();
        let (u, ts) = (input(300), SampleTime::new(0.05).unwrap());
        let channels = (vec![Channel::new("u", "m/s^2")], vec![Channel::new("y", "m")]);
        let record = Record::new(channels.0, channels.1, u, vec![0.0; 300], ts).unwrap();
        let log = Log::new(&record, &simulator, 1).unwrap();
        // Refitted, not nominal.
        let found = dominant_time_constant(&simulator, &[d], &[0.0; 3], &log).unwrap();
        let expected = 2.0 / d / 0.05;
        // Runge-Kutta with steps of 0.3 of the fastest time, at d = 100, and differences.
        prop_assert!((found / expected - 1.0).abs() < 1e-3, "{} {}", found, expected);
    }

    #[test]
    fn horizons_grow_and_end_with_the_free_run(
        time in proptest::option::of(0.1..1e5_f64), states in 0_usize..8, samples in 1_usize..5000
    ) {
        let all = horizons(time, states, samples);
        let length = |h: &Horizon| match h {
            Horizon::Windows { samples } => *samples,
            Horizon::FreeRun => usize::MAX,
        };
        prop_assert_eq!(all.last(), Some(&Horizon::FreeRun));
        prop_assert!(all.windows(2).all(|pair| length(&pair[0]) < length(&pair[1])));
        prop_assert!(all.iter().all(|h| length(h) == usize::MAX || 2 * length(h) <= samples));
        prop_assert!(all.iter().all(|h| 4 * states <= length(h) && 8 <= length(h)));
    }
}

#[test]
fn what_never_forgets_has_no_time_constant() {
    let model: Model = lag().to_string().replace("(u - x)/T", "u/T").parse().unwrap();
    let simulator = EquationSimulator::new(&model).unwrap();
    let log = Log::new(&record(&input(100), vec![0.0; 100]), &simulator, 1).unwrap();
    assert_eq!(dominant_time_constant(&simulator, &[0.5], &[0.0], &log), None);
}

/// In the middle of a ramp, a rate limit that is started afresh would be at the wrong place.
#[test]
fn windows_know_what_the_inputs_before_them_have_left() {
    let (model, u) = (lag(), input(600));
    let nominal = EquationSimulator::new(&model).unwrap();
    // One second per volt: ramps of up to 4 s, longer than half a window.
    let (limited, known) = effect(&model, &u, "input-rate-limit", &[1.0]);
    let record = answer(&limited, &theta(&limited, &known), &u);
    let logs = [Log::new(&record, &nominal, 1).unwrap()];
    let horizon = Horizon::Windows { samples: 20 };
    let left = |simulator: &dyn Simulator, effects: &Known| {
        let settled = Settled { simulator, nuisances: &[], effects, paths: Paths::AsFitted };
        gap(&forecast_errors(&nominal, settled, &logs, horizon, &[0.001]).unwrap().unwrap())
    };
    let (with, without) = (left(&limited, &known), left(&nominal, &vec![]));
    // The states are settled up to 1e-4 of squares that begin at some 1e3 sigma.
    assert!(with < 1.0, "{with}");
    assert!(100.0 < without, "{without}");
}

#[test]
fn the_truth_wins() {
    let (model, u) = (lag(), input(900));
    let nominal = EquationSimulator::new(&model).unwrap();
    let (limited, known) = effect(&model, &u, "input-rate-limit", &[1.0]);
    let (late, lateness) = effect(&model, &u, "input-lag", &[0.8]);
    let record = answer(&limited, &theta(&limited, &known), &u);
    let logs = [Log::new(&record, &nominal, 1).unwrap()];
    let settled =
        |simulator, effects| Settled { simulator, nuisances: &[], effects, paths: Paths::AsFitted };
    let all = [
        settled(&nominal as &dyn Simulator, &[][..]),
        settled(&limited, &known),
        settled(&late, &lateness),
        settled(&limited, &known),
    ];
    let horizons = horizons(Some(5.0), 1, 900);
    let rules = Rules { floor: 1.0, replicas: 200, seed: 1 };
    let forecasts = Forecasts::of(&nominal, &all, &[&logs], &horizons, &[0.001]).unwrap();
    let outcome = forecasts.contest(&rules);
    // Equals share.
    assert_eq!(outcome.wins, [0.0, 0.5, 0.0, 0.5]);
    for closed in &outcome.closed[1] {
        assert!(0.99 < closed.unwrap().interval[0], "{closed:?}");
    }
}

#[test]
fn a_law_is_judged_by_what_all_others_leave() {
    let u = input(900);
    let [nominal, offset, bias, both] =
        [["u", "x"], ["u + 0.3", "x"], ["u", "x + 0.2"], ["u + 0.3", "x + 0.2"]]
            .map(|[drive, measured]| EquationSimulator::new(&lag_of(drive, measured)).unwrap());
    let record = answer(&both, &[0.5], &u);
    let logs = [Log::new(&record, &nominal, 1).unwrap()];
    let rules = Rules { floor: 1.0, replicas: 200, seed: 1 };
    let forecasts = |all: [&EquationSimulator; 3]| {
        let all = all.map(|simulator| Settled {
            simulator,
            nuisances: &[],
            effects: &[],
            paths: Paths::AsFitted,
        });
        Forecasts::of(&nominal, &all, &[&logs], &[Horizon::FreeRun], &[0.001]).unwrap()
    };
    let first = forecasts([&nominal, &offset, &bias]);
    let share = |forecasts: &Forecasts| forecasts.contest(&rules).closed[1][0].unwrap().fraction;
    // Of 0.5 V, one sigma being 1 mV, all but the noise that is not there.
    assert!((share(&first) - 0.3 / 0.499).abs() < 1e-3, "{}", share(&first));
    // Of 0.3 V, with the bias there.
    let second = forecasts([&offset, &both, &offset]);
    let beside = first.beside(1, &second, 1);
    assert!((share(&beside) - 0.3 / 0.299).abs() < 1e-3, "{}", share(&beside));
    assert_eq!(beside.contest(&rules).wins, [0.0, 1.0, 0.0]);
}
