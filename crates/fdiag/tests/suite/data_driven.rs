//! Generators from data next to those from models, and through a whole diagnosis.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use crate::support::{input, plant, run, ts};
use faer::Mat;
use fd_numeric::dense::Dense;
use fdiag::{
    data::parity::DataParityDesign,
    log::{LogMap, read_log},
    model::{
        Channel, Inputs, Simulation,
        fault::{FaultProfile, FaultSpec, Site},
        file::LinearModel,
        signal::{Prbs, WhiteNoise},
    },
    residual::{GeneratorDesign, parity::ParityDesign},
    spec::PipelineSpec,
    training::{Healthy, Trace, train},
};

/// Orthonormal rows of the same span.
fn basis(rows: &Mat<f64>) -> Mat<f64> {
    rows.transpose().factor_qr().compute_thin_Q().transpose().to_owned()
}

/// Without noise the relations of a log are the parity space of the model of what made it.
#[test]
fn relations_from_data_span_the_parity_space_of_the_model() {
    let log = run(&plant(), &input(2000, 1), 0.0, 1);
    for order in 2..5 {
        let data =
            DataParityDesign { order, states: None }.learn(std::slice::from_ref(&log)).unwrap();
        let model = ParityDesign::all(&plant(), order).unwrap().form().unwrap();
        // A form is a shift register of past samples of [u; y] and the present one.
        let (c, d) = (model.system().c(), model.system().d());
        let of_model = Mat::from_fn(c.nrows(), c.ncols() + d.ncols(), |i, j| {
            if j < c.ncols() { c[(i, j)] } else { d[(i, j - c.ncols())] }
        });
        let of_data = data.map().map().to_owned();
        assert_eq!(of_data.nrows(), of_model.nrows(), "order {order}");
        let (a, b) = (basis(&of_data), basis(&of_model));
        let outside = &b - &b * a.transpose() * &a;
        // The inputs are levels and slow tones: windows of them have singular values down to 1e-5 of the largest,
        // which leaves ten of sixteen digits.
        assert!(outside.norm_max() < 1e-8, "order {order}: {}", outside.norm_max());
    }
}

/// A drift of a sensor is found by relations that were learned from the same log as the thresholds, with no
/// right model anywhere; the model of the pipeline is not looked at.
#[test]
fn a_drift_is_found_without_a_model() {
    let frozen = plant().freeze::<f64, fdiag::core::Heap>().unwrap();
    let inputs =
        Inputs::from_signals([(Channel::new("u", "1"), Prbs::new(9, 0.5, 1.0))], 3000, ts())
            .unwrap();
    let run = |seed: u64, faults: Vec<FaultSpec>| {
        let output_noise =
            (0..2_u64).map(|i| WhiteNoise::new(1e-3, 10 * seed + i).into()).collect();
        let simulation = Simulation { output_noise, faults, ..Simulation::default() };
        simulation.run(&frozen, &inputs, Channel::numbered("y", 2))
    };
    let healthy = run(1, vec![]).unwrap();
    for generator in [
        r#"kind = "data-parity", order = 3"#,
        r#"kind = "cva", past = 4, future = 4"#,
        r#"kind = "pca", lags = 2, components = { kind = "variance", share = 0.999 }"#,
        r#"kind = "pca", lags = 2, components = { kind = "variance", share = 0.999 }, part = "statistics""#,
    ] {
        let text = format!(
            "generator = {{ {generator} }}\nsettle_s = 5.0\n\
             detector = {{ kind = \"chi-square\", window = 5, false_alarms = {{ kind = \"per-run\", probability = 0.01, samples = 3000 }} }}\n\
             calibration.beyond = \"extrapolate\"\nrule = {{ raise = 3, out_of = 3 }}"
        );
        let spec: PipelineSpec = text.parse().unwrap();
        let trained =
            train(&spec, &crate::support::nominal(), &[Healthy::split(&healthy, 0.5)]).unwrap();
        let drift = FaultSpec::add(Site::sensor(0), 150.0, FaultProfile::drift(1e-3));
        let trace = Trace::of(&mut trained.uncompensated().unwrap(), &run(2, vec![drift]).unwrap())
            .unwrap();
        let found = trace.first_alarm(0);
        assert!(found.is_some_and(|k| 1500 <= k), "{generator}: {found:?}");
        let quiet =
            Trace::of(&mut trained.uncompensated().unwrap(), &run(3, vec![]).unwrap()).unwrap();
        assert_eq!(quiet.first_alarm(0), None, "{generator}");
    }
}

/// `examples/data-driven.toml` on the model and the log beside it, as `fdiag compensate` goes about it.
#[test]
fn the_example_runs() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples");
    let model = LinearModel::read(root.join("turbine.toml")).unwrap();
    let log = read_log(root.join("turbine-run.csv"), &LogMap::for_model(&model)).unwrap().record;
    let log = log.scaled(&model.scaling()).unwrap();
    let plant = model.system.sampled(log.ts()).unwrap();
    let text = std::fs::read_to_string(root.join("data-driven.toml")).unwrap();
    let spec: PipelineSpec = text.parse().unwrap();
    let trained = train(&spec, &plant, &[Healthy::split(&log, 0.7)]).unwrap();
    for mut pipeline in [trained.uncompensated().unwrap(), trained.compensated().unwrap()] {
        let trace = Trace::of(&mut pipeline, &log).unwrap();
        assert_eq!(trace.channels, trained.design().residual_len());
        assert_eq!(trace.first_alarm(0), None, "the log is that of a healthy turbine");
    }
}
