//! A simulation with a named cause in it: its memory, wear that is followed, faults that are not.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::common::{normal, random, residuals};
use fd_core::{
    Frame, Snapshot,
    stage::{ResidualGenerator, Stage},
    testing::{memory, nonsense},
};
use fd_model::{Channel, ChannelScale, Record, SampleTime, Scaling};
use fd_nonlinear::{
    NonlinearError,
    patched::{Patched, PatchedDesign, Tracked, Tracking},
};
use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Simulator},
};

/// A heater that fouls (`k`), behind a valve that acts late; two temperatures.
const HEATER: &str = r#"
version = 1
kind = "equations"
name = "heater"
sample_time = 1.0
[parameters]
k = { unit = "1/s", value = 0.1, tolerance = 0.0, bounds = [0.01, 0.5] }
late = { unit = "s", value = 2.5, tolerance = 0.0 }
[inputs]
u = { unit = "1" }
[delays]
v = { value = "u", time = "late" }
[states]
T = { unit = "K", initial = 20.0, derivative = "20*k*v - k*(T - 20) + 0.002*(T - 20)*v" }
S = { unit = "K", initial = 20.0, derivative = "0.3*(T - S)" }
[outputs]
T_m = { unit = "K", value = "T" }
S_m = { unit = "K", value = "S" }
"#;
const NOISE: f64 = 0.05;

fn simulator(k: f64) -> EquationSimulator {
    let model: Model = HEATER.replace("value = 0.1", &format!("value = {k}")).parse().unwrap();
    EquationSimulator::new(&model).unwrap()
}

fn scaling() -> Scaling {
    Scaling {
        inputs: vec![ChannelScale::per_unit(0.5, 0.5)],
        outputs: vec![ChannelScale::per_unit(20.0, 10.0); 2],
    }
}

/// Inputs in the signals of the pipeline: levels of ±0.8 that change every 40 s.
fn inputs(samples: usize, seed: u64) -> Vec<Vec<f64>> {
    let mut random = random(seed);
    let mut level = 0.0;
    (0..samples)
        .map(|k| {
            if k % 40 == 0 {
                level = (0.5 * normal(&mut random)).clamp(-0.8, 0.8);
            }
            vec![level]
        })
        .collect()
}

/// A plant of which `k` goes from 0.1 to `last` in a straight line, with sensor noise.
fn plant(u: &[Vec<f64>], last: f64, seed: u64) -> Vec<Vec<f64>> {
    let mut random = random(seed);
    let n = u.len() as f64;
    let scaling = scaling();
    // The equations with the wear written out, as a function of the time.
    let worn = HEATER.replace(
        "T = { unit",
        "W = { unit = \"1\", initial = 0.0, derivative = \"1\" }\nT = { unit",
    );
    let worn = worn.replace("k*", &format!("(k + W*{})*", (last - 0.1) / n));
    let model: Model = worn.parse().unwrap();
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    simulator.start(&model.nominal(), &model.initial(), 0);
    let mut y = [0.0; 2];
    u.iter()
        .map(|u| {
            let physical = [scaling.inputs[0].physical(u[0])];
            Simulator::step(&mut simulator, &physical, &physical, &[], &mut y);
            y.iter().map(|y| (y + NOISE * normal(&mut random) - 20.0) / 10.0).collect()
        })
        .collect()
}

fn record(u: &[Vec<f64>], y: &[Vec<f64>]) -> Record {
    let rows = u.iter().zip(y).map(|(u, y)| (u.as_slice(), y.as_slice()));
    let (inputs, outputs) = (Channel::numbered("u", 1), Channel::numbered("y", 2));
    Record::from_rows(inputs, outputs, rows, SampleTime::new(1.0).unwrap()).unwrap()
}

fn design(drift: f64) -> PatchedDesign {
    let u = inputs(2000, 1);
    let healthy = record(&u, &plant(&u, 0.1, 2));
    let parameters = vec![Tracked { parameter: 0, drift }];
    let tracking = Tracking { parameters, suspicion: 1.5, memory: 10.0 };
    let design = PatchedDesign::new(Box::new(simulator(0.1)), scaling()).unwrap();
    design.tracking(&tracking, &[healthy], 50).unwrap()
}

fn step(generator: &mut Patched, u: &[f64], y: &[f64]) -> Vec<u64> {
    let mut r = [0.0; 2];
    generator.step(Frame::new(generator.io(), 0, u, y).unwrap(), &mut r);
    r.iter().map(|r| r.to_bits()).collect()
}

#[test]
fn memory_is_shown_whole_delays_included() {
    let u = inputs(200, 5);
    let y = plant(&u, 0.11, 6);
    let design = design(1e-5);
    let (mut one, mut twin) = (design.freeze(), design.freeze());
    memory(&mut one, &mut twin, 200, |generator, k| step(generator, &u[k], &y[k]));
    nonsense(&mut one, 100, |generator, k| step(generator, &u[k], &y[k]));
}

/// Over 6000 s the heater fouls by a tenth. Followed, the residual stays near that of a healthy plant.
#[test]
fn wear_is_followed() {
    let u = inputs(6000, 7);
    let y = plant(&u, 0.09, 8);
    let size = |design: &PatchedDesign| {
        let r = residuals(&mut design.freeze(), &u, &y);
        fd_numeric::rms(r[5000..].iter().map(|r| r[0]))
    };
    let fixed = PatchedDesign::new(Box::new(simulator(0.1)), scaling()).unwrap();
    let (without, with) = (size(&fixed), size(&design(3e-5)));
    // The noise alone is 0.005 in the signals of the pipeline; an estimate follows a ramp at a distance.
    assert!(with < 0.0075 && without > 2.0 * with, "{without} {with}");
    let mut followed = design(3e-5).freeze();
    residuals(&mut followed, &u, &y);
    let last = followed.tracked().next().unwrap();
    // The slope is that at 0.1: a tenth of the way is missed by a tenth of it, and a little by the ramp.
    assert!((last - 0.09).abs() < 0.002, "{last}");
}

/// A sensor that jumps, or creeps faster than wear may go, stays visible.
#[test]
fn a_fault_is_not_followed() {
    let u = inputs(3000, 9);
    let healthy = plant(&u, 0.1, 10);
    for rise in [1.0, 200.0] {
        let mut y = healthy.clone();
        for (k, y) in y.iter_mut().enumerate().skip(1000) {
            y[0] += 0.05 * (((k - 1000) as f64 + 1.0) / rise).min(1.0);
        }
        let mut generator = design(3e-5).freeze();
        let r = residuals(&mut generator, &u, &y);
        let mean = r[2000..].iter().map(|r| r[0]).sum::<f64>() / 1000.0;
        assert!(generator.is_frozen(), "suspected, rise {rise}");
        assert!(mean > 0.04, "{mean} of 0.05 is left, rise {rise}");
    }
}

#[test]
fn what_has_no_answer_is_said_and_survived() {
    // A heat that runs away from 1e300: the simulation has no answer from then on.
    let u = inputs(300, 11);
    let y = plant(&u, 0.1, 12);
    let mut wild = u.clone();
    wild[100][0] = 1e300;
    let mut generator = design(1e-5).freeze();
    let r = residuals(&mut generator, &wild, &y);
    assert!(r[100..110].iter().any(|r| r[0].is_nan()));
    assert!(r[250..].iter().all(|r| r[0].abs() < 0.1), "back after its own transient");
    Snapshot::of(&mut generator).restore(&mut generator).unwrap();
    generator.reset();
    assert_eq!(residuals(&mut generator, &u[..50], &y[..50]), r[..50]);
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let design = || PatchedDesign::new(Box::new(simulator(0.1)), scaling()).unwrap();
    let tracking = |parameter, drift, suspicion| Tracking {
        parameters: vec![Tracked { parameter, drift }],
        suspicion,
        memory: 10.0,
    };
    let u = inputs(30, 1);
    let short = [record(&u, &plant(&u, 0.1, 2))];
    for (tracking, setting) in [
        (tracking(7, 1e-5, 1.5), "tracked parameter"),
        (tracking(0, -1.0, 1.5), "drift of a tracked parameter"),
        (tracking(0, 1e-5, 0.5), "suspicion"),
    ] {
        let error = design().tracking(&tracking, &short, 0).unwrap_err();
        let NonlinearError::Setting { setting: found, .. } = error else { unreachable!("{error}") };
        assert_eq!(found, setting);
    }
    let error = design().tracking(&tracking(0, 1e-5, 1.5), &short, 0).unwrap_err();
    assert!(error.to_string().contains("at least: expected 50 values, found 30"), "{error}");
}
