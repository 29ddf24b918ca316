//! Distributions of measurement errors that are not Gaussian: rounding, outliers, heavy tails.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use fd_numeric::robust_deviation;
use statrs::function::{erf::erfc, gamma::ln_gamma};

/// Log-density of Gaussian noise that is rounded to a grid, at errors `e` from the rounded value:
/// `Σ ln((Φ((q/2 − e)/s) − Φ((−q/2 − e)/s))/q)` for noise `s` and step `q`.
///
/// ```
/// use fd_gap::quality::interval_log_likelihood;
///
/// // On a fine grid: the density itself.
/// let density = -0.5 * (2.0 * std::f64::consts::PI).ln() - 0.5 * 0.3_f64.powi(2);
/// assert!((interval_log_likelihood(&[0.3], 1.0, 1e-3) - density).abs() < 1e-6);
/// // On a coarse one all values within the cell are alike.
/// assert!((interval_log_likelihood(&[0.3], 1e-3, 1.0)).abs() < 1e-6);
/// ```
#[must_use]
pub fn interval_log_likelihood(errors: &[f64], noise: f64, step: f64) -> f64 {
    let cell = |e: &f64| {
        // By symmetry on the side on which both tails are small.
        let e = e.abs();
        let [near, far] = [e - 0.5 * step, e + 0.5 * step].map(|x| x / noise * FRAC_1_SQRT_2);
        let mass = 0.5 * (erfc(near) - erfc(far));
        // Far out in the tail the probability is lost in rounding; its density is not.
        let density = -0.5 * (e / noise).powi(2) - noise.ln() - 0.5 * (2.0 * PI).ln();
        if 1e-280 < mass { (mass / step).ln() } else { density }
    };
    errors.iter().map(cell).sum()
}

/// A mixture of noise and wider noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutlierMixture {
    /// Log-likelihood.
    pub log: f64,
    /// Standard deviation of the noise.
    pub scale: f64,
    /// Share of the outliers.
    pub share: f64,
    /// How many times wider they are.
    pub width: f64,
}

/// How many times wider outliers may be.
pub(crate) const OUTLIER_WIDTHS: [f64; 5] = [4.0, 8.0, 16.0, 50.0, 200.0];
/// Largest share of outliers.
pub(crate) const MOST_OUTLIERS: f64 = 0.3;
/// Steps of the iteration.
const STEPS: usize = 60;

/// Fits `(1 − p) N(0, s²) + p N(0, (w s)²)` by expectation and maximisation (Dempster, Laird &
/// Rubin 1977) for each of a few widths `w`, and returns the best. `None` without data.
///
/// ```
/// use fd_gap::quality::outlier_mixture;
///
/// let mut e: Vec<f64> = (0..200).map(|k| f64::from(k % 7) - 3.0).collect();
/// e[50] = 90.0;
/// e[120] = -70.0;
/// let mixture = outlier_mixture(&e).unwrap();
/// assert!((mixture.share - 0.01).abs() < 0.001 && (mixture.scale - 2.0).abs() < 0.1);
/// ```
#[must_use]
pub fn outlier_mixture(errors: &[f64]) -> Option<OutlierMixture> {
    let mut sizes: Vec<f64> = errors.iter().map(|e| e.abs()).collect();
    let robust = robust_deviation(&mut sizes)?;
    let fits = OUTLIER_WIDTHS.map(|width| fit(errors, robust.max(f64::MIN_POSITIVE), width));
    fits.into_iter().max_by(|a, b| a.log.total_cmp(&b.log))
}

fn fit(errors: &[f64], robust: f64, width: f64) -> OutlierMixture {
    let n = errors.len() as f64;
    let (mut scale, mut share) = (robust, 0.02);
    let mut log = f64::NEG_INFINITY;
    for _ in 0..STEPS {
        let (mut outliers, mut squares, mut sum) = (0.0, 0.0, 0.0);
        for e in errors {
            let square = (e / scale).powi(2);
            let inner = (1.0 - share) * (-0.5 * square).exp();
            let outer = share / width * (-0.5 * square / (width * width)).exp();
            let total = (inner + outer).max(f64::MIN_POSITIVE);
            let odds = outer / total;
            outliers += odds;
            squares += e * e * ((1.0 - odds) + odds / (width * width));
            sum += total.ln() - scale.ln() - 0.5 * (2.0 * PI).ln();
        }
        let is_done = sum - log < 1e-6;
        log = sum;
        if is_done {
            break;
        }
        share = (outliers / n).clamp(0.1 / n, MOST_OUTLIERS);
        scale = (squares / n).sqrt().max(f64::MIN_POSITIVE);
    }
    OutlierMixture { log, scale, share, width }
}

/// Student's distribution, fitted to errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeavyTails {
    /// Log-likelihood.
    pub log: f64,
    /// Degrees of freedom.
    pub freedom: f64,
    /// Scale; the standard deviation is `√(ν/(ν − 2))` times that.
    pub scale: f64,
}

impl HeavyTails {
    /// Standard deviation, for more than two degrees of freedom.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.scale * (self.freedom / (self.freedom - 2.0)).sqrt()
    }
}

/// Fits Student's distribution of known degrees of freedom by expectation and maximisation (Lange,
/// Little & Taylor 1989): errors count by `(ν + 1)/(ν + (e/s)²)`. Where an outlier mixture has two
/// kinds of errors, here all are of one kind, and large ones are frequent. `None` without data.
///
/// ```
/// use fd_gap::quality::heavy_tails;
///
/// // Quantiles of a Cauchy distribution of scale 2.
/// let e: Vec<f64> = (0..999).map(|k| {
///     2.0 * (std::f64::consts::PI * (f64::from(k + 1) / 1000.0 - 0.5)).tan()
/// }).collect();
/// assert!((heavy_tails(&e, 1.0).unwrap().scale - 2.0).abs() < 0.02);
/// ```
#[must_use]
pub fn heavy_tails(errors: &[f64], freedom: f64) -> Option<HeavyTails> {
    let n = errors.len() as f64;
    let mut square = errors.iter().map(|e| e * e).sum::<f64>() / n;
    if !(0.0 < square && square.is_finite()) {
        return None;
    }
    let constant =
        ln_gamma(0.5 * (freedom + 1.0)) - ln_gamma(0.5 * freedom) - 0.5 * (freedom * PI).ln();
    let mut log = f64::NEG_INFINITY;
    for _ in 0..STEPS {
        let (mut sum, mut squares) = (0.0, 0.0);
        for e in errors {
            let ratio = e * e / square;
            sum -= 0.5 * (freedom + 1.0) * (ratio / freedom).ln_1p();
            squares += e * e * (freedom + 1.0) / (freedom + ratio);
        }
        sum += n * (constant - 0.5 * square.ln());
        let is_done = sum - log < 1e-6;
        log = sum;
        if is_done {
            break;
        }
        square = squares / n;
    }
    Some(HeavyTails { log, freedom, scale: square.sqrt() })
}
