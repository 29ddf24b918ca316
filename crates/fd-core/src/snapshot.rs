//! Saving and restoring the memory of running stages, to the bit.
//!
//! Every stage lists its memory once, in [`Stage::visit_state`];
//! the same list serves saving and restoring, so the two cannot drift apart.
//!
//! A snapshot comes back from a file, where anything may have happened to it. Before a stage sees a
//! number of it, its version, its checksum, the names and lengths of its fields and the numbers
//! themselves are checked.

mod checksum;
mod field;

use serde::{Deserialize, Serialize};
use thiserror::Error;

use self::{checksum::Checksum, field::Field};
use crate::{scalar::Scalar, stage::Stage, visitor::StateVisitor};

/// Version of the way in which snapshots are kept.
const VERSION: u32 = 1;
/// Largest counter: below it `f64` holds every whole number, and no counter of samples gets there.
const MOST: u64 = 1 << 53;

/// The memory of a stage or pipeline at one instant.
///
/// Reals are kept as the bits of their `f64` value, so that a snapshot that went through a text
/// file restores the very same numbers, infinities included. A checksum over all names and numbers
/// goes with them: it finds every change of a single number for certain, and any other change but for
/// one in 2⁶⁴. It is there against damage, not against forgery.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Snapshot {
    version: u32,
    checksum: Checksum,
    fields: Vec<Field>,
}

/// A snapshot is damaged, or does not belong to the stage it is restored into.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SnapshotError {
    /// It was written by another version of this library.
    #[error("snapshot: expected version {expected}, found {found}")]
    Version {
        /// Version that is read.
        expected: u32,
        /// Version of the snapshot.
        found: u32,
    },
    /// It is not what was saved.
    #[error(
        "snapshot: expected the checksum {expected} that was saved with it, found {found}: a name or \
         number was changed"
    )]
    Damaged {
        /// Checksum in the snapshot.
        expected: Checksum,
        /// Checksum of what it holds.
        found: Checksum,
    },
    /// A number cannot be the memory of a stage.
    #[error("snapshot field `{field}`, value {place}: expected {expected}, found {found}")]
    Value {
        /// Name of the quantity.
        field: String,
        /// Place among its values, from 1.
        place: usize,
        /// What it could be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// Another quantity was expected at this place.
    #[error(
        "snapshot field {index}: expected `{expected}` with {expected_len} values, found {found}"
    )]
    Field {
        /// Position in the snapshot.
        index: usize,
        /// Name of the quantity in the stage.
        expected: &'static str,
        /// Its length in the stage.
        expected_len: usize,
        /// What the snapshot holds instead.
        found: String,
    },
    /// The snapshot holds more than the stage.
    #[error("snapshot has {found} fields, the stage has {expected}")]
    Surplus {
        /// Fields of the stage.
        expected: usize,
        /// Fields of the snapshot.
        found: usize,
    },
}

impl Snapshot {
    /// Reads the memory of `stage`, which is left as it was.
    pub fn of<T: Scalar>(stage: &mut (impl Stage<T> + ?Sized)) -> Self {
        let mut save = Save { fields: Vec::new() };
        stage.visit_state(&mut save);
        Self::sealed(save.fields)
    }

    fn sealed(fields: Vec<Field>) -> Self {
        Self { version: VERSION, checksum: Checksum::of(&fields), fields }
    }

    /// Puts the memory back.
    ///
    /// # Errors
    ///
    /// Returns what is damaged, or the first field that does not fit; `stage` is then unchanged.
    pub fn restore<T: Scalar>(
        &self,
        stage: &mut (impl Stage<T> + ?Sized),
    ) -> Result<(), SnapshotError> {
        if self.version != VERSION {
            return Err(SnapshotError::Version { expected: VERSION, found: self.version });
        }
        let found = Checksum::of(&self.fields);
        if found != self.checksum {
            return Err(SnapshotError::Damaged { expected: self.checksum, found });
        }
        let mut check = Check { fields: &self.fields, next: 0, error: None };
        stage.visit_state(&mut check);
        if let Some(error) = check.error {
            return Err(error);
        }
        if check.next != self.fields.len() {
            return Err(SnapshotError::Surplus { expected: check.next, found: self.fields.len() });
        }
        stage.visit_state(&mut Load { fields: self.fields.iter() });
        Ok(())
    }
}

struct Save {
    fields: Vec<Field>,
}

impl<T: Scalar> StateVisitor<T> for Save {
    fn reals(&mut self, name: &'static str, values: &mut [T]) {
        let bits = values.iter().map(|v| v.to_report().to_bits()).collect();
        self.fields.push(Field { name: name.to_owned(), bits });
    }

    fn counts(&mut self, name: &'static str, values: &mut [u64]) {
        self.fields.push(Field { name: name.to_owned(), bits: values.to_vec() });
    }
}

struct Check<'a> {
    fields: &'a [Field],
    next: usize,
    error: Option<SnapshotError>,
}

impl Check<'_> {
    fn field(
        &mut self,
        expected: &'static str,
        expected_len: usize,
        wrong: impl Fn(u64) -> Option<(&'static str, String)>,
    ) {
        let index = self.next;
        self.next += 1;
        if self.error.is_some() {
            return;
        }
        let field = self.fields.get(index);
        if let Some(f) = field.filter(|f| f.name == expected && f.bits.len() == expected_len) {
            let mut values = f.bits.iter().enumerate();
            let wrong = values.find_map(|(i, bits)| Some((i + 1, wrong(*bits)?)));
            self.error = wrong.map(|(place, (expected, found))| {
                let field = f.name.clone();
                SnapshotError::Value { field, place, expected, found }
            });
            return;
        }
        let found = field.map_or_else(
            || "nothing".to_owned(),
            |f| format!("`{}` with {} values", f.name, f.bits.len()),
        );
        self.error = Some(SnapshotError::Field { index, expected, expected_len, found });
    }
}

impl<T> StateVisitor<T> for Check<'_> {
    fn reals(&mut self, name: &'static str, values: &mut [T]) {
        self.field(name, values.len(), |bits| {
            f64::from_bits(bits).is_nan().then(|| ("a number", "NaN".to_owned()))
        });
    }

    fn reals_with_holes(&mut self, name: &'static str, values: &mut [T]) {
        self.field(name, values.len(), |_| None);
    }

    fn counts(&mut self, name: &'static str, values: &mut [u64]) {
        self.field(name, values.len(), |count| {
            (MOST < count).then(|| ("a count of at most 2^53", count.to_string()))
        });
    }
}

struct Load<'a> {
    fields: std::slice::Iter<'a, Field>,
}

impl<T: Scalar> StateVisitor<T> for Load<'_> {
    fn reals(&mut self, _name: &'static str, values: &mut [T]) {
        for (v, bits) in values.iter_mut().zip(self.fields.next().into_iter().flat_map(|f| &f.bits))
        {
            *v = T::from_design(f64::from_bits(*bits));
        }
    }

    fn counts(&mut self, _name: &'static str, values: &mut [u64]) {
        for (v, bits) in values.iter_mut().zip(self.fields.next().into_iter().flat_map(|f| &f.bits))
        {
            *v = *bits;
        }
    }
}
