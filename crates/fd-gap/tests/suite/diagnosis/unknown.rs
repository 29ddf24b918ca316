//! What nobody has written down, as a covariance of residuals.

use faer::{Mat, Side, linalg::solvers::Solve};
use fd_gap::fit::Unknown;
use proptest::prelude::*;

/// Two outputs, two segments of these lengths, and columns that respond within one of them.
const LENGTHS: [usize; 2] = [6, 4];
const ROWS: usize = 20;

fn columns() -> impl Strategy<Value = Vec<Vec<f64>>> {
    let column = (prop::collection::vec(-3.0..3.0_f64, ROWS), any::<bool>());
    let within = |(mut column, is_first): (Vec<f64>, bool)| {
        let silent = if is_first { 12..ROWS } else { 0..12 };
        column[silent].fill(0.0);
        column
    };
    prop::collection::vec(column.prop_map(within), 1..8)
}

fn covariance(noise: [f64; 2], columns: &[Vec<f64>]) -> Mat<f64> {
    // Output by output within each segment.
    let scale = |i: usize| noise[if i < 12 { i / LENGTHS[0] } else { (i - 12) / LENGTHS[1] }];
    Mat::from_fn(ROWS, ROWS, |i, j| {
        let own = f64::from(u8::from(i == j));
        let unknown: f64 = columns.iter().map(|w| w[i] * w[j]).sum();
        scale(i) * scale(j) * (own + unknown)
    })
}

proptest! {
    /// `|C^−½ r|² = rᵀ C⁻¹ r`, the determinant is that of `C`, and restoring undoes whitening. Directions that are left out
    /// for being a thousandth of the noise move a square by as much.
    #[test]
    fn it_is_the_covariance_that_it_says(
        columns in columns(),
        noise in prop::array::uniform2(0.5..4.0_f64),
        r in prop::collection::vec(-5.0..5.0_f64, ROWS),
    ) {
        let segments = [0..12, 12..ROWS];
        let unknown = Unknown::new(noise.to_vec(), &columns, &segments).unwrap();
        let c = covariance(noise, &columns).llt(Side::Lower).unwrap();
        let mut white = r.clone();
        unknown.whiten(0, &mut white[..12]);
        unknown.whiten(1, &mut white[12..]);
        let squares: f64 = white.iter().map(|w| w * w).sum();
        let solution = c.solve(&Mat::from_fn(ROWS, 1, |i, _| r[i]));
        let expected: f64 = (0..ROWS).map(|i| r[i] * solution[(i, 0)]).sum();
        prop_assert!((squares - expected).abs() <= 2e-3 * expected + 1e-9, "{squares} {expected}");
        let determinant = unknown.log_determinant(&[10.0, 10.0]);
        let expected: f64 = (0..ROWS).map(|i| 2.0 * c.L()[(i, i)].ln()).sum();
        prop_assert!((determinant - expected).abs() < 1e-3 * 8.0 + 1e-9, "{determinant} {expected}");
        unknown.restore(0, &mut white[..12]);
        unknown.restore(1, &mut white[12..]);
        for (a, b) in white.iter().zip(&r) {
            prop_assert!((a - b).abs() < 1e-10, "{a} {b}");
        }
    }

    /// The more is unknown, the less a residual counts.
    #[test]
    fn more_unknown_costs_less(
        columns in columns(),
        more in 1.0..10.0_f64,
        r in prop::collection::vec(-5.0..5.0_f64, ROWS),
    ) {
        let segments = [0..12, 12..ROWS];
        let squares = |columns: &[Vec<f64>]| {
            let unknown = Unknown::new(vec![1.0, 1.0], columns, &segments).unwrap();
            let mut r = r.clone();
            unknown.whiten(0, &mut r[..12]);
            unknown.whiten(1, &mut r[12..]);
            r.iter().map(|r| r * r).sum::<f64>()
        };
        let scaled: Vec<Vec<f64>> =
            columns.iter().map(|c| c.iter().map(|w| w * more).collect()).collect();
        // Directions that are left out count for a thousandth of their square.
        prop_assert!(squares(&scaled) <= squares(&columns) * (1.0 + 1e-3));
    }
}
