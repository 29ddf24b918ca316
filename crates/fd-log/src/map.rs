//! Which columns of a log are time, inputs and outputs.

use std::{fmt, path::Path};

use fd_model::{
    Channel, ResamplePolicy, Shown,
    file::{LinearModel, SettingsError, read_settings},
};
use serde::{Deserialize, Serialize};

use crate::{expression::names, time_map::TimeMap};

/// The way from the columns of a log to the channels of a record.
///
/// ```
/// use fd_log::LogMap;
///
/// let map: LogMap = toml::from_str(
///     r#"
///     time = { column = "time_s" }
///
///     [[inputs]]
///     name = "voltage"
///     column = "input_voltage_V"
///     unit = "V"
///
///     [[outputs]]
///     name = "power"
///     column = "electric_power_W"
///     column_unit = "W"
///     unit = "kW"
///     "#,
/// )?;
/// assert_eq!(map.outputs[0].column.as_deref(), Some("electric_power_W"));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LogMap {
    /// Where time comes from.
    pub time: TimeMap,
    /// Input channels, in order.
    pub inputs: Vec<ColumnMap>,
    /// Output channels, in order; at least one.
    pub outputs: Vec<ColumnMap>,
    /// Columns and constants under names of their own, for expressions.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<ColumnMap>,
    /// Separator of columns; without it, the most frequent of `,`, `;` and tab in the header.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<char>,
    /// Whether numbers are written `1,5` instead of `1.5`.
    pub decimal_comma: bool,
    /// Which rows are samples of this log: those that every rule lets through; all if there is none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<RowRule>,
    /// Which rows of single files are samples, besides what holds for all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub logs: Vec<FileRows>,
    /// How columns that have clocks of their own are brought together.
    #[serde(skip_serializing_if = "MergeMap::is_default")]
    pub merge: MergeMap,
    /// How the samples are put on an even time base.
    pub resample: ResamplePolicy,
}

/// Rules about the rows of one file.
///
/// ```
/// use fd_log::LogMap;
///
/// let map: LogMap = toml::from_str(
///     r#"
///     outputs = [{ name = "y" }]
///     logs = [{ file = "monday.csv", rows = [{ column = "t", from = 5 }] }]
///     "#,
/// )?;
/// assert_eq!(map.logs[0].rows[0].from, Some(5.0));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileRows {
    /// The file: its name, or the end of its path.
    pub file: String,
    /// What its rows must fit.
    pub rows: Vec<RowRule>,
}

/// How columns of several topics, each with a clock of its own, become one table: every instant of one clock
/// gets the last value of the other topics, if it is not too old.
///
/// ```
/// let map: fd_log::LogMap = toml::from_str(
///     r#"
///     outputs = [{ name = "q", column = "/joint_states.position[arm]", unit = "rad" }]
///     merge = { clock = "/joint_states", max_age_s = 0.05 }
///     "#,
/// )?;
/// assert_eq!(map.merge.max_age_s, Some(0.05));
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MergeMap {
    /// The topic whose clock counts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock: Option<String>,
    /// How old a value of another topic may be, in seconds; beyond that it is missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_age_s: Option<f64>,
}

impl MergeMap {
    fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// Which rows belong to the log, by the number in one of their columns, or one that is computed from them: a run out of
/// a file of many, a stretch of time, all that is fast. Everything that is given must hold; a row whose number is missing
/// is out.
///
/// ```
/// use fd_log::{LogMap, RowRule, read_log_from};
///
/// let csv = "run,t,y\n0,0,5\n0,1,6\n1,0,7\n1,1,8\n";
/// let mut map: LogMap = toml::from_str("outputs = [{ name = 'y' }]")?;
/// map.rows = vec![RowRule::equal("run", 1.0)];
/// assert_eq!(read_log_from("runs.csv", csv.as_bytes(), &map)?.record.y(0), [7.0]);
/// map.rows = vec![RowRule { from: Some(7.5), ..RowRule::computed("y + 0.5*run") }];
/// assert_eq!(read_log_from("runs.csv", csv.as_bytes(), &map)?.record.y(0), [7.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RowRule {
    /// Header of the column, with or without its unit; numbers are compared as they are in the file. Empty where the
    /// number is computed.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub column: String,
    /// How the number is computed, as [`ColumnMap::expression`]; without a column of time, `t` counts all rows of the
    /// file, and so does the time of those that are let through.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expression: Option<String>,
    /// The number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub equals: Option<f64>,
    /// The least number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// A number that is too large.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// The way from a column to a channel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ColumnMap {
    /// Name of the channel in the record.
    pub name: String,
    /// Unit of the channel in the record; without it, the unit of the column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Header of the column, with or without its unit; without it, `name`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Unit of the column where the header gives none; without it, `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column_unit: Option<String>,
    /// The number that the channel always has, in `column_unit`, else in `unit`; no column is looked for then.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constant: Option<f64>,
    /// How the channel is computed from columns, in the language of model files; in `column_unit`, else in `unit`.
    /// Names are those of [`LogMap::columns`], else columns in the units of the file; `t` is the time of the row in
    /// seconds.
    ///
    /// ```
    /// use fd_log::{LogMap, read_log_from};
    ///
    /// let map: LogMap = toml::from_str(
    ///     r#"
    ///     outputs = [{ name = "torque", unit = "N m", expression = "0.12*(current - 0.5)" }]
    ///     columns = [{ name = "current", column = "motor.i", unit = "A" }]
    ///     "#,
    /// )?;
    /// let csv = "t,motor.i [mA]\n0,1500\n1,500\n";
    /// let log = read_log_from("monday.csv", csv.as_bytes(), &map)?;
    /// assert_eq!((log.record.y(0)[0], log.record.y(1)[0]), (0.12, 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expression: Option<String>,
    /// Whether the channel is an angle that begins anew after a turn: it is read as one that goes on, so that between two samples
    /// on either side of the jump there is no half turn.
    ///
    /// ```
    /// use fd_log::{LogMap, read_log_from};
    ///
    /// let map: LogMap = toml::from_str("outputs = [{ name = 'heading', wraps = true }]")?;
    /// let csv = "t,heading [deg]\n0,170\n1,\n2,-170\n3,-150\n";
    /// let log = read_log_from("turn.csv", csv.as_bytes(), &map)?;
    /// assert_eq!([0, 2, 3].map(|k| log.record.y(k)[0]), [170.0, 190.0, 210.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub wraps: bool,
}

impl LogMap {
    /// Reads a map from a TOML file.
    ///
    /// # Errors
    ///
    /// As [`read_settings`].
    pub fn read(file: &Path) -> Result<Self, SettingsError> {
        read_settings(file)
    }

    /// Columns that are called as the channels, converted to the units of the channels.
    ///
    /// ```
    /// # use fd_log::LogMap;
    /// # use fd_model::Channel;
    /// let map = LogMap::for_channels(&[Channel::new("wf", "kg/s")], &[Channel::new("N", "rpm")]);
    /// assert_eq!(map.inputs[0].name, "wf");
    /// ```
    #[must_use]
    pub fn for_channels(inputs: &[Channel], outputs: &[Channel]) -> Self {
        let map = |channels: &[Channel]| channels.iter().map(ColumnMap::from).collect();
        Self { inputs: map(inputs), outputs: map(outputs), ..Self::default() }
    }

    /// Columns that are called as the channels of a model, converted to its units.
    ///
    /// ```
    /// # use fd_log::LogMap;
    /// # use fd_model::file::LinearModel;
    /// # let text = r#"
    /// # version = 1
    /// # kind = "state-space"
    /// # inputs = [{ name = "u", unit = "V" }]
    /// # outputs = [{ name = "y", unit = "W" }]
    /// # matrices = { A = [[-1.0]], B = [[1.0]], C = [[1.0]], D = [[0.0]] }
    /// # "#;
    /// let model = LinearModel::parse("model.toml", text)?;
    /// let map = LogMap::for_model(&model);
    /// assert_eq!(map.outputs[0].unit.as_deref(), Some("W"));
    /// # Ok::<(), fd_model::file::ModelFileError>(())
    /// ```
    #[must_use]
    pub fn for_model(model: &LinearModel) -> Self {
        Self::for_channels(&model.input_channels(), &model.output_channels())
    }
}

impl LogMap {
    /// Rules about the rows of a file: those of all files, and those of its own.
    pub(super) fn rules<'a>(&'a self, file: &'a str) -> impl Iterator<Item = &'a RowRule> {
        let own = self.logs.iter().filter(move |log| Path::new(file).ends_with(&log.file));
        self.rows.iter().chain(own.flat_map(|log| &log.rows))
    }

    /// Headers of all columns that are looked at; time only if it is named.
    pub(super) fn wanted(&self, file: &str) -> Vec<String> {
        let column = |map: &ColumnMap| -> Option<String> {
            map.constant.is_none().then(|| map.column.as_ref().unwrap_or(&map.name).clone())
        };
        let mut wanted = Vec::new();
        let mut expressions = Vec::new();
        for channel in self.inputs.iter().chain(&self.outputs) {
            match &channel.expression {
                Some(text) => expressions.push(text),
                None => wanted.extend(column(channel)),
            }
        }
        for rule in self.rules(file) {
            match &rule.expression {
                Some(text) => expressions.push(text),
                None => wanted.push(rule.column.clone()),
            }
        }
        for name in expressions.into_iter().flat_map(|text| names(text)) {
            match self.columns.iter().find(|column| column.name == name) {
                Some(named) => wanted.extend(column(named)),
                None => wanted.push(name),
            }
        }
        wanted.extend(self.time.column.clone());
        wanted
    }
}

impl RowRule {
    /// Rows with this number in a column.
    #[must_use]
    pub fn equal(column: impl Into<String>, number: f64) -> Self {
        Self { column: column.into(), equals: Some(number), ..Self::default() }
    }

    /// Rows by a number that is computed; which numbers is then to be said.
    ///
    /// ```
    /// # use fd_log::RowRule;
    /// let fast = RowRule { from: Some(0.2), ..RowRule::computed("sqrt(vx^2 + vy^2)") };
    /// assert_eq!(fast.column, "");
    /// ```
    #[must_use]
    pub fn computed(expression: impl Into<String>) -> Self {
        Self { expression: Some(expression.into()), ..Self::default() }
    }

    /// Whether a row with this number belongs to the log.
    pub(super) fn admits(&self, number: f64) -> bool {
        // NaN is neither equal, nor at least, nor below.
        self.equals.is_none_or(|wanted| (wanted..=wanted).contains(&number))
            && self.from.is_none_or(|least| least <= number)
            && self.until.is_none_or(|end| number < end)
            && !number.is_nan()
    }
}

/// As a condition: `run = 3`, `2 <= time_s < 5`.
impl fmt::Display for RowRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = self.expression.as_ref().unwrap_or(&self.column);
        if let Some(from) = self.from {
            write!(f, "{from} <= ")?;
        }
        write!(f, "{}", Shown(what))?;
        if let Some(number) = self.equals {
            write!(f, " = {number}")?;
        }
        self.until.map_or(Ok(()), |until| write!(f, " < {until}"))
    }
}

impl ColumnMap {
    /// A channel from a column of another name, in the unit of the column.
    ///
    /// ```
    /// # use fd_log::ColumnMap;
    /// let power = ColumnMap::new("power", "electric_power_W").in_unit("W");
    /// assert_eq!(power.unit.as_deref(), Some("W"));
    /// ```
    #[must_use]
    pub fn new(name: impl Into<String>, column: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            unit: None,
            column: Some(column.into()),
            column_unit: None,
            constant: None,
            expression: None,
            wraps: false,
        }
    }

    /// Sets the unit of the channel.
    #[must_use]
    pub fn in_unit(mut self, unit: impl Into<String>) -> Self {
        self.unit = Some(unit.into());
        self
    }
}

impl From<&Channel> for ColumnMap {
    fn from(channel: &Channel) -> Self {
        Self {
            name: channel.name.clone(),
            unit: Some(channel.unit.clone()),
            column: None,
            column_unit: None,
            constant: None,
            expression: None,
            wraps: channel.wraps,
        }
    }
}
