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
    pub version: u32,
    pub kind: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileModel {
    #[serde(rename = "version")]
    _version: u32,
    #[serde(rename = "kind")]
    _kind: String,
    pub name: String,
    #[serde(default)]
    pub description: String,
    pub sample_time: Spanned<f64>,
    pub step: Option<Spanned<f64>>,
    #[serde(default)]
    pub hold: Hold,
    #[serde(default)]
    pub parameters: Ordered<FileParameter>,
    #[serde(default)]
    pub inputs: Ordered<FileInput>,
    #[serde(default)]
    pub states: Ordered<FileState>,
    pub outputs: Ordered<FileOutput>,
    #[serde(default)]
    pub definitions: Ordered<Spanned<Text>>,
    #[serde(default)]
    pub sites: Ordered<FileSite>,
    #[serde(default)]
    pub delays: Ordered<FileDelay>,
    #[serde(default)]
    pub signs: Ordered<Spanned<Text>>,
    #[serde(default)]
    pub tables: Ordered<FileTable>,
    pub controller: Option<FileController>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileParameter {
    pub unit: String,
    pub value: f64,
    pub tolerance: Option<f64>,
    pub bounds: Option<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileInput {
    pub unit: String,
    pub saturation: Option<[Spanned<Text>; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileState {
    pub unit: String,
    pub initial: f64,
    pub tolerance: Option<f64>,
    pub derivative: Option<Spanned<Text>>,
    pub update: Option<Spanned<Text>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileOutput {
    pub unit: String,
    pub value: Spanned<Text>,
    pub noise: Option<f64>,
    #[serde(default)]
    pub wraps: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileSite {
    pub unit: String,
    pub enters: Ordered<Spanned<Text>>,
    pub position: Option<Spanned<Text>>,
    pub velocity: Option<Spanned<Text>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileDelay {
    pub value: Spanned<Text>,
    pub time: Spanned<Text>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileTable {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    #[serde(default)]
    pub outside: Outside,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileController {
    pub sample_time: Option<f64>,
    #[serde(default)]
    pub references: Ordered<FileReference>,
    #[serde(default)]
    pub states: Ordered<FileState>,
    #[serde(default)]
    pub definitions: Ordered<Spanned<Text>>,
    pub signals: Ordered<Spanned<Text>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FileReference {
    pub unit: String,
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
