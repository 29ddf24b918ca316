//! Triangular factors of covariances, by orthogonal transformations in place.
//!
//! Square-root filters keep `S` with `P = S Sᵀ` and never form `P`: it cannot lose its positive
//! definiteness to rounding, and twice as many digits count (Kailath, Sayed and Hassibi 2000, *Linear
//! Estimation*, section 12.1).

use fd_numeric::dot;

/// Makes the matrix `A`, row by row in `a` with at least as many columns as rows, lower triangular with
/// a diagonal that is not negative, by Householder reflections from the right: `A Aᵀ` stays as it is.
pub(crate) fn triangularise(a: &mut [f64], columns: usize) {
    for i in 0..a.len() / columns {
        let (above, below) = a.split_at_mut((i + 1) * columns);
        let pivot = &mut above[i * columns + i..];
        let norm = dot(pivot, pivot).sqrt();
        if norm > 0.0 {
            // v = pivot − alpha e₁ with the sign that does not cancel; 2 / vᵀv = 1 / (norm (norm + |p₁|)).
            let alpha = if pivot[0] > 0.0 { -norm } else { norm };
            let scale = (norm * (norm + pivot[0].abs())).recip();
            pivot[0] -= alpha;
            for row in below.chunks_exact_mut(columns) {
                let row = &mut row[i..];
                let share = scale * dot(pivot, row);
                row.iter_mut().zip(&*pivot).for_each(|(to, v)| *to -= share * v);
                if alpha < 0.0 {
                    row[0] = -row[0];
                }
            }
            pivot.fill(0.0);
            pivot[0] = norm;
        } else {
            // Nothing to reflect; what is not a number stays visible.
            pivot.fill(0.0);
            pivot[0] = norm;
            if norm.is_nan() {
                below.chunks_exact_mut(columns).for_each(|row| row[i] = f64::NAN);
            }
        }
    }
}

/// Solves `L z = b` in place, `L` lower triangular in the first columns of rows that are `stride` long.
pub(crate) fn solve_lower(l: &[f64], stride: usize, b: &mut [f64]) {
    for i in 0..b.len() {
        let (done, rest) = b.split_at_mut(i);
        rest[0] = (rest[0] - dot(&l[i * stride..i * stride + i], done)) / l[i * stride + i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_product_with_its_transpose_stays() {
        let a: Vec<f64> = (0..3 * 7).map(|i| (1.3 * f64::from(i * i)).sin()).collect();
        let mut l = a.clone();
        triangularise(&mut l, 7);
        for i in 0..3 {
            assert!(l[i * 7 + i] > 0.0 && l[i * 7 + i + 1..(i + 1) * 7].iter().all(|v| *v == 0.0));
            for j in 0..3 {
                let product = |m: &[f64]| dot(&m[i * 7..(i + 1) * 7], &m[j * 7..(j + 1) * 7]);
                // Some twenty roundings of numbers of size seven.
                assert!((product(&a) - product(&l)).abs() < 1e-14, "{i} {j}");
            }
        }
        let mut z = [1.0, 2.0, 3.0];
        solve_lower(&l, 7, &mut z);
        for i in 0..3 {
            let b = dot(&l[i * 7..i * 7 + 3], &z);
            assert!((b - [1.0, 2.0, 3.0][i]).abs() < 1e-13);
        }
    }

    #[test]
    fn an_exact_state_has_a_row_of_zeros() {
        let mut a = vec![0.0, 0.0, 0.0, 2.0, 3.0, 4.0];
        triangularise(&mut a, 3);
        assert_eq!(a, [0.0, 0.0, 0.0, 2.0, 5.0, 0.0]);
    }

    #[test]
    fn what_is_not_a_number_stays_visible() {
        let mut a = vec![f64::NAN, 1.0, 1.0, 1.0];
        triangularise(&mut a, 2);
        assert!(a[0].is_nan() && a[2].is_nan());
    }
}
