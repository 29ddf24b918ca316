//! Laws of files: round trips, errors with their place, real logs, and the documentation itself.

mod models;
