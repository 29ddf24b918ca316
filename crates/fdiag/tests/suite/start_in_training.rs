//! A spec that starts in training, and follows a plant that changes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::{SPEC, input, nominal, plant, run};
use fdiag::{
    core::{Event, EventKind},
    model::{
        Record,
        fault::{FaultProfile, FaultSpec, Site},
    },
    spec::{PipelineSpec, StartSpec},
    training::{Healthy, Trace, Trained, TrainingError, train},
};

use EventKind::{CharacteristicsChanged, Frozen, TrainingStarted};

fn spec() -> PipelineSpec {
    // Keys of the top level come first.
    let text = format!("start = \"training\"\n{SPEC}");
    let text = text.replace(
        "operating_point = { policy = { kind = \"retrain\" } }",
        "operating_point = { policy = { kind = \"ignore\" } }
         convergence = { tolerance = 1e-2 }
         plant_change = { policy = \"retrain\", window = 200 }",
    );
    text.parse().unwrap()
}

fn healthy(samples: usize, variant: u32) -> Record {
    run(&plant(), &input(samples, variant), 1e-3, u64::from(variant))
}

fn trained(spec: &PipelineSpec) -> Trained {
    let (one, other) = (healthy(2500, 1), healthy(2500, 2));
    train(spec, &nominal(), &[Healthy::learn(&one), Healthy::calibrate(&other)]).unwrap()
}

fn when(events: &[Event], kind: EventKind) -> Vec<usize> {
    let at = events.iter().filter(|e| e.kind == kind);
    at.map(|e| usize::try_from(e.k).unwrap()).collect()
}

#[test]
fn it_learns_first_and_judges_then() {
    let trained = trained(&spec());
    let mut log = healthy(2500, 3);
    let drift = FaultProfile::incipient(0.05, 5.0);
    FaultSpec::add(Site::sensor(0), 180.0, drift).apply_to_record(&mut log).unwrap();
    let trace = Trace::of(&mut trained.compensated().unwrap(), &log).unwrap();
    assert_eq!(when(&trace.events, TrainingStarted), [0]);
    let [open] = when(&trace.events, Frozen)[..] else { panic!("{:?}", trace.events) };
    assert!((249..1500).contains(&open), "{open}");
    assert!(trace.compensating.iter().enumerate().all(|(k, &on)| on == (k > open)));
    // The fault begins at sample 1800 and is no change of the plant.
    let alarm = trace.first_alarm(0);
    assert!(alarm.is_some_and(|k| (1800..1900).contains(&k)), "{alarm:?}");
    assert_eq!(when(&trace.events, CharacteristicsChanged), [0_usize; 0]);
    // What is subtracted is the bias: less than half is left (2.6 times less in this run), the rest is noise.
    let peak = |v: &[f64]| v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let open = open + 1..1800;
    assert!(2.0 * peak(&trace.compensated[open.clone()]) < peak(&trace.residual[open]));
    // Whatever the spec says, that is what `learning` does.
    let fitted = PipelineSpec { start: StartSpec::Fitted, ..spec() };
    let mut other = self::trained(&fitted).learning().unwrap();
    assert_eq!(Trace::of(&mut other, &log).unwrap().events[..2], trace.events[..2]);
}

/// The generator starts from rest and the plant does not: five time constants are not learned from.
#[test]
fn it_waits_until_the_generator_has_settled() {
    let spec = PipelineSpec { settle_s: None, ..spec() };
    let trained = trained(&spec);
    let trace = Trace::of(&mut trained.compensated().unwrap(), &healthy(2500, 4)).unwrap();
    // A rate of 2 /s: 2.5 s are 25 samples, or 26 as the pole is rounded, and two for the memory of the bias.
    let started = when(&trace.events, TrainingStarted);
    assert!(started == [27] || started == [28], "{started:?}");
}

#[test]
fn a_plant_that_changes_is_learned_again_from_a_spec() {
    let trained = trained(&spec());
    let mut log = healthy(5000, 5);
    // A sensor that reads 40 % too much acts through the inputs, as the bias does.
    for k in 2500..log.len() {
        log.y_mut(k)[0] *= 1.4;
    }
    let trace = Trace::of(&mut trained.compensated().unwrap(), &log).unwrap();
    let changed = when(&trace.events, CharacteristicsChanged);
    assert!(changed.first().is_some_and(|&k| (2500..3200).contains(&k)), "{:?}", trace.events);
    assert!(when(&trace.events, Frozen).len() >= 2, "{:?}", trace.events);
}

#[test]
fn healthy_logs_that_are_too_short_to_open_the_switch_are_refused() {
    let (one, other) = (healthy(2500, 1), healthy(150, 2));
    let logs = [Healthy::learn(&one), Healthy::calibrate(&other)];
    let error = train(&spec(), &nominal(), &logs).unwrap_err();
    assert_eq!(error, TrainingError::NeverOpened { samples: 150 });
    assert!(error.to_string().contains("compensation.convergence"), "{error}");
}

#[test]
fn an_unknown_start_is_refused_with_the_known_ones() {
    let error = "start = \"asleep\"".parse::<PipelineSpec>().unwrap_err().to_string();
    assert!(error.contains("fitted") && error.contains("training"), "{error}");
}
