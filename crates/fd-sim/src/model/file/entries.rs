//! The entries of a model file, as serde sees them.

use std::{fmt, marker::PhantomData};

use serde::{
    Deserialize, Deserializer,
    de::{MapAccess, Visitor},
};
use toml::Spanned;

use super::super::draft::Hold;
use crate::equation::Outside;

/// What is read first, so that another format is named instead of its unknown entries.
#[derive(Deserialize)]
pub(super) struct Head {
    pub(super) version: u32,
    pub(super) kind: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileModel {
    #[serde(rename = "version")]
    _version: u32,
    #[serde(rename = "kind")]
    _kind: String,
    pub(super) name: String,
    #[serde(default)]
    pub(super) description: String,
    pub(super) sample_time: Spanned<f64>,
    pub(super) step: Option<Spanned<f64>>,
    #[serde(default)]
    pub(super) hold: Hold,
    #[serde(default)]
    pub(super) parameters: Ordered<FileParameter>,
    #[serde(default)]
    pub(super) inputs: Ordered<FileInput>,
    #[serde(default)]
    pub(super) states: Ordered<FileState>,
    pub(super) outputs: Ordered<FileOutput>,
    #[serde(default)]
    pub(super) definitions: Ordered<Spanned<Text>>,
    #[serde(default)]
    pub(super) sites: Ordered<FileSite>,
    #[serde(default)]
    pub(super) delays: Ordered<FileDelay>,
    #[serde(default)]
    pub(super) signs: Ordered<Spanned<Text>>,
    #[serde(default)]
    pub(super) tables: Ordered<FileTable>,
    pub(super) controller: Option<FileController>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileParameter {
    pub(super) unit: String,
    pub(super) value: f64,
    pub(super) tolerance: Option<f64>,
    pub(super) bounds: Option<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileInput {
    pub(super) unit: String,
    pub(super) saturation: Option<[Spanned<Text>; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileState {
    pub(super) unit: String,
    pub(super) initial: f64,
    pub(super) tolerance: Option<f64>,
    pub(super) derivative: Option<Spanned<Text>>,
    pub(super) update: Option<Spanned<Text>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileOutput {
    pub(super) unit: String,
    pub(super) value: Spanned<Text>,
    pub(super) noise: Option<f64>,
    #[serde(default)]
    pub(super) wraps: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileSite {
    pub(super) unit: String,
    pub(super) enters: Ordered<Spanned<Text>>,
    pub(super) position: Option<Spanned<Text>>,
    pub(super) velocity: Option<Spanned<Text>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileDelay {
    pub(super) value: Spanned<Text>,
    pub(super) time: Spanned<Text>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileTable {
    pub(super) x: Vec<f64>,
    pub(super) y: Vec<f64>,
    #[serde(default)]
    pub(super) outside: Outside,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileController {
    pub(super) sample_time: Option<f64>,
    #[serde(default)]
    pub(super) references: Ordered<FileReference>,
    #[serde(default)]
    pub(super) states: Ordered<FileState>,
    #[serde(default)]
    pub(super) definitions: Ordered<Spanned<Text>>,
    pub(super) signals: Ordered<Spanned<Text>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileReference {
    pub(super) unit: String,
}

/// An expression, or a plain number in its place.
pub(super) enum Text {
    Number(f64),
    Expression(String),
}

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TextVisitor;

        impl Visitor<'_> for TextVisitor {
            type Value = Text;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an expression (a string) or a number")
            }

            fn visit_str<E>(self, text: &str) -> Result<Text, E> {
                Ok(Text::Expression(text.to_owned()))
            }

            fn visit_f64<E>(self, value: f64) -> Result<Text, E> {
                Ok(Text::Number(value))
            }

            fn visit_i64<E>(self, value: i64) -> Result<Text, E> {
                Ok(Text::Number(value as f64))
            }
        }

        deserializer.deserialize_any(TextVisitor)
    }
}

/// The entries of a table in the order of the file, which a map does not keep.
pub(crate) struct Ordered<T>(pub(crate) Vec<(Spanned<String>, T)>);

impl<T> Default for Ordered<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Ordered<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OrderedVisitor<T>(PhantomData<T>);

        impl<'de, T: Deserialize<'de>> Visitor<'de> for OrderedVisitor<T> {
            type Value = Ordered<T>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Ordered<T>, A::Error> {
                let mut entries: Vec<(Spanned<String>, T)> = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                entries.sort_by_key(|(name, _)| name.span().start);
                Ok(Ordered(entries))
            }
        }

        deserializer.deserialize_map(OrderedVisitor(PhantomData))
    }
}
