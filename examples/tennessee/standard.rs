//! Detection rates on the standard data of the Tennessee Eastman process beside published ones, as Markdown.
//!
//! The data set is that of Russell, Chiang and Braatz (2000); it can be had, free, from
//! <https://github.com/camaramm/tennessee-eastman-profBraatz>. Of its folder are read
//!
//! * `d00.dat`: 52 lines of 500 numbers (or 500 lines of 52), the healthy run that is learned from,
//! * `d00_te.dat`: 960 lines of 52 numbers, another healthy run,
//! * `d01_te.dat` to `d21_te.dat`: as many, with a fault from the 161st line on.
//!
//! Numbers are separated by spaces: 41 measurements, then 11 manipulated variables, every 3 min.
//!
//! ```text
//! cargo run -p fdiag --example tennessee_standard -- FOLDER
//! ```
#![allow(clippy::print_stdout, reason = "an example prints")]

mod columns;
mod published;

use std::{env, fs, path::Path};

use columns::{Column, Outcome, add, chi_square};
use fdiag::{
    data::{
        cva::CvaDesign,
        limits::empirical,
        monitor::MonitorDesign,
        parity::DataParityDesign,
        pca::{Components, PcaDesign},
    },
    model::{Channel, Record, SampleTime},
};
use published::{
    DEEP, DIALLO, LV_Q, LV_T2, Published, VARIATE_KERNELS, YIN_9, YIN_17, YIN_DYNAMIC,
};

/// Lines of a run before its fault begins.
const ONSET: usize = 160;
const LEVEL: f64 = 0.99;
const WIDTH: usize = 52;

fn main() -> Outcome<()> {
    let folder = env::args().nth(1).ok_or("expected the folder with d00.dat .. d21_te.dat")?;
    let folder = Path::new(&folder);
    let learned = lines(&folder.join("d00.dat"))?;
    let tests = (0..=21)
        .map(|fault| lines(&folder.join(format!("d{fault:02}_te.dat"))))
        .collect::<Outcome<Vec<_>>>()?;
    let records = |measurements: usize| -> Outcome<(Record, Vec<Record>)> {
        let tests = tests.iter().map(|test| record(test, measurements)).collect::<Outcome<_>>()?;
        Ok((record(&learned, measurements)?, tests))
    };
    // Without the compositions, which are analysed only every 6 to 15 min.
    let (train, runs) = records(22)?;
    either(&train, &runs)?;
    let (train, runs) = records(41)?;
    false_alarms(&train, &runs[0])?;
    each(&train, &runs)
}

/// T² or Q above its limit by formula, as Yin et al. count.
fn either(train: &Record, runs: &[Record]) -> Outcome<()> {
    println!("## T² or Q above its limit by formula at 99 %, 33 channels\n");
    let pairs = [(0, 9, YIN_9), (0, 17, YIN_17), (2, 17, YIN_DYNAMIC)];
    let mut ours = Vec::new();
    for (lags, count, published) in &pairs {
        let components = Components::Count(*count);
        let pca = PcaDesign { lags: *lags, components, ..PcaDesign::default() }
            .learn(std::slice::from_ref(train))?;
        let share = |run: &Record| flagged(pca.monitor(), run);
        let rates = runs.iter().map(share).collect::<Outcome<Vec<f64>>>()?;
        let what = if *lags > 0 { "DPCA" } else { "PCA" };
        ours.push((format!("{what} {count}"), rates, published));
    }
    let names: Vec<String> =
        ours.iter().map(|(name, _, published)| format!("{name} | {}", published.name)).collect();
    head(&names, 2);
    for fault in 0..=21 {
        let cells: Vec<String> = ours
            .iter()
            .map(|(_, rates, published)| {
                format!("{:.2} | {}", rates[fault], cell(of(published, fault), 2))
            })
            .collect();
        println!("| {} | {} |", name(fault), cells.join(" | "));
    }
    for (name, rates, published) in &ours {
        let differences = (0..=21).map(|fault| (rates[fault] - of(published, fault)).abs());
        // `max` leaves out what is not a number.
        println!("\n{name}: at most {:.2} points apart.", differences.fold(0.0, f64::max));
    }
    Ok(())
}

/// Share of the samples from the onset on, in per cent, in which a statistic is above its limit.
fn flagged(monitor: &MonitorDesign, run: &Record) -> Outcome<f64> {
    let (all, limits) = (monitor.statistics(run)?, monitor.limits());
    let late = all.into_iter().skip(ONSET);
    let above: Vec<f64> = late
        .map(|s| f64::from(u8::from(s.is_some_and(|s| s.t2 > limits.t2 || s.q > limits.q))))
        .collect();
    Ok(100.0 * above.iter().sum::<f64>() / above.len() as f64)
}

/// How often the formulas alarm on the other healthy run, as Diallo et al. count.
fn false_alarms(train: &Record, healthy: &Record) -> Outcome<()> {
    println!("\n## False alarms on d00_te with limits by formula, 52 channels\n");
    let pca = PcaDesign::default().learn(std::slice::from_ref(train))?;
    let found = pca.monitor().components();
    println!("| PCA {found} | T² | Diallo, PCA 11, T² | Q | Diallo, PCA 11, SPE |");
    println!("|---|---|---|---|---|");
    for (level, t2, q) in DIALLO {
        let monitor = pca.monitor().clone().limited(level)?;
        let (all, limits) = (monitor.statistics(healthy)?, monitor.limits());
        let all: Vec<_> = all.into_iter().flatten().collect();
        let share = |count: usize| 100.0 * count as f64 / all.len() as f64;
        println!(
            "| at {:.0} % | {:.2} | {t2:.2} | {:.2} | {q:.2} |",
            100.0 * level,
            share(all.iter().filter(|s| s.t2 > limits.t2).count()),
            share(all.iter().filter(|s| s.q > limits.q).count()),
        );
    }
    Ok(())
}

/// Every statistic by itself, above the limit that 1 % of the samples of `d00_te` exceed.
fn each(train: &Record, runs: &[Record]) -> Outcome<()> {
    let train = std::slice::from_ref(train);
    let mut columns = Vec::new();
    let pca = PcaDesign::default().learn(train)?;
    add(&mut columns, "PCA", pca.monitor());
    let dpca = PcaDesign { lags: 2, ..PcaDesign::default() }.learn(train)?;
    add(&mut columns, "DPCA", dpca.monitor());
    let cva = CvaDesign { past: 3, future: 3, ..CvaDesign::default() }.learn(train)?;
    add(&mut columns, "CVA", cva.monitor());
    let parity = DataParityDesign { order: 2, states: None }.learn(train)?;
    for window in [1, 20] {
        columns.push(chi_square(parity.map(), train, window)?);
    }
    println!("\n## Each statistic above the limit that 1 % of d00_te exceeds, 52 channels\n");
    println!(
        "PCA {} components; DPCA, 2 lags, {} of {}; CVA, 3 past and 3 future, {} states of {}; parity, order \
         2, {} states, {} relations.\n",
        pca.monitor().components(),
        dpca.monitor().components(),
        dpca.eigenvalues().len(),
        cva.monitor().components(),
        cva.correlations().len(),
        parity.states(),
        parity.map().map().nrows(),
    );
    for column in &mut columns {
        column.limit = empirical(&(column.values)(&runs[0])?, LEVEL)?;
    }
    let published = [LV_T2, LV_Q, DEEP, VARIATE_KERNELS];
    let names: Vec<String> = (columns.iter().map(|column| column.name.clone()))
        .chain(published.iter().map(|published| published.name.to_owned()))
        .collect();
    head(&names, 1);
    for fault in 0..=21 {
        let mut cells = Vec::new();
        for column in &columns {
            cells.push(cell(share(column, fault, runs)?, 1));
        }
        cells.extend(published.iter().map(|published| cell(of(published, fault), 1)));
        println!("| {} | {} |", name(fault), cells.join(" | "));
    }
    Ok(())
}

/// Samples above the limit, in per cent: after the onset of a fault, or before it in all the faulty runs.
fn share(column: &Column, fault: usize, runs: &[Record]) -> Outcome<f64> {
    let mut values = Vec::new();
    if fault == 0 {
        for run in &runs[1..] {
            values.extend((column.values)(&run.slice(0, ONSET))?);
        }
    } else {
        // What is missing are windows that are not full, all of them before the onset.
        let all = (column.values)(&runs[fault])?;
        values.extend(all.into_iter().rev().take(runs[fault].len() - ONSET));
    }
    let above = values.iter().filter(|&&value| value > column.limit).count();
    Ok(100.0 * above as f64 / values.len() as f64)
}

/// The lines of a file of the data set, 52 numbers each.
fn lines(path: &Path) -> Outcome<Vec<Vec<f64>>> {
    let at = |line: usize| format!("{}, line {}", path.display(), line + 1);
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let mut rows: Vec<Vec<f64>> = Vec::new();
    for (k, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let row: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let row = row.map_err(|error| format!("{}: {error}", at(k)))?;
        if let Some(first) = rows.first().filter(|first| first.len() != row.len()) {
            return Err(format!(
                "{}: expected {} numbers, found {}",
                at(k),
                first.len(),
                row.len()
            )
            .into());
        }
        rows.push(row);
    }
    match (rows.len(), rows.first().map_or(0, Vec::len)) {
        (_, WIDTH) => Ok(rows),
        // The run that is learned from lies on its side.
        (WIDTH, length) => {
            Ok((0..length).map(|k| rows.iter().map(|row| row[k]).collect()).collect())
        }
        (lines, numbers) => Err(format!(
            "{}: expected 52 numbers a line or 52 lines, found {lines} lines of {numbers}",
            path.display()
        )
        .into()),
    }
}

/// So many measurements and all manipulated variables.
fn record(lines: &[Vec<f64>], measurements: usize) -> Outcome<Record> {
    let (outputs, inputs) =
        (Channel::numbered("xmeas_", measurements), Channel::numbered("xmv_", 11));
    let u: Vec<f64> = lines.iter().flat_map(|line| line[41..WIDTH].iter().copied()).collect();
    let y: Vec<f64> = lines.iter().flat_map(|line| line[..measurements].iter().copied()).collect();
    Ok(Record::new(inputs, outputs, u, y, SampleTime::new(180.0)?)?)
}

fn of(published: &Published, fault: usize) -> f64 {
    if fault == 0 { published.false_alarms } else { published.rates[fault - 1] }
}

fn name(fault: usize) -> String {
    if fault == 0 { "no fault".to_owned() } else { format!("IDV({fault})") }
}

fn cell(rate: f64, digits: usize) -> String {
    if rate.is_nan() { "–".to_owned() } else { format!("{rate:.digits$}") }
}

fn head(names: &[String], width: usize) {
    println!("| | {} |\n|---|{}", names.join(" | "), "---|".repeat(width * names.len()));
}
