//! Checks that the parameters of several signals share, and the one rule for comparing times.

use crate::{domain::SampleTime, signal::error::SignalError};

pub(super) fn finite(
    signal: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<(), SignalError> {
    if value.is_finite() {
        Ok(())
    } else {
        Err(SignalError::NotFinite { signal, parameter, value })
    }
}

pub(super) fn in_range(
    signal: &'static str,
    parameter: &'static str,
    expected: &'static str,
    value: f64,
    inside: bool,
) -> Result<(), SignalError> {
    finite(signal, parameter, value)?;
    if inside { Ok(()) } else { Err(SignalError::Range { signal, parameter, expected, value }) }
}

pub(super) fn positive_seconds(
    signal: &'static str,
    parameter: &'static str,
    value: f64,
) -> Result<(), SignalError> {
    in_range(signal, parameter, "above 0 s", value, 0.0 < value)
}

pub(super) fn below_nyquist(
    signal: &'static str,
    frequency_hz: f64,
    ts: SampleTime,
) -> Result<(), SignalError> {
    let nyquist_hz = 0.5 / ts.seconds();
    if frequency_hz < nyquist_hz {
        Ok(())
    } else {
        Err(SignalError::Aliased { signal, frequency_hz, nyquist_hz })
    }
}

/// Times of the first `n` samples, in seconds.
pub(super) fn times(n: usize, ts: SampleTime) -> impl Iterator<Item = f64> {
    (0..n).map(move |k| k as f64 * ts.seconds())
}
