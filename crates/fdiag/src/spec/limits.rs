//! The whole numbers of a spec against limits, each under the path of its key.

use fd_core::{LimitError, Limits, Resource};
use serde::Serialize;
use serde_json::Value;

use super::PipelineSpec;

impl PipelineSpec {
    /// Compares every whole number with its limit, before anything of that size is made.
    ///
    /// ```
    /// use fdiag::{core::Limits, spec::PipelineSpec};
    ///
    /// let spec: PipelineSpec = toml::from_str("rule = { raise = 3, out_of = 100000 }")?;
    /// let refused = spec.check_limits(&Limits::default()).map_err(|error| error.to_string());
    /// let words = "rule.out_of: expected at most 10000 samples (limit `window`), found 100000";
    /// assert_eq!(refused, Err(words.to_owned()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first key that is beyond its limit.
    pub fn check_limits(&self, limits: &Limits) -> Result<(), LimitError> {
        check_limits(self, limits)
    }
}

/// Compares every whole number of some settings with the limit that goes with the name of its key.
///
/// # Errors
///
/// Returns the first key that is beyond its limit.
pub fn check_limits(settings: &impl Serialize, limits: &Limits) -> Result<(), LimitError> {
    // Settings come from a file, so they can be put into one.
    let value = serde_json::to_value(settings).unwrap_or_default();
    check(&mut String::new(), "", &value, limits)
}

fn check(path: &mut String, key: &str, value: &Value, limits: &Limits) -> Result<(), LimitError> {
    let within = path.len();
    match value {
        Value::Object(entries) => {
            for (key, value) in entries {
                if 0 < within {
                    path.push('.');
                }
                path.push_str(key);
                check(path, key, value, limits)?;
                path.truncate(within);
            }
            Ok(())
        }
        Value::Array(values) => values.iter().try_for_each(|value| check(path, key, value, limits)),
        Value::Number(number) => match (resource(key), number.as_u64()) {
            (Some(resource), Some(found)) => limits.check(resource, path.as_str(), found as f64),
            _ => Ok(()),
        },
        _ => Ok(()),
    }
}

/// What a whole number under this key makes large; a seed makes nothing large.
fn resource(key: &str) -> Option<Resource> {
    Some(match key {
        "seed" | "first_seed" => return None,
        "window" | "out_of" | "raise" | "horizon" | "delay" | "lag" | "columns" => Resource::Window,
        "na" | "nb" | "nc" | "nd" | "most" | "order" | "degree" | "segments" | "states"
        | "regions" | "rank" | "whitening" | "tones" | "lags" | "past" | "future" => {
            Resource::Order
        }
        "corners" => Resource::Corners,
        "models" | "draws" | "runs" | "records" | "rounds" | "calibration_runs"
        | "threshold_runs" | "test_runs" | "fault_runs" => Resource::Models,
        "seeds" | "thresholds" | "test" => Resource::Cases,
        _ => Resource::Count,
    })
}
