//! Whether a simulator is fit for a diagnosis, next to a log or alone, and what that will cost.

use fd_gap::quality::inspect;
use fd_model::{Channel, Record, figure, unit::quantity};
use fd_sim::{
    outside::{
        Checked, Conformance, Contract, Drive, Grade, OutsideError, OutsideSimulator, check_driven,
    },
    simulate::Simulator,
};

use super::{
    data::Data,
    error::GapError,
    read::read_logs,
    request::{HeldOutChoice, Request},
    sparing::planned_runs,
    subject::Subject,
    words,
};

/// Runs of a search on the simulator itself: a single cause, pairs, everything.
const THOROUGH: [(u64, &str); 3] = [
    (3_000, "thorough: one cause"),
    (10_000, "thorough: pairs tried"),
    (40_000, "thorough: none of the known causes"),
];

/// What was found out about a simulator.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatorCheck {
    /// Findings in the order in which they were made.
    pub findings: Vec<Checked>,
    /// Samples of a run.
    pub samples: usize,
    /// Time of a whole run in one call, in seconds; NaN where there is no run.
    pub run: f64,
    /// Time of a run step by step, in seconds; NaN where it does not step.
    pub steps: f64,
    /// Relative precision of its outputs.
    pub precision: f64,
    /// What a diagnosis with logs of that length will cost; empty where it is not known.
    pub costs: Vec<Cost>,
    /// What went wrong last with a simulator outside of this program.
    pub trouble: Option<OutsideError>,
    /// What was found out about it while it ran, and its user should know.
    pub note: Option<String>,
}

/// What a diagnosis will cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Cost {
    /// Which one.
    pub what: &'static str,
    /// Runs through the logs; `None` for equations, of which nobody counts them.
    pub runs: Option<u64>,
    /// Time, in seconds: with all workers at work, or on one thread.
    pub seconds: f64,
}

impl SimulatorCheck {
    /// Checks the simulator of a request through the inputs of its first log or, without logs, through steps of random
    /// height between minus and plus `amplitude`. `outside` is that simulator where it is outside of this program, started
    /// for this check: effects around it are not what is checked.
    ///
    /// ```
    /// use fdiag::gap_study::{Request, SimulatorCheck, Subject};
    ///
    /// let text = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "lag"
    /// sample_time = 0.1
    /// inputs = { u = { unit = "1" } }
    /// states = { x = { unit = "1", initial = 0.0, derivative = "u - x" } }
    /// outputs = { y = { unit = "1", value = "x" } }
    /// "#;
    /// let request = Request::new("lag.toml", Vec::<&str>::new());
    /// let subject = Subject::of_text(&request, text)?;
    /// let check = SimulatorCheck::of(&request, &subject, None, (500, 1.0))?;
    /// assert!(!check.is_broken() && check.samples == 500 && !check.costs.is_empty());
    /// # Ok::<(), fdiag::gap_study::GapError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns what is wrong with the logs, or why there is no simulator.
    pub fn of(
        request: &Request,
        subject: &Subject,
        outside: Option<OutsideSimulator>,
        (samples, amplitude): (usize, f64),
    ) -> Result<Self, GapError> {
        let request = Request { held_out: HeldOutChoice::Logs(Vec::new()), ..request.clone() };
        let is_alone = request.logs.is_empty();
        let data = (!is_alone).then(|| read_logs(&request, subject, None)).transpose()?;
        let model = subject.model();
        let ts = data.as_ref().and_then(Data::ts).map_or_else(|| model.sample_time(), Ok)?;
        let mut simulator = subject.nominal().simulator(ts)?;
        let mut drive = Drive::random(samples.max(2), simulator.inputs().len(), amplitude);
        let mut logged = Vec::new();
        if let Some(data) = &data {
            logged = of_logs(data, subject, &*simulator)?;
            if let Some(record) = data.fit.first() {
                drive = logged_drive(record, simulator.inputs());
            }
        }
        let mut check = if let Some(outside) = outside {
            Self::of_outside(outside, drive)
        } else {
            let found = check_driven(&mut *simulator, drive);
            let units = simulator.parameters().iter().map(|p| p.unit.as_str());
            let mut check = Self::new(found, None);
            check.units([simulator.inputs(), simulator.outputs()], units);
            check.noise(model.outputs.iter().any(|output| output.noise.is_none()));
            let cost = subject.cost(check.samples, ts).unwrap_or_default();
            let what = ["at least, on one thread", "at most, on one thread"];
            let costs = what.into_iter().zip(cost).filter(|(_, seconds)| 0.0 < *seconds);
            let costs = costs.map(|(what, seconds)| Cost { what, runs: None, seconds });
            check.costs = costs.collect();
            check
        };
        check.findings.extend(logged);
        Ok(check)
    }

    /// Checks a simulator outside of this program that has no copies.
    #[must_use]
    pub fn of_outside(simulator: OutsideSimulator, drive: Drive) -> Self {
        let (contract, workers) = (simulator.contract().clone(), simulator.workers());
        let planned = planned_runs(&simulator);
        let mut simulator = simulator.without_memory();
        let drive = Drive { by_steps: drive.by_steps && contract.powers.step, ..drive };
        let found = check_driven(&mut simulator, drive);
        let mut check = Self::new(found.clone(), simulator.trouble());
        check.note = simulator.note();
        let units = contract.parameters.iter().map(|p| p.unit.as_str());
        check.units([&contract.inputs, &contract.outputs], units);
        check.noise(contract.noise.iter().any(Option::is_none));
        check.powers(&contract);
        if found.run.is_finite() {
            let all = [(planned, "at most")].into_iter().chain(THOROUGH);
            let cost = |(runs, what)| Cost {
                what,
                runs: Some(runs),
                seconds: found.cost(runs) / workers as f64,
            };
            check.costs = all.map(cost).collect();
        }
        check
    }

    fn new(found: Conformance, trouble: Option<OutsideError>) -> Self {
        let Conformance { findings, samples, run, steps, precision, .. } = found;
        Self { findings, samples, run, steps, precision, costs: Vec::new(), trouble, note: None }
    }

    /// The worst of all findings.
    #[must_use]
    pub fn worst(&self) -> Grade {
        self.findings.iter().map(|finding| finding.grade).max().unwrap_or(Grade::Fine)
    }

    /// Whether a diagnosis would go wrong.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.worst() == Grade::Broken || self.trouble.is_some()
    }

    fn say(&mut self, grade: Grade, what: &'static str, text: impl Into<String>) {
        self.findings.push(Checked { what, grade, text: text.into() });
    }

    fn units<'a>(
        &mut self,
        channels: [&'a [Channel]; 2],
        parameters: impl Iterator<Item = &'a str>,
    ) {
        let units = channels.into_iter().flatten().map(|c| c.unit.as_str()).chain(parameters);
        let mut unknown: Vec<&str> =
            units.filter(|unit| *unit != "1" && quantity(unit).is_none()).collect();
        unknown.sort_unstable();
        unknown.dedup();
        let text = if unknown.is_empty() {
            "all units of channels and parameters are known".to_owned()
        } else {
            format!("`{}` are not converted: logs must use the same units", unknown.join("`, `"))
        };
        self.say(Grade::Fine, "units", text);
    }

    fn noise(&mut self, is_unknown: bool) {
        if is_unknown {
            self.say(Grade::Fine, "noise", "not stated for every output: it will be estimated");
        }
    }

    fn powers(&mut self, contract: &Contract) {
        let powers = contract.powers;
        if let Some(precision) = powers.precision.filter(|p| 100.0 * p < self.precision) {
            let text = format!("stated as {precision:.0e}, measured as {:.0e}", self.precision);
            self.say(Grade::Doubt, "stated precision", text);
        }
        if !powers.deterministic {
            let text = "it declares that the same run may give different numbers: what differs is measured and counts \
                        as noise";
            self.say(Grade::Doubt, "stated powers", text);
        }
        if !powers.step {
            let text = "it makes whole runs only: one with friction, a spring or a stop takes two runs where the \
                        plant is linear, and up to ten or more where it is not";
            self.say(Grade::Doubt, "steps", text);
        }
    }
}

/// The inputs of a log in the order of the simulator; one that is missing keeps its last value.
fn logged_drive(record: &Record, inputs: &[Channel]) -> Drive {
    let columns: Vec<Vec<f64>> = inputs
        .iter()
        .map(|channel| {
            let mut last = 0.0;
            let values = record.input_index(&channel.name).map(|i| record.input(i));
            let values = values.into_iter().flatten();
            values
                .map(|value| {
                    if value.is_finite() {
                        last = value;
                    }
                    last
                })
                .collect()
        })
        .collect();
    let value = |k: usize, column: &Vec<f64>| column.get(k).copied().unwrap_or(0.0);
    let u = (0..record.len()).flat_map(|k| columns.iter().map(move |column| value(k, column)));
    Drive::logged(u.collect(), record.len())
}

/// What the logs are, and what is wrong with them.
fn of_logs(
    data: &Data,
    subject: &Subject,
    simulator: &dyn Simulator,
) -> Result<Vec<Checked>, GapError> {
    let noise: Vec<Option<f64>> = subject.model().outputs.iter().map(|o| o.noise).collect();
    let known = simulator.inputs().len();
    let mut all = Vec::new();
    for (i, (record, part)) in data.fit.iter().zip(&data.parts).enumerate() {
        let (samples, step) = (record.len(), figure(record.ts().seconds()));
        let text = format!("{}: {samples} samples every {step} s", part.file);
        all.push(Checked { what: "log", grade: Grade::Fine, text });
        let found = inspect(record, simulator, known, &noise, None, i + 1);
        let found = found.map_err(|source| GapError::Unfit {
            file: part.path.clone(),
            source: Box::new(source),
        })?;
        for finding in found {
            let text = format!("{}: `{}`: {}", part.file, finding.channel, finding.defect);
            all.push(Checked { what: "log", grade: Grade::Doubt, text });
        }
    }
    for finding in &data.findings {
        let defect = words::defect(&finding.defect);
        let text = format!("{}: `{}`: {defect}", finding.file, finding.channel);
        all.push(Checked { what: "log", grade: Grade::Doubt, text });
    }
    Ok(all)
}
