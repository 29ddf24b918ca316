//! How much is confirmed on a simulator whose runs are counted.

/// How much is confirmed on the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Effort {
    /// Most single causes, halves of pairs not counted.
    pub causes: usize,
    /// Most pairs of causes.
    pub pairs: usize,
    /// Whether limits are tried on the simulator itself where nothing that was proposed is the cause: some
    /// thousand runs per input and port.
    pub limits: bool,
}

impl Default for Effort {
    fn default() -> Self {
        Self { causes: 8, pairs: 3, limits: true }
    }
}
