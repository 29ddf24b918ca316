//! How long does a right-hand side take, and a simulation of 1000 samples?
#![allow(clippy::unwrap_used, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{hint::black_box, path::Path};

use criterion::{Criterion, criterion_group, criterion_main};
use fd_sim::{
    equation::{Expr, Program, Scope},
    model::{Model, Parameter, Sign},
    simulate::{EquationSimulator, Run, Simulator},
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

/// Dry friction, sixteen runs side by side: smooth, and as a set-valued sign where it slides, stops and sticks.
fn friction(c: &mut Criterion) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/models");
    let mut group = c.benchmark_group("friction, 16 runs of 1000 samples");
    for law in ["none", "tanh", "sign"] {
        let text = std::fs::read_to_string(root.join("mass_spring_damper.toml")).unwrap();
        let mut draft = text.parse::<Model>().unwrap().into_draft();
        let velocity = draft.sites[0].velocity.clone().unwrap();
        let (state, factor) = draft.sites[0].enters[0].clone();
        draft.parameters.push(Parameter::new("f", "N", 0.3));
        let direction = match law {
            "none" => None,
            "tanh" => Some(
                Expr::parse("tanh(w/0.002)")
                    .unwrap()
                    .substitute(&|name| (name == "w").then(|| velocity.clone())),
            ),
            _ => {
                draft.signs.push(Sign { name: "slip".into(), velocity: velocity.clone() });
                Some(Expr::name("slip"))
            }
        };
        if let Some(direction) = direction {
            let law = draft.states.iter_mut().find(|known| known.name == state).unwrap();
            let force = Expr::name("f") * direction;
            *law.law.expr_mut() = law.law.expr().clone() - factor * force;
        }
        let model = Model::try_from(draft).unwrap();
        let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
        let u: Vec<f64> = (0..1000).map(|k| 2.0 * (0.03 * f64::from(k)).sin()).collect();
        let (ny, x0) = (model.outputs.len(), model.initial());
        let thetas: Vec<Vec<f64>> = (0..16)
            .map(|i| {
                let mut theta = model.nominal();
                *theta.last_mut().unwrap() = 0.02 * f64::from(i);
                theta
            })
            .collect();
        let mut y = vec![vec![0.0; 1000 * ny]; 16];
        group.bench_function(law, |b| {
            b.iter(|| {
                let runs = thetas.iter().zip(&mut y);
                let mut runs: Vec<Run<'_>> =
                    runs.map(|(theta, y)| Run::new(theta, &x0, y)).collect();
                simulator.simulate_many(0, black_box(&u), &mut runs);
            });
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

criterion_group!(benches, right_hand_side, simulations, friction, sensitivities, compilation);
criterion_main!(benches);
