//! Native effects, as an outside simulator states them.

use super::{
    error::{OutsideError, wrong},
    stated::{Entry, Stated},
};
use crate::{model::Parameter, simulate::NativeEffect};

impl Entry {
    /// What there is to say of a native effect.
    pub(super) fn of_native(native: &NativeEffect) -> Self {
        let NativeEffect { label, family, place, parameter, size, is_reciprocal } = native.clone();
        Self {
            name: parameter.name,
            unit: Some(parameter.unit),
            value: Some(parameter.value),
            bounds: parameter.bounds,
            label: Some(label),
            family: Some(family).filter(|family| !family.is_empty()),
            place: Some(place),
            size: Some(size),
            reciprocal: is_reciprocal.then_some(true),
            ..Self::default()
        }
    }
}

/// Longest label, in characters.
const LONGEST: usize = 64;

/// The native effects that are stated; `place` is who says it, for messages.
pub(super) fn natives(stated: &Stated, place: &str) -> Result<Vec<NativeEffect>, OutsideError> {
    let entries = &stated.native_effects;
    let each = entries.iter().enumerate().map(|(i, entry)| {
        let key = format!("native_effects.{}", entry.name);
        if stated.parameters.iter().any(|known| known.name == entry.name) {
            let expected = "a name that no parameter has";
            return Err(wrong(place, key, expected, format!("`{}`", entry.name)));
        }
        let native = native(entry, &key, place)?;
        let is_it = |e: &&Entry| e.label == entry.label && e.place == entry.place;
        if entries[..i].iter().find(is_it).is_some() {
            let found = format!("`{}` at `{}` twice", native.label, native.place);
            return Err(wrong(place, key, "every label once at a place", found));
        }
        Ok(native)
    });
    each.collect()
}

fn native(entry: &Entry, key: &str, place: &str) -> Result<NativeEffect, OutsideError> {
    let fail = |what: &str, expected: &str, found: String| {
        Err(wrong(place, format!("{key}.{what}"), expected, found))
    };
    let text = |text: &Option<String>| text.clone().unwrap_or_default();
    let (label, family) = (text(&entry.label), text(&entry.family));
    for (what, word, is_needed) in [("label", &label, true), ("family", &family, false)] {
        if !(is_label(word) || word.is_empty() && !is_needed) {
            let expected = "a word of small letters, digits and dashes, such as `coulomb-friction`";
            return fail(what, expected, format!("`{word}`"));
        }
    }
    let Some(at) = entry.place.clone().filter(|at| !at.trim().is_empty()) else {
        let expected = "a port, an input, an output or another part of the simulator";
        return fail("place", expected, "none".to_owned());
    };
    let value = entry.value.unwrap_or(0.0);
    if !value.is_finite() {
        return fail("value", "the finite value at which it rests", value.to_string());
    }
    if let Some([low, high]) =
        entry.bounds.filter(|[low, high]| !(low <= &value && &value <= high && low < high))
    {
        let expected = format!("bounds around the value {value} at which it rests");
        return fail("bounds", &expected, format!("[{low}, {high}]"));
    }
    let size = entry.size.unwrap_or(value.abs());
    if !(size.is_finite() && 0.0 < size) {
        let expected = "a change of the value that is noticed, above 0";
        let found = entry.size.map_or("none, and a value of 0".to_owned(), |size| size.to_string());
        return fail("size", expected, found);
    }
    let unit = entry.unit.clone().unwrap_or_else(|| "1".to_owned());
    let parameter = Parameter { bounds: entry.bounds, ..Parameter::new(&entry.name, unit, value) };
    let is_reciprocal = entry.reciprocal.unwrap_or(false);
    Ok(NativeEffect { family, is_reciprocal, ..NativeEffect::new(label, at, parameter, size) })
}

/// Whether a text can be the label of an effect.
fn is_label(text: &str) -> bool {
    let is_fine = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.len() <= LONGEST
        && text.chars().all(is_fine)
}
