//! Batch least squares: certified values of NIST Longley (case I1), and data that tell too little.
#![allow(clippy::unwrap_used, reason = "a test may stop at the first surprise")]

use crate::common::noise;
use faer::Mat;
use fd_ident::{
    IdentError,
    least_squares::{Deficient, LeastSquares},
};

/// Longley (1967), NIST Statistical Reference Datasets: employment, then price deflator, gross
/// national product, unemployed, armed forces, population, year.
const LONGLEY: [[f64; 7]; 16] = [
    [60323.0, 83.0, 234_289.0, 2356.0, 1590.0, 107_608.0, 1947.0],
    [61122.0, 88.5, 259_426.0, 2325.0, 1456.0, 108_632.0, 1948.0],
    [60171.0, 88.2, 258_054.0, 3682.0, 1616.0, 109_773.0, 1949.0],
    [61187.0, 89.5, 284_599.0, 3351.0, 1650.0, 110_929.0, 1950.0],
    [63221.0, 96.2, 328_975.0, 2099.0, 3099.0, 112_075.0, 1951.0],
    [63639.0, 98.1, 346_999.0, 1932.0, 3594.0, 113_270.0, 1952.0],
    [64989.0, 99.0, 365_385.0, 1870.0, 3547.0, 115_094.0, 1953.0],
    [63761.0, 100.0, 363_112.0, 3578.0, 3350.0, 116_219.0, 1954.0],
    [66019.0, 101.2, 397_469.0, 2904.0, 3048.0, 117_388.0, 1955.0],
    [67857.0, 104.6, 419_180.0, 2822.0, 2857.0, 118_734.0, 1956.0],
    [68169.0, 108.4, 442_769.0, 2936.0, 2798.0, 120_445.0, 1957.0],
    [66513.0, 110.8, 444_546.0, 4681.0, 2637.0, 121_950.0, 1958.0],
    [68655.0, 112.6, 482_704.0, 3813.0, 2552.0, 123_366.0, 1959.0],
    [69564.0, 114.2, 502_601.0, 3931.0, 2514.0, 125_368.0, 1960.0],
    [69331.0, 115.7, 518_173.0, 4806.0, 2572.0, 127_852.0, 1961.0],
    [70551.0, 116.9, 554_894.0, 4007.0, 2827.0, 130_081.0, 1962.0],
];

/// Certified estimates and standard errors: constant, then as in [`LONGLEY`].
const CERTIFIED: [(f64, f64); 7] = [
    (-3_482_258.634_595_82, 890_420.383_607_373),
    (15.061_872_271_373_3, 84.914_925_774_766_9),
    (-0.358_191_792_925_910e-1, 0.334_910_077_722_432e-1),
    (-2.020_229_803_816_83, 0.488_399_681_651_699),
    (-1.033_226_867_173_59, 0.214_274_163_161_675),
    (-0.511_041_056_535_807e-1, 0.226_073_200_069_370),
    (1_829.151_464_613_55, 455.478_499_142_212),
];

#[test]
fn longley_to_nine_digits() {
    let x = Mat::from_fn(16, 7, |i, j| if j == 0 { 1.0 } else { LONGLEY[i][j] });
    let y: Vec<f64> = LONGLEY.iter().map(|row| row[0]).collect();
    let fit = LeastSquares::new().solve(x.as_ref(), &y).unwrap();

    let mut fewest_digits = f64::INFINITY;
    for ((&found, found_error), (certified, error)) in
        fit.coefficients.iter().zip(fit.standard_errors()).zip(CERTIFIED)
    {
        fewest_digits = fewest_digits.min(-((found - certified) / certified).abs().log10());
        assert!((found_error - error).abs() < 1e-9 * error, "{found_error} {error}");
    }
    println!("digits: {fewest_digits:.1}, condition after scaling: {:.3e}", fit.condition);
    assert!(fewest_digits >= 9.0, "{fewest_digits}");
    assert_eq!((fit.rank, fit.rows), (7, 16));
    // Certified residual sum of squares.
    assert!((fit.rss - 836_424.055_505_915).abs() < 1e-9 * fit.rss, "{}", fit.rss);
}

/// Four columns of which the last is the sum of the first two, in units far apart.
fn deficient() -> (Mat<f64>, Vec<f64>) {
    let numbers = noise(1, 150);
    let x = Mat::from_fn(50, 4, |i, j| {
        let row = &numbers[3 * i..3 * i + 3];
        if j < 3 { [1e6, 1.0, 1e-6][j] * row[j] } else { row[0] + row[1] }
    });
    let y = (0..50).map(|i| 2e-6 * x[(i, 0)] + 3e6 * x[(i, 2)] + x[(i, 3)]).collect();
    (x, y)
}

#[test]
fn missing_excitation_is_refused_with_rank_and_condition() {
    let (x, y) = deficient();
    let error = LeastSquares::new().solve(x.as_ref(), &y).unwrap_err();
    let IdentError::RankDeficient { rank, parameters, rows, condition, .. } = error else {
        unreachable!("{error}")
    };
    assert_eq!((rank, parameters, rows), (3, 4, 50));
    assert!(condition > 1e14, "{condition}");
}

#[test]
fn the_minimum_norm_solution_is_the_shortest_in_scaled_columns() {
    let (x, y) = deficient();
    let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
    let fit = solver.solve(x.as_ref(), &y).unwrap();
    assert_eq!(fit.rank, 3);
    // It fits as well as the parameters that made the data; 50 rows of size 5, 1e3 eps.
    assert!(fit.rss < 1e-24, "{}", fit.rss);
    // Along the null direction (1e-6, 1, 0, -1) nothing can be gained: the scaled solution is
    // orthogonal to the scaled null direction.
    let scales: Vec<f64> = (0..4).map(|j| x.col(j).norm_l2().log2().round().exp2()).collect();
    let null = [1e-6, 1.0, 0.0, -1.0];
    let along: f64 = (0..4).map(|j| fit.coefficients[j] * null[j] * scales[j].powi(2)).sum();
    assert!(along.abs() < 1e-9, "{along}");
    // A tolerance that accepts everything finds full rank.
    let all = LeastSquares::new().with_rank_tolerance(0.0).solve(x.as_ref(), &y).unwrap();
    assert_eq!(all.rank, 4);
}

#[test]
fn bad_matrices_are_named() {
    let solve = |x: Mat<f64>, y: &[f64]| LeastSquares::new().solve(x.as_ref(), y).unwrap_err();
    let error = solve(Mat::zeros(3, 1), &[0.0; 2]);
    assert_eq!(error.to_string(), "least-squares target must be 3x1, got 2x1");
    let error = solve(Mat::zeros(2, 2), &[0.0; 2]);
    assert!(matches!(error, IdentError::TooFewRows { parameters: 2, found: 2, .. }));
    let error = solve(Mat::from_fn(3, 1, |i, _| if i == 1 { f64::NAN } else { 1.0 }), &[0.0; 3]);
    assert_eq!(error.to_string(), "regressor matrix[1, 0] must be finite, got NaN");
    // A column of zeros cannot be excited.
    let error = solve(Mat::zeros(3, 1), &[0.0; 3]);
    assert!(matches!(error, IdentError::RankDeficient { rank: 0, .. }), "{error}");
    let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
    let fit = solver.solve(Mat::<f64>::zeros(3, 2).as_ref(), &[1.0, 2.0, 2.0]).unwrap();
    assert!(fit.rank == 0 && (fit.rss - 9.0).abs() < 1e-15);
}

/// Regressors below the smallest normal number are silence; beside ordinary ones they add no rank.
#[test]
fn subnormal_regressors_are_silence() {
    let tiny = Mat::from_fn(20, 3, |i, j| 1e-310 * ((i * 7 + j * 3) % 5) as f64);
    let y = noise(2, 20);
    let refused = LeastSquares::new().solve(tiny.as_ref(), &y).unwrap_err();
    assert!(matches!(refused, IdentError::RankDeficient { rank: 0, .. }), "{refused}");
    let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
    let fit = solver.solve(tiny.as_ref(), &y).unwrap();
    assert_eq!(fit.rank, 0);
    assert!(fit.coefficients.iter().all(|&c| c == 0.0));
    let numbers = noise(3, 20);
    let mixed = Mat::from_fn(20, 2, |i, j| if j == 0 { numbers[i] } else { tiny[(i, 1)] });
    let fit = solver.solve(mixed.as_ref(), &y).unwrap();
    assert_eq!(fit.rank, 1);
    assert!(fit.coefficients.iter().all(|c| c.is_finite()));
}
