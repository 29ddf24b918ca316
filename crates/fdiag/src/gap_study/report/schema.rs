//! The JSON schema of a report, from its types.

use schemars::{
    Schema,
    generate::SchemaSettings,
    transform::{RecursiveTransform, Transform},
};
use serde_json::{Value, json};

use super::{REPORT_VERSION, Report};

/// The JSON schema (draft 2020-12) of what a [`Report`] serialises to.
///
/// A number that is not finite is `null` in JSON, so `null` is allowed wherever a number with a
/// fraction is.
///
/// ```
/// use fdiag::gap_study::schema;
///
/// assert_eq!(schema()["properties"]["version"]["const"], 2);
/// ```
#[must_use]
pub fn schema() -> Value {
    let generator = SchemaSettings::draft2020_12().for_serialize().into_generator();
    let mut schema = generator.into_root_schema_for::<Report>();
    RecursiveTransform(finite_or_null).transform(&mut schema);
    RecursiveTransform(plain_words).transform(&mut schema);
    let mut schema = schema.to_value();
    schema["title"] = json!("Report of `fdiag gap`");
    schema["properties"]["version"]["const"] = json!(REPORT_VERSION);
    schema
}

/// What is not finite is `null`.
fn finite_or_null(schema: &mut Schema) {
    if schema.get("type").is_some_and(|kind| kind == "number") {
        schema.insert("type".to_owned(), json!(["number", "null"]));
    }
}

/// Descriptions on one line, in the words of JSON, and without the targets of links, which lead into the
/// documentation of the code.
fn plain_words(schema: &mut Schema) {
    if let Some(Value::String(text)) = schema.get_mut("description") {
        *text = without_targets(text).replace('\n', " ").replace("`None`", "`null`");
    }
}

fn without_targets(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once('[') {
        plain.push_str(before);
        let Some((label, tail)) = after.split_once(']') else {
            plain.push('[');
            rest = after;
            continue;
        };
        match tail.strip_prefix('(').and_then(|tail| tail.split_once(')')) {
            Some((_, tail)) => {
                plain.push_str(label);
                rest = tail;
            }
            None if label.starts_with('`') => {
                plain.push_str(label);
                rest = tail;
            }
            None => {
                plain.push('[');
                rest = after;
            }
        }
    }
    plain + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_lose_their_targets_and_brackets_stay() {
        let text = "Places in [`a`](crate::A) of [`B`], `[over, value]`.";
        assert_eq!(without_targets(text), "Places in `a` of `B`, `[over, value]`.");
    }
}
