//! Scalar products of long signals, several at a time.
//!
//! Eight sums are added up side by side, whatever the registers of the machine hold, and then together: the
//! same bits everywhere, but not those of a sum in order.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use crate::lanes::{DoubleRegisters, Machine, Simd, Work};

/// Sums that are added up side by side in a scalar product, so that none waits for another.
const SUMS: usize = 8;
/// Scalar products with the same signal at a time, for the same reason.
const GROUP: usize = 4;

/// The scalar product of two signals of the same length.
///
/// ```
/// let (a, b) = ([0.5; 1000], [2.0; 1000]);
/// assert_eq!(fd_numeric::wide::dot(&a, &b), 1000.0);
/// ```
///
/// # Panics
///
/// Panics when `b` is shorter than `a`.
#[must_use]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let [product, ..] = Machine::detect().run(Products { a, b: [b; 1] });
    product
}

/// The scalar products of a signal with others of the same length, each to the bit what [`dot`]
/// says.
///
/// ```
/// use fd_numeric::wide::{dot, dots};
///
/// let (a, b, c) = ([0.1; 99], [0.2; 99], [0.3; 99]);
/// assert_eq!(dots(&a, &[&b, &c]), [dot(&a, &b), dot(&a, &c)]);
/// ```
///
/// # Panics
///
/// Panics when one of the others is shorter than `a`.
#[must_use]
pub fn dots(a: &[f64], others: &[&[f64]]) -> Vec<f64> {
    let machine = Machine::detect();
    let mut products = Vec::with_capacity(others.len());
    let (groups, rest) = others.as_chunks::<GROUP>();
    for b in groups {
        products.extend(machine.run(Products { a, b: *b }));
    }
    products.extend(rest.iter().map(|b| dot(a, b)));
    products
}

struct Products<'a, const N: usize> {
    a: &'a [f64],
    b: [&'a [f64]; N],
}

impl<const N: usize> Work<f64> for Products<'_, N> {
    type Output = [f64; N];

    #[inline(always)]
    fn run<S: Simd>(self, _: DoubleRegisters<S>) -> [f64; N] {
        let (a, a_rest) = self.a.as_chunks::<SUMS>();
        let mut b: [&[[f64; SUMS]]; N] = [&[]; N];
        for (chunks, signal) in b.iter_mut().zip(self.b) {
            *chunks = &signal.as_chunks().0[..a.len()];
        }
        let mut sums = [[0.0; SUMS]; N];
        for k in 0..a.len() {
            for j in 0..N {
                for i in 0..SUMS {
                    sums[j][i] += a[k][i] * b[j][k][i];
                }
            }
        }
        let mut products = [0.0; N];
        for j in 0..N {
            let rest = a_rest.iter().zip(&self.b[j][self.a.len() - a_rest.len()..]);
            let rest = rest.map(|(a, b)| a * b).sum::<f64>();
            products[j] = sums[j].iter().sum::<f64>() + rest;
        }
        products
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn products_are_sums_of_products_one_by_one_and_together(
            rows in prop::collection::vec(prop::array::uniform7(-1e3..1e3_f64), 0..70),
        ) {
            let signals: Vec<Vec<f64>> =
                (0..7).map(|c| rows.iter().map(|row| row[c]).collect()).collect();
            let slices: Vec<&[f64]> = signals.iter().map(Vec::as_slice).collect();
            for a in &slices {
                let together = dots(a, &slices);
                for (b, product) in slices.iter().zip(&together) {
                    let terms: Vec<f64> = a.iter().zip(*b).map(|(a, b)| a * b).collect();
                    let (sum, size) = (terms.iter().sum::<f64>(), terms.iter().map(|t| t.abs()).sum::<f64>());
                    // Two orders of n additions, each with at most n rounding errors.
                    let n = terms.len() as f64;
                    prop_assert!((product - sum).abs() <= 2.0 * n * f64::EPSILON * size);
                    prop_assert_eq!(product.to_bits(), dot(a, b).to_bits());
                }
            }
        }
    }
}
