//! How long do all candidates of a plant take: to be made, compiled and simulated?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use fd_effect::{Candidate, Kind, library, offers};
use fd_sim::{
    model::Model,
    scales::ReplayScales,
    simulate::{EquationSimulator, Simulator},
};

fn candidates(c: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/models");
    let library = library();
    for plant in ["pendulum", "two_mass_drive", "cart_pole"] {
        let model = Model::load(&root.join(format!("{plant}.toml"))).unwrap();
        let u: Vec<f64> = (0..1000)
            .map(|k| if k / 60 % 2 == 0 { 1.0 } else { -0.7 } * f64::from(k).cos())
            .collect();
        let ts = model.sample_time().unwrap();
        let scales = ReplayScales::of(&model, ts, &u, 1000).unwrap();
        let made = || -> Vec<Candidate> {
            let all = offers(&library, &model, &scales).into_iter().filter_map(Result::ok);
            all.filter(|candidate| candidate.kind == Kind::Simulation).collect()
        };
        let all = made();
        let mut group = c.benchmark_group(format!("{plant}, {} candidates", all.len()));
        group.sample_size(10);
        group.bench_function("make", |b| b.iter(made));
        let compile =
            |candidate: &Candidate| EquationSimulator::<f64>::at(&candidate.model, ts).unwrap();
        group.bench_function("compile", |b| {
            b.iter(|| all.iter().map(compile).collect::<Vec<_>>());
        });
        let mut simulators: Vec<_> = all.iter().map(compile).collect();
        let mut y = vec![0.0; 1000 * model.outputs.len()];
        group.bench_function("simulate 1000 samples", |b| {
            b.iter(|| {
                for (candidate, simulator) in all.iter().zip(&mut simulators) {
                    let mut theta = model.nominal();
                    theta.extend(&candidate.starts[0]);
                    let x0 = candidate.model.initial();
                    black_box(Simulator::simulate(simulator, &theta, &x0, &u, &mut y));
                }
            });
        });
        group.finish();
    }
}

criterion_group!(benches, candidates);
criterion_main!(benches);
