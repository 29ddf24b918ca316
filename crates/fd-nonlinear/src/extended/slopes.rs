//! Slopes along the columns of a factor, by central differences.

/// Relative size of a step: near the cube root of the rounding unit, where rounding and curvature take
/// equal parts of the error of a central difference.
pub(super) const STEP: f64 = 6e-6;

/// How far to go along column `column` of the factor `s` at the state `x`: as far as moves the state that is
/// moved most by [`STEP`] of its size, or of its spread where that is larger. `None` for a column of zeros.
pub(super) fn step_along(x: &[f64], s: &[f64], column: usize) -> Option<f64> {
    let rows = || x.iter().zip(s.chunks_exact(x.len()));
    let moved = |(x, row): (&f64, &[f64])| {
        let spread = fd_numeric::dot(row, row).sqrt();
        let size = x.abs().max(spread);
        if size > 0.0 { row[column].abs() / size } else { 0.0 }
    };
    let largest = rows().map(moved).fold(0.0, f64::max);
    (0.0 < largest && largest.is_finite()).then(|| STEP / largest)
}

/// `x + step s_column`.
pub(super) fn moved(x: &[f64], s: &[f64], column: usize, step: f64, to: &mut [f64]) {
    for ((to, x), row) in to.iter_mut().zip(x).zip(s.chunks_exact(x.len())) {
        *to = x + step * row[column];
    }
}

/// Entry `i` of the slope between both ends; zero where there was no step.
pub(super) fn slope(ends: &[Vec<f64>; 2], i: usize, step: Option<f64>) -> f64 {
    step.map_or(0.0, |step| (ends[0][i] - ends[1][i]) / (2.0 * step))
}
