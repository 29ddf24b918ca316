//! Mistakes in words, and what to write to mend them.

use fd_model::{
    figure,
    unit::{Conversion, KNOWN_UNITS, quantity},
};
use fd_sim::model::Model;

use super::{hypotheses::SAME, mistake::Mistake};

/// Units of the same kind that are not in the table, with their factor: values in these are smaller.
const MORE: [(&str, &str, f64); 3] =
    [("N", "kgf", 9.806_65), ("N m", "kgf m", 9.806_65), ("m/s^2", "g", 9.806_65)];

/// What is said of a mistake.
pub(super) struct Said {
    pub statement: String,
    pub advice: String,
    pub lines: String,
}

/// A mistake in words; `model` and `ts` (the time between samples) are mended.
pub(super) fn said(mistake: &Mistake, model: &Model, ts: f64) -> Said {
    match mistake {
        Mistake::Sign { channels } => Said {
            statement: format!("{} had the other sign", names(channels)),
            advice: format!("Reverse the sign of {} in the log, or in the model.", names(channels)),
            lines: value_lines(model, channels, -1.0),
        },
        Mistake::Unit { channels, factor } => unit_said(channels, *factor, model),
        Mistake::Zero { channel, .. } => {
            let unit = unit_of(model, channel);
            let is = if unit == "K" { "degC" } else { "K" };
            Said {
                statement: format!("`{channel}` were in {is}, not {unit}"),
                advice: IN_MAP.to_owned(),
                lines: unit_lines(model, channel, &unit, is),
            }
        }
        Mistake::CutOff { channels, steps } => cut_off_said(channels, steps, model),
        Mistake::Swap { channels: [a, b] } => Said {
            statement: format!("`{a}` and `{b}` were each in the other's column"),
            advice: IN_MAP.to_owned(),
            lines: [[a, b], [b, a]]
                .map(|[name, column]| {
                    format!("{}\nname = \"{name}\"\ncolumn = \"{column}\"\n", table(model, name))
                })
                .concat(),
        },
        Mistake::Clock { channel, late } => {
            let (by, when) = (late.unsigned_abs(), if 0 < *late { "late" } else { "early" });
            let seconds = figure(by as f64 * ts);
            let samples = if by == 1 { "sample" } else { "samples" };
            let way = if 0 < *late { "up" } else { "down" };
            Said {
                statement: format!("`{channel}` were logged {by} {samples} ({seconds} s) {when}"),
                advice: format!("Shift the column of `{channel}` {way} by {by} rows in the log."),
                lines: String::new(),
            }
        }
        Mistake::Time { factor } => time_said(*factor, ts),
        Mistake::Parameter { name, factor } => parameter_said(name, *factor, model),
    }
}

/// Where most mistakes are mended.
const IN_MAP: &str = "Write this into the column map (`--columns`, docs/formats.md).";

fn unit_said(channels: &[String], factor: f64, model: &Model) -> Said {
    let stated: Vec<String> = channels.iter().map(|channel| unit_of(model, channel)).collect();
    let found: Vec<Option<String>> = stated.iter().map(|unit| other_unit(unit, factor)).collect();
    let mut parts = Vec::new();
    let mut lines = String::new();
    for ((channel, stated), found) in channels.iter().zip(&stated).zip(&found) {
        if let Some(is) = found {
            parts.push(format!("`{channel}` were in {is}, not {stated}"));
            if quantity(is).is_some() {
                lines += &unit_lines(model, channel, stated, is);
            }
        } else {
            parts.push(format!("`{channel}` were {}", times(factor)));
        }
    }
    let advice = if lines.is_empty() {
        lines = value_lines(model, channels, factor);
        format!("Multiply {} by {} in the log.", names(channels), figure(1.0 / factor))
    } else {
        format!("{IN_MAP} A unit in the header of the column has to be corrected as well.")
    };
    Said { statement: parts.join(" and "), advice, lines }
}

fn cut_off_said(channels: &[String], steps: &[f64], model: &Model) -> Said {
    let each = |what: &dyn Fn(&str, f64, &str) -> String| -> String {
        let parts = channels.iter().zip(steps).map(|(c, step)| what(c, *step, &unit_of(model, c)));
        parts.collect::<Vec<_>>().join(" and ")
    };
    let cut =
        each(&|c, step, unit| format!("`{c}` were truncated to steps of {} {unit}", figure(step)));
    let halves = each(&|c, step, unit| format!("{} {unit} to `{c}`", figure(0.5 * step)));
    Said {
        statement: format!("{cut}, not rounded"),
        advice: format!("Round where it is logged, or add half a step: {halves}."),
        lines: String::new(),
    }
}

fn time_said(factor: f64, ts: f64) -> Said {
    let is = |wanted: f64| (factor / wanted - 1.0).abs() < SAME;
    let unit = if is(1e3) {
        Some("ms")
    } else if is(1.0 / 60.0) {
        Some("min")
    } else {
        None
    };
    let (statement, lines) = match unit {
        Some(unit) => {
            (format!("time were in {unit}, not s"), format!("[time]\nunit = \"{unit}\"\n"))
        }
        None => (
            format!("samples were {} s apart, not {} s", figure(ts), figure(ts * factor)),
            format!("[time]\nsample_time = {ts}\n"),
        ),
    };
    Said { statement, advice: IN_MAP.to_owned(), lines }
}

fn parameter_said(name: &str, factor: f64, model: &Model) -> Said {
    let parameter = model.parameter(name);
    let unit = parameter.map_or_else(String::new, |p| p.unit.clone());
    let statement = if factor < 0.0 {
        format!("the parameter `{name}` of the model had the other sign")
    } else if let Some(is) = other_unit(&unit, factor) {
        format!("the parameter `{name}` of the model were stated in {is}, not {unit}")
    } else {
        format!("the parameter `{name}` of the model were stated {}", times(factor))
    };
    let lines = parameter.map_or_else(String::new, |p| {
        let (value, tolerance) = (p.value, p.tolerance);
        format!("{name} = {{ unit = \"{unit}\", value = {value}, tolerance = {tolerance} }}\n")
    });
    let advice = "Write this into the model file, below `[parameters]`.".to_owned();
    Said { statement, advice, lines }
}

/// `57.3 times too large`.
fn times(factor: f64) -> String {
    let (times, size) = if 1.0 < factor { (factor, "large") } else { (1.0 / factor, "small") };
    format!("{} times too {size}", figure(times))
}

/// The unit in which values are `factor` times those in `unit`.
fn other_unit(unit: &str, factor: f64) -> Option<String> {
    let is = |found: f64| (found / factor - 1.0).abs() < SAME;
    let own = quantity(unit)?;
    let known = KNOWN_UNITS.iter().filter(|(_, other, ..)| *other == own);
    let mut known = known.filter_map(|(names, ..)| {
        let conversion = Conversion::between(unit, names[0]).ok()?;
        is(conversion.apply_to_difference(1.0)).then(|| names[0].to_owned())
    });
    known.next().or_else(|| {
        let mut more = MORE.iter().filter(|(from, _, size)| *from == unit && is(1.0 / size));
        more.next().map(|(_, name, _)| (*name).to_owned())
    })
}

fn unit_of(model: &Model, channel: &str) -> String {
    let channels = [model.external_inputs(), model.output_channels()].concat();
    let found = channels.iter().find(|known| known.name == channel);
    found.map_or_else(|| "1".to_owned(), |channel| channel.unit.clone())
}

/// The header of the entry of a channel in a column map.
fn table(model: &Model, channel: &str) -> &'static str {
    let is_output = model.outputs.iter().any(|output| output.name == channel);
    if is_output { "[[outputs]]" } else { "[[inputs]]" }
}

fn unit_lines(model: &Model, channel: &str, unit: &str, column_unit: &str) -> String {
    let table = table(model, channel);
    format!("{table}\nname = \"{channel}\"\nunit = \"{unit}\"\ncolumn_unit = \"{column_unit}\"\n")
}

/// Lines of a model whose outputs are as the log has them; none where an input is concerned.
fn value_lines(model: &Model, channels: &[String], factor: f64) -> String {
    let line = |channel: &String| {
        let output = model.outputs.iter().find(|output| output.name == *channel)?;
        let (unit, value) = (&output.unit, &output.value);
        Some(format!("{channel} = {{ unit = \"{unit}\", value = \"{factor}*({value})\" }}\n"))
    };
    let lines = channels.iter().map(line).collect::<Option<Vec<_>>>();
    lines.map_or_else(String::new, |lines| format!("# model file\n[outputs]\n{}", lines.concat()))
}

/// `a`, `a and b`.
fn names(channels: &[String]) -> String {
    channels.iter().map(|channel| format!("`{channel}`")).collect::<Vec<_>>().join(" and ")
}
