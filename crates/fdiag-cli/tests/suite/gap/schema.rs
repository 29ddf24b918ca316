//! `report.json` against its schema, and the schema against its types and its description.

use std::{
    cell::RefCell,
    collections::{BTreeSet, VecDeque},
    fs,
    path::PathBuf,
};

use serde_json::{Value, json};

use crate::gap::desk::{Desk, FEW};

fn file() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs/gap-report.schema.json")
}

/// The schema as it is published.
pub(crate) fn schema() -> Value {
    serde_json::from_str(&fs::read_to_string(file()).unwrap()).unwrap()
}

/// What of a value is not as a schema says, with its place. Knows the words that the schema of a report
/// is made of, and finds fault with any other: a word that is not checked would pass everything. It is
/// stricter than the schema in that objects have no key that is not described.
pub(crate) fn faults(root: &Value, value: &Value) -> Vec<String> {
    let mut faults = Vec::new();
    check(root, root, value, "$", &mut faults);
    faults
}

fn check(root: &Value, schema: &Value, value: &Value, at: &str, faults: &mut Vec<String>) {
    let Some(schema) = schema.as_object() else {
        faults.push(format!("{at}: a schema that is no object: {schema}"));
        return;
    };
    for (word, says) in schema {
        let is_right = match word.as_str() {
            "$schema" | "$defs" | "title" | "description" => true,
            "$ref" => {
                let target = says.as_str().and_then(|path| root.pointer(path.strip_prefix('#')?));
                check(root, target.unwrap_or(&Value::Null), value, at, faults);
                true
            }
            "type" => match says {
                Value::Array(kinds) => kinds.iter().any(|kind| is_of(value, kind)),
                kind => is_of(value, kind),
            },
            "const" => value == says,
            "enum" => says.as_array().unwrap().contains(value),
            "format" => ["uint", "uint32", "uint64", "double"].contains(&says.as_str().unwrap()),
            "minimum" => value.as_f64().is_none_or(|value| says.as_f64().unwrap() <= value),
            "minItems" => value.as_array().is_none_or(|a| says.as_u64().unwrap() <= a.len() as u64),
            "maxItems" => value.as_array().is_none_or(|a| a.len() as u64 <= says.as_u64().unwrap()),
            "required" => {
                let is_there = |key: &Value| value.get(key.as_str().unwrap()).is_some();
                !value.is_object() || says.as_array().unwrap().iter().all(is_there)
            }
            "properties" => {
                for (key, value) in value.as_object().into_iter().flatten() {
                    match says.get(key) {
                        Some(of) => check(root, of, value, &format!("{at}.{key}"), faults),
                        None => faults.push(format!("{at}.{key} is not described")),
                    }
                }
                true
            }
            "items" => {
                for (i, value) in value.as_array().into_iter().flatten().enumerate() {
                    check(root, says, value, &format!("{at}[{i}]"), faults);
                }
                true
            }
            "anyOf" | "oneOf" => {
                let fits = |of: &&Value| {
                    let mut faults = Vec::new();
                    check(root, of, value, at, &mut faults);
                    faults.is_empty()
                };
                let count = says.as_array().unwrap().iter().filter(fits).count();
                count == 1 || word == "anyOf" && 0 < count
            }
            _ => false,
        };
        if !is_right {
            faults.push(format!("{at}: {value} is not `{word}` {says}"));
        }
    }
}

fn is_of(value: &Value, kind: &Value) -> bool {
    match kind.as_str().unwrap() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        _ => false,
    }
}

/// Collects the keys that a schema describes.
fn described(schema: &Value, keys: &mut BTreeSet<String>) {
    match schema {
        Value::Object(map) => {
            for (word, says) in map {
                if let ("properties", Some(properties)) = (word.as_str(), says.as_object()) {
                    keys.extend(properties.keys().cloned());
                }
                described(says, keys);
            }
        }
        Value::Array(list) => list.iter().for_each(|schema| described(schema, keys)),
        _ => {}
    }
}

/// `FDIAG_WRITE_SCHEMA=1` writes the file instead (`cargo xtask schema` does).
#[test]
fn the_schema_is_that_of_the_types() {
    let text = serde_json::to_string_pretty(&fdiag::gap_study::schema()).unwrap() + "\n";
    if std::env::var_os("FDIAG_WRITE_SCHEMA").is_some() {
        fs::write(file(), &text).unwrap();
    }
    let file = fs::read_to_string(file()).unwrap();
    assert!(file == text, "docs/gap-report.schema.json is old: run `cargo xtask schema`");
}

/// Every key is described in words.
#[test]
fn the_document_names_every_key() {
    let mut keys = BTreeSet::new();
    described(&schema(), &mut keys);
    let page = include_str!("../../../../../docs/gap-report.md");
    let missing: Vec<&String> =
        keys.iter().filter(|key| !page.contains(&format!("`{key}`"))).collect();
    assert!(missing.is_empty(), "docs/gap-report.md does not name {missing:?}");
    assert!(60 < keys.len(), "{}", keys.len());
}

/// One real report of every answer but "unclear", each as the schema says ([`Desk::report`] checks it).
#[test]
fn reports_of_every_answer_follow_the_schema() {
    let of = |desk: &Desk, verdict: &str, arguments: &[&str]| {
        let output = desk.run(&[arguments, &["--out", "out"]].concat());
        assert!(output.status.success(), "{verdict}: {output:?}");
        let report = desk.report();
        assert_eq!(report["diagnosis"]["verdict"], verdict, "{}", report["headline"]);
        report
    };
    let desk = Desk::new();
    let plain = ["--model", "model.toml", "--log", "monday.csv"];
    of(&desk, "cause", &[&plain[..], &FEW].concat());
    let patched = ["--model", "patched.toml", "--log", "monday.csv"];
    desk.put("patched.toml", &desk.read("out/patched.toml"));
    of(&desk, "no-gap", &[&patched[..], &FEW].concat());
    // Friction, of which neither of these knows anything.
    let gains = ["--only", "input-gain", "--only", "sensor-scale"];
    let none = of(&desk, "none-of-these", &[&plain[..], &gains].concat());
    assert!(none["ceiling"]["linear"].is_object());
    // The tacho is five samples late as well.
    let late = RefCell::new(VecDeque::new());
    desk.spoil("monday.csv", |_, row| {
        let mut late = late.borrow_mut();
        late.push_back(row[2].clone());
        row[2] = late[0].clone();
        if 5 < late.len() {
            late.pop_front();
        }
    });
    let pair = of(&desk, "pair", &[&plain[..], &FEW].concat());
    assert_eq!(pair["diagnosis"]["pairs"][0]["causes"].as_array().unwrap().len(), 2);
    // Efficiencies of the compressor and its turbine act alike.
    let desk = Desk::of("engine", &["linear.toml", "worn.csv"]);
    let worn = ["--model", "linear.toml", "--log", "worn.csv", "--only", "module-efficiency"];
    let tied = of(&desk, "tied", &[&worn[..], &["--calibrate", "1"]].concat());
    assert!(tied["advice"]["tried"].is_array() && tied["calibration"]["counts"].is_array());
}

/// A report with any one thing wrong is none.
#[test]
fn a_report_that_is_wrong_is_found_out() {
    let desk = Desk::new();
    assert!(desk.gap(&FEW).status.success());
    let (schema, good) = (schema(), desk.report());
    let wrong: [(&str, Value); 9] = [
        ("/version", 1.into()),
        ("/headline", Value::Null),
        ("/diagnosis/verdict", "perhaps".into()),
        ("/diagnosis/causes/0/site/kind", "sensor".into()),
        ("/diagnosis/causes/0/probability", "high".into()),
        ("/diagnosis/tied/0", 0.5.into()),
        ("/diagnosis/held_out/0/closed_of_refit/interval", json!([0.1, 0.2, 0.3])),
        ("/inputs/logs/0/role", "HeldOut".into()),
        ("/timing", json!({ "seconds": 1.0, "threads": 2, "cores": 4 })),
    ];
    for (place, value) in wrong {
        let mut report = good.clone();
        *report.pointer_mut(place).unwrap_or_else(|| panic!("{place}")) = value;
        let faults = faults(&schema, &report);
        assert!(!faults.is_empty(), "{place}");
    }
    for key in good.as_object().unwrap().keys() {
        let mut report = good.clone();
        report.as_object_mut().unwrap().remove(key);
        assert!(!faults(&schema, &report).is_empty(), "{key}");
    }
    // A number that is not known is null.
    let mut report = good.clone();
    report["diagnosis"]["causes"][0]["log_evidence"] = Value::Null;
    assert_eq!(faults(&schema, &report), [""; 0]);
}
