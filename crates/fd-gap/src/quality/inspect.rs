//! Defects of a log, alone and compared with the nominal simulation.

use fd_sim::simulate::Simulator;

use super::{
    agreement::agreement,
    channel::defects,
    direct_path::passes_at_once,
    feedback::feedback,
    finding::{Defect, Finding},
    inputs::input_defects,
    unresponsive::unresponsive,
    wrapped::jumps,
};
use crate::fit::{FitError, Log};

/// Part of the late motion of an output that a model must be able to make without its inputs.
const FOLLOWED: f64 = 0.2;
/// By how much two columns must agree better with each other's simulation.
const SWAPPED: f64 = 0.5;

/// Inspects a record, of which the first `known` inputs of the simulator are what it was driven with (what comes
/// after them are logged outputs that it follows). `noise` is what is stated for each output of the simulator, and `errors` are
/// those (simulated less measured, one signal per output) that a fit has left in this log, if
/// there was one: only they can show feedback.
///
/// # Errors
///
/// As [`Log::new`].
pub fn inspect(
    record: &fd_model::Record,
    simulator: &dyn Simulator,
    known: usize,
    noise: &[Option<f64>],
    errors: Option<&[Vec<f64>]>,
    number: usize,
) -> Result<Vec<Finding>, FitError> {
    let log = Log::new(record, simulator, number)?;
    let mut all = Vec::new();
    let mut add = |channel: &str, defect| {
        all.push(Finding { log: number, channel: channel.to_owned(), defect });
    };
    for channel in simulator.inputs().iter().take(known) {
        let Some(i) = record.input_index(&channel.name) else { continue };
        let signal: Vec<f64> = record.input(i).collect();
        for defect in defects(&signal, None, true) {
            add(&channel.name, defect);
        }
    }
    for (i, defect) in input_defects(simulator, &log, known) {
        add(&simulator.inputs()[i].name, defect);
    }
    let column = |values: &[f64], c: usize| -> Vec<f64> {
        values.iter().skip(c).step_by(log.ny).copied().collect()
    };
    let outputs = simulator.outputs();
    let measured: Vec<Vec<f64>> = (0..log.ny).map(|c| column(&log.y, c)).collect();
    let mut simulator = simulator.boxed();
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
    let mut y = vec![0.0; log.y.len()];
    // What diverges is NaN, and does not count below.
    let _ = simulator.simulate(&theta, &x0, &log.u, &mut y);
    let simulated: Vec<Vec<f64>> = (0..log.ny).map(|c| column(&y, c)).collect();
    for (c, channel) in outputs.iter().enumerate() {
        let is_small = unit_factor(&measured[c], &simulated[c]).is_some();
        for defect in defects(&measured[c], noise[c], false) {
            // In the wrong unit the noise is wrong as well.
            if !is_small || defect != Defect::NotExcited {
                add(&channel.name, defect);
            }
        }
        let times = jumps(channel, &measured[c]);
        if 0 < times {
            add(&channel.name, Defect::Wrapped { times });
        }
    }
    for (c, channel) in outputs.iter().enumerate() {
        if let Some(factor) = unit_factor(&measured[c], &simulated[c]) {
            add(&channel.name, Defect::WrongUnit { factor });
        }
        for other in c + 1..log.ny {
            let straight = agreement(&measured[c], &simulated[c])
                + agreement(&measured[other], &simulated[other]);
            let crossed = agreement(&measured[c], &simulated[other])
                + agreement(&measured[other], &simulated[c]);
            if straight + 2.0 * SWAPPED < crossed {
                add(&channel.name, Defect::Swapped { with: outputs[other].name.clone() });
            }
        }
    }
    let is_driven = (0..log.nu).any(|i| {
        let first = log.u.get(i).copied();
        log.u.iter().skip(i).step_by(log.nu).any(|u| Some(*u) != first)
    });
    if 0 < log.nu && !is_driven {
        let able = motions(&mut *simulator, &theta, &log);
        for ((able, measured), channel) in able.iter().zip(&measured).zip(outputs) {
            let late = &measured[measured.len() / 2..];
            let is_noise = defects(late, None, false).contains(&Defect::NotExcited);
            if !is_noise && able / FOLLOWED < spread(late) {
                add(&channel.name, Defect::Undriven);
            }
        }
    }
    for [i, c] in unresponsive(&*simulator, &log, known) {
        // What stands still, is in another unit or wraps is said to be that.
        let still = [Defect::Constant, Defect::NotExcited];
        let is_still =
            defects(&measured[c], noise[c], false).iter().any(|found| still.contains(found));
        let is_other = unit_factor(&measured[c], &simulated[c]).is_some()
            || 0 < jumps(&outputs[c], &measured[c]);
        if !is_other && !is_still {
            let input = simulator.inputs()[i].name.clone();
            add(&outputs[c].name, Defect::Unresponsive { input });
        }
    }
    let at_once = passes_at_once(&*simulator, &log);
    for ((errors, channel), at_once) in errors.into_iter().flatten().zip(outputs).zip(at_once) {
        for (i, input) in simulator.inputs().iter().enumerate().take(known) {
            let u: Vec<f64> = log.u.iter().skip(i).step_by(log.nu).copied().collect();
            if let Some(correlation) = feedback(&u, errors, usize::from(at_once)) {
                add(&channel.name, Defect::Feedback { correlation, input: input.name.clone() });
            }
        }
    }
    Ok(all)
}

/// Standard deviation of each output in the second half of a simulation: the largest of those from
/// the nominal initial state, and with each state moved by its tolerance.
fn motions(simulator: &mut dyn Simulator, theta: &[f64], log: &Log) -> Vec<f64> {
    let initial = simulator.initial().to_vec();
    let nominal: Vec<f64> = initial.iter().map(|state| state.value).collect();
    let mut starts = vec![nominal.clone()];
    for (i, state) in initial.iter().enumerate() {
        let mut moved = nominal.clone();
        moved[i] += state.tolerance.unwrap_or(0.0);
        starts.push(moved);
    }
    let mut largest = vec![0.0_f64; log.ny];
    let mut y = vec![0.0; log.y.len()];
    for x0 in starts {
        // What diverges moves.
        let _ = simulator.simulate(theta, &x0, &log.u, &mut y);
        for (c, largest) in largest.iter_mut().enumerate() {
            let late = log.samples / 2 * log.ny;
            let values: Vec<f64> = y[late..].iter().skip(c).step_by(log.ny).copied().collect();
            let is_finite = values.iter().all(|v| v.is_finite());
            *largest = largest.max(if is_finite { spread(&values) } else { f64::INFINITY });
        }
    }
    largest
}

/// Standard deviation of what is there.
fn spread(signal: &[f64]) -> f64 {
    fd_numeric::mean_and_deviation(signal.iter().copied().filter(|v| v.is_finite()))[1]
}

/// The power of a thousand that makes a measured signal agree with the simulated one, if it does
/// not already and comes within a factor of three.
fn unit_factor(measured: &[f64], simulated: &[f64]) -> Option<f64> {
    let size = |signal: &[f64]| {
        let finite = signal.iter().filter(|v| v.is_finite());
        f64::sqrt(finite.clone().map(|v| v * v).sum::<f64>() / finite.count().max(1) as f64)
    };
    let ratio = size(simulated) / size(measured);
    let power = (ratio.log10() / 3.0).round();
    if !power.is_finite() || power.abs() < 0.5 {
        return None;
    }
    let factor = 1000.0_f64.powf(power);
    let converted: Vec<f64> = measured.iter().map(|v| factor * v).collect();
    (0.5 < agreement(&converted, simulated)).then_some(factor)
}
