//! A line of NDJSON: one object, whose keys are columns.

use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};

use super::{
    cells::{self, Cell},
    columns::Bound,
    draft::Draft,
};

/// Reads a line into a draft.
pub(super) fn read(draft: &mut Draft, line: &[u8]) -> Result<(), String> {
    let mut json = serde_json::Deserializer::from_slice(line);
    RowSeed(draft).deserialize(&mut json).and_then(|()| json.end()).map_err(|e| e.to_string())
}

struct RowSeed<'a>(&'a mut Draft);

impl<'de> DeserializeSeed<'de> for RowSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<(), D::Error> {
        from.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for RowSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of columns")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(bound) = map.next_key_seed(KeySeed(self.0))? {
            match bound {
                Bound::Unknown => {
                    map.next_value::<IgnoredAny>()?;
                }
                Bound::Unit => map.next_value_seed(UnitSeed(self.0))?,
                bound => {
                    let cell = map.next_value_seed(CellSeed)?;
                    self.0.set(bound, cell).map_err(A::Error::custom)?;
                }
            }
        }
        Ok(())
    }
}

/// A key is looked up without being copied.
struct KeySeed<'a>(&'a mut Draft);

impl<'de> DeserializeSeed<'de> for KeySeed<'_> {
    type Value = Bound;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<Bound, D::Error> {
        from.deserialize_str(self)
    }
}

impl Visitor<'_> for KeySeed<'_> {
    type Value = Bound;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a column")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<Bound, E> {
        self.0.find(name).map_err(E::custom)
    }
}

/// The name of a unit is a text, or a whole number that stands for one.
struct UnitSeed<'a>(&'a mut Draft);

impl<'de> DeserializeSeed<'de> for UnitSeed<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<(), D::Error> {
        from.deserialize_any(self)
    }
}

impl Visitor<'_> for UnitSeed<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the name of a unit")
    }

    fn visit_str<E: Error>(self, name: &str) -> Result<(), E> {
        self.0.set_unit(name).map_err(E::custom)
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<(), E> {
        self.visit_str(&number.to_string())
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<(), E> {
        self.visit_str(&number.to_string())
    }
}

struct CellSeed;

impl<'de> DeserializeSeed<'de> for CellSeed {
    type Value = Cell;

    fn deserialize<D: Deserializer<'de>>(self, from: D) -> Result<Cell, D::Error> {
        from.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for CellSeed {
    type Value = Cell;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or nothing")
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<Cell, E> {
        Ok(cells::finite(number, "an infinity"))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<Cell, E> {
        Ok(Cell::Number(number as f64))
    }

    fn visit_u64<E: Error>(self, number: u64) -> Result<Cell, E> {
        Ok(Cell::Number(number as f64))
    }

    fn visit_unit<E: Error>(self) -> Result<Cell, E> {
        Ok(Cell::Missing)
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Cell, E> {
        Ok(Cell::Text(value.to_string()))
    }

    /// A number may be written in quotes, and `"NaN"` has to be: JSON has no other way to say it.
    fn visit_str<E: Error>(self, text: &str) -> Result<Cell, E> {
        Ok(cells::read(text, false))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Cell, A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Cell::Text("a list".to_owned()))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Cell, A::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Cell::Text("an object".to_owned()))
    }
}
