//! Ablation: what can be left out of the method.

use fd_effect::{Effect, library};
use fd_gap::diagnose::{ControllerSees, Settings, Without};
use fd_model::HeldInputs;

/// Effects that are no curve, no law of one signal and no parameter: stores, paths over time and leaks between sensors.
const STORES_AND_PATHS: [&str; 3] = ["hidden-store", "parameter-wander", "sensor-cross-talk"];

/// A part of the method that can be left out, to see what it brings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Plants that run away are followed along their logs.
    Following,
    /// The controller of a loop may have seen what was logged.
    LoggedLoops,
    /// A log may begin in motion.
    FreeStarts,
    /// What an engineer would not believe at first sight is not named.
    Vetoes,
    /// Mistakes of reading.
    Readings,
    /// Lists of causes.
    Lists,
    /// Effects on signals inside the model.
    InnerPlaces,
    /// Hidden stores, wandering parameters, cross-talk.
    StoresAndPaths,
    /// Inputs that are resampled keep their integral.
    HeldInputs,
    /// All of these.
    All,
}

impl Feature {
    /// Every feature, alone and together.
    pub const EVERY: [Self; 10] = [
        Self::Following,
        Self::LoggedLoops,
        Self::FreeStarts,
        Self::Vetoes,
        Self::Readings,
        Self::Lists,
        Self::InnerPlaces,
        Self::StoresAndPaths,
        Self::HeldInputs,
        Self::All,
    ];

    /// Its name on a command line.
    ///
    /// ```
    /// use fd_lab::blind::Feature;
    ///
    /// assert_eq!(Feature::InnerPlaces.name(), "inner-places");
    /// ```
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Following => "following",
            Self::LoggedLoops => "logged-loops",
            Self::FreeStarts => "free-starts",
            Self::Vetoes => "vetoes",
            Self::Readings => "readings",
            Self::Lists => "lists",
            Self::InnerPlaces => "inner-places",
            Self::StoresAndPaths => "stores-and-paths",
            Self::HeldInputs => "held-inputs",
            Self::All => "all",
        }
    }

    /// What it is, in words.
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Following => "Plants that run away are followed along their logs",
            Self::LoggedLoops => "The controller of a loop may have seen what was logged",
            Self::FreeStarts => "A log may begin in motion",
            Self::Vetoes => "What an engineer would not believe at first sight is not named",
            Self::Readings => "Mistakes of reading",
            Self::Lists => "Lists of causes",
            Self::InnerPlaces => "Effects on signals inside the model",
            Self::StoresAndPaths => "Hidden stores, wandering parameters, cross-talk",
            Self::HeldInputs => "Inputs that are resampled keep their integral",
            Self::All => "All of these",
        }
    }
}

/// A method of which something may be left out.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Method {
    pub without: Option<Feature>,
}

impl Method {
    /// Whether a feature is there.
    pub(super) fn has(self, feature: Feature) -> bool {
        self.without.is_none_or(|without| without != feature && without != Feature::All)
    }

    /// The effects that are tried.
    pub(super) fn library(self) -> Vec<Box<dyn Effect>> {
        let has_all = self.has(Feature::StoresAndPaths);
        let is_tried = |label: &str| has_all || !STORES_AND_PATHS.contains(&label);
        library().into_iter().filter(|effect| is_tried(effect.label())).collect()
    }

    /// What inputs do between samples.
    pub(super) fn held_inputs(self) -> HeldInputs {
        if self.has(Feature::HeldInputs) { HeldInputs::Mean } else { HeldInputs::Latest }
    }

    /// Settings without the rules of a diagnosis that are left out.
    pub(super) fn settings(self, settings: &Settings) -> Settings {
        let without = Without {
            free_starts: !self.has(Feature::FreeStarts),
            vetoes: !self.has(Feature::Vetoes),
        };
        let controller_sees = if self.has(Feature::LoggedLoops) {
            settings.controller_sees
        } else {
            ControllerSees::Simulated
        };
        Settings { without, controller_sees, ..settings.clone() }
    }
}
