//! The threads that a command runs on.

use super::failure::Failure;

/// So many threads; 0 takes all cores.
pub(crate) fn pool(threads: usize) -> Result<rayon::ThreadPool, Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().map_err(Failure::analysis)
}
