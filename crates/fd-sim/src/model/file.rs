//! The TOML file of a model, read in its order and with the places of its entries.

mod entries;

use toml::Spanned;

pub(crate) use self::entries::Ordered;
use self::entries::{FileController, FileModel, FileState, Head, Text};
use super::{
    draft::{
        Controller, DEFAULT_TOLERANCE, Definition, Delay, Draft, Input, Law, NamedTable, Output,
        Parameter, Reference, Sign, Signal, Site, State,
    },
    error::{Mistake, ModelError, Place, Places},
};
use crate::equation::{Expr, Table};

/// Format version that this program reads and writes.
pub(super) const VERSION: u32 = 1;
/// Value of `kind` in the file.
pub(super) const KIND: &str = "equations";

/// Reads a file.
pub(super) fn read(text: &str) -> Result<(Draft, Places), ModelError> {
    let head: Head = from_toml(text)?;
    let refuse = |key: &str, mistake| Err(ModelError::new(key, mistake));
    if head.kind != KIND {
        return refuse("kind", Mistake::Kind { found: head.kind });
    }
    if head.version != VERSION {
        return refuse("version", Mistake::Version { found: head.version });
    }
    let file: FileModel = from_toml(text)?;
    let mut reader = Reader { text, places: Places::new(), errors: Vec::new() };
    let draft = reader.model(file);
    ModelError::all(reader.errors)?;
    Ok((draft, reader.places))
}

fn from_toml<T: serde::de::DeserializeOwned>(text: &str) -> Result<T, ModelError> {
    toml::from_str(text).map_err(|error| {
        let mistake = Mistake::Toml(error.message().to_owned());
        let place = error.span().map(|span| Place::of(text, span.start));
        ModelError { place, ..ModelError::new("", mistake) }
    })
}

struct Reader<'a> {
    text: &'a str,
    places: Places,
    /// What is wrong with entries, which are then left out.
    errors: Vec<ModelError>,
}

type Read<T> = Result<T, ModelError>;

impl Reader<'_> {
    fn model(&mut self, file: FileModel) -> Draft {
        for (key, place) in [("sample_time", &file.sample_time)]
            .into_iter()
            .chain(file.step.as_ref().map(|s| ("step", s)))
        {
            self.places.insert(key.to_owned(), place.span());
        }
        Draft {
            name: file.name,
            description: file.description,
            sample_time: file.sample_time.into_inner(),
            step: file.step.map(Spanned::into_inner),
            hold: file.hold,
            parameters: self.each("parameters", file.parameters, |_, _, name, p| {
                Ok(Parameter {
                    name,
                    unit: p.unit,
                    value: p.value,
                    tolerance: p.tolerance.unwrap_or(DEFAULT_TOLERANCE),
                    bounds: p.bounds,
                })
            }),
            inputs: self.each("inputs", file.inputs, |reader, key, name, i| {
                let limits = i.saturation.map(|[low, high]| {
                    let key = format!("{key}.saturation");
                    Ok([reader.expr(&key, low)?, reader.expr(&key, high)?])
                });
                Ok(Input { name, unit: i.unit, saturation: limits.transpose()? })
            }),
            states: self.each("states", file.states, Self::state),
            outputs: self.each("outputs", file.outputs, |reader, key, name, o| {
                let value = reader.expr(&format!("{key}.value"), o.value)?;
                Ok(Output { name, unit: o.unit, value, noise: o.noise, wraps: o.wraps })
            }),
            definitions: self.each("definitions", file.definitions, Self::definition),
            sites: self.each("sites", file.sites, |reader, key, name, s| {
                let enters = reader.each(
                    &format!("{key}.enters"),
                    s.enters,
                    |reader, key, state, factor| Ok((state, reader.expr(key, factor)?)),
                );
                let mut optional = |entry: &str, text: Option<Spanned<Text>>| {
                    text.map(|text| reader.expr(&format!("{key}.{entry}"), text)).transpose()
                };
                let (position, velocity) =
                    (optional("position", s.position)?, optional("velocity", s.velocity)?);
                Ok(Site { name, unit: s.unit, enters, position, velocity })
            }),
            delays: self.each("delays", file.delays, |reader, key, name, d| {
                let value = reader.expr(&format!("{key}.value"), d.value)?;
                Ok(Delay { name, value, time: reader.expr(&format!("{key}.time"), d.time)? })
            }),
            signs: self.each("signs", file.signs, |reader, key, name, text| {
                Ok(Sign { name, velocity: reader.expr(key, text)? })
            }),
            tables: self.each("tables", file.tables, |_, key, name, t| {
                let table = Table::new(t.x, t.y, t.outside);
                Ok(NamedTable { name, table: table.map_err(|e| ModelError::new(key, e.into()))? })
            }),
            controller: file.controller.map(|controller| self.controller(controller)),
        }
    }

    fn controller(&mut self, file: FileController) -> Controller {
        Controller {
            sample_time: file.sample_time,
            references: self.each("controller.references", file.references, |_, _, name, r| {
                Ok(Reference { name, unit: r.unit })
            }),
            states: self.each("controller.states", file.states, Self::state),
            definitions: self.each("controller.definitions", file.definitions, Self::definition),
            signals: self.each("controller.signals", file.signals, |reader, key, input, text| {
                Ok(Signal { input, value: reader.expr(key, text)? })
            }),
        }
    }

    fn state(&mut self, key: &str, name: String, file: FileState) -> Read<State> {
        let law = match (file.derivative, file.update) {
            (Some(text), None) => Law::Derivative(self.expr(&format!("{key}.derivative"), text)?),
            (None, Some(text)) => Law::Update(self.expr(&format!("{key}.update"), text)?),
            _ => return Err(ModelError::new(key, Mistake::Law).found_in(&self.places, self.text)),
        };
        Ok(State { name, unit: file.unit, initial: file.initial, tolerance: file.tolerance, law })
    }

    fn definition(&mut self, key: &str, name: String, text: Spanned<Text>) -> Read<Definition> {
        Ok(Definition { name, value: self.expr(key, text)? })
    }

    /// Reads the entries of a table in the order of the file.
    fn each<F, T>(
        &mut self,
        room: &str,
        entries: Ordered<F>,
        mut read: impl FnMut(&mut Self, &str, String, F) -> Read<T>,
    ) -> Vec<T> {
        let mut all = Vec::with_capacity(entries.0.len());
        for (name, value) in entries.0 {
            let key = format!("{room}.{}", name.get_ref());
            self.places.insert(key.clone(), name.span());
            match read(self, &key, name.into_inner(), value) {
                Ok(entry) => all.push(entry),
                Err(error) if error.place.is_some() => self.errors.push(error),
                Err(error) => self.errors.push(error.found_in(&self.places, self.text)),
            }
        }
        all
    }

    fn expr(&mut self, key: &str, text: Spanned<Text>) -> Read<Expr> {
        self.places.insert(key.to_owned(), text.span());
        match text.into_inner() {
            Text::Number(value) => Ok(Expr::Number(value)),
            Text::Expression(text) => Expr::parse(&text).map_err(|error| {
                let problem = Mistake::Syntax(error.problem);
                ModelError::new(key, problem).in_expression(text, error.span)
            }),
        }
    }
}
