//! The two halves joined, over nonlinear engines: the tables of `docs/results/nonlinear.md`. Arguments are the number
//! of engines, the first seed, `quick` to leave out the filters (minutes per engine), and scenarios by name; without these
//! all.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints")]

use std::{collections::BTreeMap, error::Error, time::Instant};

use fd_lab::engine::joined::{JoinedTrial, Residual, scenarios, table};

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
        let mut trials: Vec<JoinedTrial> = Vec::new();
        for seed in first..first + engines {
            match scenario.trial(seed, asked) {
                Ok(trial) => {
                    eprintln!(
                        "{} {seed}: {} ({:.0} s)",
                        scenario.name, trial.named, trial.diagnosis_s
                    );
                    for (residual, found) in Residual::ALL.iter().zip(&trial.residuals) {
                        if let (Err(error), true) = (found, asked.contains(residual)) {
                            eprintln!("  {}: {error}", residual.name());
                        }
                    }
                    trials.push(trial);
                }
                Err(error) => eprintln!("{} {seed}: {error}", scenario.name),
            }
        }
        let mut named: BTreeMap<&str, usize> = BTreeMap::new();
        for trial in &trials {
            *named.entry(&trial.named).or_default() += 1;
        }
        println!("## {}\n\n{}.\n\n{}", scenario.name, scenario.about, table(&trials));
        println!("Named: {named:?}; {} s.\n", begin.elapsed().as_secs());
    }
    Ok(())
}
