//! The prior price of a physical explanation, before it explains anything.

use crate::diagnose::{Cause, Diagnosis, Verdict};

/// Spread of the logarithm of an honest gain about 1.
const HONEST: f64 = 0.3;
/// Price of a gain whose sign is wrong.
const IMPOSSIBLE: f64 = 30.0;
/// Causes whose first strength is a relative error of a gain.
const GAINS: [&str; 3] = ["input-gain", "sensor-scale", "parameter-error"];

/// Logarithm of what an explanation has to gain: for being one of many, for its parameters, which
/// `independent` samples have to tell, and for gains that no honest device has.
pub(super) fn price(diagnosis: &Diagnosis, independent: f64) -> f64 {
    let many = (diagnosis.causes.len().max(1) as f64).ln();
    let of = |cause: &Cause| {
        let parameters = cause.parameters.len() as f64;
        many + 0.5 * parameters * independent.max(2.0).ln() + dishonesty(cause)
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
