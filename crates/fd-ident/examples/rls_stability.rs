//! Does recursive least squares survive 10⁸ samples, in single precision too?
//!
//! `cargo run --release -p fd-ident --example rls_stability [SAMPLES [WORDS]]`: the three cases in
//! which other forms diverge, a register full of estimators each, next to a QR reference in `f64`.
//! Prints a table for `docs/results/rls-stability.md`, of the cases that all words occur in, such
//! as `100000000 Stops Directional f32`.
#![allow(clippy::print_stdout, reason = "an example prints its results")]
#![allow(clippy::unwrap_used, reason = "an example may stop at the first surprise")]

#[path = "../tests/suite/common/long_run.rs"]
mod long_run;

use std::time::Instant;

use fd_ident::{batch::BatchScalar, rls::Forgetting};
use long_run::{Input, rounding, run};

fn case<T: BatchScalar>(
    scalar: &str,
    input: Input,
    forgetting: Forgetting,
    samples: usize,
    words: &[String],
) {
    let name = format!("| {input:?} | {forgetting:?} | {scalar} |");
    if !words.iter().all(|word| name.contains(word)) {
        return;
    }
    let start = Instant::now();
    let mut last = None;
    // Of all looks the worst, as a part of what the reference allows.
    let mut worst = 0.0_f64;
    let guard = run::<T>(input, forgetting, samples, |look| {
        worst = worst.max(look.from_reference / rounding::<T>(&look));
        last = Some(look);
    });
    let look = last.unwrap();
    println!(
        "{name} {:.1e} | {:.1e} | {:.1e} | {:.1e} | {worst:.2} | {:.1e} | {:.1e} | {:.1e} to {:.1e} | {} | {:.0} |",
        look.samples as f64,
        look.from_reference,
        look.condition,
        rounding::<T>(&look),
        look.from_truth,
        look.reference_from_truth,
        look.variance[0],
        look.variance[1],
        guard.bounded,
        start.elapsed().as_secs_f64(),
    );
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let samples = arguments.next().map_or(100_000_000, |text| text.parse().unwrap());
    let words: Vec<String> = arguments.collect();
    println!(
        "| input | forgetting | scalar | samples | from QR in f64 | condition κ | n ε κ ‖θ‖ | \
         worst share | from the truth, worst lane | QR from the truth | variances | pauses | s |"
    );
    println!("|{}", "---|".repeat(13));
    for (input, lambda) in [
        (Input::White, 0.99),
        (Input::Paper, 0.99),
        (Input::Stops, 0.99),
        (Input::Stops, 0.999),
        (Input::Stops, 1.0),
    ] {
        for forgetting in [Forgetting::Exponential { lambda }, Forgetting::Directional { lambda }] {
            case::<f64>("f64", input, forgetting, samples, &words);
            case::<f32>("f32", input, forgetting, samples, &words);
        }
    }
}
