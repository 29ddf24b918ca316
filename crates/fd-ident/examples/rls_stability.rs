//! Does recursive least squares survive 10⁸ samples, in single precision too?
//!
//! `cargo run --release -p fd-ident --example rls_stability [SAMPLES]`: the three cases in which
//! other forms diverge, a register full of estimators each, next to a QR reference in `f64`.
#![allow(clippy::print_stdout, reason = "an example prints its results")]
#![allow(clippy::unwrap_used, reason = "an example may stop at the first surprise")]

#[path = "../tests/common/long_run.rs"]
mod long_run;

use std::time::Instant;

use fd_ident::batch::LaneScalar;
use long_run::{Input, run};

fn case<T: LaneScalar>(scalar: &str, input: Input, lambda: f64, samples: usize) {
    let start = Instant::now();
    println!("{input:?}, lambda {lambda}, {scalar}, {} estimators:", T::WIDTH);
    let guard = run::<T>(input, lambda, samples, |look| {
        println!(
            "  {:>11} samples: from QR {:.1e}, from truth {:.1e} (QR {:.1e}), variance {:.1e} to \
             {:.1e}, condition {:.1e}",
            look.samples,
            look.from_reference,
            look.from_truth,
            look.reference_from_truth,
            look.variance[0],
            look.variance[1],
            look.condition
        );
    });
    println!("  {guard:?}, {:.1} s", start.elapsed().as_secs_f64());
}

fn main() {
    let samples = std::env::args().nth(1).map_or(100_000_000, |text| text.parse().unwrap());
    for (input, lambda) in
        [(Input::White, 0.99), (Input::Paper, 0.99), (Input::Stops, 0.99), (Input::Stops, 0.999)]
    {
        case::<f64>("f64", input, lambda, samples);
        case::<f32>("f32", input, lambda, samples);
    }
}
