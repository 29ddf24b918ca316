//! Every structure and every way of learning a bias is a line of a spec away, and works.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "helpers of tests may stop at the first surprise and say what they measured"
)]

use crate::support::{SPEC, calibration, eventful, input, nominal, plant, run, training};
use fdiag::{
    core::{Event, EventKind, Snapshot},
    model::Record,
    spec::{
        LearningSpec, PipelineSpec, StructureSpec,
        testing::{every_learning, every_structure, kinds},
    },
    training::{Healthy, Trace, Trained, TrainingError, train},
};

const LINEAR: &str = r#"kind = "linear""#;
const SCHEDULED: &str = r#"kind = "scheduled", time_constant_s = 4.0, regions = 2"#;
const OUTPUT_ERROR: &str = r#"kind = "output-error""#;
const RECURSIVE: &str = r#"kind = "recursive", prior_variance = 1e6"#;
const RECURSIVE_EXTENDED: &str =
    r#"kind = "recursive-extended", nc = 2, rls = { prior_variance = 1e6 }"#;
const RECURSIVE_INSTRUMENTAL: &str =
    r#"kind = "recursive-instrumental", prior_variance = 1e6, warm_up = 300"#;

fn spec(structure: &str, learning: &str) -> PipelineSpec {
    let lines = SPEC
        .lines()
        .map(|line| match line {
            _ if line.starts_with("learning") => {
                format!("learning = {{ {learning} }}\nstructure = {{ {structure} }}")
            }
            _ => line.to_owned(),
        })
        .collect::<Vec<_>>()
        .join("\n");
    let spec: PipelineSpec = lines.parse().unwrap();
    let again: PipelineSpec = toml::to_string(&spec).unwrap().parse().unwrap();
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
fn every_kind_has_a_line() {
    let learning: Vec<&str> = every_learning().unwrap().iter().map(|(line, _)| *line).collect();
    let structure: Vec<&str> = every_structure().unwrap().iter().map(|(line, _)| *line).collect();
    for (kinds, lines) in
        [(kinds::<LearningSpec>(), learning), (kinds::<StructureSpec>(), structure)]
    {
        for kind in kinds {
            let start = format!("kind = \"{kind}\"");
            assert!(lines.iter().any(|line| line.starts_with(&start)), "{kind} has no line");
        }
    }
}

#[test]
fn every_way_of_learning_compensates_a_linear_bias() {
    let (log, run) = (training(), eventful());
    for (learning, _) in every_learning().unwrap() {
        assert_works(LINEAR, learning, &log, &run);
    }
}

#[test]
fn every_structure_compensates_a_linear_bias() {
    let (log, run) = (training(), eventful());
    for (structure, _) in every_structure().unwrap() {
        for learning in [OUTPUT_ERROR, RECURSIVE] {
            assert_works(structure, learning, &log, &run);
        }
    }
}

#[test]
fn what_does_not_go_together_is_refused_by_name() {
    let log = training();
    for learning in [RECURSIVE_EXTENDED, RECURSIVE_INSTRUMENTAL] {
        let error = trained(SCHEDULED, learning, &log).unwrap_err();
        assert!(
            matches!(error, TrainingError::NotTogether { structure: "scheduled", .. }),
            "{error}"
        );
    }
    let unknown = SPEC.replace("kind = \"recursive\"", "kind = \"magic\"");
    let error = unknown.parse::<PipelineSpec>().unwrap_err().to_string();
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
            trained(structure, RECURSIVE, &training()).unwrap().compensated().unwrap();
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
    let (times, _) = left(LINEAR);
    assert_eq!(times, 2);
    let scheduled = r#"kind = "scheduled", time_constant_s = 2.0, centres = [0.0, 2.0]"#;
    let (times, share) = left(scheduled);
    assert_eq!(times, 1);
    assert!(share < 0.2, "{share}");
}
