//! Detection rates on the Tennessee Eastman process at equal rates of false alarms, as Markdown.
//!
//! ```text
//! pip install tep-studio==0.2.0
//! python examples/tennessee/make_logs.py LOGS
//! cargo run -p fdiag --example tennessee -- LOGS
//! ```
#![allow(clippy::print_stdout, reason = "an example prints")]

use std::{env, error::Error, fs, path::Path};

use fdiag::{
    compensate::{SampleRows, detect::ChiSquare},
    core::{
        Frame,
        stage::{Detector, ResidualGenerator, Stage},
    },
    data::{
        cva::CvaDesign, limits::empirical, monitor::MonitorDesign, parity::DataParityDesign,
        pca::PcaDesign, window::WindowMapDesign,
    },
    log::{LogMap, read_log},
    model::{Channel, Record},
};

/// Samples of 3 min before a disturbance begins; no log is looked at before.
const ONSET: usize = 160;
const LEVEL: f64 = 0.99;

type Outcome<T> = Result<T, Box<dyn Error>>;
/// The values of a statistic for the samples of a log.
type Values = dyn Fn(&Record) -> Outcome<Vec<f64>>;

/// One statistic: what it is called, and its values for the samples of a log.
struct Column {
    name: String,
    values: Box<Values>,
    limit: f64,
}

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

/// The statistics of a monitor.
fn add(columns: &mut Vec<Column>, name: &str, monitor: &MonitorDesign) {
    let mut push = |what: &str, of: fn(&fdiag::data::monitor::Statistics<f64>) -> Option<f64>| {
        let design = monitor.clone();
        let values = move |record: &Record| -> Outcome<Vec<f64>> {
            Ok(design.statistics(record)?.iter().flatten().filter_map(of).collect())
        };
        let (name, values) = (format!("{name} {what}"), Box::new(values));
        columns.push(Column { name, values, limit: f64::INFINITY });
    };
    push("T²", |s| Some(s.t2));
    if monitor.limits().rest.is_some() {
        push("T² of the rest", |s| s.rest);
    }
    push("Q", |s| Some(s.q));
}

/// The chi-square of a residual over a window, its covariance from the logs that were learned from.
fn chi_square(map: &WindowMapDesign, train: &[Record], window: usize) -> Outcome<Column> {
    let mut rows = Vec::new();
    for record in train {
        rows.extend(residuals(map, record)?.concat());
    }
    let detector: ChiSquare<f64> =
        ChiSquare::from_fault_free(SampleRows::new(map.map().nrows(), &rows)?, window, 1.0)?;
    let map = map.clone();
    let values = move |record: &Record| -> Outcome<Vec<f64>> {
        let mut detector = detector.clone();
        detector.reset();
        let all = residuals(&map, record)?;
        let all: Vec<f64> = all.iter().map(|r| detector.update(&[], r).statistic).collect();
        Ok(all.into_iter().skip(window - 1).collect())
    };
    let name = format!("parity, χ² of {window}");
    Ok(Column { name, values: Box::new(values), limit: f64::INFINITY })
}

fn residuals(map: &WindowMapDesign, record: &Record) -> Outcome<Vec<Vec<f64>>> {
    let mut running = map.freeze::<f64>()?;
    let mut r = vec![0.0; running.residual_len()];
    let mut all = Vec::new();
    for (k, (u, y)) in record.samples().enumerate() {
        running.step(Frame::new(map.io(), k as u64, u, y)?, &mut r);
        all.push(r.clone());
    }
    Ok(all.split_off(map.order()))
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
