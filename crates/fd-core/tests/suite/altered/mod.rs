//! Snapshots that somebody has changed.
#![allow(clippy::unwrap_used, reason = "a failure here is a failed test")]

use serde_json::Value;

/// Every copy of a JSON value in which one number is another.
pub(crate) fn with_one_number_altered(value: &Value) -> Vec<Value> {
    match value {
        Value::Number(number) => {
            let number = number.as_u64().unwrap();
            let others = [number ^ 1, number ^ (1 << 31), number ^ (1 << 63), !number, 0, 1];
            others.into_iter().filter(|other| *other != number).map(Value::from).collect()
        }
        Value::Array(items) => (0..items.len())
            .flat_map(|i| {
                with_one_number_altered(&items[i]).into_iter().map(move |item| {
                    let mut copy = items.clone();
                    copy[i] = item;
                    Value::Array(copy)
                })
            })
            .collect(),
        Value::Object(entries) => entries
            .iter()
            .flat_map(|(key, item)| {
                with_one_number_altered(item).into_iter().map(move |item| {
                    let mut copy = entries.clone();
                    copy.insert(key.clone(), item);
                    Value::Object(copy)
                })
            })
            .collect(),
        _ => Vec::new(),
    }
}
