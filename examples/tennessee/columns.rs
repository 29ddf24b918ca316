//! The statistics that the studies of this folder compare.

use std::error::Error;

use fdiag::{
    compensate::{SampleRows, detect::ChiSquare},
    core::{
        Frame,
        stage::{Detector, ResidualGenerator, Stage},
    },
    data::{monitor::MonitorDesign, window::WindowMapDesign},
    model::Record,
};

pub(crate) type Outcome<T> = Result<T, Box<dyn Error>>;
/// The values of a statistic for the samples of a log, without those before the first full window.
type Values = dyn Fn(&Record) -> Outcome<Vec<f64>>;

/// One statistic: what it is called, and its values for the samples of a log.
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) values: Box<Values>,
    pub(crate) limit: f64,
}

/// The statistics of a monitor.
pub(crate) fn add(columns: &mut Vec<Column>, name: &str, monitor: &MonitorDesign) {
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
pub(crate) fn chi_square(
    map: &WindowMapDesign,
    train: &[Record],
    window: usize,
) -> Outcome<Column> {
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
