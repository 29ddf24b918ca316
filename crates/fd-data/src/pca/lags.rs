//! How many past samples the relations between the channels reach back.

use fd_model::Record;

use super::design::PcaDesign;
use crate::error::DataError;

/// The number of lags by Ku, Storer and Georgakis (1995, section 3.2), at most `most`: windows grow as long as
/// they show relations that are not shifted copies of those of shorter windows.
///
/// The relations of a window are what its components leave. With `r(l)` of them, those that are new are
/// `n(l) = r(l) − Σ_{i<l} (l − i + 1) n(i)`; the search ends where none is. The number depends on the rule for
/// components, which has to see what is a relation and what is noise; `lags` of the design does not matter.
///
/// # Errors
///
/// As [`PcaDesign::learn`].
///
/// ```
/// use fd_data::pca::{Components, PcaDesign, choose_lags};
/// use fd_model::{Channel, Record, SampleTime};
///
/// // y(k) = 0.8 y(k−1) + u(k−1), one relation of one lag.
/// let u: Vec<f64> = (0..400_u32).map(|k| f64::from(k * k % 17) - 8.0).collect();
/// let mut y = vec![0.0];
/// (1..400).for_each(|k| y.push(0.8 * y[k - 1] + u[k - 1]));
/// let one = |name| Channel::numbered(name, 1);
/// let log = Record::new(one("u"), one("y"), u, y, SampleTime::new(1.0)?)?;
/// let design = PcaDesign { components: Components::Variance(1.0 - 1e-9), ..PcaDesign::default() };
/// assert_eq!(choose_lags(&design, &[log], 4)?, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[expect(clippy::cast_possible_wrap, reason = "counts of channels")]
pub fn choose_lags(
    design: &PcaDesign,
    healthy: &[Record],
    most: usize,
) -> Result<usize, DataError> {
    let mut new: Vec<i64> = Vec::new();
    for lags in 0..=most {
        let pca = PcaDesign { lags, ..*design }.learn(healthy)?;
        let relations = (pca.eigenvalues().len() - pca.monitor().components()) as i64;
        let known: i64 = new.iter().enumerate().map(|(i, n)| (lags - i + 1) as i64 * n).sum();
        let fresh = relations - known;
        // No relation at all between the channels of one sample says nothing of longer windows.
        if fresh <= 0 && 0 < lags && new.iter().any(|&n| n > 0) {
            return Ok(lags - 1);
        }
        new.push(fresh);
    }
    Ok(most)
}
