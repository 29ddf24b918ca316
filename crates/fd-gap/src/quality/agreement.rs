//! How well a measured signal and a simulated one agree.

/// `1 − Σ(m − s)²/Σ(m² + s²)` about the means: 1 for equal signals, 0 for unrelated ones.
pub(super) fn agreement(a: &[f64], b: &[f64]) -> f64 {
    let pairs: Vec<(f64, f64)> =
        a.iter().zip(b).filter(|(a, b)| (**a - **b).is_finite()).map(|(a, b)| (*a, *b)).collect();
    let n = pairs.len().max(1) as f64;
    let sum = pairs.iter().fold((0.0, 0.0), |sum, (a, b)| (sum.0 + a, sum.1 + b));
    let (ma, mb) = (sum.0 / n, sum.1 / n);
    let (mut product, mut power) = (0.0, 0.0);
    for (a, b) in pairs {
        product += 2.0 * (a - ma) * (b - mb);
        power += (a - ma).powi(2) + (b - mb).powi(2);
    }
    if 0.0 < power { product / power } else { 0.0 }
}
