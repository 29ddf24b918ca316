//! The tables of a study.
#![allow(clippy::print_stdout, reason = "an example prints")]

use fdiag::model::figure;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::{DETECTORS, Fault, RUNS, Sizes, Study, Unit};

/// The whole table for the first detector, then a line for each compensator and detector.
pub(super) fn print(study: &Study<'_>, factors: &[f64], test: &[Unit]) {
    let names: Vec<String> = study.faults.iter().map(heading).collect();
    println!("| residual | compensated | false alarms [%] | {} |", names.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(names.len()));
    let (ways, detectors) = (study.compensators.len(), DETECTORS.len());
    let entry = |generator: usize, way: usize, detector: usize| {
        (generator * ways + way) * detectors + detector
    };
    for (generator, (name, _)) in study.generators.iter().enumerate() {
        for (way, (compensator, _)) in study.compensators.iter().enumerate() {
            let entry = entry(generator, way, 0);
            let cells: Vec<String> = study
                .faults
                .iter()
                .enumerate()
                .map(|(fault, told)| cell(study, told, &found(test, entry, fault)))
                .collect();
            let alarms = false_alarms(factors, test, entry);
            let refused = match test.len() - alarms.len() {
                0 => String::new(),
                count => format!(", not learned on {count}"),
            };
            let alarms = interval(&alarms);
            println!("| {name} | {compensator}{refused} | {alarms} | {} |", cells.join(" | "));
        }
    }
    println!();
    println!("| detector | compensated | false alarms [%] | {} |", names.join(" | "));
    println!("|---|---|---|{}", "---|".repeat(names.len()));
    for (detector, (name, _)) in DETECTORS.iter().enumerate() {
        for (way, (compensator, _)) in study.compensators.iter().enumerate() {
            let entries: Vec<usize> =
                (0..study.generators.len()).map(|i| entry(i, way, detector)).collect();
            let cells: Vec<String> = study
                .faults
                .iter()
                .enumerate()
                .map(|(fault, told)| best(study, told, test, &entries, fault))
                .collect();
            let alarms: Vec<f64> =
                entries.iter().flat_map(|&entry| false_alarms(factors, test, entry)).collect();
            let mean = alarms.iter().sum::<f64>() / alarms.len() as f64;
            println!("| {name} | {compensator} | {mean:.1} | {} |", cells.join(" | "));
        }
    }
}

fn heading(fault: &Fault) -> String {
    match fault.sizes {
        Sizes::Range { .. } => format!("{} [{}]", fault.name, fault.unit),
        Sizes::Published => fault.name.to_owned(),
    }
}

/// Delay in samples per plant and size.
fn found(test: &[Unit], entry: usize, fault: usize) -> Vec<Vec<Option<usize>>> {
    test.iter().filter_map(|unit| unit.found[entry].get(fault).cloned()).collect()
}

/// Percentage of the healthy runs of each plant that alarmed.
fn false_alarms(factors: &[f64], test: &[Unit], entry: usize) -> Vec<f64> {
    let over = |unit: &Unit| {
        let count = unit.healthy[entry].iter().filter(|&&value| value > factors[entry]).count();
        100.0 * count as f64 / RUNS as f64
    };
    test.iter().filter(|unit| !unit.healthy[entry].is_empty()).map(over).collect()
}

fn cell(study: &Study<'_>, fault: &Fault, found: &[Vec<Option<usize>>]) -> String {
    match fault.sizes {
        Sizes::Range { .. } => half(fault, found),
        Sizes::Published => share(study, found),
    }
}

/// The best of several generators: its smallest size or its largest share, and which one it is.
fn best(study: &Study<'_>, fault: &Fault, test: &[Unit], entries: &[usize], at: usize) -> String {
    let ranked = entries.iter().enumerate().filter_map(|(generator, &entry)| {
        let found = found(test, entry, at);
        if found.is_empty() {
            return None;
        }
        let everyone: Vec<usize> = (0..found.len()).collect();
        let rank = match fault.sizes {
            Sizes::Range { count, .. } => crossing(count, &found, &everyone),
            Sizes::Published => {
                // Most plants first; among equals, the sooner.
                let missed = found.iter().filter(|sizes| sizes[0].is_none()).count() as f64;
                let delays: usize = found.iter().filter_map(|sizes| sizes[0]).sum();
                missed + 1e-9 * delays as f64
            }
        };
        Some((rank, generator, found))
    });
    let Some((_, generator, found)) = ranked.min_by(|a, b| a.0.total_cmp(&b.0)) else {
        return String::new();
    };
    format!("{}: {}", study.generators[generator].0, cell(study, fault, &found))
}

/// The share of plants on which the fault is found, with the interval of Wilson (1927), and the median delay.
fn share(study: &Study<'_>, found: &[Vec<Option<usize>>]) -> String {
    if found.is_empty() {
        return "–".to_owned();
    }
    let mut delays: Vec<usize> = found.iter().filter_map(|sizes| sizes[0]).collect();
    delays.sort_unstable();
    let n = found.len() as f64;
    let p = delays.len() as f64 / n;
    let z2 = 1.96 * 1.96;
    let middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let spread = 1.96 * (p * (1.0 - p) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
    let told = format!(
        "{:.0} % [{:.0} .. {:.0}]",
        100.0 * p,
        100.0 * (middle - spread),
        100.0 * (middle + spread)
    );
    match delays.get(delays.len() / 2) {
        Some(&median) => format!("{told} after {} s", figure((median + 1) as f64 * study.ts_s)),
        None => told,
    }
}

/// Mean over plants and twice its standard error, in per cent; runs of one plant are not independent.
fn interval(shares: &[f64]) -> String {
    let n = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / n;
    let square = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>();
    format!("{mean:.1} ± {:.1}", 2.0 * (square / (n * (n - 1.0))).sqrt())
}

/// Place among the sizes that is found on half of some plants.
fn crossing(count: usize, found: &[Vec<Option<usize>>], plants: &[usize]) -> f64 {
    let share = |i: usize| {
        let hits = plants.iter().filter(|&&plant| found[plant][i].is_some()).count();
        hits as f64 / plants.len() as f64
    };
    // The last size that is found on less than half.
    match (0..count).rev().find(|&i| share(i) < 0.5) {
        None => 0.0,
        Some(i) if i + 1 == count => f64::INFINITY,
        Some(i) => i as f64 + (0.5 - share(i)) / (share(i + 1) - share(i)),
    }
}

/// The size that is found on half of the plants, interpolated in the logarithm, with the interval in which it lies
/// for 95 of 100 draws of as many plants.
fn half(fault: &Fault, found: &[Vec<Option<usize>>]) -> String {
    if found.is_empty() {
        return "–".to_owned();
    }
    let count = fault.sizes.count();
    let mut random = Xoshiro256PlusPlus::seed_from_u64(0);
    let mut drawn: Vec<f64> = (0..400)
        .map(|_| {
            let plants: Vec<usize> =
                (0..found.len()).map(|_| random.random_range(0..found.len())).collect();
            crossing(count, found, &plants)
        })
        .collect();
    drawn.sort_by(f64::total_cmp);
    let words = |at: f64| match at {
        at if at <= 0.0 => format!("< {}", fault.sizes.at(0.0)),
        at if at.is_infinite() => format!("> {}", fault.sizes.at((count - 1) as f64)),
        at => figure(fault.sizes.at(at)),
    };
    let all: Vec<usize> = (0..found.len()).collect();
    let told = words(crossing(count, found, &all));
    format!("{told} [{} .. {}]", words(drawn[10]), words(drawn[389]))
}
