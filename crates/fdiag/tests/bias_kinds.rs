//! Every structure and every way of learning a bias is a line of a spec away, and works.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests may stop at the first surprise and say what they measured"
)]

mod support;

use fdiag::{
    core::{Event, EventKind, Snapshot},
    model::Record,
    spec::PipelineSpec,
    training::{Healthy, Trace, Trained, TrainingError, train},
};
use support::{SPEC, calibration, eventful, input, nominal, plant, run, training};

const LEARNING: [&str; 16] = [
    r#"{ kind = "batch" }"#,
    r#"{ kind = "batch", prefilter_rad_s = 4.0 }"#,
    r#"{ kind = "instrumental" }"#,
    r#"{ kind = "instrumental", instruments = { kind = "simulated", rounds = 2 } }"#,
    r#"{ kind = "instrumental", instruments = { kind = "delayed-inputs" } }"#,
    r#"{ kind = "instrumental", instruments = { kind = "delayed-outputs", lag = 2 } }"#,
    r#"{ kind = "refined-instrumental" }"#,
    r#"{ kind = "extended", nc = 2 }"#,
    r#"{ kind = "armax", nc = 2 }"#,
    r#"{ kind = "output-error" }"#,
    r#"{ kind = "output-error", from_rest = true }"#,
    r#"{ kind = "box-jenkins", nc = 1, nd = 1 }"#,
    r#"{ kind = "recursive", prior_variance = 1e6 }"#,
    r#"{ kind = "random-walk", prior_variance = 1e6, drift = { kind = "uniform", variance = 1e-9 } }"#,
    r#"{ kind = "recursive-extended", nc = 2, rls = { prior_variance = 1e6 } }"#,
    r#"{ kind = "recursive-instrumental", prior_variance = 1e6, warm_up = 300 }"#,
];

const STRUCTURE: [&str; 5] = [
    r#"{ kind = "linear" }"#,
    r#"{ kind = "hammerstein", basis = { kind = "polynomial", degree = 2 } }"#,
    r#"{ kind = "hammerstein", basis = { kind = "piecewise-linear", segments = 3 } }"#,
    r#"{ kind = "scheduled", time_constant_s = 4.0, regions = 2 }"#,
    r#"{ kind = "state-space", states = 3, horizon = 6 }"#,
];

fn spec(structure: &str, learning: &str) -> PipelineSpec {
    let lines = SPEC
        .lines()
        .map(|line| match line {
            _ if line.starts_with("learning") => {
                format!("learning = {learning}\nstructure = {structure}")
            }
            _ => line.to_owned(),
        })
        .collect::<Vec<_>>()
        .join("\n");
    let spec: PipelineSpec = toml::from_str(&lines).unwrap();
    let again: PipelineSpec = toml::from_str(&toml::to_string(&spec).unwrap()).unwrap();
    assert_eq!(again, spec);
    spec
}

fn trained(structure: &str, learning: &str, log: &Record) -> Result<Trained, TrainingError> {
    let calibration = calibration();
    let healthy = [Healthy::learn(log), Healthy::calibrate(&calibration)];
    train(&spec(structure, learning), &nominal(), &healthy)
}

/// Healthy maxima at least three times smaller, and a restored pipeline that goes on to the bit.
fn assert_works(structure: &str, learning: &str, log: &Record, run: &Record) {
    let name = format!("{structure} {learning}");
    let trained =
        trained(structure, learning, log).unwrap_or_else(|error| panic!("{name}: {error}"));
    let (primary, compensated) = trained.fault_free_maxima();
    println!("{name}: {primary:.5} to {compensated:.5}, {}", trained.bias_model().orders());
    assert!(3.0 * compensated < primary, "{name}: {primary} to {compensated}");

    let mut pipeline = trained.compensated().unwrap();
    Trace::of(&mut pipeline, &run.slice(0, 900)).unwrap();
    let saved = Snapshot::of(&mut pipeline);
    let later = run.slice(900, 1500);
    let first = Trace::of(&mut pipeline, &later).unwrap();
    saved.restore(&mut pipeline).unwrap();
    let second = Trace::of(&mut pipeline, &later).unwrap();
    let bits = |trace: &Trace| trace.compensated.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&first), bits(&second), "{name}");
}

#[test]
fn every_way_of_learning_compensates_a_linear_bias() {
    let (log, run) = (training(), eventful());
    for learning in LEARNING {
        assert_works(STRUCTURE[0], learning, &log, &run);
    }
}

#[test]
fn every_structure_compensates_a_linear_bias() {
    let (log, run) = (training(), eventful());
    for structure in STRUCTURE {
        for learning in [LEARNING[9], LEARNING[12]] {
            assert_works(structure, learning, &log, &run);
        }
    }
}

#[test]
fn what_does_not_go_together_is_refused_by_name() {
    let log = training();
    for learning in [LEARNING[14], LEARNING[15]] {
        let error = trained(STRUCTURE[3], learning, &log).unwrap_err();
        assert!(
            matches!(error, TrainingError::NotTogether { structure: "scheduled", .. }),
            "{error}"
        );
    }
    let unknown = SPEC.replace("kind = \"recursive\"", "kind = \"magic\"");
    let error = toml::from_str::<PipelineSpec>(&unknown).unwrap_err().to_string();
    assert!(error.contains("box-jenkins") && error.contains("recursive-instrumental"), "{error}");
}

/// There and back again: with one equation, coming back means training a third time; with local
/// equations what was learned at home is still known.
#[test]
fn a_scheduled_bias_remembers_where_it_has_been() {
    let mut u = input(6000, 7);
    u[600..4600].iter_mut().for_each(|v| *v += 2.0);
    let travels = run(&plant(), &u, 1e-4, 3);
    let left = |structure: &str| {
        let mut pipeline =
            trained(structure, LEARNING[12], &training()).unwrap().compensated().unwrap();
        let trace = Trace::of(&mut pipeline, &travels).unwrap();
        let left = |event: &&Event| event.kind == EventKind::OperatingPointLeft;
        let rms = |values: &[f64]| {
            let last = &values[values.len() - 1000..];
            (last.iter().map(|v| v * v).sum::<f64>() / 1000.0).sqrt()
        };
        let share = rms(&trace.compensated) / rms(&trace.residual);
        println!("{structure}: {:?}, {share:.3} left", trace.events);
        (trace.events.iter().filter(left).count(), share)
    };
    let (times, _) = left(STRUCTURE[0]);
    assert_eq!(times, 2);
    let scheduled = r#"{ kind = "scheduled", time_constant_s = 2.0, centres = [0.0, 2.0] }"#;
    let (times, share) = left(scheduled);
    assert_eq!(times, 1);
    assert!(share < 0.2, "{share}");
}
