//! The benchmark's result as a sentence, tables, pictures and a page.

use fd_model::figure;
use fd_numeric::median;
use fd_report::{Line, Page, Picture, PictureError, Table};

use super::{
    example::{Example, FaultyRun, Residuals},
    range::Range,
    study::Study,
};

/// A picture with the name of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedPicture {
    /// File name without its ending.
    pub file: String,
    /// The picture.
    pub picture: Picture,
    /// What to see in it.
    pub caption: String,
}

impl Study {
    /// What came out, in one sentence.
    #[must_use]
    pub fn headline(&self) -> String {
        let s = &self.summary;
        let faults: Vec<String> = s
            .faults
            .iter()
            .map(|fault| {
                format!(
                    "{} faults {} times smaller ({} instead of {} of the reading)",
                    fault.sensor,
                    figure(fault.smallest_ratio.median),
                    percent(fault.smallest_compensated.median),
                    percent(fault.smallest_primary.median),
                )
            })
            .collect();
        format!(
            "{}Compensation makes the largest fault-free residual {} times smaller and shows {} at \
             the same threshold rule (medians over {} engines).{}",
            self.cut_short(),
            figure(s.fault_free_ratio.median),
            if faults.is_empty() { "no faults".to_owned() } else { faults.join(" and ") },
            self.trials.len(),
            self.fair_words(),
        )
    }

    /// Whether somebody did not wait for all engines, as the beginning of a sentence.
    fn cut_short(&self) -> String {
        let (done, asked) = ((self.trials.len() + self.failed.len()) as u64, self.config.seeds);
        if done < asked {
            format!("Stopped after {done} of {asked} engines; so far: ")
        } else {
            String::new()
        }
    }

    /// How much of that is left next to the best constant threshold.
    fn fair_words(&self) -> String {
        let ratios: Vec<String> = self
            .summary
            .faults
            .iter()
            .filter(|fault| fault.fair_ratio.median.is_finite())
            .map(|fault| format!("{:.2} times for {}", fault.fair_ratio.median, fault.sensor))
            .collect();
        if ratios.is_empty() {
            return String::new();
        }
        format!(
            " Against the best constant threshold on the whole residual vector the gain is {}.",
            ratios.join(" and ")
        )
    }

    /// The result as tables: residuals and faults.
    #[must_use]
    pub fn tables(&self) -> Vec<Table> {
        let s = &self.summary;
        let mut residuals = Table::new(
            format!("{}, {} seeds: median [5 % .. 95 %]", self.engine, self.trials.len()),
            &["fault-free", "primary", "compensated", "times smaller"],
        );
        residuals.push([
            "largest residual [per unit]".to_owned(),
            range(&s.fault_free_primary),
            range(&s.fault_free_compensated),
            range(&s.fault_free_ratio),
        ]);
        residuals.push([
            "false alarms [% of runs]".to_owned(),
            format!("{:.1}", 100.0 * s.false_alarms_primary),
            format!("{:.1}", 100.0 * s.false_alarms_compensated),
            String::new(),
        ]);
        residuals.push([
            "largest residual, test runs".to_owned(),
            String::new(),
            String::new(),
            range(&s.fault_free_test_ratio),
        ]);
        let mut faults = Table::new(
            "Smallest detectable incipient sensor fault",
            &["sensor", "primary [%]", "compensated [%]", "times smaller"],
        );
        let mut found = Table::new(
            format!("Incipient fault of {} of the reading", percent(self.config.faults.size)),
            &[
                "sensor",
                "found, primary [%]",
                "found, compensated [%]",
                "delay [s]",
                "estimated / true size",
            ],
        );
        for fault in &s.faults {
            faults.push([
                fault.sensor.clone(),
                scaled_range(&fault.smallest_primary, 100.0),
                scaled_range(&fault.smallest_compensated, 100.0),
                range(&fault.smallest_ratio),
            ]);
            found.push([
                fault.sensor.clone(),
                format!("{:.1}", 100.0 * fault.found_primary),
                format!("{:.1}", 100.0 * fault.found_compensated),
                range(&fault.delay_compensated_s),
                range(&fault.estimated),
            ]);
        }
        let mut tables = vec![residuals, faults, found, self.vector_table()];
        tables.extend(self.on_line_tables());
        tables.push(self.bias_table());
        tables
    }

    /// The orders that were used and the parameters, one row per structure.
    fn bias_table(&self) -> Table {
        let mut table = Table::new(
            "Bias model, parameters as medians over the engines",
            &["order", "engines", "theta"],
        );
        let mut orders: Vec<&str> = self.trials.iter().map(|t| t.orders.as_str()).collect();
        orders.sort_unstable();
        orders.dedup();
        for order in orders {
            let thetas: Vec<&[f64]> = self
                .trials
                .iter()
                .filter(|t| t.orders == order)
                .map(|t| t.theta.as_slice())
                .collect();
            let parameters = thetas.first().map_or(0, |theta| theta.len());
            let medians: Vec<String> = (0..parameters)
                .map(|i| format!("{:.5}", median(&mut thetas.iter().map(|t| t[i]).collect())))
                .collect();
            table.push([order.to_owned(), thetas.len().to_string(), medians.join(", ")]);
        }
        table
    }

    /// The cumulative share of seeds over the two ratios.
    #[must_use]
    pub fn ratio_picture(&self) -> NamedPicture {
        let cumulative = |name: String, mut values: Vec<f64>| {
            values.retain(|v| v.is_finite());
            values.sort_by(f64::total_cmp);
            let n = values.len() as f64;
            let shares = (1..).map(|i| 100.0 * f64::from(i) / n);
            Line::new(name, values.iter().copied().zip(shares))
        };
        let residual = self.trials.iter().map(|t| t.fault_free.ratio()).collect();
        let mut lines = vec![cumulative("largest fault-free residual".to_owned(), residual)];
        for (i, fault) in self.summary.faults.iter().enumerate() {
            let ratios = self.trials.iter().map(|t| t.faults[i].smallest.ratio()).collect();
            let line = cumulative(format!("smallest {} fault", fault.sensor), ratios);
            // A line on another would hide it: both have one then.
            match lines.iter_mut().find(|known| is_on(known, &line)) {
                Some(known) => known.name = format!("{}, {}", known.name, line.name),
                None => lines.push(line),
            }
        }
        NamedPicture {
            file: "ratios".to_owned(),
            caption: "Share of perturbed engines for which compensation gains less than this \
                      factor. Left of 1 it would make things worse."
                .to_owned(),
            picture: Picture {
                title: "How many times smaller with compensation".to_owned(),
                x_label: "factor [1]".to_owned(),
                y_label: "share of engines [%]".to_owned(),
                log_x: true,
                lines,
                marks: vec![(1.0, String::new())],
                ..Picture::default()
            },
        }
    }

    /// The whole report as a page.
    ///
    /// # Errors
    ///
    /// Returns an error when a picture cannot be drawn.
    pub fn page(&self, example: &Example) -> Result<Page, PictureError> {
        let mut page =
            Page::new("Engine benchmark: on-line residual compensation", self.headline());
        page.text(format!(
            "Each of the {} engines differs from the model by what the configuration below says. \
             The bias that this leaves in the residual is learned on one healthy run, frozen, and \
             simulated from the fuel flow alone. Thresholds of both residuals come from the same \
             {} healthy runs, results from {} others, all with fresh inputs.",
            self.trials.len(),
            self.config.calibration_runs,
            self.config.test_runs,
        ));
        let ratios = self.ratio_picture();
        page.picture(&ratios.picture, ratios.caption)?;
        page.heading(format!("One engine closely: seed {}", example.seed));
        for named in example.pictures() {
            page.picture(&named.picture, named.caption)?;
        }
        page.heading("All engines");
        for table in self.tables() {
            page.table(table);
        }
        if !self.failed.is_empty() {
            let mut failed = Table::new("Seeds without a diagnosis", &["seed", "reason"]);
            for (seed, reason) in &self.failed {
                failed.push([seed.to_string(), reason.clone()]);
            }
            page.table(failed);
        }
        Ok(page)
    }
}

impl Example {
    /// The pictures of one seed; figures 4 to 7 are those of the paper.
    #[must_use]
    pub fn pictures(&self) -> Vec<NamedPicture> {
        let mut pictures = vec![self.training_picture(), self.healthy_picture()];
        for (i, run) in self.faulty.iter().enumerate() {
            pictures.extend(self.fault_pictures(run, i));
        }
        if !self.gains.is_empty() {
            pictures.push(self.gain_picture());
        }
        pictures
    }

    fn over_time(title: String, lines: Vec<Line>, y_label: &str) -> Picture {
        Picture {
            title,
            x_label: "time [s]".to_owned(),
            y_label: y_label.to_owned(),
            lines,
            ..Picture::default()
        }
    }

    fn residual_lines(&self, residuals: &Residuals) -> [Line; 2] {
        let line = |name: &str, values: &[f64]| {
            Line::new(name, self.time.iter().copied().zip(values.iter().copied()))
        };
        [line("primary r", &residuals.primary), line("compensated r*", &residuals.compensated)]
    }

    fn training_picture(&self) -> NamedPicture {
        let t = &self.training;
        let line = |name: &str, values: &[f64]| {
            Line::new(name, t.time.iter().copied().zip(values.iter().copied()))
        };
        let lines = vec![line("primary residual", &t.residual), line("simulated bias", &t.bias)];
        NamedPicture {
            file: "training".to_owned(),
            caption: "The healthy run that the bias is learned from: the residual, and what the \
                      frozen model makes of the fuel flow alone."
                .to_owned(),
            picture: Self::over_time("Training".to_owned(), lines, "residual [per unit]"),
        }
    }

    fn healthy_picture(&self) -> NamedPicture {
        let mut picture = Self::over_time(
            "Figure 4: healthy engine, fresh input".to_owned(),
            self.residual_lines(&self.healthy).to_vec(),
            "residual [per unit]",
        );
        let (_, compensated) = self.thresholds;
        picture.levels = vec![(compensated, "threshold of r*".to_owned())];
        NamedPicture {
            file: "figure-4".to_owned(),
            caption: "Without a fault the primary residual is far from zero, so that a small \
                      threshold cannot be set; the compensated one stays near zero."
                .to_owned(),
            picture,
        }
    }

    fn fault_pictures(&self, run: &FaultyRun, index: usize) -> Vec<NamedPicture> {
        let sensor = &run.sensor;
        let begins = run.fault.iter().position(|v| v.abs() > 0.0);
        let begins = begins.map_or(f64::NAN, |k| self.time[k.saturating_sub(1)]);
        let mark = vec![(begins, "fault begins".to_owned())];
        let line = |name: &str, values: &[f64]| {
            Line::new(name, self.time.iter().copied().zip(values.iter().copied()))
        };
        // The paper gives the first sensor two figures, each further one a single figure.
        let figure = 6 + index;
        let reading_figure = if index == 0 { 5 } else { figure };
        let mut reading = Self::over_time(
            format!("Figure {reading_figure}: reading of {sensor} with an incipient fault"),
            vec![line("reading", &run.reading), line("fault in it", &run.fault)],
            &format!("change of {sensor} [{}]", run.unit),
        );
        reading.marks.clone_from(&mark);
        let [primary, compensated] = self.residual_lines(&run.residuals);
        let residual = |title: String, line: Line, threshold: f64| {
            let mut picture = Self::over_time(title, vec![line], "residual [per unit]");
            picture.levels = vec![(threshold, "threshold".to_owned()), (-threshold, String::new())];
            picture.marks.clone_from(&mark);
            picture
        };
        let alarm = |at: Option<f64>| {
            at.map_or_else(|| "no alarm".to_owned(), |t| format!("alarm at {t:.2} s"))
        };
        vec![
            NamedPicture {
                file: format!("figure-{reading_figure}-{sensor}"),
                caption: format!("The fault is hardly visible in the reading of {sensor} itself."),
                picture: reading,
            },
            NamedPicture {
                file: format!("figure-{figure}a-{sensor}"),
                caption: format!("Primary residual: {}.", alarm(run.alarms.0)),
                picture: residual(
                    format!("Figure {figure} (a): {sensor} fault, primary residual"),
                    primary,
                    self.thresholds.0,
                ),
            },
            NamedPicture {
                file: format!("figure-{figure}b-{sensor}"),
                caption: format!("Compensated residual: {}.", alarm(run.alarms.1)),
                picture: residual(
                    format!("Figure {figure} (b): {sensor} fault, compensated residual"),
                    compensated,
                    self.thresholds.1,
                ),
            },
        ]
    }

    fn gain_picture(&self) -> NamedPicture {
        let truth = self.gains.iter().map(|g| (g.0, g.1));
        let learned = self.gains.iter().map(|g| (g.0, g.2));
        NamedPicture {
            file: "bias-gain".to_owned(),
            caption: "The bias that modelling errors really cause (eq. 13), and the one that was \
                      learned."
                .to_owned(),
            picture: Picture {
                title: "Gain from fuel flow to residual".to_owned(),
                x_label: "frequency [rad/s]".to_owned(),
                y_label: "gain [1]".to_owned(),
                log_x: true,
                log_y: true,
                lines: vec![Line::new("true bias", truth), Line::new("bias model", learned)],
                ..Picture::default()
            },
        }
    }
}

pub(super) fn percent(share: f64) -> String {
    format!("{} %", figure(100.0 * share))
}

pub(super) fn range(r: &Range) -> String {
    scaled_range(r, 1.0)
}

pub(super) fn scaled_range(r: &Range, by: f64) -> String {
    format!("{} [{} .. {}]", figure(by * r.median), figure(by * r.low), figure(by * r.high))
}

/// Whether two lines over a logarithmic axis are one to the eye.
fn is_on(one: &Line, other: &Line) -> bool {
    let is_near = |(a, b): (&(f64, f64), &(f64, f64))| (a.0 / b.0).ln().abs() < 0.01;
    one.points.len() == other.points.len() && one.points.iter().zip(&other.points).all(is_near)
}
