//! Laws of logs: round trips, errors with their place, real logs, and the documentation itself.

mod docs;
mod logs;
mod turbine;
