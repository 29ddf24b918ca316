//! A pipeline composed by hand from types and the one that a TOML spec describes are the same.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::{Outcome, calibration, count, eventful, nominal, spec, training};
use faer::{c64, mat};
use fdiag::{
    compensate::{
        SampleRows,
        decide::{Debounce, Debouncing},
        detect::Magnitude,
        residual_compensation::{CompensationPlan, PreFitted, RangePolicy, ResidualCompensator},
    },
    core::{
        DynPipeline, EventKind, Fixed, Pipeline, Stages, Storage,
        stage::{BiasModel, Compensator, DecisionRule, Detector, Phase, ResidualGenerator},
    },
    ident::{
        arx::{ArxOrders, ArxSimulator, RecursiveArx},
        rls::{RlsDesign, Static, UdRls},
    },
    model::{Record, freeze},
    residual::{
        observer::{Observer, ObserverDesign},
        weighted::Weighted,
    },
    spec::PipelineSpec,
    training::{Healthy, train},
};

type Size = Fixed<2, 1, 2>;
type Row = <Fixed<2, 1, 1> as Storage<f64>>::Yx;
type Generator = Weighted<f64, Observer<f64, Size>, Row, [f64; 2]>;
type Identifier = RecursiveArx<f64, UdRls<f64, Static<5, 1>>>;
type Switch = ResidualCompensator<f64, Identifier, ArxSimulator>;
type Diagnosis = Pipeline<f64, Stages<Generator, Switch, Magnitude<f64>, Debounce>>;

fn generator() -> Generator {
    let pole = c64::new((-2.0 * crate::support::ts().seconds()).exp(), 0.0);
    let design = ObserverDesign::place(&nominal(), &[pole; 2]).unwrap();
    let weight: Row = freeze("W", mat![[1.0, 0.5]].as_ref()).unwrap();
    Weighted::new(design.freeze::<f64, Size>().unwrap(), weight).unwrap()
}

fn orders() -> ArxOrders {
    ArxOrders::paper(2)
}

fn identifier() -> Identifier {
    let design = RlsDesign { prior_variance: 1e6, ..RlsDesign::default() };
    let kernel = UdRls::new(orders().parameters(1), &design).unwrap();
    RecursiveArx::new(orders(), 1, 1, kernel).unwrap()
}

fn plan() -> CompensationPlan {
    let mut plan = CompensationPlan::default();
    plan.operating_point.policy = RangePolicy::Retrain;
    plan
}

fn diagnosis(compensator: Switch, detector: Magnitude<f64>) -> Diagnosis {
    let rule = Debouncing { raise: 3, out_of: 4, clear: 5, latch: false };
    Pipeline::new(Stages {
        generator: generator(),
        compensator,
        detector,
        rule: Debounce::new(1, rule).unwrap(),
    })
    .unwrap()
}

fn silent() -> Magnitude<f64> {
    Magnitude::new(&[1.0], f64::MAX).unwrap()
}

fn outcomes<G, C, D, J>(
    pipeline: &mut Pipeline<f64, Stages<G, C, D, J>>,
    record: &Record,
) -> Vec<Outcome>
where
    G: ResidualGenerator,
    C: Compensator,
    D: Detector,
    J: DecisionRule,
{
    record.samples().map(|(u, y)| Outcome::of(&pipeline.step(u, y).unwrap())).collect()
}

/// The whole road by hand, without the heap in the generator and without any `dyn`.
fn by_hand(training: &Record, calibration: &Record) -> (Vec<f64>, Diagnosis) {
    let learning =
        ResidualCompensator::new(identifier(), ArxSimulator::new(orders(), 1, 1).unwrap(), &plan())
            .unwrap();
    let mut learning = diagnosis(learning, silent());
    let mut residual = Vec::new();
    let mut theta = None;
    for (u, y) in training.samples() {
        let step = learning.step(u, y).unwrap();
        residual.push(step.residual[0]);
        let frozen = step.events.iter().any(|kind| kind == EventKind::Frozen);
        if frozen && theta.is_none() {
            theta = learning.stages().compensator.theta().map(<[f64]>::to_vec);
        }
    }
    let theta = theta.unwrap();
    let inputs: Vec<f64> = training.input(0).collect();
    let fit = PreFitted::from_training(
        theta.clone(),
        SampleRows::new(1, &inputs).unwrap(),
        SampleRows::new(1, &residual).unwrap(),
    );
    let fitted = || {
        let mut simulator = ArxSimulator::new(orders(), 1, 1).unwrap();
        simulator.load(&theta);
        ResidualCompensator::pre_fitted(identifier(), simulator, fit.clone(), &plan()).unwrap()
    };
    let mut healthy = Vec::new();
    let mut watching = diagnosis(fitted(), silent());
    for (u, y) in calibration.samples() {
        let step = watching.step(u, y).unwrap();
        if step.phase == Phase::Compensating {
            healthy.push(step.compensated[0]);
        }
    }
    let healthy = SampleRows::new(1, &healthy).unwrap();
    let detector = Magnitude::above_fault_free_maximum(healthy, 0.1).unwrap();
    let pipeline = diagnosis(fitted(), detector);
    (theta, pipeline)
}

fn from_spec(training: &Record, calibration: &Record) -> (Vec<f64>, DynPipeline) {
    let healthy = [Healthy::learn(training), Healthy::calibrate(calibration)];
    let trained = train(&spec(), &nominal(), &healthy).unwrap();
    (trained.bias_model().theta(), trained.compensated().unwrap())
}

/// Training, freezing, calibration, re-training at another operating point, and a fault.
#[test]
fn by_hand_and_from_a_spec_are_identical_to_the_bit() {
    let (training, calibration) = (training(), calibration());
    let (theta, mut fixed) = by_hand(&training, &calibration);
    let (theta_spec, mut boxed) = from_spec(&training, &calibration);
    let bits = |theta: &[f64]| theta.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(&theta), bits(&theta_spec));

    let record = eventful();
    let (fixed, boxed) = (outcomes(&mut fixed, &record), outcomes(&mut boxed, &record));
    for (a, b) in fixed.iter().zip(&boxed) {
        assert_eq!(a, b);
    }
    // The run has in it what it is meant to have.
    assert_eq!(count(&fixed, EventKind::OperatingPointLeft), 1);
    assert_eq!(count(&fixed, EventKind::TrainingStarted), 1);
    assert_eq!(count(&fixed, EventKind::Frozen), 1);
    let frozen = fixed.iter().position(|o| o.events.iter().any(|e| e.kind == EventKind::Frozen));
    let frozen = frozen.unwrap();
    assert!((800..4600).contains(&frozen), "frozen at {frozen}");
    let alarm = frozen + fixed[frozen..].iter().position(|o| o.fault_since.is_some()).unwrap();
    assert!((4600..4620).contains(&alarm), "alarm at {alarm}");
}

/// The message of a wrong spec.
fn refusal(text: &str) -> String {
    text.parse::<PipelineSpec>().unwrap_err().to_string()
}

fn assert_lists(message: &str, found: &str, known: &[&str]) {
    assert!(message.contains(&format!("`{found}`")), "{message}");
    for name in known {
        assert!(message.contains(&format!("`{name}`")), "`{name}` is not in: {message}");
    }
}

#[test]
fn a_wrong_name_lists_the_right_ones() {
    let message = refusal("[generator]\nkind = \"obsever\"\nrate = 2.0\n");
    assert_lists(&message, "obsever", &["simulation", "observer", "kalman", "parity"]);
    let message = refusal("[generator]\nkind = \"kalman\"\nprocess_noise = 1.0\nnoise = 1.0\n");
    assert_lists(&message, "noise", &["process_noise", "output_noise"]);
    let message = refusal("[generator]\nkind = \"observer\"\nspeed = 2.0\n");
    assert_lists(&message, "speed", &["rate"]);
    let message = refusal("[detector]\nkind = \"max\"\n");
    assert_lists(&message, "max", &["maximum"]);
    let message = refusal("[bias]\nlearning = { kind = \"online\" }\n");
    assert_lists(&message, "online", &["batch", "recursive"]);
    let message = refusal("[bias]\nlearning = { kind = \"recursive\", prior = 1.0 }\n");
    assert_lists(&message, "prior", &["prior_variance", "forgetting"]);
    let message = refusal("[bias]\norders = { kind = \"fixed\", na = 2, nc = 1 }\n");
    assert_lists(&message, "nc", &["na", "nb", "delay", "offset"]);
    let message = refusal("[rule]\nrise = 3\n");
    assert_lists(&message, "rise", &["raise", "out_of", "clear", "latch"]);
    let message = refusal("[compensation]\nmode = \"simulate\"\n");
    assert_lists(&message, "simulate", &["simulation", "one-step"]);
    let message = refusal("detecter = 1\n");
    assert_lists(&message, "detecter", &["generator", "weighting", "bias", "detector", "rule"]);
    // The message shows the line.
    assert!(message.contains("line 1"), "{message}");
}

#[test]
fn specs_survive_toml() {
    let specs = [
        spec(),
        PipelineSpec::default(),
        r#"
            hold_missing = 3
            generator = { kind = "parity", order = 4 }
            bias.orders = { kind = "select", most = 4, criterion = "bic", offset = true }
            bias.learning = { kind = "batch", prefilter_rad_s = 8.0 }
            compensation.operating_point.policy = { kind = "retrain-after", samples = 9, band = 0.1 }
            compensation.convergence.longest = 500
            "#
        .parse()
        .unwrap(),
    ];
    for spec in specs {
        let text = toml::to_string(&spec).unwrap();
        assert_eq!(text.parse::<PipelineSpec>().unwrap(), spec, "{text}");
    }
}
