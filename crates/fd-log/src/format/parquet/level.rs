//! From definition and repetition levels (Melnik et al. 2010, Dremel) to rows.

/// Most columns that lists may become.
pub(super) const MOST_COLUMNS: usize = 4096;

/// One column of a file as it grows: a number per row, or a list of numbers per row.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Leaf {
    /// Level at which there is a value.
    defined: i16,
    is_list: bool,
    rows: usize,
    /// One list per place in the lists of the rows.
    columns: Vec<Vec<f64>>,
}

impl Leaf {
    pub(super) fn new(defined: i16, is_list: bool) -> Self {
        Self { defined, is_list, ..Self::default() }
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    /// How long the longest list is.
    pub(super) fn width(&self) -> usize {
        self.columns.len()
    }

    /// Values that have to be filled in until every list is as long as the longest.
    pub(super) fn missing(&self) -> u64 {
        self.columns.iter().map(|column| self.rows.saturating_sub(column.len()) as u64).sum()
    }

    /// Takes what was decoded, and returns how many values were filled in besides: levels are left out where
    /// a column needs none of them. A list that is far too long is only measured.
    pub(super) fn add(
        &mut self,
        levels: usize,
        def: &[i16],
        rep: &[i16],
        values: &mut dyn Iterator<Item = f64>,
    ) -> u64 {
        let (mut place, mut filled) = (0, 0);
        for level in 0..levels {
            place = if rep.get(level).is_none_or(|rep| *rep == 0) {
                self.rows += 1;
                0
            } else {
                place + 1
            };
            if def.get(level).is_none_or(|def| *def == self.defined) {
                let Some(value) = values.next() else { break };
                if self.columns.len() <= place {
                    self.columns.resize_with(place + 1, Vec::new);
                }
                let Some(row) = self.rows.checked_sub(1) else { continue };
                if self.columns.len() > MOST_COLUMNS {
                    break;
                }
                // What was not there until now has no value.
                filled += row.saturating_sub(self.columns[place].len()) as u64;
                self.columns[place].resize(row, f64::NAN);
                self.columns[place].push(value);
            }
        }
        filled
    }

    /// The columns under the name of a column, or with an index behind it.
    pub(super) fn into_columns(self, name: &str) -> impl Iterator<Item = (String, Vec<f64>)> {
        let Self { is_list, rows, mut columns, .. } = self;
        if columns.is_empty() && !is_list {
            columns.push(Vec::new());
        }
        columns.into_iter().enumerate().map(move |(place, mut values)| {
            values.resize(rows, f64::NAN);
            (if is_list { format!("{name}[{place}]") } else { name.to_owned() }, values)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_what_is_missing_keep_their_rows() {
        let mut leaf = Leaf::new(3, true);
        // [1, 2], null, [], [null, 5]
        let (def, rep) = ([3, 3, 0, 1, 2, 3], [0, 1, 0, 0, 0, 1]);
        leaf.add(6, &def, &rep, &mut [1.0, 2.0, 5.0].into_iter());
        let columns: Vec<_> = leaf.into_columns("q").collect();
        assert_eq!((columns.len(), columns[1].0.as_str()), (2, "q[1]"));
        let shown = format!("{:?} {:?}", columns[0].1, columns[1].1);
        assert_eq!(shown, "[1.0, NaN, NaN, NaN] [2.0, NaN, NaN, 5.0]");
    }

    #[test]
    fn plain_numbers_need_no_levels() {
        let mut leaf = Leaf::new(0, false);
        leaf.add(2, &[], &[], &mut [4.0, 5.0].into_iter());
        assert_eq!(leaf.into_columns("q").next(), Some(("q".to_owned(), vec![4.0, 5.0])));
    }
}
