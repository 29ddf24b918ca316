//! What is said instead of an answer.

/// A status and why.
#[derive(Debug)]
pub(super) struct Refusal(pub u16, pub String);
