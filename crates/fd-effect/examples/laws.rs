//! Order of convergence, error and cost of all laws: the page docs/results/laws.md.
#![allow(
    dead_code,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "plants and inputs are those of the tests, which need more of them; it prints a page"
)]

#[path = "../tests/effects/cases.rs"]
mod cases;
#[path = "../tests/effects/finer.rs"]
mod finer;

use std::{collections::BTreeMap, fmt::Write as _, time::Instant};

use fd_sim::simulate::{EquationSimulator, Simulator};

use crate::{
    cases::{Case, PLANTS},
    finer::{error, run},
};

/// A law at a site of a plant, with all that was measured of it.
#[derive(Default)]
struct Row {
    /// Orders, from halving the step twice.
    orders: Vec<f64>,
    /// Largest error at the default step.
    error: f64,
    /// Time of a run, in that of the nominal model.
    cost: Vec<f64>,
    cases: usize,
}

fn main() {
    let mut rows = BTreeMap::<(&str, &str), Row>::new();
    for plant in PLANTS {
        let case = Case::new(plant, 300);
        let nominal = time(&case, &case.model, &case.model.nominal());
        for candidate in case.simulated() {
            let row = rows.entry((candidate.label, candidate.law)).or_default();
            // The first start and the last: weak or early, and strong or late.
            for start in [candidate.starts.first(), candidate.starts.last()].into_iter().flatten() {
                let fine = run(&case, &candidate, start, 128);
                let at = |f| error(&case, &run(&case, &candidate, start, f), &fine);
                let [coarse, quarter] = [1, 4].map(at);
                row.error = row.error.max(coarse);
                // Below that, rounding and the fine run have a say.
                if 1e-9 < quarter && quarter < coarse {
                    row.orders.push(0.5 * (coarse / quarter).log2());
                }
                row.cases += 1;
            }
            let mut theta = case.model.nominal();
            theta.extend(&candidate.starts[0]);
            row.cost.push(time(&case, &candidate.model, &theta) / nominal);
        }
    }
    let mut page = String::from(HEAD);
    for ((label, law), row) in &mut rows {
        let order = match median(&mut row.orders) {
            Some(order) => format!("{order:.1}"),
            None => "exact".to_owned(),
        };
        let cost = median(&mut row.cost).unwrap_or(f64::NAN);
        let _ = writeln!(
            page,
            "| `{label}` | {law} | {} | {order} | {} | {cost:.2} |",
            row.cases,
            short(row.error)
        );
    }
    print!("{page}");
}

const HEAD: &str = "# Laws of effects: how exact, at what cost

Every law of the library at every place of the eight plants in `examples/models`, at its first and its last start, 300 samples
of steps of random height and length. *order*: by which power of the integration step the error (root of the mean square,
against a run with 128 times finer steps) falls, from the default step to a quarter of it, median; `exact` where rounding is left. *error*: the largest at the default step, in standard deviations of the output. *cost*:
time of a run, in that of the model without the law, median. The diagnosis halves the step until its likelihoods do not
depend on it.

Made by `cargo run --release -p fd-effect --example laws > docs/results/laws.md`.

| effect | law | cases | order | error | cost |
|---|---|---|---|---|---|
";

/// The shortest of several runs, in seconds.
fn time(case: &Case, model: &fd_sim::model::Model, theta: &[f64]) -> f64 {
    let mut simulator = EquationSimulator::<f64>::new(model).unwrap();
    let mut y = vec![0.0; case.samples * model.outputs.len()];
    let x0 = model.initial();
    let mut once = || {
        let begun = Instant::now();
        Simulator::simulate(&mut simulator, theta, &x0, &case.u, &mut y);
        begun.elapsed().as_secs_f64()
    };
    (0..9).map(|_| once()).fold(f64::INFINITY, f64::min)
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn short(error: f64) -> String {
    if error < 1e-9 { "0".to_owned() } else { format!("{error:.0e}") }
}
