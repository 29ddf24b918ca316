//! From a model to the text of its file.

use std::fmt::Write;

use faer::MatRef;

use crate::file::{
    model::{LinearModel, ModelChannel},
    model_parse::{KIND, VERSION},
};

pub(super) fn to_toml(model: &LinearModel) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_document(&mut text, model);
    text
}

fn write_document(text: &mut String, model: &LinearModel) -> std::fmt::Result {
    writeln!(text, "version = {VERSION}")?;
    writeln!(text, "kind = \"{KIND}\"")?;
    if let Some(name) = &model.name {
        writeln!(text, "name = {}", quoted(name))?;
    }
    if let Some(ts) = model.system.sample_time() {
        writeln!(text, "sample_time = {:?}", ts.seconds())?;
    }
    if model.allow_unstable {
        writeln!(text, "allow_unstable = true")?;
    }
    for (key, channels) in
        [("inputs", &model.inputs), ("states", &model.states), ("outputs", &model.outputs)]
    {
        for channel in channels {
            write_channel(text, key, channel)?;
        }
    }
    writeln!(text, "\n[matrices]")?;
    for (key, matrix) in ["A", "B", "C", "D"].into_iter().zip(model.system.matrices()) {
        write_matrix(text, key, matrix)?;
    }
    Ok(())
}

fn write_channel(text: &mut String, key: &str, model: &ModelChannel) -> std::fmt::Result {
    writeln!(text, "\n[[{key}]]")?;
    writeln!(text, "name = {}", quoted(&model.channel.name))?;
    writeln!(text, "unit = {}", quoted(&model.channel.unit))?;
    writeln!(text, "operating_point = {:?}", model.scale.offset)?;
    if let Some(scale) = model.scale.scale {
        writeln!(text, "scale = {scale:?}")?;
    }
    Ok(())
}

/// `{:?}` of a finite number is the shortest text that is read back as the same number, and
/// always has a point or an exponent, as TOML wants it.
fn write_matrix(text: &mut String, key: &str, matrix: MatRef<'_, f64>) -> std::fmt::Result {
    writeln!(text, "{key} = [")?;
    for i in 0..matrix.nrows() {
        let row: Vec<String> =
            (0..matrix.ncols()).map(|j| format!("{:?}", matrix[(i, j)])).collect();
        writeln!(text, "    [{}],", row.join(", "))?;
    }
    writeln!(text, "]")
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}
