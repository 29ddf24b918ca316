//! Signals for pictures: measured, and simulated before and after.

use fd_gap::fit::{Horizon, Log};
use fd_model::SampleTime;
use fd_sim::simulate::Nominal;

use super::{
    data::Data,
    log_part::{LogPart, Role},
    report::Report,
};

/// Signals of one run, or of a part of one.
#[derive(Clone, Debug)]
pub struct Trace {
    /// What the log is used for.
    pub role: Role,
    /// Length of the windows that were forecast one by one, in seconds; `None` where it is one run.
    pub window: Option<f64>,
    /// Times, in seconds from the start of the file.
    pub time: Vec<f64>,
    /// One entry per output that was measured.
    pub outputs: Vec<Signals>,
    /// One entry per input.
    pub inputs: Vec<Drive>,
}

/// An input over time, as it drives the simulator.
#[derive(Clone, Debug)]
pub struct Drive {
    /// Name of the input.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// As logged; where it is missing, its last value.
    pub values: Vec<f64>,
}

/// An output over time; NaN where there is no value.
#[derive(Clone, Debug)]
pub struct Signals {
    /// Name of the output.
    pub name: String,
    /// Its unit, in which all of these are.
    pub unit: String,
    /// As logged.
    pub measured: Vec<f64>,
    /// Simulated with the model as it came.
    pub before: Vec<f64>,
    /// Simulated with the best explanation.
    pub after: Vec<f64>,
}

/// The first held-out part, as it was forecast for the headline; the first fitted log when nothing is held out or all
/// forecasts diverge.
pub(super) fn trace(
    nominal: &dyn Nominal,
    report: &Report,
    data: &Data,
    [fitted, held_out]: &[Vec<Log>; 2],
    ts: SampleTime,
) -> Option<Trace> {
    let part = data.parts.iter().find(|part| part.role == Role::HeldOut);
    if let (Some(log), Some(part), Some(forecast)) = (held_out.first(), part, report.forecast()) {
        let simulated = |c: usize| {
            forecast.errors.each_ref().map(|errors| {
                let errors = errors[c].iter().enumerate();
                errors.map(|(k, error)| log.output(log.lead() + k)[c] + error).collect()
            })
        };
        let window = (forecast.horizon != Horizon::FreeRun).then_some(forecast.seconds);
        return Some(Trace { window, ..of(part, log, ts, nominal, simulated) });
    }
    let (part, log) = (data.parts.first()?, fitted.first()?);
    let ny = nominal.model().outputs.len();
    let column = |values: &[Vec<f64>], c: usize| -> Vec<f64> {
        values.first().into_iter().flatten().skip(c).step_by(ny).copied().collect()
    };
    let simulated =
        |c| [&report.diagnosis.nominal, &report.diagnosis.best].map(|e| column(&e.outputs, c));
    Some(of(part, log, ts, nominal, simulated))
}

fn of(
    part: &LogPart,
    log: &Log,
    ts: SampleTime,
    nominal: &dyn Nominal,
    simulated: impl Fn(usize) -> [Vec<f64>; 2],
) -> Trace {
    let time = (part.samples[0]..part.samples[1]).map(|k| k as f64 * ts.seconds());
    let outputs = nominal.model().outputs.iter().enumerate().map(|(c, output)| {
        let [before, after] = simulated(c);
        Signals {
            name: output.name.clone(),
            unit: output.unit.clone(),
            measured: (log.lead()..log.samples()).map(|k| log.output(k)[c]).collect(),
            before,
            after,
        }
    });
    let inputs = nominal.model().external_inputs();
    let inputs = inputs.into_iter().enumerate().map(|(i, input)| {
        let values = (log.lead()..log.samples()).filter_map(|k| log.input(k).get(i).copied());
        Drive { name: input.name, unit: input.unit, values: values.collect() }
    });
    let is_measured = |signals: &Signals| signals.measured.iter().any(|value| value.is_finite());
    let (time, outputs) = (time.collect(), outputs.filter(is_measured).collect());
    Trace { role: part.role, window: None, time, outputs, inputs: inputs.collect() }
}
