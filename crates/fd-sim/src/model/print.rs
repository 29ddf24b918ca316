//! A model as the text of its file.

use std::fmt;

use super::{
    Model,
    draft::{Controller, Definition, Draft, Hold, Law, State},
    file::{KIND, VERSION},
};
use crate::equation::{Expr, Outside};

/// The text of a file that loads to the same model, bit for bit.
impl fmt::Display for Model {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let model: &Draft = self;
        writeln!(
            f,
            "version = {VERSION}\nkind = {}\nname = {}",
            Quoted(KIND),
            Quoted(&model.name)
        )?;
        if !model.description.is_empty() {
            writeln!(f, "description = {}", Quoted(&model.description))?;
        }
        writeln!(f, "sample_time = {:?}", model.sample_time)?;
        optional(f, "step", model.step)?;
        if model.hold == Hold::Linear {
            writeln!(f, "hold = \"linear\"")?;
        }
        room(f, "parameters", &model.parameters, |f, p| {
            write!(
                f,
                "{} = {{ unit = {}, value = {:?}, tolerance = {:?}",
                p.name,
                Quoted(&p.unit),
                p.value,
                p.tolerance
            )?;
            if let Some([low, high]) = p.bounds {
                write!(f, ", bounds = [{low:?}, {high:?}]")?;
            }
            f.write_str(" }")
        })?;
        room(f, "inputs", &model.inputs, |f, i| {
            write!(f, "{} = {{ unit = {}", i.name, Quoted(&i.unit))?;
            if let Some([low, high]) = &i.saturation {
                write!(f, ", saturation = [{}, {}]", Entry(low), Entry(high))?;
            }
            f.write_str(" }")
        })?;
        room(f, "states", &model.states, state)?;
        room(f, "outputs", &model.outputs, |f, o| {
            write!(f, "{} = {{ unit = {}, value = {}", o.name, Quoted(&o.unit), Entry(&o.value))?;
            if let Some(noise) = o.noise {
                write!(f, ", noise = {noise:?}")?;
            }
            if o.wraps {
                f.write_str(", wraps = true")?;
            }
            f.write_str(" }")
        })?;
        room(f, "definitions", &model.definitions, definition)?;
        room(f, "sites", &model.sites, |f, s| {
            write!(f, "{} = {{ unit = {}, enters = {{ ", s.name, Quoted(&s.unit))?;
            for (i, (state, factor)) in s.enters.iter().enumerate() {
                let separator = if i == 0 { "" } else { ", " };
                write!(f, "{separator}{state} = {}", Entry(factor))?;
            }
            f.write_str(" }")?;
            for (key, expr) in [("position", &s.position), ("velocity", &s.velocity)] {
                if let Some(expr) = expr {
                    write!(f, ", {key} = {}", Entry(expr))?;
                }
            }
            f.write_str(" }")
        })?;
        room(f, "delays", &model.delays, |f, d| {
            write!(f, "{} = {{ value = {}, time = {} }}", d.name, Entry(&d.value), Entry(&d.time))
        })?;
        room(f, "signs", &model.signs, |f, s| write!(f, "{} = {}", s.name, Entry(&s.velocity)))?;
        room(f, "tables", &model.tables, |f, t| {
            let (x, y) = (t.table.x(), t.table.y());
            write!(f, "{} = {{ x = {x:?}, y = {y:?}", t.name)?;
            if t.table.outside() == Outside::Extend {
                f.write_str(", outside = \"extend\"")?;
            }
            f.write_str(" }")
        })?;
        model.controller.iter().try_for_each(|c| controller(f, c))
    }
}

fn controller(f: &mut fmt::Formatter<'_>, controller: &Controller) -> fmt::Result {
    if let Some(sample_time) = controller.sample_time {
        write!(f, "\n[controller]\nsample_time = {sample_time:?}\n")?;
    }
    room(f, "controller.references", &controller.references, |f, r| {
        write!(f, "{} = {{ unit = {} }}", r.name, Quoted(&r.unit))
    })?;
    room(f, "controller.states", &controller.states, state)?;
    room(f, "controller.definitions", &controller.definitions, definition)?;
    room(f, "controller.signals", &controller.signals, |f, s| {
        write!(f, "{} = {}", s.input, Entry(&s.value))
    })
}

/// A table with one line per entry, left out when there is none.
fn room<T>(
    f: &mut fmt::Formatter<'_>,
    name: &str,
    entries: &[T],
    print: impl Fn(&mut fmt::Formatter<'_>, &T) -> fmt::Result,
) -> fmt::Result {
    if entries.is_empty() {
        return Ok(());
    }
    writeln!(f, "\n[{name}]")?;
    for entry in entries {
        print(f, entry)?;
        writeln!(f)?;
    }
    Ok(())
}

fn state(f: &mut fmt::Formatter<'_>, s: &State) -> fmt::Result {
    write!(f, "{} = {{ unit = {}, initial = {:?}", s.name, Quoted(&s.unit), s.initial)?;
    if let Some(tolerance) = s.tolerance {
        write!(f, ", tolerance = {tolerance:?}")?;
    }
    let key = if matches!(s.law, Law::Derivative(_)) { "derivative" } else { "update" };
    write!(f, ", {key} = {} }}", Entry(s.law.expr()))
}

fn definition(f: &mut fmt::Formatter<'_>, d: &Definition) -> fmt::Result {
    write!(f, "{} = {}", d.name, Entry(&d.value))
}

fn optional(f: &mut fmt::Formatter<'_>, key: &str, value: Option<f64>) -> fmt::Result {
    value.map_or(Ok(()), |value| writeln!(f, "{key} = {value:?}"))
}

/// An expression as a TOML value: a literal as a number, everything else as a string.
struct Entry<'a>(&'a Expr);

impl fmt::Display for Entry<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Expr::Number(value) if value.is_finite() => write!(f, "{value:?}"),
            expr => write!(f, "\"{expr}\""),
        }
    }
}

/// A basic TOML string.
struct Quoted<'a>(&'a str);

impl fmt::Display for Quoted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("\"")?;
        for c in self.0.chars() {
            match c {
                '"' | '\\' => write!(f, "\\{c}")?,
                c if c.is_control() => write!(f, "\\u{:04X}", u32::from(c))?,
                c => write!(f, "{c}")?,
            }
        }
        f.write_str("\"")
    }
}
