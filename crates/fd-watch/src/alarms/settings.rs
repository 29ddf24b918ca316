//! How alarms are raised, held and repeated.

use std::path::Path;

use fdiag::model::file::{self, read_settings};
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Settings of the alarm system, all times in s of the samples. The names are those of ANSI/ISA-18.2-2016.
///
/// ```
/// use fd_watch::AlarmSettings;
///
/// let settings = AlarmSettings::parse("off_delay_s = 30.0\nshelved = [{ unit = \"p1\", from_s = 0.0, until_s = 60.0 }]")?;
/// assert_eq!((settings.off_delay_s, settings.on_delay_s), (30.0, 0.0));
/// assert!(AlarmSettings::parse("deadband = 2.0").is_err());
/// # Ok::<(), fd_watch::SettingsError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct AlarmSettings {
    /// A fault must last for so long before its alarm is raised; default 0, since the rule of the spec has debounced it.
    pub on_delay_s: f64,
    /// A unit must be normal for so long before its alarm is over; default 60.
    pub off_delay_s: f64,
    /// While an alarm stands, a unit is normal only when its statistic is below `(1 − deadband)` of the threshold;
    /// default 0.05.
    pub deadband: f64,
    /// A fault that comes back within so long after its alarm was over is the same alarm, which returns; each time it
    /// does, the off-delay doubles, up to this. Default 600.
    pub hold_s: f64,
    /// An alarm that stands is told again after so long; default 28 800, a shift. 0: never.
    pub renotify_s: f64,
    /// Least time between updates that name another cause; it doubles with each of them. Default 60.
    pub update_s: f64,
    /// Ratios of statistic to threshold from which on an alarm is of severity 2, 3 and so on; it rises while an alarm
    /// stands, and does not fall. Default 3 and 10.
    pub severities: Vec<f64>,
    /// Units whose alarms are put aside for a while.
    pub shelved: Vec<Shelf>,
    /// Alarms of one cause within `flood_s` from which on they are told as a flood; default 10, as in 18.2.
    pub flood_alarms: usize,
    /// See `flood_alarms`; default 600.
    pub flood_s: f64,
}

/// Alarms of a unit that nobody wants to hear for a while, as during maintenance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shelf {
    /// The unit.
    pub unit: String,
    /// Since when, in s.
    pub from_s: f64,
    /// Until when, in s; an alarm that stands then is raised.
    pub until_s: f64,
}

/// Settings that cannot be.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// They cannot be read.
    #[error("{0}")]
    Toml(#[from] Box<toml::de::Error>),
    /// A number is out of its range.
    #[error("{setting}: expected {expected}, found {found}")]
    Range {
        /// Which.
        setting: &'static str,
        /// The range in words.
        expected: &'static str,
        /// The number.
        found: f64,
    },
}

impl Default for AlarmSettings {
    fn default() -> Self {
        Self {
            on_delay_s: 0.0,
            off_delay_s: 60.0,
            deadband: 0.05,
            hold_s: 600.0,
            renotify_s: 28_800.0,
            update_s: 60.0,
            severities: vec![3.0, 10.0],
            shelved: Vec::new(),
            flood_alarms: 10,
            flood_s: 600.0,
        }
    }
}

impl AlarmSettings {
    /// Every decision of the diagnosis as it is made: nothing is delayed, held or repeated.
    ///
    /// ```
    /// assert_eq!(fd_watch::AlarmSettings::immediate().off_delay_s, 0.0);
    /// ```
    #[must_use]
    pub fn immediate() -> Self {
        let (off_delay_s, deadband, hold_s, renotify_s, update_s) = (0.0, 0.0, 0.0, 0.0, 0.0);
        Self { off_delay_s, deadband, hold_s, renotify_s, update_s, ..Self::default() }
    }

    /// Reads them from a TOML file; [`check`](Self::check) is left to the monitor.
    ///
    /// # Errors
    ///
    /// As [`read_settings`].
    pub fn read(file: &Path) -> Result<Self, file::SettingsError> {
        read_settings(file)
    }

    /// Reads them from TOML.
    ///
    /// # Errors
    ///
    /// Returns what cannot be read, or the first number out of its range.
    pub fn parse(text: &str) -> Result<Self, SettingsError> {
        let settings: Self = toml::from_str(text).map_err(Box::new)?;
        settings.check()?;
        Ok(settings)
    }

    /// Checks the numbers.
    ///
    /// # Errors
    ///
    /// Returns the first that is out of its range.
    pub fn check(&self) -> Result<(), SettingsError> {
        let refuse =
            |setting, expected, found| Err(SettingsError::Range { setting, expected, found });
        let times = [
            ("on_delay_s", self.on_delay_s),
            ("off_delay_s", self.off_delay_s),
            ("hold_s", self.hold_s),
            ("renotify_s", self.renotify_s),
            ("update_s", self.update_s),
            ("flood_s", self.flood_s),
        ];
        for (setting, found) in times {
            if !(found >= 0.0 && found.is_finite()) {
                return refuse(setting, "seconds, 0 or more", found);
            }
        }
        if !(0.0..1.0).contains(&self.deadband) {
            return refuse("deadband", "0 or more and below 1", self.deadband);
        }
        if self.flood_alarms == 0 {
            return refuse("flood_alarms", "at least 1", 0.0);
        }
        let mut above = 1.0;
        for &step in &self.severities {
            // A NaN fails the comparison.
            if !(step > above && step.is_finite()) {
                return refuse("severities", "numbers above 1, each above the one before", step);
            }
            above = step;
        }
        for Shelf { from_s, until_s, .. } in &self.shelved {
            if !(from_s < until_s && until_s.is_finite()) {
                return refuse("shelved.until_s", "a time after from_s", *until_s);
            }
        }
        Ok(())
    }

    /// The severity of a ratio of statistic to threshold, from 1.
    pub(crate) fn severity(&self, ratio: f64) -> u8 {
        let steps = self.severities.iter().filter(|step| **step <= ratio).count();
        u8::try_from(steps).unwrap_or(u8::MAX - 1) + 1
    }

    pub(crate) fn is_shelved(&self, unit: &str, time: f64) -> bool {
        let holds =
            |shelf: &Shelf| shelf.unit == unit && (shelf.from_s..shelf.until_s).contains(&time);
        self.shelved.iter().any(holds)
    }
}
