//! The faults that every entry is asked to find.

use std::fmt;

use fd_model::{
    fault::{FaultProfile, FaultSpec, Site},
    figure,
};
use serde::{Deserialize, Serialize};

use super::error::CompareError;

/// The faults: every site with every profile in every size, both signs in turn.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FaultGrid {
    /// Faulty sensors by output name; sizes are shares of the reading.
    pub sensors: Vec<String>,
    /// Profiles of sensor faults.
    pub profiles: Vec<ProfileKind>,
    /// Sizes of sensor faults.
    pub sensor_sizes: Sizes,
    /// Health parameters that wear; nonlinear engines only. Incipient, sizes are shares.
    pub components: Vec<String>,
    /// Sizes of component faults.
    pub component_sizes: Sizes,
    /// Start of all faults in s from the beginning of a run.
    pub start_s: f64,
    /// Rise time of incipient faults in s.
    pub rise_s: f64,
}

/// Sizes spaced evenly in the logarithm, both ends among them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sizes {
    /// Smallest.
    pub smallest: f64,
    /// Largest.
    pub largest: f64,
    /// How many.
    pub count: usize,
}

/// How a fault develops.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProfileKind {
    /// All at once.
    Abrupt,
    /// A straight rise that ends.
    Incipient,
    /// A straight rise that reaches its size at the end of the run.
    Drift,
}

impl ProfileKind {
    /// In one word.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Abrupt => "abrupt",
            Self::Incipient => "incipient",
            Self::Drift => "drift",
        }
    }
}

impl Default for FaultGrid {
    fn default() -> Self {
        Self {
            sensors: vec!["T_7".to_owned(), "P_6".to_owned()],
            profiles: vec![ProfileKind::Abrupt, ProfileKind::Incipient, ProfileKind::Drift],
            sensor_sizes: Sizes { smallest: 5e-5, largest: 0.05, count: 10 },
            components: vec!["hpc_efficiency".to_owned(), "lpt_flow".to_owned()],
            component_sizes: Sizes { smallest: 5e-4, largest: 0.03, count: 6 },
            start_s: 10.0,
            rise_s: 10.0,
        }
    }
}

impl Sizes {
    /// The sizes, smallest first.
    ///
    /// ```
    /// use fd_lab::compare::Sizes;
    ///
    /// let sizes = Sizes { smallest: 0.01, largest: 1.0, count: 3 }.values();
    /// assert!((sizes[1] - 0.1).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn values(&self) -> Vec<f64> {
        let last = self.count.saturating_sub(1).max(1) as f64;
        let ratio = self.largest / self.smallest;
        (0..self.count).map(|i| self.smallest * ratio.powf(i as f64 / last)).collect()
    }

    /// What [`are_possible`](Self::are_possible) asks for.
    pub(super) const POSSIBLE: &str = "0 < smallest <= largest, both finite, and at least one size";

    pub(super) fn are_possible(&self) -> bool {
        let range = self.smallest > 0.0 && self.largest >= self.smallest;
        range && self.largest.is_finite() && self.count > 0
    }

    fn check(&self, setting: &str) -> Result<(), CompareError> {
        if self.are_possible() {
            return Ok(());
        }
        let (expected, found) = (Self::POSSIBLE, self.to_string());
        Err(CompareError::Setting { setting: setting.to_owned(), expected, found })
    }
}

impl fmt::Display for Sizes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}, {} sizes", self.smallest, self.largest, self.count)
    }
}

/// One place and one development of a fault, in all its sizes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FaultKind {
    /// Where.
    pub site: Site,
    /// How it develops.
    pub profile: ProfileKind,
    /// How large, smallest first.
    pub sizes: Vec<f64>,
    /// Unit of the sizes; none for shares of the reading or the parameter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// What it is called, unless after its site and profile.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub called: Option<String>,
}

impl FaultKind {
    /// In words.
    #[must_use]
    pub fn name(&self) -> String {
        let plain = || format!("{} {}", self.site.target(), self.profile.name());
        self.called.clone().unwrap_or_else(plain)
    }

    /// Its name with the unit of its sizes.
    pub(super) fn heading(&self) -> String {
        format!("{} [{}]", self.name(), self.unit())
    }

    /// The unit of its sizes in reports.
    pub(super) fn unit(&self) -> &str {
        self.unit.as_deref().unwrap_or("%")
    }

    /// A size in that unit.
    pub(super) fn in_unit(&self, size: f64) -> f64 {
        if self.unit.is_some() { size } else { 100.0 * size }
    }

    /// A size in words, without its unit.
    pub(super) fn shown(&self, size: f64) -> String {
        figure(self.in_unit(size))
    }

    /// A size that can be compared with those of other kinds: a share of the reading, or of the largest size that is tried.
    pub(super) fn relative(&self, size: f64) -> f64 {
        if self.unit.is_some() { size / self.largest() } else { size }
    }

    /// The largest size that is tried.
    pub(super) fn largest(&self) -> f64 {
        self.sizes.last().copied().unwrap_or(f64::NAN)
    }

    /// What is said of the smallest size found when none of those tried is.
    pub(super) fn beyond(&self) -> String {
        format!("> {}", self.shown(self.largest()))
    }
}

impl FaultGrid {
    /// All kinds of faults, those of components only if there are any.
    pub(super) fn kinds(&self, with_components: bool) -> Vec<FaultKind> {
        let of_sensors = self.sensors.iter().flat_map(|sensor| {
            self.profiles.iter().map(|&profile| FaultKind {
                site: Site::sensor(sensor.as_str()),
                profile,
                sizes: self.sensor_sizes.values(),
                unit: None,
                called: None,
            })
        });
        let components = if with_components { self.components.as_slice() } else { &[] };
        let of_components = components.iter().map(|component| FaultKind {
            site: Site::component(component.as_str()),
            profile: ProfileKind::Incipient,
            sizes: self.component_sizes.values(),
            unit: None,
            called: None,
        });
        of_sensors.chain(of_components).collect()
    }

    /// The fault of one size in a run of `duration_s`.
    pub(super) fn spec(&self, kind: &FaultKind, signed_size: f64, duration_s: f64) -> FaultSpec {
        let start_s = self.start_s;
        let profile = match kind.profile {
            ProfileKind::Abrupt => FaultProfile::abrupt(signed_size),
            ProfileKind::Incipient => FaultProfile::incipient(signed_size, self.rise_s),
            ProfileKind::Drift => FaultProfile::drift(signed_size / (duration_s - start_s)),
        };
        FaultSpec::add(kind.site.clone(), start_s, profile)
    }

    pub(super) fn check(&self, duration_s: f64) -> Result<(), CompareError> {
        self.sensor_sizes.check("faults.sensor_sizes")?;
        self.component_sizes.check("faults.component_sizes")?;
        if !(0.0..duration_s).contains(&self.start_s) {
            return Err(CompareError::Setting {
                setting: "faults.start_s".to_owned(),
                expected: "within the run",
                found: format!("{} s in a run of {duration_s} s", self.start_s),
            });
        }
        Ok(())
    }
}
