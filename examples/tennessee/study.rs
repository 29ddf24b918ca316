//! Detection rates on the Tennessee Eastman process at equal rates of false alarms, as Markdown.
//!
//! ```text
//! pip install tep-studio==0.2.0
//! python examples/tennessee/make_logs.py LOGS
//! cargo run -p fdiag --example tennessee -- LOGS
//! ```
#![allow(clippy::print_stdout, reason = "an example prints")]

mod columns;

use std::{env, fs, path::Path};

use columns::{Column, Outcome, add, chi_square};
use fdiag::{
    data::{cva::CvaDesign, limits::empirical, parity::DataParityDesign, pca::PcaDesign},
    log::{LogMap, read_log},
    model::{Channel, Record},
};

/// Samples of 3 min before a disturbance begins; no log is looked at before.
const ONSET: usize = 160;
const LEVEL: f64 = 0.99;

fn main() -> Outcome<()> {
    let folder = env::args().nth(1).ok_or("expected the folder of the logs")?;
    let folder = Path::new(&folder);
    let moving = |record: &Record, j: usize| {
        let first = record.u(ONSET)[j];
        record.input(j).skip(ONSET).any(|u| (u - first).abs() > 1e-6 * first.abs())
    };
    let all: Vec<usize> = (1..=11).collect();
    let probe = logs(folder, "train_", &all)?;
    let inputs: Vec<usize> =
        all.into_iter().filter(|j| probe.iter().all(|r| moving(r, j - 1))).collect();
    let [train, limit, healthy] =
        ["train_", "limit_", "healthy_"].map(|part| logs(folder, part, &inputs));
    let (train, limit, healthy) = (cut(&train?), cut(&limit?), cut(&healthy?));
    let (samples, width) = (train.iter().map(Record::len).sum::<usize>(), 41 + inputs.len());
    println!("{width} channels; xmv that move: {inputs:?}; {samples} samples learned from.\n");

    let mut columns = Vec::new();
    let pca = PcaDesign::default().learn(&train)?;
    add(&mut columns, "PCA", pca.monitor());
    let dpca = PcaDesign { lags: 2, ..PcaDesign::default() }.learn(&train)?;
    add(&mut columns, "DPCA", dpca.monitor());
    let cva = CvaDesign { past: 3, future: 3, ..CvaDesign::default() }.learn(&train)?;
    add(&mut columns, "CVA", cva.monitor());
    let parity = DataParityDesign { order: 2, states: None }.learn(&train)?;
    for window in [1, 20] {
        columns.push(chi_square(parity.map(), &train, window)?);
    }
    println!(
        "Components: PCA {}, DPCA {} of {}, CVA {} states of {}; parity {} states, {} relations.\n",
        pca.monitor().components(),
        dpca.monitor().components(),
        dpca.eigenvalues().len(),
        cva.monitor().components(),
        cva.correlations().len(),
        parity.states(),
        parity.map().map().nrows(),
    );
    for column in &mut columns {
        let values: Vec<Vec<f64>> = limit.iter().map(&column.values).collect::<Outcome<_>>()?;
        column.limit = empirical(&values.concat(), LEVEL)?;
    }

    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    println!("| | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
    row("healthy", &columns, &healthy, interval)?;
    for fault in 1..=20 {
        let found = cut(&logs(folder, &format!("idv_{fault:02}_"), &inputs)?);
        row(&format!("IDV({fault})"), &columns, &found, range)?;
    }
    Ok(())
}

/// The logs whose names begin so, in order.
fn logs(folder: &Path, start: &str, inputs: &[usize]) -> Outcome<Vec<Record>> {
    let channel = |kind: &str, j: usize| Channel::new(format!("{kind}_{j}"), "1");
    let inputs: Vec<Channel> = inputs.iter().map(|&j| channel("xmv", j)).collect();
    let outputs: Vec<Channel> = (1..=41).map(|j| channel("xmeas", j)).collect();
    let map = LogMap::for_channels(&inputs, &outputs);
    let mut paths = Vec::new();
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_owned();
        if name.starts_with(start) && path.extension().is_some_and(|end| end == "csv") {
            paths.push(path);
        }
    }
    if paths.is_empty() {
        return Err(format!("{}: no logs {start}*.csv", folder.display()).into());
    }
    paths.sort();
    paths.iter().map(|path| Ok(read_log(path, &map)?.record)).collect()
}

/// From the onset on; a run that tripped before it does not count.
fn cut(records: &[Record]) -> Vec<Record> {
    let long = records.iter().filter(|record| ONSET < record.len());
    long.map(|record| record.slice(ONSET, record.len())).collect()
}

/// One line of the table: shares of samples above the limit, run by run, told by `tell`.
fn row(name: &str, columns: &[Column], runs: &[Record], tell: fn(&[f64]) -> String) -> Outcome<()> {
    let mut cells = Vec::new();
    for column in columns {
        let share = |record: &Record| -> Outcome<f64> {
            let values = (column.values)(record)?;
            let above = values.iter().filter(|&&value| value > column.limit).count();
            Ok(100.0 * above as f64 / values.len() as f64)
        };
        cells.push(tell(&runs.iter().map(share).collect::<Outcome<Vec<_>>>()?));
    }
    println!("| {name} | {} |", cells.join(" | "));
    Ok(())
}

/// Mean over runs and twice its standard error.
fn interval(shares: &[f64]) -> String {
    let n = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / n;
    let square = shares.iter().map(|share| (share - mean).powi(2)).sum::<f64>();
    format!("{mean:.2} ± {:.2}", 2.0 * (square / (n * (n - 1.0))).sqrt())
}

/// Mean over runs, and the least and the most.
fn range(shares: &[f64]) -> String {
    let mean = shares.iter().sum::<f64>() / shares.len() as f64;
    let (least, most) = shares.iter().fold((f64::INFINITY, 0.0_f64), |(least, most), &share| {
        (least.min(share), most.max(share))
    });
    format!("{mean:.0} ({least:.0}..{most:.0})")
}
