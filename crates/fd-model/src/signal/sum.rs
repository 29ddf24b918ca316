//! The sum of two signals.

pub(super) fn add(mut sum: Vec<f64>, term: &[f64]) -> Vec<f64> {
    for (sum, term) in sum.iter_mut().zip(term) {
        *sum += term;
    }
    sum
}
