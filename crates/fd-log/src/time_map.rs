//! Where the time of a log comes from.

use fd_model::SampleTime;
use serde::{Deserialize, Serialize};

/// Where the time of a log comes from.
///
/// | `column` | `sample_time` | Time base |
/// |----------|---------------|-----------|
/// | given | | that column, resampled if it is not even |
/// | given | given | that column, resampled to that sample time |
/// | | given | rows are samples, the first at 0 s |
/// | | | a column called `time`, `t`, `time_s` or `timestamp`; else the one that holds dates |
///
/// A capital `T` is a temperature, unless its header gives a unit of time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TimeMap {
    /// Column of time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Unit of that column; without it, the unit in the header, and without that, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Time between samples, in seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample_time: Option<f64>,
    /// Whether dates such as `03/04/2026` have the day or the month first, where the file does not show it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date_order: Option<DateOrder>,
}

/// What stands first in dates with strokes.
///
/// ```
/// use fd_log::{DateOrder, TimeMap};
///
/// let time: TimeMap = toml::from_str("date_order = 'month-first'")?;
/// assert_eq!(time.date_order, Some(DateOrder::MonthFirst));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum DateOrder {
    /// `31/12/2026`.
    DayFirst,
    /// `12/31/2026`.
    MonthFirst,
}

impl TimeMap {
    /// A column of time in seconds, or in the unit that its header gives.
    ///
    /// ```
    /// # use fd_log::TimeMap;
    /// assert_eq!(TimeMap::in_column("time_s").unit, None);
    /// ```
    #[must_use]
    pub fn in_column(column: impl Into<String>) -> Self {
        Self { column: Some(column.into()), ..Self::default() }
    }

    /// Rows that are samples.
    ///
    /// ```
    /// # use fd_log::TimeMap;
    /// # use fd_model::SampleTime;
    /// assert_eq!(TimeMap::every(SampleTime::new(0.1)?).sample_time, Some(0.1));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    #[must_use]
    pub fn every(ts: SampleTime) -> Self {
        Self { sample_time: Some(ts.seconds()), ..Self::default() }
    }
}
