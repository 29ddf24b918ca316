//! Quadratic problems in numbers that must not be negative.

use faer::Mat;

/// Most sweeps over all unknowns.
const MOST_SWEEPS: usize = 5000;

/// Relative change of an unknown that still counts.
const TOLERANCE: f64 = 1e-10;

/// Minimises `½ xᵀ A x − bᵀ x` over `x ≥ 0` for a positive semidefinite `A`, one unknown at a time, which
/// converges for every such problem (Tseng 2001); an unknown without curvature stays as it is.
pub(super) fn minimise(a: &Mat<f64>, b: &[f64], mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len();
    // Row by row in one piece: the sweeps are many and short.
    let rows: Vec<f64> = (0..n).flat_map(|i| (0..n).map(move |j| a[(i, j)])).collect();
    let roots: Vec<f64> = (0..n).map(|i| a[(i, i)].max(0.0).sqrt()).collect();
    for _ in 0..MOST_SWEEPS {
        let mut largest = 0.0_f64;
        for (i, row) in rows.chunks_exact(n).enumerate() {
            if row[i] <= 0.0 {
                continue;
            }
            let slope: f64 = row.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() - b[i];
            let moved = (x[i] - slope / row[i]).max(0.0);
            // Changes are weighed by what they do to the quadratic form.
            largest = largest.max((moved - x[i]).abs() * roots[i]);
            x[i] = moved;
        }
        let size = x.iter().zip(&roots).map(|(x, root)| x * root).fold(0.0, f64::max);
        if largest <= TOLERANCE * size {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use faer::mat;

    use super::*;

    /// The optimum is where the gradient vanishes for positive unknowns and is not negative for zeros.
    #[test]
    fn the_conditions_of_the_optimum_hold() {
        let a = mat![[2.0, 1.0, 0.3], [1.0, 3.0, -0.2], [0.3, -0.2, 1.0]];
        let b = [1.0, -2.0, 0.5];
        let x = minimise(&a, &b, vec![1.0; 3]);
        for i in 0..3 {
            let slope: f64 = (0..3).map(|j| a[(i, j)] * x[j]).sum::<f64>() - b[i];
            // The sweeps end when no unknown moves by more than 1e-10.
            assert!(
                if x[i] > 0.0 { slope.abs() < 1e-8 } else { slope > 0.0 },
                "{i}: {slope} {x:?}"
            );
        }
        assert!(x[1] <= 0.0, "the unknown that would be negative is zero: {x:?}");
    }
}
