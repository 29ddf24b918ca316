//! Do answers about ranks depend on coordinates and units?
//!
//! `cargo run -p fd-residual --example ranks`: published problems, each in 20 changes of coordinates, in
//! 20 changes of units at each of four widths, and in both at once. Prints the shares of wrong answers as
//! the table of `docs/results/ranks.md`. With `-- <words of a case> <first seed>` wrong answers of that case
//! too, and other draws.
#![allow(clippy::print_stdout, reason = "an example prints its results")]
#![allow(clippy::unwrap_used, reason = "an example may stop at the first surprise")]

#[allow(dead_code, reason = "the tests use more of it")]
#[path = "../tests/suite/common"]
mod common {
    pub(crate) mod cases;
    pub(crate) mod changes;
    pub(crate) mod design_cases;
    pub(crate) mod problems;
    pub(crate) mod transfer;
}

use common::{
    cases::{Case, every_case},
    changes::Change,
    design_cases::design_cases,
    problems::Problem,
};

const RUNS: u32 = 20;

type Redraw = fn(&Case, u64) -> Problem;

fn main() {
    let columns: [(&str, Redraw); 6] = [
        ("coordinates", |case, seed| Change::coordinates(&case.problem, seed).of(&case.problem)),
        ("units 1e±2", |case, seed| units(case, &case.problem, 2.0, seed)),
        ("units 1e±3", |case, seed| units(case, &case.problem, 3.0, seed)),
        ("units 1e±4", |case, seed| units(case, &case.problem, 4.0, seed)),
        ("units 1e±5", |case, seed| units(case, &case.problem, 5.0, seed)),
        ("coordinates, then units 1e±4", |case, seed| {
            let mixed = Change::coordinates(&case.problem, seed).of(&case.problem);
            units(case, &mixed, 4.0, seed)
        }),
    ];
    let head: Vec<_> = columns.iter().map(|(name, _)| *name).collect();
    println!("| case | as published | {} |", head.join(" | "));
    println!("|---|---|{}", "---|".repeat(columns.len()));
    let (mut wrong, mut all) = (vec![0; columns.len()], 0);
    let aloud = std::env::args().nth(1);
    let first: u64 = std::env::args().nth(2).map_or(0, |seed| seed.parse().unwrap());
    for case in every_case().into_iter().chain(design_cases()) {
        let right = |problem: &Problem| {
            let found = (case.ask)(problem).unwrap_or_else(|error| error.to_string());
            if aloud.as_ref().is_some_and(|word| case.name.contains(word.as_str()))
                && found != case.answer
            {
                println!("{}: {found}", case.name);
            }
            found == case.answer
        };
        let counts: Vec<_> = columns
            .iter()
            .map(|(_, redraw)| {
                let seeds = (0..RUNS).map(|run| first + u64::from(run));
                seeds.filter(|&seed| !right(&redraw(&case, seed))).count()
            })
            .collect();
        let published = if right(&case.problem) { "right" } else { "wrong" };
        let cells: Vec<_> = counts.iter().map(ToString::to_string).collect();
        println!("| {} | {published} | {} |", case.name, cells.join(" | "));
        wrong.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
        all += RUNS;
    }
    let shares = wrong.iter().map(|&count| format!("{count} of {all}"));
    println!("| **wrong** | | {} |", shares.collect::<Vec<_>>().join(" | "));
}

fn units(case: &Case, problem: &Problem, decades: f64, seed: u64) -> Problem {
    Change::units(problem, decades, !case.keeps_units_of_faults, seed).of(problem)
}
