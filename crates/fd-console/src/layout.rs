//! JSON on one line or on many, chosen while running: a type that is written is compiled once instead of once for each.

use std::io::{self, Write};

use serde::{Serialize, ser::Error as _};
use serde_json::ser::{CompactFormatter, Formatter, PrettyFormatter, Serializer};

/// JSON of what is given.
pub(crate) fn json(data: &impl Serialize, compact: bool) -> serde_json::Result<String> {
    let layout = if compact { Layout::Line } else { Layout::Lines(PrettyFormatter::new()) };
    let mut text = Vec::new();
    data.serialize(&mut Serializer::with_formatter(&mut text, layout))?;
    String::from_utf8(text).map_err(serde_json::Error::custom)
}

enum Layout {
    Line,
    Lines(PrettyFormatter<'static>),
}

macro_rules! as_chosen {
    ($($name:ident($($first:ident)?)),* $(,)?) => {
        $(fn $name<W: ?Sized + Write>(&mut self, to: &mut W $(, $first: bool)?) -> io::Result<()> {
            match self {
                Self::Line => CompactFormatter.$name(to $(, $first)?),
                Self::Lines(lines) => lines.$name(to $(, $first)?),
            }
        })*
    };
}

impl Formatter for Layout {
    as_chosen!(
        begin_array(),
        end_array(),
        begin_array_value(first),
        end_array_value(),
        begin_object(),
        end_object(),
        begin_object_key(first),
        end_object_key(),
        begin_object_value(),
        end_object_value(),
    );
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    #[test]
    fn both_are_those_of_serde_json() {
        let data = json!({"a": [1, {}, []], "b": {"c": null, "d": "e"}});
        let text = |compact| super::json(&data, compact).unwrap();
        assert_eq!(text(true), serde_json::to_string(&data).unwrap());
        assert_eq!(text(false), serde_json::to_string_pretty(&data).unwrap());
    }
}
