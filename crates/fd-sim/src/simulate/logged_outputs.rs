//! Logged outputs among the inputs of a record, and a controller that sees these.

use fd_model::{Channel, ModelError, Record, SampleTime};

use crate::model::{Controller, Model, Reference};

/// Relative difference of two times that are meant to be equal.
const ROUNDING: f64 = 1e-6;

/// Samples of a log, `ts` apart, from one action of a controller to the next; `None` where it is continuous, or acts between
/// samples.
pub(super) fn samples_of_action(controller: &Controller, ts: SampleTime) -> Option<f64> {
    let samples = controller.sample_time? / ts.seconds();
    let is_whole = 0.5 < samples && (samples - samples.round()).abs() < ROUNDING * samples;
    is_whole.then(|| samples.round())
}

/// A record with logged outputs among its inputs, under names of their own (`logged`: name of the output, name of
/// the input), interpolated where they are missing. Outputs that it does not have are left out; those that are `commanded`
/// follow from the log and are not known any more.
pub(super) fn with_logged_outputs(
    record: &Record,
    logged: &[(String, String)],
    commanded: &[String],
) -> Result<Record, ModelError> {
    let places = logged.iter().filter_map(|(output, name)| {
        let place = record.output_index(output)?;
        let channel = Channel::new(name, &record.outputs()[place].unit);
        Some((channel, without_holes(record.output(place).collect())))
    });
    let (channels, columns): (Vec<Channel>, Vec<Vec<f64>>) = places.unzip();
    let inputs = [record.inputs(), &channels].concat();
    let row = |k: usize| [record.u(k).to_vec(), columns.iter().map(|c| c[k]).collect()].concat();
    let u: Vec<f64> = (0..record.len()).flat_map(row).collect();
    let is_commanded: Vec<bool> =
        record.outputs().iter().map(|c| commanded.contains(&c.name)).collect();
    let seen = |(value, is_commanded): (&f64, &bool)| if *is_commanded { f64::NAN } else { *value };
    let row = |k: usize| record.y(k).iter().zip(&is_commanded).map(seen);
    let y: Vec<f64> = (0..record.len()).flat_map(row).collect();
    let new = Record::new(inputs, record.outputs().to_vec(), u, y, record.ts())?;
    Ok(new.at_the_place_of(record))
}

/// Lets the controller of a model see `logged` outputs (name of the output, name of a reference in its place) where it saw
/// those of the simulation.
pub(super) fn see_logged(controller: &mut Controller, model: &Model, logged: &[(String, String)]) {
    for (output, name) in logged {
        let known = model.outputs.iter().find(|known| known.name == *output);
        let unit = known.map_or_else(|| "1".to_owned(), |output| output.unit.clone());
        controller.references.push(Reference { name: name.clone(), unit });
        for expr in controller.expressions_mut() {
            *expr = expr.rename(output, name);
        }
    }
}

/// Missing values on straight lines between their neighbours; the ends are held, and a signal
/// without any value is zero.
fn without_holes(mut signal: Vec<f64>) -> Vec<f64> {
    let known: Vec<usize> = (0..signal.len()).filter(|k| signal[*k].is_finite()).collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return vec![0.0; signal.len()];
    };
    let [begin, end] = [signal[first], signal[last]];
    signal[..first].fill(begin);
    signal[last..].fill(end);
    for pair in known.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let (a, slope) = (signal[from], (signal[to] - signal[from]) / (to - from) as f64);
        for (i, value) in signal[from..to].iter_mut().enumerate() {
            *value = a + slope * i as f64;
        }
    }
    signal
}
