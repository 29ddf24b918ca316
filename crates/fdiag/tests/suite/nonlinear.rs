//! Generators with a nonlinear model of their own: against the linear ones, and in the pipeline.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failure here is a failed test")]

use crate::support::{input, nominal, plant, run};
use faer::mat;
use fdiag::{
    core::{Frame, Snapshot, stage::ResidualGenerator},
    engine_plant::EngineFile,
    model::{Channel, ChannelScale, Discrete, Record, SampleTime, Scaling, StateSpace},
    sim::{equation::Expr, model::Parameter, patch::Patch},
    spec::{GeneratorSpec, ModelSource, NominalPlant, PipelineSpec, testing::every_generator},
    training::{Healthy, TrainingError, train},
};

const MODEL: &str = r#"
version = 1
kind = "equations"
name = "nominal"
sample_time = 0.1
inputs = { u1 = { unit = "1" } }
[states]
a = { unit = "1", initial = 0.0, update = "0.9*a + 0.06*b + 0.06*u1" }
b = { unit = "1", initial = 0.0, update = "0.83*b - 0.04*a + 0.11*u1" }
[outputs]
y1 = { unit = "1", value = "a" }
y2 = { unit = "1", value = "0.3*a + b" }
"#;

fn generator(kind: &str, settings: &str) -> GeneratorSpec {
    let head = format!("[generator]\nkind = \"{kind}\"\n{settings}");
    let text = format!("{head}\nmodel = {{ text = '''{MODEL}''' }}");
    text.parse::<PipelineSpec>().unwrap().generator
}

fn residuals(generator: &mut dyn ResidualGenerator, log: &Record) -> Vec<f64> {
    let mut all = Vec::new();
    for (k, (u, y)) in (0..).zip(log.samples()) {
        let mut r = vec![0.0; generator.residual_len()];
        generator.step(Frame::new(generator.io(), k, u, y).unwrap(), &mut r);
        all.extend(r);
    }
    all
}

/// `fd_residual`'s stationary Kalman filter, with the variances that the tables of the nonlinear ones say.
#[test]
fn on_a_linear_model_the_filters_are_the_stationary_kalman_filter() {
    let log = run(&plant(), &input(3000, 1), 1e-3, 4);
    // Variances of 1e-3 per sample of 0.1 s, and 4e-4.
    let linear = GeneratorSpec::Kalman { process_noise: 1e-3, output_noise: 4e-4 };
    let expected =
        residuals(&mut *linear.design(&nominal(), None, &[]).unwrap().build().unwrap(), &log);
    let settings = "process_noise = { a = 0.1, b = 0.1 }\noutput_noise = { y1 = 0.02, y2 = 0.02 }";
    for kind in ["extended", "unscented"] {
        let design = generator(kind, settings).design(&nominal(), None, &[]).unwrap();
        let found = residuals(&mut *design.build().unwrap(), &log);
        // After 300 samples the gain is the stationary one to 0.7³⁰⁰; slopes err by 1e-10 relative.
        let pairs = expected.iter().zip(&found).skip(2 * 300);
        let left = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(left < 1e-9, "{kind}: {left}");
        // What it says of itself is that filter, too.
        let (form, theirs) =
            (design.form().unwrap(), linear.design(&nominal(), None, &[]).unwrap());
        let theirs = theirs.form().unwrap();
        let difference = (form.system().a() - theirs.system().a()).norm_max();
        assert!(difference < 1e-8, "{kind}: {difference}");
    }
}

/// What is left of the patched simulation, observed: of a linear model the residual of the observer itself.
#[test]
fn on_a_linear_model_the_observed_simulation_is_the_observer() {
    let log = run(&plant(), &input(3000, 1), 1e-3, 4);
    let linear = GeneratorSpec::Observer { rate: 2.0 };
    let expected =
        residuals(&mut *linear.design(&nominal(), None, &[]).unwrap().build().unwrap(), &log);
    let design = generator("patched", "observer_rate = 2.0").design(&nominal(), None, &[]).unwrap();
    let found = residuals(&mut *design.build().unwrap(), &log);
    let largest = expected.iter().map(|r| r.abs()).fold(0.0, f64::max);
    let left = expected.iter().zip(&found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // The same sums in another order: outputs below 10, stable states, rounding of 2e-16 a step.
    assert!(left < 1e-12 && 1e-3 < largest, "{left} {largest}");
    let theirs = linear.design(&nominal(), None, &[]).unwrap().form().unwrap();
    let (ours, theirs) = (design.form().unwrap().hy().unwrap(), theirs.hy().unwrap());
    let difference = (ours.dc_gain().unwrap() - theirs.dc_gain().unwrap()).norm_max();
    assert!(difference < 1e-12, "{difference}");
}

#[test]
fn they_go_through_gaps_and_snapshots() {
    let log = run(&plant(), &input(2000, 0), 1e-2, 1);
    let mut gaps = run(&plant(), &input(600, 3), 1e-2, 2);
    gaps.y_mut(200).fill(f64::NAN);
    (300..310).for_each(|k| gaps.y_mut(k)[1] = f64::NAN);
    let kinds = ["extended", "unscented", "particle", "patched"];
    for (line, generator) in every_generator().unwrap() {
        if !kinds.iter().any(|kind| line.starts_with(&format!("kind = \"{kind}\""))) {
            continue;
        }
        let spec = PipelineSpec {
            generator,
            settle_s: Some(5.0),
            hold_missing: 3,
            ..PipelineSpec::default()
        };
        let trained = train(&spec, &nominal(), &[Healthy::split(&log, 0.7)]).unwrap();
        let (mut one, mut other) = (trained.compensated().unwrap(), trained.compensated().unwrap());
        let mut refused = 0;
        for (k, (u, y)) in gaps.samples().enumerate() {
            if k == 350 {
                Snapshot::of(&mut one).restore(&mut other).unwrap();
            }
            match one.step(u, y) {
                Ok(step) => assert!(step.residual.iter().all(|r| r.is_finite()), "{line} {k}"),
                Err(_) => refused += 1,
            }
            if k >= 350 {
                let said = one_sample(&mut other, u, y);
                let again = Snapshot::of(&mut one);
                assert_eq!(again, Snapshot::of(&mut other), "{line} {k} {said:?}");
            }
        }
        assert_eq!(refused, 7, "{line}");
    }
}

fn one_sample(pipeline: &mut fdiag::core::DynPipeline, u: &[f64], y: &[f64]) -> Vec<f64> {
    pipeline.step(u, y).map(|step| step.compensated.to_vec()).unwrap_or_default()
}

/// In a scaled pipeline the residual is that of the units, scaled.
#[test]
fn scales_are_taken_into_account() {
    let log = run(&plant(), &input(500, 1), 1e-3, 4);
    let scales = |inputs: &[(f64, f64)]| -> Vec<ChannelScale> {
        inputs.iter().map(|(offset, scale)| ChannelScale::per_unit(*offset, *scale)).collect()
    };
    let scaling =
        Scaling { inputs: scales(&[(0.2, 2.0)]), outputs: scales(&[(0.1, 0.5), (-0.3, 4.0)]) };
    let scaled = log.scaled(&scaling).unwrap();
    let settings = "process_noise = { a = 0.1, b = 0.1 }\noutput_noise = { y1 = 0.02, y2 = 0.02 }";
    for (kind, settings) in
        [("extended", settings), ("unscented", settings), ("patched", ""), ("particle", settings)]
    {
        let spec = generator(kind, settings);
        let plain = spec.design(&nominal(), None, &[]).unwrap();
        let model = nominal();
        let plant = NominalPlant::from(&model).in_units(scaling.clone());
        let other = spec.design(plant, None, &[]).unwrap();
        let (plain, other) = (
            residuals(&mut *plain.build().unwrap(), &log),
            residuals(&mut *other.build().unwrap(), &scaled),
        );
        for (k, (plain, other)) in plain.chunks(2).zip(other.chunks(2)).enumerate() {
            for (i, scale) in [0.5, 4.0].iter().enumerate() {
                // Rounding of the slopes; in particles, of the weights.
                assert!(
                    (plain[i] - scale * other[i]).abs() < 1e-8,
                    "{kind} {k} {plain:?} {other:?}"
                );
            }
        }
    }
}

#[test]
fn what_does_not_fit_is_refused_in_words() {
    let log = run(&plant(), &input(300, 0), 1e-3, 1);
    let refusal = |text: &str, log: &Record| {
        let spec: PipelineSpec = text.parse().unwrap();
        match train(&spec, &nominal(), &[Healthy::split(log, 0.7)]) {
            Err(TrainingError::Nonlinear(error)) => error.to_string(),
            other => panic!("{other:?}"),
        }
    };
    let with = |settings: &str, model: &str| {
        format!("[generator]\nkind = \"extended\"\n{settings}\nmodel = {{ text = '''{model}''' }}")
    };
    let noises = "process_noise = 0.1\noutput_noise = { y1 = 0.1, y2 = 0.1 }";
    assert!(refusal(&with(noises, MODEL), &log).contains("initial value of 0"));
    let by_name = "process_noise = { c = 0.1 }\noutput_noise = { y1 = 0.1, y2 = 0.1 }";
    let said = refusal(&with(by_name, MODEL), &log);
    assert_eq!(said, "generator.process_noise: expected names out of `a`, `b`, found `c`");
    let silent = "process_noise = { a = 0.1 }";
    assert!(refusal(&with(silent, MODEL), &log).contains("expected a number for `y1`"));
    let good = "process_noise = { a = 0.1 }\noutput_noise = { y1 = 0.1, y2 = 0.1 }";
    let said = refusal(&with(good, &MODEL.replace("y2 =", "z =").replace("y1 = 0.1", "y1")), &log);
    assert!(said.contains("expected the outputs `y1`, `y2`, found `y1`, `z`"), "{said}");
    let gone = "[generator]\nkind = \"patched\"\nmodel = \"gone.toml\"";
    assert!(refusal(gone, &log).contains("gone.toml"));
    let linear = "[generator]\nkind = \"patched\"\nmodel = { text = 'kind = \"state-space\"' }";
    assert!(refusal(linear, &log).contains("expected `equations` or `engine17`"));
    let track = format!(
        "[generator]\nkind = \"patched\"\ntrack = {{ k = 1.0 }}\nmodel = {{ text = '''{MODEL}''' }}"
    );
    assert!(refusal(&track, &log).contains("generator.track"));
}

/// engine17 by a line of a spec: at rest where it is known to be, the innovation is zero.
#[test]
fn the_engine_is_a_model_of_a_filter() {
    let ts = SampleTime::new(0.05).unwrap();
    // The linear model of the pipeline only says how many channels there are, and the sample time.
    let linear = StateSpace::new(
        mat![[0.5]],
        mat![[1.0]],
        mat![[1.0], [1.0]],
        mat![[0.0], [0.0]],
        Discrete { ts },
    )
    .unwrap();
    let engine = "version = 1\nkind = \"engine17\"\noutputs = [\"N_L\", \"T_7\"]";
    let file = EngineFile::parse("engine", engine).unwrap();
    let mut simulator = file.nominal(ts).unwrap().simulator(ts).unwrap();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let mut y = vec![0.0; 2 * 40];
    simulator.simulate(&theta, &vec![0.0; simulator.initial().len()], &[0.72; 40], &mut y);
    let names = |names: &[&str]| names.iter().map(|name| Channel::new(*name, "1")).collect();
    let log = Record::new(names(&["W_f"]), names(&["N_L", "T_7"]), vec![0.72; 40], y.clone(), ts);
    let log = log.unwrap();
    for (kind, more) in [("extended", ""), ("extended", "linearised_over = 10"), ("unscented", "")]
    {
        let text = format!(
            "[generator]\nkind = \"{kind}\"\n{more}\nprocess_noise = 1e-3\noutput_noise = 5e-4\nmodel = {{ text = '''{engine}''' }}"
        );
        let PipelineSpec { generator: spec, .. } = text.parse().unwrap();
        let design = spec.design(&linear, None, std::slice::from_ref(&log)).unwrap();
        let r = residuals(&mut *design.build().unwrap(), &log);
        for (r, y) in r.iter().zip(&y) {
            // Two integrations with steps of 2.5 and 5 ms; points of the unscented filter lie in a bend.
            assert!(r.abs() < 2e-5 * y, "{kind} {more}: {r} of {y}");
        }
    }
}

/// The engine in a shell of equations shows all of its memory, that of the equations included.
#[test]
fn a_patched_engine_goes_on_from_a_snapshot() {
    let ts = SampleTime::new(0.05).unwrap();
    let domain = Discrete { ts };
    let linear =
        StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain).unwrap();
    let text = "version = 1\nkind = \"engine17\"\noutputs = [\"N_L\"]";
    let file = EngineFile::parse("engine", text).unwrap();
    let nominal = file.nominal(ts).unwrap();
    // A fuel valve that gives less than it is told.
    let mut patch = Patch::of(nominal.model());
    patch.add_parameter(Parameter::new("share", "1", 0.97));
    patch.wrap_input("W_f", "W_f_real", Expr::parse("share*W_f").unwrap()).unwrap();
    let patched = file.text(&patch.finish().unwrap());
    let spec = GeneratorSpec::Patched {
        model: ModelSource::Text { text: patched },
        track: std::collections::BTreeMap::new(),
        suspicion: 1.5,
        memory_s: 5.0,
        settle_s: 0.0,
        observer_rate: None,
    };
    let design = spec.design(&linear, None, &[]).unwrap();
    let (mut one, mut twin) = (design.build().unwrap(), design.build().unwrap());
    let step = |generator: &mut Box<dyn ResidualGenerator>, k: u32| {
        let (u, mut r) = ([0.712 + 0.001 * f64::from(k)], [0.0]);
        generator.step(Frame::new(generator.io(), 0, &u, &[3000.0]).unwrap(), &mut r);
        r[0].to_bits()
    };
    (0..20).for_each(|k| {
        step(&mut one, k);
    });
    (5..9).for_each(|k| {
        step(&mut twin, k);
    });
    Snapshot::of(&mut one).restore(&mut twin).unwrap();
    for k in 20..40 {
        assert_eq!(step(&mut one, k), step(&mut twin, k), "{k}");
    }
}
