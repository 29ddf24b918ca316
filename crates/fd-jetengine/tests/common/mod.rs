//! Reading the reference data that lies beside the workspace, when it is there.

#![allow(dead_code, clippy::unwrap_used, clippy::print_stdout, reason = "shared test helpers")]

use serde_json::Value;

/// A JSON file of the reference data, or `None`, said on the output, when it is not there.
pub(crate) fn reference(path: &str) -> Option<Value> {
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared/reference/");
    let Ok(text) = std::fs::read_to_string(format!("{root}{path}")) else {
        println!("skipped: no reference data `{path}` beside the workspace");
        return None;
    };
    Some(serde_json::from_str(&text).unwrap())
}

/// An array of numbers.
pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

/// A matrix as rows.
pub(crate) fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}
