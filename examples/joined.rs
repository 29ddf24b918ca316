//! The two halves joined, over nonlinear engines: the tables of `docs/results/nonlinear.md`. Arguments are the number
//! of engines, the first seed, `quick` to leave out the filters (up to minutes per engine), and scenarios by name;
//! without these all.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints")]

use std::{collections::BTreeMap, error::Error, time::Instant};

use fd_lab::engine::joined::{JoinedTrial, Residual, scenarios, table};
use rayon::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let engines: u64 = arguments.next().map_or(Ok(8), |text| text.parse())?;
    let first: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let mut wanted: Vec<String> = arguments.collect();
    let is_quick = wanted.first().is_some_and(|word| word == "quick");
    let asked: &[Residual] = if is_quick { &Residual::QUICK } else { &Residual::ALL };
    wanted.retain(|word| word != "quick");
    for scenario in scenarios() {
        if !wanted.is_empty() && !wanted.iter().any(|name| name == scenario.name) {
            continue;
        }
        let begin = Instant::now();
        let seeds: Vec<u64> = (first..first + engines).collect();
        let one = |&seed: &u64| {
            let trial = scenario.trial(seed, asked);
            match &trial {
                Ok(trial) => tell(scenario.name, asked, trial),
                Err(error) => eprintln!("{} {seed}: {error}", scenario.name),
            }
            trial.ok()
        };
        let trials: Vec<JoinedTrial> = seeds.par_iter().filter_map(one).collect();
        let mut named: BTreeMap<&str, usize> = BTreeMap::new();
        for trial in &trials {
            *named.entry(&trial.named).or_default() += 1;
        }
        println!("## {}\n\n{}.\n\n{}", scenario.name, scenario.about, table(&trials));
        println!("Named: {named:?}; {} s.\n", begin.elapsed().as_secs());
    }
    Ok(())
}

/// What was named on an engine, and what could not watch it.
fn tell(scenario: &str, asked: &[Residual], trial: &JoinedTrial) {
    let JoinedTrial { seed, named, diagnosis_s, diagnosis_runs, .. } = trial;
    eprintln!("{scenario} {seed}: {named} ({diagnosis_s:.0} s, {diagnosis_runs:.0} runs)");
    for (residual, found) in Residual::ALL.iter().zip(&trial.residuals) {
        if let (Err(error), true) = (found, asked.contains(residual)) {
            eprintln!("  {}: {error}", residual.name());
        }
    }
}
