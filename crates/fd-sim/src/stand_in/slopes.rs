//! A simulator linearised along replays, as numbers.

/// What each step of the replays starts from, gives, and how that changes.
#[derive(Clone, Debug)]
pub(super) struct Slopes {
    /// Numbers of states, inputs, forces and parameters: what is moved, in this order.
    pub widths: [usize; 4],
    /// Number of outputs.
    pub ny: usize,
    /// Nominal parameters.
    pub theta: Vec<f64>,
    /// Inputs, row by row.
    pub u: Vec<f64>,
    /// Forces, row by row.
    pub f: Vec<f64>,
    /// States before each step, row by row.
    pub x: Vec<f64>,
    /// Outputs and then the states after each step, row by row.
    pub result: Vec<f64>,
    /// Slopes of the results, row by row and in a row column by column.
    pub columns: Vec<f64>,
}

impl Slopes {
    /// Numbers that a step gives.
    pub(super) fn results(&self) -> usize {
        self.ny + self.widths[0]
    }

    /// Steps of all replays.
    pub(super) fn rows(&self) -> usize {
        self.result.len() / self.results()
    }

    /// The slopes of a row, column by column.
    pub(super) fn of_row(&self, row: usize) -> &[f64] {
        let size = self.results() * self.widths.iter().sum::<usize>();
        &self.columns[row * size..(row + 1) * size]
    }
}
