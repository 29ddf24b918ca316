//! Labels that are only known when the program runs.

use std::{
    collections::HashSet,
    sync::{Mutex, PoisonError},
};

static KNOWN: Mutex<Option<HashSet<&'static str>>> = Mutex::new(None);

/// A label that a user or a simulator says, for as long as the program runs: labels are compared and copied
/// everywhere. Each text is kept once, so what this takes is as much as there are different labels.
///
/// ```
/// use fd_effect::interned;
///
/// let text = String::from("daily-swing");
/// assert!(std::ptr::eq(interned(&text), interned("daily-swing")));
/// ```
#[must_use]
pub fn interned(text: &str) -> &'static str {
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let known = known.get_or_insert_default();
    if let Some(label) = known.get(text) {
        return label;
    }
    let label: &'static str = Box::leak(text.into());
    known.insert(label);
    label
}
