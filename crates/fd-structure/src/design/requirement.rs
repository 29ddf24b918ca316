//! What is asked of a set of sensors or tests.

use serde::Serialize;

use crate::{analysis::Isolability, model::StructuralModel};

/// Something that a diagnosis should be able to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Requirement {
    /// Detect a fault.
    Detect(usize),
    /// Isolate the first fault from the second: some test reacts to the first and not to the second.
    Isolate(usize, usize),
}

impl Requirement {
    /// Detect all faults.
    ///
    /// ```
    /// use fd_structure::design::Requirement;
    ///
    /// assert_eq!(Requirement::detect_all(2), [Requirement::Detect(0), Requirement::Detect(1)]);
    /// ```
    #[must_use]
    pub fn detect_all(faults: usize) -> Vec<Self> {
        (0..faults).map(Self::Detect).collect()
    }

    /// Detect all faults, and isolate each from every other.
    #[must_use]
    pub fn isolate_all(faults: usize) -> Vec<Self> {
        let pairs = (0..faults).flat_map(|i| (0..faults).map(move |j| (i, j)));
        let isolate = pairs.filter(|(i, j)| i != j).map(|(i, j)| Self::Isolate(i, j));
        Self::detect_all(faults).into_iter().chain(isolate).collect()
    }

    /// All that these detectability and isolability matrices have.
    #[must_use]
    pub fn met_by(found: &Isolability) -> Vec<Self> {
        let all = Self::isolate_all(found.detectable.len()).into_iter();
        all.filter(|requirement| requirement.is_met_by(found)).collect()
    }

    /// Whether it is met.
    #[must_use]
    pub fn is_met_by(self, found: &Isolability) -> bool {
        match self {
            Self::Detect(i) => found.detectable.get(i) == Some(&true),
            Self::Isolate(i, j) => found.isolable.get(i).and_then(|row| row.get(j)) == Some(&true),
        }
    }

    /// In words.
    #[must_use]
    pub fn describe(self, model: &StructuralModel) -> String {
        let name = |fault: usize| model.faults.get(fault).map_or("?", |fault| fault.name.as_str());
        match self {
            Self::Detect(i) => format!("detect {}", name(i)),
            Self::Isolate(i, j) => format!("isolate {} from {}", name(i), name(j)),
        }
    }
}
