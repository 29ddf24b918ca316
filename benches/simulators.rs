//! What does a simulator outside of this program cost, per step and per run of 1000 samples, beside equations?
//!
//! A mass or a cart, which hardly computes anything: what is left is the seam. Each run has other parameters, and none
//! is remembered. Processes and FMUs are compiled with `cc`, or what `CC` says.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark")]
#![allow(missing_docs, reason = "criterion's macros make public functions")]

use std::{
    fs,
    hint::black_box,
    path::{Path, PathBuf},
    process::Command,
};

use criterion::{
    BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main, measurement::WallTime,
};
use fd_sim::{
    model::Model,
    outside::OutsideFile,
    simulate::{EquationSimulator, Nominal, Shell, Simulator},
};
use tempfile::TempDir;

const SAMPLES: usize = 1000;

const FMU: &str = r#"
version = 1
kind = "fmu"
fmu = "."
sample_time = 0.02
[parameters]
m = { variable = "body.m", tolerance = 0.05 }
d = {}
k = {}
[states]
place = { tolerance = 0.02 }
speed = {}
[outputs]
place = { noise = 0.001 }
speed = {}
[ports]
push = { position = "place", velocity = "speed" }
"#;

/// A file of this checkout.
fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(path)
}

fn compiled(arguments: &[&str], source: &str, to: &Path) {
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let done = Command::new(&compiler)
        .args(arguments)
        .arg("-o")
        .arg(to)
        .arg(file(source))
        .arg("-lm")
        .output();
    let done = done
        .unwrap_or_else(|e| panic!("this bench needs a C compiler, and `{compiler}` gives: {e}"));
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// A simulator of a model file, with nothing remembered.
fn opened(path: &Path, text: &str) -> Box<dyn Simulator> {
    Box::new(OutsideFile::parse(path, text).unwrap().open().unwrap().without_memory())
}

fn fmu(directory: &TempDir) -> Box<dyn Simulator> {
    let platform = match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => "linux64",
        ("linux", "aarch64") => "aarch64-linux",
        ("macos", _) => "darwin64",
        other => panic!("this bench does not know where FMUs keep the library of {other:?}"),
    };
    let binaries = directory.path().join("binaries").join(platform);
    fs::create_dir_all(&binaries).unwrap();
    fs::copy(
        file("crates/fd-sim/tests/fmu/mass.xml"),
        directory.path().join("modelDescription.xml"),
    )
    .unwrap();
    let library = binaries.join(format!("mass{}", std::env::consts::DLL_SUFFIX));
    let arguments = ["-shared", "-fPIC", "-O2", "-DVERSION=\"2.0\"", "-DFAULT=3"];
    compiled(&arguments, "crates/fd-sim/tests/fmu/mass.c", &library);
    opened(&directory.path().join("model.toml"), FMU)
}

fn process(directory: &TempDir, command: &str) -> Box<dyn Simulator> {
    let text = format!("version = 1\nkind = \"process\"\ncommand = [{command}]\nworkers = 1\n");
    opened(&directory.path().join("model.toml"), &text)
}

/// A run at once, and the same step by step.
fn measure(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, simulator: &mut dyn Simulator) {
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let (nu, ny, ports) =
        (simulator.inputs().len(), simulator.outputs().len(), simulator.ports().len());
    let u: Vec<f64> = (0..SAMPLES * nu).map(|k| (0.05 * k as f64).sin()).collect();
    let (mut y, push) = (vec![0.0; SAMPLES * ny], vec![0.01; ports]);
    let mut run = 0_u32;
    let mut other = || {
        run += 1;
        let mut theta = theta.clone();
        theta[0] *= 1.0 + 1e-9 * f64::from(run);
        theta
    };
    group.bench_function(format!("{name}/run"), |b| {
        b.iter(|| simulator.simulate(black_box(&other()), &x0, &u, &mut y));
    });
    group.bench_function(format!("{name}/steps"), |b| {
        b.iter(|| {
            simulator.start(black_box(&other()), &x0, 0);
            for (u, y) in u.chunks_exact(nu).zip(y.chunks_exact_mut(ny)) {
                simulator.step(u, u, &push, y);
            }
        });
    });
}

fn simulators(c: &mut Criterion) {
    let mut group = c.benchmark_group("simulators");
    group.throughput(Throughput::Elements(SAMPLES as u64)).sample_size(20);
    let model = Model::load(&file("crates/fd-sim/testing/mass.toml")).unwrap();
    let ts = model.sample_time().unwrap();
    let inside = EquationSimulator::with_ports(&model, ts).unwrap();
    measure(&mut group, "equations", &mut inside.clone());
    let shell = Shell::new("mass", Box::new(inside)).unwrap();
    measure(&mut group, "equations in a shell", &mut *shell.simulator(ts).unwrap());
    let [library, c_server, python_server] = std::array::from_fn(|_| tempfile::tempdir().unwrap());
    measure(&mut group, "fmu", &mut *fmu(&library));
    let cart = c_server.path().join("cart");
    compiled(&["-O2"], "examples/process/cart.c", &cart);
    measure(
        &mut group,
        "process in c",
        &mut *process(&c_server, &format!("{:?}", cart.display().to_string())),
    );
    let script = file("examples/process/cart.py").display().to_string();
    let command = format!("\"python3\", {script:?}");
    measure(&mut group, "process in python", &mut *process(&python_server, &command));
    group.finish();
}

criterion_group!(benches, simulators);
criterion_main!(benches);
