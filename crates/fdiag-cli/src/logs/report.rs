//! A study of logs as tables, pictures and a page.

use std::cmp::Ordering;

use fd_model::figure;
use fd_report::{Line, Page, Picture, PictureError, Table};
use fdiag::training::{Applied, Compared, Trace};

use super::study::{LogResult, LogStudy, SignalUnit, Traces};

/// A statistic that is so many thresholds large is drawn on a logarithmic axis, where the threshold can be seen.
const FAR_ABOVE: f64 = 20.0;
/// Forms of the bias model in the table; all of them are in the JSON.
const SHOWN_FORMS: usize = 8;

impl LogStudy {
    /// The result as tables.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        let mut logs = Table::new(
            format!("{}: residuals", self.model),
            &[
                "log",
                "role",
                "samples",
                "residual",
                "rms primary",
                "rms compensated",
                "times smaller",
                "first alarm [s]",
                "in alarm [%]",
            ],
        );
        for log in &self.logs {
            for (channel, residual) in self.residuals.iter().enumerate() {
                let scale = residual.scale;
                let before = scale * log.rms_primary[channel];
                let after = scale * log.rms_compensated[channel];
                logs.push([
                    file_name(log),
                    if log.healthy { "healthy" } else { "later" }.to_owned(),
                    log.samples.to_string(),
                    format!("{} [{}]", residual.name, residual.unit),
                    figure(before),
                    figure(after),
                    figure(before / after),
                    log.first_alarm_s.1.map_or_else(|| "none".to_owned(), |t| format!("{t:.1}")),
                    format!("{:.2}", 100.0 * log.alarm_share.1),
                ]);
            }
        }
        let mut bias = Table::new("Learned bias model", &["quantity", "value"]);
        bias.push(["orders".to_owned(), self.bias.orders.clone()]);
        bias.push(["parameters".to_owned(), list(&self.bias.theta)]);
        for (name, poles) in self.residuals.iter().zip(&self.bias.poles) {
            bias.push([format!("pole magnitudes, {}", name.name), list(poles)]);
        }
        if let Some(selection) = &self.bias.selection {
            bias.push(["order criteria".to_owned(), selection.clone()]);
        }
        let mut tables = vec![logs, bias];
        tables.extend(self.payments_table());
        tables.extend(self.compared_table());
        if !self.doubts.is_empty() {
            let mut doubts = Table::new("Doubts about the healthy logs", &["log", "doubt"]);
            for doubt in &self.doubts {
                let log = doubt.log.clone().unwrap_or_else(|| "all".to_owned());
                doubts.push([log, doubt.words.clone()]);
            }
            tables.push(doubts);
        }
        tables
    }

    /// What the bias is worth in each residual.
    fn payments_table(&self) -> Option<Table> {
        let payments = &self.bias.payments;
        let mut table = Table::new(
            "Does the bias pay on held-out healthy samples?",
            &[
                "residual",
                "rms primary",
                "rms less a constant",
                "rms less the bias model",
                "gain of the square",
                "standard error",
                "subtracted",
            ],
        );
        for (residual, payment) in self.residuals.iter().zip(payments) {
            let square = residual.scale * residual.scale;
            table.push([
                format!("{} [{}]", residual.name, residual.unit),
                figure(residual.scale * payment.rms_primary),
                figure(residual.scale * payment.rms_constant),
                figure(residual.scale * payment.rms_compensated),
                figure(square * payment.gain),
                figure(square * payment.standard_error),
                match payment.applied {
                    Applied::Bias => "bias model",
                    Applied::Constant => "a constant",
                    Applied::Nothing => "nothing",
                }
                .to_owned(),
            ]);
        }
        (!payments.is_empty()).then_some(table)
    }

    /// The best of the forms that were compared, and the one that was taken.
    fn compared_table(&self) -> Option<Table> {
        let mut shown: Vec<&Compared> =
            self.bias.compared.iter().filter(|form| form.left.is_some()).collect();
        shown.sort_by(|a, b| a.left.partial_cmp(&b.left).unwrap_or(Ordering::Equal));
        let none = self.bias.compared.iter().filter(|form| form.parameters == 0);
        let best = shown.iter().copied().take(SHOWN_FORMS);
        let others = shown.iter().copied().skip(SHOWN_FORMS).filter(|form| form.chosen);
        let none = none.filter(|form| !form.chosen);
        let mut table = Table::new(
            format!("Forms of the bias model, {} compared by free runs", self.bias.compared.len()),
            &[
                "form",
                "parameters",
                "rms left [%]",
                "square above the best [%]",
                "standard error",
                "",
            ],
        );
        let percent = |v: Option<f64>| v.map_or_else(|| "-".to_owned(), |v| figure(100.0 * v));
        for form in best.chain(others).chain(none) {
            table.push([
                form.model.clone(),
                form.parameters.to_string(),
                percent(form.left),
                percent(form.above_best),
                percent(form.standard_error),
                if form.chosen { "taken" } else { "" }.to_owned(),
            ]);
        }
        (!self.bias.compared.is_empty()).then_some(table)
    }

    /// The whole report as a page.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn page(&self, traces: &Traces) -> Result<Page, PictureError> {
        let mut page = Page::new("Residual compensation on logs", self.headline());
        for table in self.tables() {
            page.table(table);
        }
        for (log, (_, with)) in self.logs.iter().zip(&traces.logs) {
            let role = if log.healthy { "healthy" } else { "later" };
            page.heading(format!("{} ({role})", file_name(log)));
            for (channel, residual) in self.residuals.iter().enumerate() {
                page.picture(&self.residual_picture(with, channel, residual), caption(log))?;
            }
            if self.residuals.len() > 1 {
                page.picture(&statistic_picture(with), "Test statistic over all residuals.")?;
            }
            if let Some(named) = &log.named {
                page.table(named.table());
            }
            if let Some(sizes) = &log.sensor_sizes {
                let mut table =
                    Table::new("If it is a lasting sensor fault", &["of sensor", "size"]);
                for (output, size) in self.outputs.iter().zip(sizes) {
                    table.push([output.name.clone(), format!("{} {}", figure(*size), output.unit)]);
                }
                page.table(table);
            }
            if !log.events.is_empty() {
                page.table(events(log));
            }
        }
        Ok(page)
    }

    fn residual_picture(&self, trace: &Trace, channel: usize, residual: &SignalUnit) -> Picture {
        let SignalUnit { name, unit, scale } = residual;
        let line = |label: &str, values: &[f64]| {
            let own = values.iter().skip(channel).step_by(trace.channels.max(1)).map(|v| v * scale);
            Line::new(label, trace.time.iter().copied().zip(own))
        };
        let mut picture = Picture {
            title: format!("Residual of {name}"),
            x_label: "time [s]".to_owned(),
            y_label: format!("residual [{unit}]"),
            lines: vec![line("primary", &trace.residual), line("compensated", &trace.compensated)],
            ..Picture::default()
        };
        if let (1, Some(&threshold)) = (self.residuals.len(), trace.threshold.first()) {
            let threshold = threshold * scale;
            picture.levels =
                vec![(threshold, "threshold of r*".to_owned()), (-threshold, String::new())];
        }
        if let Some(k) = trace.first_alarm(0) {
            picture.marks.push((trace.time[k], "first alarm".to_owned()));
        }
        picture
    }
}

pub(super) fn file_name(log: &LogResult) -> String {
    log.file.file_name().map_or_else(String::new, |f| f.to_string_lossy().into_owned())
}

/// The statistic against its threshold, where it is judged: while the generator settles it may be a hundred times as
/// large, and nothing else could be seen.
fn statistic_picture(trace: &Trace) -> Picture {
    let is_ever = trace.compensating.contains(&true);
    let judged = |values: &[f64]| -> Vec<(f64, f64)> {
        let all = trace.time.iter().zip(values).zip(&trace.compensating);
        all.map(|((t, v), judged)| (*t, if *judged || !is_ever { *v } else { f64::NAN })).collect()
    };
    let (statistic, threshold) = (judged(&trace.statistic), judged(&trace.threshold));
    let largest = |line: &[(f64, f64)]| line.iter().map(|(_, v)| *v).fold(0.0, f64::max);
    let log_y = FAR_ABOVE * largest(&threshold) < largest(&statistic);
    let mut picture = Picture {
        title: "Detector".to_owned(),
        x_label: "time [s]".to_owned(),
        y_label: "statistic [1]".to_owned(),
        log_y,
        lines: vec![Line::new("statistic", statistic), Line::new("threshold", threshold)],
        ..Picture::default()
    };
    if let Some(k) = trace.first_alarm(0) {
        picture.marks.push((trace.time[k], "first alarm".to_owned()));
    }
    picture
}

fn caption(log: &LogResult) -> String {
    let base = &log.time_base;
    let even = if base.even {
        "an even time base".to_owned()
    } else {
        format!("an uneven time base (jitter {} s), resampled", figure(base.jitter_s))
    };
    let refused = match log.refused {
        0 => String::new(),
        n => format!(" {n} samples were missing and left out."),
    };
    format!("{} samples on {even}.{refused}", log.samples)
}

fn events(log: &LogResult) -> Table {
    let mut table = Table::new("Events", &["sample", "event"]);
    for event in &log.events {
        table.push([event.k.to_string(), event.kind.to_string()]);
    }
    table
}

fn list(values: &[f64]) -> String {
    values.iter().map(|v| format!("{v:.5}")).collect::<Vec<_>>().join(", ")
}
