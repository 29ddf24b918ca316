//! Outputs that a controller makes of the log.
//!
//! Where a command is logged, and the controller of the model acts on logged outputs, that column is computed from the others.
//! What is left of it is rounding that went through the controller, and an integrator makes a drift of that. It says
//! nothing of the plant.

use fd_model::Record;
use fd_sim::simulate::{LoggedLoop, Nominal};

use crate::{fit::Log, quality::robust_third_difference_floor};

/// Most that is left of such an output, in what the noise of the log makes of it on its way through the controller: one that
/// saw other noise, or none, leaves all of that …
const ROUNDING: f64 = 0.1;
/// … and where there is no noise, in standard deviations of the output.
const EXACT: f64 = 1e-6;

/// Names of the outputs that the controller of a loop makes of all records; none where it cannot be asked.
///
/// ```
/// use fd_gap::diagnose::commanded;
/// use fd_model::{Channel, Record};
/// use fd_sim::{model::Model, simulate::LoggedLoop};
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "tank"
/// sample_time = 0.1
/// inputs = { u = { unit = "m/s" } }
/// states = { h = { unit = "m", initial = 0.0, derivative = "u - h" } }
/// [outputs]
/// y = { unit = "m", value = "h" }
/// command = { unit = "m/s", value = "u" }
/// [controller]
/// sample_time = 0.1
/// references = { r = { unit = "m" } }
/// signals = { u = "2*(r - y)" }
/// "#.parse()?;
/// let ts = model.sample_time()?;
/// let row = |k: u32| {
///     let y = f64::from(k * k % 13);
///     ([1.0], [y, 2.0 * (1.0 - y)])
/// };
/// let (r, y) = (model.external_inputs(), model.output_channels());
/// let record = Record::from_rows(r, y, (0..50).map(row), ts)?;
/// let looped = LoggedLoop::of(&model, ts).ok_or("a sampled controller")?;
/// assert_eq!(commanded(&looped, &[record]), ["command"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn commanded(looped: &LoggedLoop<'_>, records: &[Record]) -> Vec<String> {
    let each: Option<Vec<Vec<String>>> =
        records.iter().map(|record| commanded_by(looped, record)).collect();
    let each = each.unwrap_or_default();
    let Some((first, others)) = each.split_first() else { return Vec::new() };
    first.iter().filter(|name| others.iter().all(|o| o.contains(name))).cloned().collect()
}

fn commanded_by(looped: &LoggedLoop<'_>, record: &Record) -> Option<Vec<String>> {
    let ts = record.ts();
    let simulator = looped.simulator(ts).ok()?;
    let log = Log::new(&looped.record(record).ok()?, &*simulator, 1).ok()?;
    let shown = looped.commands(&log.u, ts)?.outputs;
    let outputs = simulator.outputs();
    let is_commanded = |c: usize| {
        let column = |signal: &[f64]| -> Vec<f64> {
            signal.iter().skip(c).step_by(outputs.len()).copied().collect()
        };
        let (logged, shown) = (column(&log.y), column(&shown));
        let known = logged.iter().zip(&shown).filter(|(y, _)| y.is_finite());
        let [_, spread] = fd_numeric::mean_and_deviation(known.clone().map(|(y, _)| *y));
        let left = fd_numeric::rms(known.map(|(y, s)| y - s));
        let noise = robust_third_difference_floor(&shown).unwrap_or(0.0);
        0.0 < spread && left <= (ROUNDING * noise).max(EXACT * spread)
    };
    let commanded = outputs.iter().enumerate().filter(|(c, _)| is_commanded(*c));
    Some(commanded.map(|(_, output)| output.name.clone()).collect())
}
