//! The prior price of a physical explanation, before it explains anything.

use crate::diagnose::{Cause, Diagnosis, Verdict};

/// Spread of the logarithm of an honest gain about 1.
const HONEST: f64 = 0.3;
/// Spread of an honest bias, in spreads of the signal: another zero of its scale, as that of degrees Celsius, is further off.
const NEAR_ZERO: f64 = 1.0;
/// Most that the sharpness of a strength costs: nobody believes a standard error of a millionth.
const SHARPEST: f64 = 10.0;
/// Price of a gain whose sign is wrong.
const IMPOSSIBLE: f64 = 30.0;
/// Causes whose first strength is a relative error of a gain.
const GAINS: [&str; 3] = ["input-gain", "sensor-scale", "parameter-error"];

/// Logarithm of what an explanation has to gain: for being one of many, for its parameters, which
/// `independent` samples have to tell, and for gains and biases that no honest device has.
pub(super) fn price(diagnosis: &Diagnosis, independent: f64) -> f64 {
    let many = (diagnosis.causes.len().max(1) as f64).ln();
    let each = 0.5 * independent.max(2.0).ln();
    let of = |cause: &Cause| {
        // A strength that is known to a small part of itself might have been anything of its size.
        let strength = cause.parameters.first().map_or(0.0, |strength| {
            (strength.value.abs() / strength.standard_error).ln().clamp(each, SHARPEST)
        });
        let others = each * cause.parameters.len().saturating_sub(1) as f64;
        many + strength + others + dishonesty(cause) + bias(cause, diagnosis)
    };
    match diagnosis.verdict {
        Verdict::NoGap => 0.0,
        Verdict::Pair => {
            diagnosis.pairs.first().map_or(0.0, |pair| pair.causes.iter().map(of).sum())
        }
        _ => diagnosis.causes.first().map_or(0.0, of),
    }
}

/// Logarithm of how much rarer a gain is than one that is nearly right.
fn dishonesty(cause: &Cause) -> f64 {
    let strength = cause.parameters.first().filter(|_| GAINS.contains(&cause.label));
    match strength.map(|strength| 1.0 + strength.value) {
        None => 0.0,
        Some(gain) if 0.0 < gain => 0.5 * (gain.ln() / HONEST).powi(2),
        Some(_) => IMPOSSIBLE,
    }
}

/// Logarithm of how much rarer a bias of a sensor is than one that is small beside what the sensor shows.
fn bias(cause: &Cause, diagnosis: &Diagnosis) -> f64 {
    let model = &diagnosis.best.model;
    let place = model.outputs.iter().position(|output| cause.site.name() == Some(&output.name));
    let strength = cause.parameters.first().filter(|_| cause.label == "sensor-bias");
    let (Some(place), Some(strength)) = (place, strength) else { return 0.0 };
    let logs = diagnosis.best.outputs.iter();
    let signal = logs.flat_map(|log| log.iter().skip(place).step_by(model.outputs.len()).copied());
    let [_, spread] = fd_numeric::mean_and_deviation(signal.filter(|value| value.is_finite()));
    if spread <= 0.0 { 0.0 } else { 0.5 * (strength.value / (NEAR_ZERO * spread)).powi(2) }
}
