//! How many instructions an update costs, counted by valgrind: a guard where time cannot be one.
//!
//! The counts are those of the test profile on x86-64 with AVX2, which is what valgrind offers; they
//! do not depend on the load of the machine. A compiler may change them by some per cent, a lost
//! unrolling or an allocation per sample changes them by more than the margin.
#![cfg(target_arch = "x86_64")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may stop at the first surprise")]

use std::{env, hint::black_box, process::Command};

use crate::common::noise;
use fd_ident::{
    batch::{BatchRls, SampleBlock},
    rls::{ConventionalRls, Forgetting, RlsDesign, RlsKernel, Static, UdRls},
};

/// What the child process is to do: kind and number of updates.
const WORK: &str = "FDIAG_COUNTED_WORK";
const N: usize = 5;
/// Updates that are counted: the difference of two runs, so that nothing else is.
const UPDATES: usize = 16_384;
/// More instructions than this part above the expected number fail.
const MARGIN: f64 = 0.25;

/// Kinds of work with the instructions that an update of 5 parameters costs.
const EXPECTED: [(&str, f64); 4] =
    [("ud", 333.0), ("conventional", 409.0), ("batch f64", 74.0), ("batch f32", 38.0)];

fn design() -> RlsDesign {
    let forgetting = Forgetting::Exponential { lambda: 0.999 };
    RlsDesign { prior_variance: 100.0, ..RlsDesign::forgetting(forgetting) }
}

fn alone(mut kernel: impl RlsKernel<f64>, updates: usize) {
    let numbers = noise(1, 64 * (N + 1));
    let mut theta = [0.0; N];
    for row in numbers.chunks_exact(N + 1).cycle().take(updates) {
        kernel.update(&row[..N], row[N], &mut theta);
    }
    black_box(theta);
}

fn side_by_side<T: fd_ident::batch::BatchScalar>(updates: usize) {
    let (estimators, steps) = (64, 64);
    let mut batch = BatchRls::<T>::new(N, estimators, &design()).unwrap();
    let mut block = SampleBlock::new(N, estimators, steps);
    for estimator in 0..estimators {
        for (step, row) in noise(2, steps * (N + 1)).chunks_exact(N + 1).enumerate() {
            let row: Vec<T> = row.iter().map(|&v| T::from_design(v)).collect();
            block.set(estimator, step, &row[..N], row[N]);
        }
    }
    for _ in 0..updates / (estimators * steps) {
        batch.update(&block).unwrap();
    }
    black_box(batch);
}

/// What the process under valgrind does.
fn work_counted(work: &str) {
    let (kind, updates) = work.split_once(':').unwrap();
    let updates = updates.parse().unwrap();
    match kind {
        "ud" => alone(UdRls::<f64, Static<N>>::new(N, &design()).unwrap(), updates),
        "conventional" => {
            alone(ConventionalRls::<f64, Static<N>>::new(N, &design()).unwrap(), updates);
        }
        "batch f64" => side_by_side::<f64>(updates),
        "batch f32" => side_by_side::<f32>(updates),
        other => panic!("unknown work {other}"),
    }
}

/// Instructions of a run.
fn instructions(kind: &str, updates: usize) -> f64 {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(env::current_exe().unwrap())
        .args(["--ignored", "--exact", "valgrind_counts_no_more_instructions_per_update"])
        .arg("--test-threads=1")
        .env(WORK, format!("{kind}:{updates}"))
        .output()
        .unwrap_or_else(|error| panic!("valgrind does not start: {error}"));
    let log = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "valgrind cannot run {kind}: {log}");
    let line = log.lines().find(|line| line.contains("Collected"));
    line.and_then(|line| line.rsplit(' ').next()?.parse().ok())
        .unwrap_or_else(|| panic!("no count of {kind} in: {log}"))
}

#[test]
#[ignore = "needs valgrind"]
fn valgrind_counts_no_more_instructions_per_update() {
    // The process that is counted is this test once more.
    if let Ok(work) = env::var(WORK) {
        return work_counted(&work);
    }
    for (kind, expected) in EXPECTED {
        let (once, twice) = (instructions(kind, UPDATES), instructions(kind, 2 * UPDATES));
        let found = (twice - once) / UPDATES as f64;
        println!("{kind}: {found:.1} instructions per update, expected {expected}");
        assert!(found < (1.0 + MARGIN) * expected, "{kind}: {found:.1} instructions per update");
    }
}
