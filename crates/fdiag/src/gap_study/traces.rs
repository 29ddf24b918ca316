//! Signals for pictures: measured, and simulated before and after.

use fd_gap::{
    diagnose::Diagnosis,
    fit::{FitError, Horizon, Log},
};
use fd_model::SampleTime;
use fd_sim::simulate::Nominal;

use super::{
    data::Data,
    report::{LogPart, Role},
    said::Said,
};

/// Signals of one run, or of a part of one.
#[derive(Clone, Debug)]
pub struct Trace {
    /// What the log is used for.
    pub role: Role,
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

/// The first held-out part, as it is forecast; the first fitted log when nothing is held out or a
/// forecast diverges.
pub(super) fn trace(
    nominal: &dyn Nominal,
    diagnosis: &Diagnosis,
    data: &Data,
    [fitted, held_out]: &[Vec<Log>; 2],
    horizon: Horizon,
    ts: SampleTime,
) -> Result<Option<Trace>, FitError> {
    if let Some(log) = held_out.first() {
        let plain = nominal.simulator(ts)?;
        let errors = |said: Said| said.errors(&*plain, log, horizon, &diagnosis.sigma);
        let before = errors(Said::nothing(nominal, ts)?)?;
        let after = errors(Said::of(nominal, &diagnosis.best, ts)?)?;
        if let (Some(before), Some(after)) = (before, after) {
            let part = data.parts.iter().find(|part| part.role == Role::HeldOut);
            let simulated = |errors: &[Vec<Vec<f64>>], c: usize| -> Vec<f64> {
                let errors = errors[c].iter().flatten().enumerate().skip(log.lead());
                errors.map(|(k, e)| log.output(k)[c] + e * diagnosis.sigma[c]).collect()
            };
            return Ok(part.map(|part| {
                of(part, log, ts, nominal, |c| [simulated(&before, c), simulated(&after, c)])
            }));
        }
    }
    let (Some(part), Some(log)) = (data.parts.first(), fitted.first()) else { return Ok(None) };
    let ny = nominal.model().outputs.len();
    let column = |values: &[Vec<f64>], c: usize| -> Vec<f64> {
        values.first().into_iter().flatten().skip(c).step_by(ny).copied().collect()
    };
    let simulated = |c| [&diagnosis.nominal, &diagnosis.best].map(|e| column(&e.outputs, c));
    Ok(Some(of(part, log, ts, nominal, simulated)))
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
    Trace { role: part.role, time, outputs, inputs: inputs.collect() }
}
