//! The threads that a command runs on.

use fdiag::core::{Limits, Resource};

use crate::failure::Failure;

/// So many threads; 0 takes all cores.
///
/// # Errors
///
/// More threads than there may be, or that the system gives.
pub fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    let limits = Limits::default();
    limits.check(Resource::Threads, "--threads", threads as f64).map_err(Failure::analysis)?;
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(Failure::analysis)
}
