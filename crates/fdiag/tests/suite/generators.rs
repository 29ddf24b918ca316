//! Every kind of residual generator, chosen by a line of a spec, trained and run.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::{input, nominal, plant, run};
use fdiag::{
    residual::DesignError,
    spec::{
        GeneratorSpec, PipelineSpec,
        testing::{every_generator, kinds},
    },
    training::{Healthy, Trace, Trained, TrainingError, train},
};

/// The direction that the logs show.
const LEARNED: &str =
    r#"kind = "unknown-input", disturbance = { kind = "learned", rank = 1 }, rate = 2.0"#;
/// The same from what is wrong with the model.
const TOLD: &str = r#"kind = "unknown-input", disturbance = { kind = "models", rank = 1, shifts = [{ a = [[0.02, -0.01], [0.01, 0.02]], b = [[-0.01], [0.01]] }] }, rate = 2.0"#;

fn spec(generator: &str) -> PipelineSpec {
    let text = format!(
        "generator = {{ {generator} }}\nsettle_s = 5.0\nbias.orders = {{ kind = \"fixed\", na = 0, nb = 3 }}"
    );
    text.parse().unwrap()
}

/// Trained on 200 s of the plant with slight sensor noise.
fn trained(generator: &str) -> Result<Trained, TrainingError> {
    let log = run(&plant(), &input(2000, 0), 1e-4, 1);
    train(&spec(generator), &nominal(), &[Healthy::split(&log, 0.7)])
}

#[test]
fn every_kind_has_a_line() {
    let lines = every_generator().unwrap();
    for kind in kinds::<GeneratorSpec>() {
        let start = format!("kind = \"{kind}\"");
        assert!(lines.iter().any(|(line, _)| line.starts_with(&start)), "{kind} has no line");
    }
}

#[test]
fn every_kind_is_trained_and_run() {
    let log = run(&plant(), &input(600, 3), 1e-4, 2);
    for (kind, _) in every_generator().unwrap() {
        let written = toml::to_string(&spec(kind)).unwrap();
        assert_eq!(written.parse::<PipelineSpec>().unwrap(), spec(kind), "{kind}");
        let trained = trained(kind).unwrap_or_else(|error| panic!("{kind}: {error}"));
        let trace = Trace::of(&mut trained.compensated().unwrap(), &log).unwrap();
        assert_eq!(trace.channels, trained.design().residual_len(), "{kind}");
        assert!(trace.residual.iter().all(|r| r.is_finite()), "{kind}");
        assert!(trace.compensating.iter().any(|&on| on), "{kind}");
    }
}

/// The direction that the logs show is decoupled: most of the modelling error is gone from the
/// primary residual, before any compensation.
#[test]
fn a_learned_disturbance_takes_out_most_of_the_error() {
    let size = |kind: &str| trained(kind).unwrap().fault_free_maxima().0;
    let plain = size(r#"kind = "observer", rate = 2.0"#);
    let learned = size(LEARNED);
    assert!(learned < 0.3 * plain, "{learned} {plain}");
    // Told what is wrong with the model, it knows the direction as well as the logs do.
    let told = size(TOLD);
    assert!(told < 0.3 * plain, "{told} {plain}");
}

#[test]
fn what_cannot_be_designed_says_why() {
    let refusal = |kind: &str| match trained(kind) {
        Err(TrainingError::Generator(error)) => error,
        other => panic!("{other:?}"),
    };
    let two = r#"kind = "unknown-input", disturbance = { kind = "learned", rank = 2 }, rate = 2.0"#;
    assert_eq!(refusal(two), DesignError::NothingLeft { inputs: 2, outputs: 2 });
    let narrow = r#"kind = "unknown-input", disturbance = { kind = "models", rank = 1, shifts = [{ a = [[0.1]], b = [[0.0], [0.0]] }] }, rate = 2.0"#;
    assert!(refusal(narrow).to_string().contains("shift of A"), "{}", refusal(narrow));
    let none =
        r#"kind = "structured", faults = [{ sensor = 0 }], structure = { kind = "dedicated" }"#;
    assert!(matches!(refusal(none), DesignError::Index { what: "output", .. }));
    let hidden = r#"kind = "structured", faults = [{ sensor = 1 }, { sensor = 2 }, { actuator = 1 }], structure = { kind = "dedicated" }"#;
    assert!(matches!(refusal(hidden), DesignError::NoSignature { .. }));
}
