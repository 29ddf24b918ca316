//! How long does a right-hand side take, and a simulation of 1000 samples?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use fd_sim::{
    equation::{Expr, Program, Scope},
    model::Model,
    simulate::{EquationSimulator, Simulator},
};
use num_dual::DualSVec64;

fn right_hand_side(c: &mut Criterion) {
    let scope = Scope {
        slow: ["m", "l", "d", "g"].map(String::from).to_vec(),
        fast: ["theta", "omega", "tau"].map(String::from).to_vec(),
        definitions: vec![("J".into(), Expr::parse("m*l^2").unwrap())],
        tables: Vec::new(),
    };
    let text = "(tau - d*omega - m*g*l*sin(theta))/J";
    let rates = [Expr::name("omega"), Expr::parse(text).unwrap()];
    let program = Program::compile(&scope, &rates).unwrap();
    let mut workspace = program.workspace::<f64>();
    workspace.slow_mut().copy_from_slice(&[1.0, 0.5, 0.05, 9.81]);
    program.prepare(&mut workspace);
    let mut rates = [0.0; 2];
    c.bench_function("right-hand side/pendulum", |b| {
        b.iter(|| {
            workspace.fast_mut().copy_from_slice(&black_box([0.3, 0.1, 0.2]));
            program.run(&mut workspace, &mut rates);
            black_box(rates)
        });
    });
}

fn simulations(c: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/models");
    let mut group = c.benchmark_group("1000 samples");
    for name in ["pendulum", "cart_pole", "dc_drive_closed_loop", "tanks"] {
        let model = Model::load(&root.join(format!("{name}.toml"))).unwrap();
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let u: Vec<f64> = (0..1000).map(|k| 1.0 + (0.01 * f64::from(k)).sin()).collect();
        let mut y = vec![0.0; 1000 * model.outputs.len()];
        let (theta, x0) = (model.nominal(), model.initial());
        group.bench_function(format!("{name}, {} steps per sample", simulator.substeps()), |b| {
            b.iter(|| Simulator::simulate(&mut simulator, black_box(&theta), &x0, &u, &mut y));
        });
    }
    group.finish();
}

fn sensitivities(c: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/models");
    let model = Model::load(&root.join("pendulum.toml")).unwrap();
    let mut simulator = EquationSimulator::<DualSVec64<6>>::new(&model).unwrap();
    let u = [1.0; 1000];
    let mut y = vec![DualSVec64::from_re(0.0); 1000];
    let seed = |(i, value): (usize, f64)| DualSVec64::from_re(value).derivative(i);
    let theta: Vec<_> = model.nominal().into_iter().enumerate().map(seed).collect();
    let x0: Vec<_> = (4..).zip(model.initial()).map(seed).collect();
    c.bench_function("1000 samples/pendulum with 6 sensitivities", |b| {
        b.iter(|| simulator.run(black_box(&theta), &x0, &u, &mut y));
    });
}

fn compilation(c: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/models");
    let model = Model::load(&root.join("pendulum.toml")).unwrap();
    c.bench_function("compile/pendulum", |b| {
        b.iter(|| EquationSimulator::<f64>::new(black_box(&model)).unwrap());
    });
}

criterion_group!(benches, right_hand_side, simulations, sensitivities, compilation);
criterion_main!(benches);
