//! The map of the engine benchmark: where compensation delivers, and where it does not.
//!
//! `cargo run --release -p fd-lab --example engine_map -- 200` prints the table of
//! `docs/results/engine.md`; a second argument picks the rows that contain it.
#![allow(clippy::print_stdout, reason = "an example that prints a table")]

use std::error::Error;

use fd_lab::engine::{Benchmark, EngineChoice, EngineConfig, Range, ReductionConfig};
use fdiag::{
    compensate::residual_compensation::{Mode, Timeout},
    ident::{arx::ArxOrders, order::Criterion, rls::RlsDesign},
    jetengine::Perturbation,
    spec::{GeneratorSpec, LearningSpec, OrderSpec},
};

/// One thing that differs from the default configuration.
type Change = (&'static str, &'static str, fn(&mut EngineConfig));

const CHANGES: &[Change] = &[
    ("default", "", |_| {}),
    ("noise [of reading]", "0 (the paper)", |c| c.plant.noise = 0.0),
    ("", "1e-3", |c| c.plant.noise = 1e-3),
    ("", "2e-3", |c| c.plant.noise = 2e-3),
    ("order n", "1", |c| order(c, 1)),
    ("", "3", |c| order(c, 3)),
    ("", "5", |c| order(c, 5)),
    ("", "chosen by held-out simulation", |c| {
        c.pipeline.bias.orders =
            OrderSpec::Select { most: 5, criterion: Criterion::default(), offset: false };
    }),
    ("learning", "least squares without prefilter", |c| {
        c.pipeline.bias.learning = LearningSpec::Batch { prefilter_rad_s: None };
    }),
    ("", "recursive, on line (eq. 18), frozen at the end of the run", |c| {
        c.pipeline.bias.learning = LearningSpec::Recursive(RlsDesign::default());
        c.pipeline.compensation.convergence.longest = Some(1_100);
        c.pipeline.compensation.convergence.at_longest = Timeout::FreezeAnyway;
    }),
    ("compensation", "one-step prediction", |c| c.pipeline.compensation.mode = Mode::OneStep),
    ("training input", "one step and five tones (the paper)", paper_training),
    ("", "the same, order 3, without prefilter", |c| {
        paper_training(c);
        order(c, 3);
        c.pipeline.bias.learning = LearningSpec::Batch { prefilter_rad_s: None };
    }),
    ("observer", "error dies out at 0.5 /s", |c| observer(c, 0.5)),
    ("", "10 /s", |c| observer(c, 10.0)),
    ("", "50 /s", |c| observer(c, 50.0)),
    ("", "Kalman, state noise = output noise", |c| {
        c.pipeline.generator = GeneratorSpec::Kalman { process_noise: 1.0, output_noise: 1.0 };
    }),
    ("", "none: open-loop simulation", |c| c.pipeline.generator = GeneratorSpec::Simulation {}),
    ("sample time [s]", "0.0025, open-loop simulation", |c| {
        c.sample_time_s = 0.0025;
        c.pipeline.generator = GeneratorSpec::Simulation {};
    }),
    ("", "0.01", |c| c.sample_time_s = 0.01),
    ("", "0.025", |c| c.sample_time_s = 0.025),
    ("", "0.1", |c| c.sample_time_s = 0.1),
    ("reduction 17 to 5", "balanced truncation", |c| {
        c.reduction = ReductionConfig::BalancedTruncation { order: 5 };
    }),
    ("", "balanced residualisation", |c| {
        c.reduction = ReductionConfig::BalancedResidualisation { order: 5 };
    }),
    ("perturbation", "none: reduction error only", |c| {
        c.plant.perturbation = Perturbation::None {};
    }),
    ("", "3 % of A and B", |c| matrices(c, 0.03)),
    ("", "20 % of A and B", |c| matrices(c, 0.2)),
    ("", "10 % of volumes, inertias, maps", |c| {
        c.plant.perturbation = Perturbation::Physical { fraction: 0.1 };
    }),
    ("", "2 % of module health", |c| {
        c.plant.perturbation = Perturbation::Health { fraction: 0.02 }
    }),
    ("operating point", "idle, 0.12 kg/s", |c| point(c, 0.12)),
    ("", "mid, 0.40 kg/s", |c| point(c, 0.4)),
    ("", "high, 0.95 kg/s", |c| point(c, 0.95)),
];

fn main() -> Result<(), Box<dyn Error>> {
    let seeds = std::env::args().nth(1).map_or(Ok(200), |n| n.parse())?;
    let only = std::env::args().nth(2).unwrap_or_default();
    println!(
        "| changed | to | fault-free residual, times smaller | smallest T7 fault, times smaller | smallest P6 fault, times smaller | false alarms [% of runs] primary / compensated | no diagnosis |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (what, to, change) in CHANGES.iter().filter(|(_, to, _)| to.contains(&only)) {
        // Seeds that the default configuration was not chosen on.
        let mut config = EngineConfig { seeds, first_seed: 50_001, ..EngineConfig::default() };
        config.on_line.run = false;
        change(&mut config);
        let row = match Benchmark::new(config)?.study(&()) {
            Ok(study) => {
                let s = &study.summary;
                let faults: Vec<String> =
                    s.faults.iter().map(|fault| range(&fault.smallest_ratio)).collect();
                format!(
                    "{} | {} | {:.1} / {:.1} | {}",
                    range(&s.fault_free_ratio),
                    faults.join(" | "),
                    100.0 * s.false_alarms_primary,
                    100.0 * s.false_alarms_compensated,
                    study.failed.len(),
                )
            }
            Err(error) => format!("{error} | | | | all"),
        };
        println!("| {what} | {to} | {row} |");
    }
    Ok(())
}

fn range(r: &Range) -> String {
    let text = fd_model::figure;
    format!("{} [{} .. {}]", text(r.median), text(r.low), text(r.high))
}

fn order(config: &mut EngineConfig, n: usize) {
    config.pipeline.bias.orders = OrderSpec::Fixed(ArxOrders::paper(n));
}

fn observer(config: &mut EngineConfig, rate: f64) {
    config.pipeline.generator = GeneratorSpec::Observer { rate };
}

fn matrices(config: &mut EngineConfig, fraction: f64) {
    if let Perturbation::Matrices(matrices) = &mut config.plant.perturbation {
        matrices.fraction = fraction;
    }
}

fn point(config: &mut EngineConfig, fuel_kg_s: f64) {
    config.plant.engine = EngineChoice::Engine17 { fuel_kg_s };
}

fn paper_training(config: &mut EngineConfig) {
    let training = &mut config.training;
    training.steps.clear();
    training.tones = 5;
    training.tone_band_rad_s = (0.5, 9.0);
    training.tone_amplitude = 0.02;
}
