//! Placeholder to be filled by its first method.
