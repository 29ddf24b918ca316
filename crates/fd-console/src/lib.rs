//! What the command lines of fdiag share: where results go, what is said, how far the work is, how long a user waits,
//! and the exit code.
//!
//! | module | what it holds |
//! |---|---|
//! | [`output`] | `--out`, `--json`: whole files, and standard output for what was asked for |
//! | [`say`] | standard output and standard error, tamed for terminals |
//! | [`progress`] | bars on standard error, only when somebody is looking |
//! | [`patience`] | `--time-limit`, `--yes`: what is announced, and what must be wanted |
//! | [`bounds`] | `--time-limit`, `--memory-limit`: what any command may take |
//! | [`failure`] | why a command failed, and its exit code |
//! | [`provenance`] | what a page says of where it is from |
//! | [`shell`] | completions and pages of `man` |

pub mod bounds;
#[cfg(feature = "testing")]
pub mod documented;
pub mod failure;
mod layout;
pub mod output;
pub mod patience;
pub mod pool;
pub mod progress;
pub mod provenance;
pub mod say;
pub mod shell;
