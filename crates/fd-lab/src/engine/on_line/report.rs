//! The columns on line as tables.

use fd_report::Table;

use crate::{
    compare::Share,
    engine::{
        on_line::{OnLineSummary, TrainingFault},
        report::{percent, range, scaled_range},
        study::Study,
    },
};

impl Study {
    /// What the best constant threshold on the whole residual vector finds, next to `W r` and `W r*`.
    pub(in crate::engine) fn vector_table(&self) -> Table {
        let mut table = Table::new(
            "Against the best constant threshold on the residual vector: smallest fault [%]",
            &[
                "sensor",
                "W r",
                "best of r",
                "W r*",
                "best of r*",
                "W r over W r*",
                "best of r over W r*",
                "best of r over best of r*",
            ],
        );
        for fault in &self.summary.faults {
            table.push([
                fault.sensor.clone(),
                scaled_range(&fault.smallest_primary, 100.0),
                scaled_range(&fault.vector_primary, 100.0),
                scaled_range(&fault.smallest_compensated, 100.0),
                scaled_range(&fault.vector_compensated, 100.0),
                range(&fault.smallest_ratio),
                range(&fault.fair_ratio),
                range(&fault.vector_ratio),
            ]);
        }
        table
    }

    /// What happened on line; no tables when nothing did.
    pub(in crate::engine) fn on_line_tables(&self) -> Vec<Table> {
        let Some(line) = &self.summary.on_line else { return Vec::new() };
        let title = format!(
            "On line: learned from the first sample, {} engines, shares with 95 % intervals",
            line.opened.of
        );
        let mut table = Table::new(title, &["what", "value"]);
        for (what, value) in self.on_line_rows(line) {
            table.push([what, value]);
        }
        let mut faults = Table::new(
            "A fault that begins half way through the training, and stays",
            &[
                "fault",
                "reported as hard [%]",
                "after [s]",
                "switch opens all the same [%]",
                "then an alarm [%]",
                "share of it that r* shows",
            ],
        );
        for (fault, said) in self.config.on_line.faults.iter().zip(&line.in_training) {
            faults.push([
                name(fault),
                share(&said.reported),
                range(&said.reported_s),
                share(&said.opened),
                share(&said.alarm),
                range(&said.shown),
            ]);
        }
        let mut after = Table::new(
            "The same faults, beginning after the opening",
            &["fault", "alarm [%]", "delay [s]"],
        );
        for (fault, (found, delay)) in self.config.on_line.faults.iter().zip(&line.faults) {
            after.push([name(fault), share(found), range(delay)]);
        }
        vec![table, faults, after]
    }

    fn on_line_rows(&self, line: &OnLineSummary) -> Vec<(String, String)> {
        let config = &self.config.on_line;
        let mut rows = vec![
            (format!("switch opens within {} s [%]", config.longest_s), share(&line.opened)),
            ("time to open [s]".to_owned(), range(&line.opened_s)),
            ("fault-free residual, times smaller".to_owned(), range(&line.fault_free_ratio)),
            (
                "false alarms of test runs, primary / compensated [%]".to_owned(),
                format!(
                    "{:.1} / {:.1}",
                    100.0 * line.false_alarms_primary,
                    100.0 * line.false_alarms_compensated
                ),
            ),
        ];
        for (fault, smallest) in self.summary.faults.iter().zip(&line.smallest) {
            let what = format!("smallest {} fault [% of reading]", fault.sensor);
            rows.push((what, scaled_range(smallest, 100.0)));
        }
        let size = percent(self.config.faults.size);
        let rest = [
            ("healthy: said to have changed [%]".to_owned(), share(&line.healthy_changed)),
            ("healthy: alarm [%]".to_owned(), share(&line.healthy_alarm)),
            (
                "healthy: threshold said to be void [% of time]".to_owned(),
                tenths(line.healthy_void),
            ),
            ("healthy, input jumps: alarm [%]".to_owned(), share(&line.jumps_alarm)),
            (
                "healthy, input jumps: alarm with the threshold not void [%]".to_owned(),
                share(&line.jumps_stated),
            ),
            (
                "healthy, input jumps: threshold said to be void [% of time]".to_owned(),
                tenths(line.jumps_void),
            ),
            (
                format!("incipient fault of {size}: taken for a change of the plant [%]"),
                share(&line.incipient_mistaken),
            ),
            (format!("incipient fault of {size}: alarm [%]"), share(&line.incipient_found)),
            (format!("incipient fault of {size}: delay [s]"), range(&line.incipient_delay_s)),
            ("drift of the plant: seen as such [%]".to_owned(), share(&line.drift_seen)),
            ("drift of the plant: alarm before that [%]".to_owned(), share(&line.drift_alarm)),
            ("drift of the plant: learned again [%]".to_owned(), share(&line.drift_learned)),
            (
                "drift of the plant: learned again after [s]".to_owned(),
                range(&line.drift_learned_s),
            ),
            ("rms of r* at the end, over before, old bias".to_owned(), range(&line.drift_old)),
            ("rms of r* at the end, over before, new bias".to_owned(), range(&line.drift_new)),
        ];
        rows.extend(rest);
        rows
    }
}

fn name(fault: &TrainingFault) -> String {
    let size = percent(fault.size);
    if fault.rise_s > 0.0 {
        format!("{size}, rising for {} s", fault.rise_s)
    } else {
        format!("{size}, abrupt")
    }
}

fn tenths(share: f64) -> String {
    format!("{:.1}", 100.0 * share)
}

fn share(share: &Share) -> String {
    let Share { hits, of, low, high } = share;
    if *of == 0 {
        return "-".to_owned();
    }
    let all = 100.0 * *hits as f64 / *of as f64;
    format!("{all:.1} [{:.1} .. {:.1}]", 100.0 * low, 100.0 * high)
}
