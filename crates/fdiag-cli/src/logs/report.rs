//! A study of logs as a sentence, tables, pictures and a page.

use std::cmp::Ordering;

use fd_model::figure;
use fd_numeric::rms;
use fd_report::{Line, Page, Picture, PictureError, Table};
use fdiag::training::{Applied, Compared, Trace, WhyNot};

use super::{
    healthy::LogDoubt,
    study::{LogResult, LogStudy, SignalUnit, Traces},
};

/// A statistic that is so many thresholds large is drawn on a logarithmic axis, where the threshold can be seen.
const FAR_ABOVE: f64 = 20.0;
/// Forms of the bias model in the table; all of them are in the JSON.
const SHOWN_FORMS: usize = 8;

impl LogStudy {
    /// What came out, in one sentence.
    #[must_use]
    pub fn headline(&self) -> String {
        let later: Vec<&LogResult> = self.logs.iter().filter(|log| !log.healthy).collect();
        let shown: Vec<&LogResult> =
            if later.is_empty() { self.logs.iter().collect() } else { later.clone() };
        let total =
            |f: &dyn Fn(&LogResult) -> &[f64]| rms(shown.iter().flat_map(|log| f(log)).copied());
        let (before, after) = (total(&|log| &log.rms_primary), total(&|log| &log.rms_compensated));
        // Several outputs have no unit in common; what is left is how much smaller they became.
        let change = match &self.residuals[..] {
            [only] => format!(
                " from {} to {} {}",
                figure(only.scale * before),
                figure(only.scale * after),
                only.unit
            ),
            _ => String::new(),
        };
        let which = if later.is_empty() { "healthy logs" } else { "later logs" };
        let alarmed = later.iter().filter(|log| log.first_alarm_s.1.is_some()).count();
        let alarms = match (later.len(), alarmed) {
            (0, _) => String::new(),
            (1, 0) => " The later log raises no alarm.".to_owned(),
            (1, _) => " The later log raises an alarm.".to_owned(),
            (n, 0) => format!(" None of the {n} later logs raises an alarm."),
            (n, a) => format!(" {a} of the {n} later logs raise an alarm."),
        };
        let off = self.where_off();
        if self.all_are(Applied::Nothing) {
            return format!("{off}{alarms}{}", self.cautions());
        }
        let factor = |after: f64| {
            if after <= before {
                format!("{} times smaller", figure(before / after))
            } else {
                format!("{} times larger", figure(after / before))
            }
        };
        let alone = if self.all_are(Applied::Constant) {
            String::new()
        } else {
            format!(", a constant alone {}", factor(total(&|log| &log.rms_constant)))
        };
        format!(
            "{off}Compensation makes the rms residual on the {which} {}{change}{alone}.{alarms}{}{}",
            factor(after),
            self.warning(),
            self.cautions(),
        )
    }

    /// Whether the same is subtracted from every residual.
    fn all_are(&self, applied: Applied) -> bool {
        let payments = &self.bias.payments;
        !payments.is_empty() && payments.iter().all(|payment| payment.applied == applied)
    }

    /// The residuals that the bias model is not subtracted from and why, as sentences; empty when there are none.
    fn where_off(&self) -> String {
        let off: Vec<(&SignalUnit, Applied, WhyNot)> = self
            .residuals
            .iter()
            .zip(&self.bias.payments)
            .filter(|(_, payment)| payment.applied != Applied::Bias)
            .filter_map(|(residual, payment)| Some((residual, payment.applied, payment.why_not?)))
            .collect();
        let Some((_, _, first)) = off.first() else { return String::new() };
        let all_for_this = off.iter().all(|(_, _, why)| why == first);
        let why = if all_for_this {
            first.in_words().to_owned()
        } else {
            let each = off.iter().map(|(of, _, why)| format!("{}: {}", of.name, why.in_words()));
            each.collect::<Vec<_>>().join("; ")
        };
        if *first == WhyNot::Never {
            "Compensation is switched off (bias.apply = \"never\"); the primary residual is judged."
                .to_owned()
        } else if self.all_are(Applied::Nothing) {
            format!(
                "Compensation does not pay here and is off, and the primary residual is judged: {why}."
            )
        } else if self.all_are(Applied::Constant) {
            format!("Only a constant is subtracted, as more does not pay here: {why}. ")
        } else {
            let instead = off.iter().map(|(residual, applied, why)| {
                let with = if *applied == Applied::Constant { "a constant" } else { "nothing" };
                format!("{} has {with} subtracted: {}", residual.name, why.in_words())
            });
            let instead: Vec<String> = instead.collect();
            format!(
                "The bias model is not subtracted where it does not pay. {}. ",
                instead.join("; ")
            )
        }
    }

    /// What speaks against the healthy logs and the thresholds from them, as sentences.
    fn cautions(&self) -> String {
        let doubts = self.doubts.iter().map(LogDoubt::sentence);
        let voids = self.logs.iter().filter_map(|log| {
            log.void.as_ref().map(|void| format!("{}: {}.", file_name(log), void.in_words()))
        });
        let not_compared = self.not_compared.as_ref();
        let not_compared =
            not_compared.map(|why| format!("Alarms without compensation are not compared: {why}."));
        let above = self.above_maximum.map(|above| above.in_words());
        let all: Vec<String> = doubts.chain(voids).chain(not_compared).chain(above).collect();
        if all.is_empty() { String::new() } else { format!(" {}", all.join(" ")) }
    }

    /// Logs on which compensation makes things worse, as a sentence; empty when there are none.
    fn warning(&self) -> String {
        let total = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
        let worse: Vec<String> = self
            .logs
            .iter()
            .filter(|log| total(&log.rms_compensated) > total(&log.rms_primary))
            .map(file_name)
            .collect();
        if worse.is_empty() {
            return String::new();
        }
        format!(
            " It makes the residual larger on {}: the bias there is not the one that was learned, \
             for example because it is not linear in the input.",
            worse.join(", ")
        )
    }

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

fn file_name(log: &LogResult) -> String {
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
