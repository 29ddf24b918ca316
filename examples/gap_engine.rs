//! One withheld cause in the nonlinear engine, against the linear and the nominal simulator: the
//! tables of `docs/results/gap-engine.md`. All six, or those that are named: `linear-weak`,
//! `linear-strong`, `nonlinear-weak`, `nonlinear-strong`, `few-runs-weak`, `few-runs-strong`.
#![allow(clippy::print_stdout, clippy::print_stderr, reason = "an example prints")]

use std::{collections::BTreeMap, error::Error, time::Instant};

use fd_lab::engine_gap::{
    Answer, EngineCause, diagnose_engine, diagnose_with_few_runs, engine_log,
};
use fdiag::{
    engine_plant::{EngineKnowledge, engine_effects, simulator},
    jetengine::engine17::HealthParameter,
    model::SampleTime,
};

fn main() -> Result<(), Box<dyn Error>> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    for manner in [Manner::Linear, Manner::Nonlinear, Manner::FewRuns] {
        for is_strong in [false, true] {
            let name = format!("{}-{}", manner.name(), if is_strong { "strong" } else { "weak" });
            if wanted.is_empty() || wanted.contains(&name) {
                println!("\n{name}\n");
                table(manner, is_strong)?;
            }
        }
    }
    Ok(())
}

/// The simulator, and how it is asked.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// The linear engine.
    Linear,
    /// The nonlinear one.
    Nonlinear,
    /// The same as a black box with few runs.
    FewRuns,
}

impl Manner {
    fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Nonlinear => "nonlinear",
            Self::FewRuns => "few-runs",
        }
    }
}

/// What is withheld, weak and strong.
fn causes() -> [[EngineCause; 2]; 14] {
    use HealthParameter as H;
    let health = |parameter, shifts: [f64; 2]| shifts.map(|x| EngineCause::Health(parameter, x));
    [
        health(H::LpcEfficiency, [-0.006, -0.02]),
        health(H::HpcEfficiency, [-0.006, -0.02]),
        health(H::HptEfficiency, [-0.006, -0.02]),
        health(H::LptEfficiency, [-0.006, -0.02]),
        health(H::HpcFlow, [-0.006, -0.02]),
        health(H::LptFlow, [0.006, 0.02]),
        health(H::BleedLeak, [0.004, 0.015]),
        health(H::NozzleArea, [0.004, 0.015]),
        [0.15, 0.7].map(|lag| EngineCause::SensorLag(2, lag)),
        [0.04, 0.1].map(|lag| EngineCause::SensorLag(3, lag)),
        [0.04, 0.15].map(EngineCause::FuelLag),
        [0.2, 0.05].map(EngineCause::FuelRateLimit),
        [0.1, 0.5].map(EngineCause::HeatSoak),
        [EngineCause::Nothing; 2],
    ]
}

/// One part of the table: 16 s of an engine of which the modules are known exactly.
fn table(manner: Manner, is_strong: bool) -> Result<(), Box<dyn Error>> {
    let begin = Instant::now();
    // Samples every 40 ms, simulated in steps of 6.7 ms.
    let known = EngineKnowledge {
        step: 0.04 / 6.0,
        module_tolerance: 0.0,
        ..EngineKnowledge::at(0.712, SampleTime::new(0.04)?)
    };
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    println!(
        "| withheld | strength | simulator | answer | verdict | first cause | p | strength | \
         gap refit | gap best | tied |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    for (i, pair) in causes().into_iter().enumerate() {
        let cause = pair[usize::from(is_strong)];
        let seed = 100 + 2 * i as u64 + u64::from(is_strong);
        let answer = row(&known, manner, cause, seed)?;
        *counts.entry(format!("{answer:?}")).or_default() += 1;
    }
    println!("{counts:?} in {:.0?}", begin.elapsed());
    Ok(())
}

/// One row.
fn row(
    known: &EngineKnowledge,
    manner: Manner,
    cause: EngineCause,
    seed: u64,
) -> Result<Answer, Box<dyn Error>> {
    let log = engine_log(known, cause, 400, seed)?;
    let begin = Instant::now();
    let (diagnosis, runs) = if manner == Manner::FewRuns {
        let found = diagnose_with_few_runs(known, engine_effects(), &log)?;
        let few = found.ok_or("the engine cannot be linearised along the log")?;
        (few.diagnosis, few.runs)
    } else {
        let nominal = simulator(known, manner == Manner::Linear)?;
        let diagnosis = diagnose_engine(&*nominal, engine_effects(), &log)?;
        let runs = diagnosis.simulations as f64;
        (diagnosis, runs)
    };
    let answer = Answer::of(&diagnosis, cause);
    let kind = manner.name();
    let first = &diagnosis.causes[0];
    let strength = &first.parameters[0];
    println!(
        "| {} {} | {} | {kind} | {answer:?} | {:?} | {} {} ({}) | {:.3} | {:.4} ± {:.4} | {:.2} | {:.2} | {} |",
        cause.name().0,
        cause.name().1,
        cause.strength(),
        diagnosis.verdict,
        first.label,
        first.site.name().unwrap_or_default(),
        first.law,
        first.probability,
        strength.value,
        strength.standard_error,
        worst(&diagnosis.refit.gap),
        worst(&diagnosis.best.gap),
        diagnosis.tied.len(),
    );
    eprintln!("    {runs:.0} runs, {} causes, {:.1?}", diagnosis.causes.len(), begin.elapsed());
    Ok(answer)
}

fn worst(gap: &[f64]) -> f64 {
    gap.iter().copied().fold(0.0, f64::max)
}
