//! Published transfer functions as state-space models.

use faer::Mat;
use fd_model::{Continuous, StateSpace};

pub(crate) type System = StateSpace<Continuous>;
/// Numerator and denominator, highest power first.
pub(crate) type Ratio = (&'static [f64], &'static [f64]);

pub(crate) const ZERO: Ratio = (&[0.0], &[1.0]);
pub(crate) const ONE: Ratio = (&[1.0], &[1.0]);

/// Realises a matrix of transfer functions entry by entry, in controllable canonical form.
pub(crate) fn realise<const N: usize>(rows: &[[Ratio; N]]) -> System {
    let states = |(_, den): &Ratio| den.len() - 1;
    let n = rows.iter().flatten().map(states).sum();
    let (mut a, mut b) = (Mat::zeros(n, n), Mat::zeros(n, N));
    let (mut c, mut d) = (Mat::zeros(rows.len(), n), Mat::zeros(rows.len(), N));
    let mut at = 0;
    for (i, row) in rows.iter().enumerate() {
        for (j, ratio) in row.iter().enumerate() {
            let order = states(ratio);
            let (num, den) = *ratio;
            let lead = den[0];
            // Coefficients of equal length, so that num = feedthrough · den + remainder.
            let padded = |k: usize| {
                let missing = order + 1 - num.len();
                if k < missing { 0.0 } else { num[k - missing] / lead }
            };
            d[(i, j)] = padded(0);
            for k in 0..order {
                // States are derivatives, lowest first.
                a[(at + order - 1, at + k)] = -den[order - k] / lead;
                c[(i, at + k)] = padded(order - k) - padded(0) * den[order - k] / lead;
                if k + 1 < order {
                    a[(at + k, at + k + 1)] = 1.0;
                }
            }
            if 0 < order {
                b[(at + order - 1, j)] = 1.0;
            }
            at += order;
        }
    }
    StateSpace::new(a, b, c, d, Continuous).unwrap()
}

pub(crate) fn assert_equal(found: &System, expected: &System) {
    for omega in [0.0, 0.1, 0.7, 1.0, 2.0, 10.0, 300.0] {
        let (f, e) = (found.frequency_response(omega), expected.frequency_response(omega));
        let (f, e) = (f.unwrap(), e.unwrap());
        // First- and second-order factors with poles of size 1 to 10: a few dozen roundings.
        assert!((&f - &e).norm_max() < 1e-12, "at {omega} rad/s: {f:?} instead of {e:?}");
    }
}

pub(crate) fn assert_close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9, "{found} instead of {expected}");
}
