//! Sample correlations over stretches of data with missing samples.

/// One stretch of evenly sampled data; NaN where a sample is missing.
pub type Stretch = Vec<f64>;

/// Sums of products `e(k) u(k−τ)` over all pairs that are there, for `τ = 0 … lags`.
pub(super) fn products(e: &[Stretch], u: &[Stretch], lags: usize) -> Vec<f64> {
    let sum = |lag: usize| {
        let of_stretch = |(e, u): (&Stretch, &Stretch)| {
            let pairs = e.iter().skip(lag).zip(u);
            pairs.map(|(e, u)| e * u).filter(|product| product.is_finite()).sum::<f64>()
        };
        e.iter().zip(u).map(of_stretch).sum()
    };
    (0..=lags).map(sum).collect()
}

/// Number of samples that are there.
pub(super) fn count(stretches: &[Stretch]) -> usize {
    stretches.iter().flatten().filter(|v| v.is_finite()).count()
}

/// The stretches less their common mean.
pub(super) fn centred(stretches: &[Stretch]) -> Vec<Stretch> {
    let there = stretches.iter().flatten().filter(|v| v.is_finite());
    let mean = there.sum::<f64>() / count(stretches).max(1) as f64;
    stretches.iter().map(|stretch| stretch.iter().map(|v| v - mean).collect()).collect()
}

/// Autocorrelation `r(0) = 1, r(1), … r(lags)`, with the mean left in.
///
/// ```
/// # use fd_ident::diagnostics::autocorrelation;
/// let r = autocorrelation(&[vec![1.0, -1.0, 1.0, -1.0]], 1);
/// assert_eq!(r, [1.0, -0.75]);
/// ```
#[must_use]
pub fn autocorrelation(stretches: &[Stretch], lags: usize) -> Vec<f64> {
    let sums = products(stretches, stretches, lags);
    let power = sums[0];
    sums.into_iter().map(|sum| if power > 0.0 { sum / power } else { 0.0 }).collect()
}
