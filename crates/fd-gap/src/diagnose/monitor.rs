//! How far a diagnosis has come.

/// Is told how far a diagnosis has come, from several threads.
pub trait Monitor: Sync {
    /// A stage of so many pieces of work begins.
    fn begin(&self, stage: Stage, pieces: usize);

    /// A piece of it is done.
    fn advance(&self);

    /// Whether nobody wants the answer any more: work in many long pieces leaves out the rest, and its result is
    /// worth nothing.
    fn is_over(&self) -> bool {
        false
    }

    /// Whether nobody wants to wait any longer: what has not been begun is left out, and the answer is the best so far.
    fn is_stopped(&self) -> bool {
        false
    }

    /// The time limit, in seconds, that has stopped it; `None` when nothing has, or somebody.
    fn time_limit(&self) -> Option<f64> {
        None
    }

    /// What is going to be done, where that takes long, in a sentence.
    fn plan(&self, _text: &str) {}
}

/// A stage of a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// A simulator is linearised along the logs.
    StandIn,
    /// Every candidate is scored.
    Screen,
    /// Promising candidates are fitted.
    Fit,
    /// Second causes are fitted beside first ones.
    Pairs,
    /// Rivals are refitted to each other, and held-out logs are forecast.
    Judge,
    /// Free signals are fitted at every place.
    Locate,
    /// Black boxes learn what is left.
    Ceiling,
    /// Experiments that would separate rivals are simulated.
    Experiment,
    /// Simulated logs of known cause are diagnosed.
    Calibrate,
}

impl Stage {
    /// What is being done, in words for a progress bar.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::StandIn => "linearising the simulator",
            Self::Screen => "trying effects",
            Self::Fit => "fitting",
            Self::Pairs => "trying pairs",
            Self::Judge => "judging",
            Self::Locate => "locating",
            Self::Ceiling => "learning black boxes",
            Self::Experiment => "trying experiments",
            Self::Calibrate => "diagnosing simulated logs",
        }
    }
}

/// Nobody is told.
impl Monitor for () {
    fn begin(&self, _stage: Stage, _pieces: usize) {}

    fn advance(&self) {}
}

/// Asks whether to stop, and tells nothing of what are parts of one piece of work.
pub(super) struct WithinAPiece<'a>(pub(super) &'a dyn Monitor);

impl Monitor for WithinAPiece<'_> {
    fn begin(&self, _stage: Stage, _pieces: usize) {}

    fn advance(&self) {}

    fn is_over(&self) -> bool {
        self.0.is_over()
    }

    fn is_stopped(&self) -> bool {
        self.0.is_stopped()
    }

    fn time_limit(&self) -> Option<f64> {
        self.0.time_limit()
    }
}
