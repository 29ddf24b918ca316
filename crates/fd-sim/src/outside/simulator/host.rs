//! What somebody needs of a simulator who lends it to another process.

use super::{
    super::{error::OutsideError, source::Instance},
    OutsideSimulator,
};

impl OutsideSimulator {
    /// One of the simulators that runs are asked of, for whoever steps it by himself: the one that was started with
    /// this, if no copy has it, or another one.
    ///
    /// # Errors
    ///
    /// Returns why it cannot be started.
    pub fn instance(&self) -> Result<Box<dyn Instance>, OutsideError> {
        self.shared.pool.empty().map_or_else(|| self.shared.source.open(), Ok)
    }

    /// How many whole runs an instance takes in one call.
    #[must_use]
    pub fn lanes(&self) -> usize {
        self.shared.source.lanes().max(self.contract().powers.lanes)
    }

    /// Whether nothing more is asked of it, because it breaks its contract or cannot be started.
    #[must_use]
    pub fn is_given_up(&self) -> bool {
        self.shared.is_given_up()
    }
}
