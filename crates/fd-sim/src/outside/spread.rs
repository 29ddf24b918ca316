//! By how much equal runs of a simulator differ.

/// By how much equal runs of a simulator differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Spread {
    /// Standard deviation of each output among equal runs, in its unit.
    pub deviation: Vec<f64>,
    /// The largest of them in parts of the largest value of its output.
    pub relative: f64,
    /// Runs that it was measured with.
    pub runs: usize,
}

impl Spread {
    /// The spread among equal runs of `ny` outputs each, row by row; `None` where they are the same to the bit, or one
    /// of them is not finite. The variance of `n` runs is taken with `n − 1` degrees of freedom.
    ///
    /// ```
    /// use fd_sim::outside::Spread;
    ///
    /// let spread = Spread::among(&[vec![1.0, 10.0], vec![3.0, 10.0]], 2).ok_or("they differ")?;
    /// assert_eq!(spread.deviation, [2.0_f64.sqrt(), 0.0]);
    /// assert!(Spread::among(&[vec![1.0], vec![1.0]], 1).is_none());
    /// # Ok::<(), &'static str>(())
    /// ```
    #[must_use]
    pub fn among(runs: &[Vec<f64>], ny: usize) -> Option<Self> {
        let (first, n) = (runs.first()?, runs.len() as f64);
        let bits = |run: &[f64]| run.iter().map(|y| y.to_bits()).collect::<Vec<_>>();
        if runs.iter().all(|run| bits(run) == bits(first))
            || runs.iter().flatten().any(|y| !y.is_finite())
            || ny == 0
        {
            return None;
        }
        let (mut squares, mut sizes) = (vec![0.0; ny], vec![0.0_f64; ny]);
        for (i, y) in first.iter().enumerate() {
            let all = || runs.iter().filter_map(|run| run.get(i)).copied();
            // About the first run: a mean of large numbers would lose the difference to rounding.
            let mean = all().map(|other| other - y).sum::<f64>() / n;
            squares[i % ny] +=
                all().map(|other| (other - y - mean).powi(2)).sum::<f64>() / (n - 1.0);
            sizes[i % ny] = all().fold(sizes[i % ny], |size, other| size.max(other.abs()));
        }
        let samples = (first.len() / ny).max(1) as f64;
        let deviation: Vec<f64> = squares.iter().map(|sum| (sum / samples).sqrt()).collect();
        let parts = deviation.iter().zip(&sizes).filter(|(_, size)| 0.0 < **size);
        let relative = parts.map(|(deviation, size)| deviation / size).fold(0.0, f64::max);
        Some(Self { deviation, relative, runs: runs.len() })
    }
}
