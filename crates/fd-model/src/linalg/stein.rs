//! Discrete Lyapunov equations, also called Stein's, of one matrix by doubling.

use faer::Mat;

/// Solves `A X Aᵀ − X + Q = 0` for several `Q`.
pub(crate) struct Stein {
    /// `A`, `A²`, `A⁴`, …
    powers: Vec<Mat<f64>>,
}

impl Stein {
    /// What [`Stein::solve`] leaves out, relative to the solution: one step of refinement takes it
    /// below rounding, for less than another doubling.
    const LEFT_OUT: f64 = 1e-9;

    /// `None` when `A` is unstable, or too close to it to converge.
    pub(crate) fn new(a: Mat<f64>) -> Option<Self> {
        // 2⁶⁴ steps: only an eigenvalue that is on the unit circle to rounding needs more.
        const DOUBLINGS: usize = 64;

        let mut powers = vec![a];
        while let Some(power) = powers.last()
            && powers.len() <= DOUBLINGS
        {
            let size = power.norm_l2();
            // A contraction, which proves that A is stable. The next power is at most the square of
            // this one, and acts from both sides.
            if size.powi(4) <= Self::LEFT_OUT {
                return Some(Self { powers });
            }
            if !size.is_finite() {
                return None;
            }
            powers.push(power * power);
        }
        None
    }

    /// The sum `Q + A Q Aᵀ + A² Q A²ᵀ + …` to a relative error of 1e-9; no number when it
    /// overflows.
    pub(crate) fn solve(&self, mut x: Mat<f64>) -> Mat<f64> {
        for power in &self.powers {
            let moved = power * &x * power.transpose();
            x += moved;
        }
        x
    }
}
