//! What a file of columns holds, before it is known which of them are wanted.

use fd_model::Shown;

use crate::{
    error::LogError,
    header::{HeaderColumn, find},
    map::LogMap,
    table::LogTable,
};

/// Columns that were taken at the same instants.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Topic {
    /// What it is called; empty where a file has only one.
    pub name: String,
    /// Seconds since the recording began, where rows have a time that is no column.
    pub times: Option<Vec<f64>>,
    /// Names and units.
    pub columns: Vec<HeaderColumn>,
    /// One list per column, all of the same length; NaN where there is no value.
    pub values: Vec<Vec<f64>>,
}

/// A file that is read column by column: tables, or topics that have a clock each.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recording {
    /// Name of the file, for errors.
    pub file: String,
    /// What was taken together, in the order of the file.
    pub topics: Vec<Topic>,
    /// What the file holds besides, and why that is no column.
    pub unfit: Vec<(String, String)>,
    /// Time between rows in seconds, if the file states it.
    pub sample_time: Option<f64>,
}

impl Topic {
    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.times.as_ref().or(self.values.first()).map_or(0, Vec::len)
    }

    /// Median time between rows, in seconds; nothing without times.
    #[must_use]
    pub fn step(&self) -> Option<f64> {
        let times = self.times.as_ref()?;
        let mut steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied()
    }

    /// What messages say of it.
    fn shown(&self) -> String {
        let rows = self.rows();
        let step = self.step().map_or(String::new(), |step| format!(", {step:.6} s apart"));
        format!("{} ({rows} rows{step})", self.name)
    }

    /// Times in seconds, and the row of each, in the order of time.
    fn in_order(&self) -> Vec<(f64, usize)> {
        let times = self.times.iter().flatten().copied();
        let mut order: Vec<(f64, usize)> = times.zip(0..).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        order
    }
}

impl Recording {
    /// Adds columns that have no clock of their own: those with equally many rows are one table.
    #[allow(dead_code, reason = "each format that has such columns is a feature")]
    pub(crate) fn add_table(&mut self, table: Topic) {
        match self.topics.iter_mut().find(|known| known.rows() == table.rows()) {
            Some(known) => {
                known.columns.extend(table.columns);
                known.values.extend(table.values);
            }
            None => self.topics.push(table),
        }
    }

    /// The recording, if it holds a column at all.
    #[allow(dead_code, reason = "each format that is a recording is a feature")]
    pub(crate) fn with_columns(self, expected: &'static str) -> Result<Self, LogError> {
        /// Most of what is no column that is named.
        const MOST_NAMED: usize = 8;
        if !self.topics.is_empty() {
            return Ok(self);
        }
        let named = self.unfit.iter().take(MOST_NAMED);
        let named: Vec<String> =
            named.map(|(name, why)| format!("`{}` ({why})", Shown(name))).collect();
        let more = self.unfit.len() - named.len();
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        let found = if named.is_empty() {
            "found nothing".to_owned()
        } else {
            format!("found only {}{more}", named.join(", "))
        };
        Err(LogError::NoLog { file: self.file, expected, found })
    }

    /// The columns that a map asks for, on one time base.
    ///
    /// When all of them come from one topic, its own clock is the time base. When they come from several, the map
    /// must name the topic whose clock counts, and how old a value of another topic may be (`[merge]`): each
    /// instant of that clock gets the last value that was there, and none where that is too old.
    ///
    /// # Errors
    ///
    /// Returns an error when a column is not there or is no column of numbers, when tables of different length
    /// are asked for together, or topics with clocks of their own without saying how.
    pub fn into_table(self, map: &LogMap) -> Result<LogTable, LogError> {
        let wanted = self.wanted(map)?;
        let mut of: Vec<usize> = wanted.iter().map(|place| place.0).collect();
        of.sort_unstable();
        of.dedup();
        let clock = match of[..] {
            [] => 0,
            [only] if map.merge.clock.is_none() => only,
            _ => self.clock(map, &wanted, &of)?,
        };
        let sample_time = self.sample_time;
        let mut held: Vec<(HeaderColumn, Vec<f64>)> = Vec::new();
        for &(topic, column) in wanted.iter().filter(|place| place.0 != clock) {
            let header = self.topics[topic].columns[column].clone();
            if !held.iter().any(|(known, _)| *known == header) {
                held.push((header, self.held(clock, topic, column, map)?));
            }
        }
        let mut topics = self.topics;
        if topics.is_empty() {
            return Err(LogError::Empty { file: self.file });
        }
        let Topic { times, columns, values, .. } = topics.swap_remove(clock);
        let time = times.map(|times| (HeaderColumn::parse("time [s]"), times));
        let columns = time.into_iter().chain(columns.into_iter().zip(values)).chain(held);
        LogTable::of_columns(self.file, columns.collect(), sample_time)
    }

    /// Topic and column of everything that a map names.
    fn wanted(&self, map: &LogMap) -> Result<Vec<(usize, usize)>, LogError> {
        let columns = |topic: usize| (0..self.topics[topic].columns.len()).map(move |c| (topic, c));
        let places: Vec<_> = (0..self.topics.len()).flat_map(columns).collect();
        let mut header: Vec<_> =
            places.iter().map(|&(t, c)| self.topics[t].columns[c].clone()).collect();
        // A clock has no place among the columns.
        if self.topics.iter().any(|topic| topic.times.is_some()) {
            header.push(HeaderColumn::parse("time [s]"));
        }
        let found = map.wanted(&self.file).into_iter().map(|name| {
            let unfit = self.unfit.iter().find(|(known, _)| *known == name);
            match (find(&self.file, &header, &name), unfit) {
                (Err(LogError::MissingColumn { .. }), Some((column, reason))) => {
                    let (file, column) = (self.file.clone(), column.clone());
                    Err(LogError::Unfit { file, column, reason: reason.clone() })
                }
                (index, _) => index,
            }
        });
        let found: Result<Vec<usize>, LogError> = found.collect();
        Ok(found?.into_iter().filter_map(|index| places.get(index).copied()).collect())
    }

    /// The topic whose clock counts.
    fn clock(
        &self,
        map: &LogMap,
        wanted: &[(usize, usize)],
        of: &[usize],
    ) -> Result<usize, LogError> {
        let file = self.file.clone();
        if let Some(&(topic, column)) = wanted.iter().find(|w| self.topics[w.0].times.is_none()) {
            // Tables of different length have nothing that could be merged by.
            let first = wanted.first().map_or(0, |place| self.topics[place.0].rows());
            let other = wanted.iter().find(|place| self.topics[place.0].rows() != first);
            let (topic, column) = other.copied().unwrap_or((topic, column));
            let found = self.topics[topic].rows();
            let column = self.topics[topic].columns[column].text.clone();
            return Err(LogError::Ragged { file, column, expected: first, found });
        }
        let known = || self.topics.iter().map(|topic| topic.name.clone()).collect();
        match (&map.merge.clock, map.merge.max_age_s) {
            (Some(name), Some(_)) => self
                .topics
                .iter()
                .position(|topic| topic.name == *name)
                .ok_or_else(|| LogError::NoClock { file, clock: name.clone(), known: known() }),
            (Some(name), None) if of == [self.position(name).unwrap_or(usize::MAX)] => Ok(of[0]),
            _ => {
                let clocks = of.iter().map(|&topic| self.topics[topic].shown()).collect();
                Err(LogError::SeveralClocks { file, clocks })
            }
        }
    }

    fn position(&self, name: &str) -> Option<usize> {
        self.topics.iter().position(|topic| topic.name == name)
    }

    /// A column of one topic at the instants of another: the last value, if it is not too old.
    fn held(
        &self,
        clock: usize,
        topic: usize,
        column: usize,
        map: &LogMap,
    ) -> Result<Vec<f64>, LogError> {
        let most = map.merge.max_age_s.unwrap_or(0.0);
        if !(most >= 0.0 && most.is_finite()) {
            return Err(LogError::Age { file: self.file.clone(), found: most });
        }
        let (source, values) = (self.topics[topic].in_order(), &self.topics[topic].values[column]);
        let mut merged = vec![f64::NAN; self.topics[clock].rows()];
        let mut next = 0;
        for (now, row) in self.topics[clock].in_order() {
            while source.get(next).is_some_and(|(time, _)| *time <= now) {
                next += 1;
            }
            let last = next.checked_sub(1).map(|last| source[last]);
            if let Some((_, last)) = last.filter(|(time, _)| now - time <= most) {
                merged[row] = values[last];
            }
        }
        Ok(merged)
    }
}
