//! Where a unit learns what is normal.

use fd_model::Record;

/// Where a unit learns what is normal.
#[derive(Clone, Debug)]
pub enum Learning {
    /// From logs of healthy plants, in the units of the channels; once, for all units.
    Logs(Vec<Record>),
    /// From its own first samples, which are taken to be healthy.
    Stream {
        /// How many samples on the even time base.
        samples: u64,
    },
}
