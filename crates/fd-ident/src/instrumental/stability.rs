//! Whether a polynomial has all roots inside the unit circle, without computing them.

use fd_core::Scalar;

/// Schur and Cohn's test by the step-down recursion: stable when every reflection coefficient of
/// `1 + a₁ z⁻¹ + … + a_n z⁻ⁿ` is below `largest` in magnitude. `scratch` is as long as `a`.
///
/// With `largest = 1` this is exact; a smaller one keeps a distance from the circle.
pub(super) fn is_stable<T: Scalar>(a: &[T], largest: T, scratch: &mut [T]) -> bool {
    scratch.copy_from_slice(a);
    for order in (1..=a.len()).rev() {
        let (lower, last) = scratch[..order].split_at_mut(order - 1);
        let k = last[0];
        // A NaN is not inside.
        let inside = k.abs() < largest;
        if !inside {
            return false;
        }
        let rest = T::one() - k * k;
        for i in 0..lower.len().div_ceil(2) {
            let j = lower.len() - 1 - i;
            let (ai, aj) = (lower[i], lower[j]);
            lower[i] = (ai - k * aj) / rest;
            lower[j] = (aj - k * ai) / rest;
        }
    }
    true
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::is_stable;
    use crate::arx::roots;

    proptest! {
        #[test]
        fn it_agrees_with_the_roots(a in prop::collection::vec(-1.5..1.5_f64, 1..6)) {
            let radius = roots(&a).unwrap().iter().map(|p| p.norm()).fold(0.0, f64::max);
            // Roots of multiplicity m are only known to ε^(1/m).
            prop_assume!((radius - 1.0).abs() > 1e-3);
            let mut scratch = vec![0.0; a.len()];
            prop_assert_eq!(is_stable(&a, 1.0, &mut scratch), radius < 1.0);
        }
    }
}
