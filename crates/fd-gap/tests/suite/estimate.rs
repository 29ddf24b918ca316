//! Calibration says what logs fix, what only together, and what not at all.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::float_cmp,
    reason = "tests panic to fail, and compare a value that nothing has moved"
)]

use fd_effect::Candidate;
use fd_gap::{
    diagnose::Case,
    estimate::{Standing, estimate},
    fit::Horizon,
};
use fd_model::{Channel, Record};
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Nothing is looked for.
const NONE: Vec<Candidate> = Vec::new();

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "lag"
sample_time = 0.1
[parameters]
a = { unit = "1", value = 1.0, tolerance = 0.3 }
b = { unit = "1", value = 1.0, tolerance = 0.3 }
T = { unit = "s", value = 1.0, tolerance = 0.3 }
idle = { unit = "1", value = 1.0, tolerance = 0.1 }
[inputs]
u = { unit = "V" }
[states]
x = { unit = "V", initial = 0.0, derivative = "(a*b*u - x)/T + 0*idle" }
[outputs]
y = { unit = "V", value = "x", noise = 0.01 }
"#;

/// A log of the plant with these parameters and white noise.
fn log(model: &Model, theta: &[f64], seed: u64) -> Record {
    let samples = 400;
    let ts = model.sample_time().unwrap();
    let u: Vec<f64> = (0..samples).map(|k| if k / 37 % 2 == 0 { 1.0 } else { -0.5 }).collect();
    let mut y = vec![0.0; samples];
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    simulator.simulate(theta, &[0.0], &u, &mut y);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    // A sum of twelve uniform numbers is as good as normal here.
    let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
    let y: Vec<f64> = y.iter().map(|y| y + 0.01 * normal()).collect();
    Record::new(vec![Channel::new("u", "V")], vec![Channel::new("y", "V")], u, y, ts).unwrap()
}

#[test]
fn what_logs_fix_and_what_they_do_not_is_told_apart() {
    let model: Model = MODEL.parse().unwrap();
    let mut far = 0;
    for seed in 0..20 {
        let logs = [log(&model, &[1.2, 1.1, 1.25, 1.0], seed)];
        let case = Case { nominal: &model, suspects: &NONE, logs: &logs, held_out: &[] };
        let found = estimate(&case, Horizon::FreeRun).unwrap();
        let standings: Vec<Standing> = found.parameters.iter().map(|p| p.standing).collect();
        let together = Standing::InCombination;
        assert_eq!(
            standings,
            [together, together, Standing::Found, Standing::Unmoved],
            "{found:?}"
        );
        let [a, b, lag, idle] = &found.parameters[..] else { panic!("{found:?}") };
        // Their product is what moves the output.
        assert!((a.value * b.value - 1.32).abs() < 0.01, "{} {}", a.value, b.value);
        assert_eq!(idle.value, 1.0);
        far += usize::from((lag.value - 1.25).abs() > 2.0 * lag.standard_error);
        assert!(found.correlations[0][1] < -0.99, "{:?}", found.correlations);
        let mut sizes: Vec<usize> = found.open.iter().map(|open| open.parts.len()).collect();
        sizes.sort_unstable();
        assert_eq!(sizes, [1, 2], "the idle one, and the two that make up for each other");
        assert!(found.left() < 1.2 && found.outputs[0].before > 5.0 * found.outputs[0].after);
    }
    // Of 20 values one is expected beyond two standard errors; four or more have probability .013.
    assert!(far <= 4, "{far}");
}

#[test]
fn a_parameter_that_wants_out_is_at_the_edge() {
    let model: Model = MODEL.parse().unwrap();
    let logs = [log(&model, &[1.0, 1.0, 2.5, 1.0], 1)];
    let case = Case { nominal: &model, suspects: &NONE, logs: &logs, held_out: &[] };
    let found = estimate(&case, Horizon::FreeRun).unwrap();
    assert_eq!(found.parameters[2].standing, Standing::AtEdge);
    assert!(found.left() > 2.0, "what is left says that it is not enough");
}
