//! Factors of gramians by doubling.

use faer::{Mat, MatRef, concat};
use fd_numeric::dense::Dense;

/// Factors of both gramians of a discrete system.
pub(crate) struct SmithFactors {
    /// `P = L Lᵀ` with `A P Aᵀ − P + B Bᵀ = 0`.
    pub controllability: Mat<f64>,
    /// `Q = L Lᵀ` with `Aᵀ Q A − Q + Cᵀ C = 0`.
    pub observability: Mat<f64>,
    /// Whether a power of `A` was found to be a contraction, which proves that `A` is stable. The
    /// factors of an unstable `A` exist too, when no input or no output sees what is unstable.
    pub proves_stability: bool,
}

/// Factors of the gramians of a discrete system `(A, B, C)`; `None` when `A` is unstable or too
/// close to it to converge.
///
/// Squared Smith iteration (Smith 1968) on the factors: `L ← [L, A L]`, `A ← A²`, with an
/// orthogonal compression when there are more columns than states. The powers serve both
/// gramians. Neither gramian is formed, so that small Hankel values survive as they do in
/// Hammarling's method; and all work is products and QR factorisations of large blocks.
///
/// What is left out is `ε` of the factor, `ε²` of the gramian.
pub(crate) fn smith_factors([a, b, c]: [Mat<f64>; 3]) -> Option<SmithFactors> {
    // 2⁶⁴ steps: only an eigenvalue that is on the unit circle to rounding needs more.
    const DOUBLINGS: usize = 64;

    let mut power = a;
    let mut controllability = Growing::new(b);
    let mut observability = Growing::new(c.transpose().to_owned());
    let mut proves_stability = false;
    for _ in 0..DOUBLINGS {
        let size = power.norm_l2();
        proves_stability |= size < 1.0;
        if f64::EPSILON < size {
            controllability.grow(power.as_ref());
            observability.grow(power.transpose());
        }
        if !(size.is_finite() && controllability.is_finite() && observability.is_finite()) {
            return None;
        }
        // The next power is at most as large as the square of this one.
        let vanishes = size * size <= f64::EPSILON;
        if vanishes || (controllability.settled && observability.settled) {
            return Some(SmithFactors {
                controllability: controllability.finish(),
                observability: observability.finish(),
                proves_stability,
            });
        }
        power = &power * &power;
    }
    None
}

/// A factor that doubles its horizon.
struct Growing {
    factor: Mat<f64>,
    /// Nothing is left to add.
    settled: bool,
}

impl Growing {
    fn new(factor: Mat<f64>) -> Self {
        Self { factor, settled: false }
    }

    /// Adds the horizon beyond, that of the factor moved by a power of `A`.
    fn grow(&mut self, power: MatRef<'_, f64>) {
        // A compression costs the more the larger it is, but two small ones cost more than one.
        const SLACK: f64 = 2.0;

        if self.settled {
            return;
        }
        let moved = power * &self.factor;
        if moved.norm_l2() <= f64::EPSILON * self.factor.norm_l2() {
            self.settled = true;
            return;
        }
        self.factor = concat![[&self.factor, &moved]];
        if SLACK * (self.factor.nrows() as f64) < self.factor.ncols() as f64 {
            self.factor = compress(self.factor.as_ref());
        }
    }

    fn is_finite(&self) -> bool {
        self.factor.norm_max().is_finite()
    }

    /// The factor with at most as many columns as rows.
    fn finish(self) -> Mat<f64> {
        if self.factor.nrows() < self.factor.ncols() {
            compress(self.factor.as_ref())
        } else {
            self.factor
        }
    }
}

/// A square factor of the same product as one with more columns than rows.
fn compress(factor: MatRef<'_, f64>) -> Mat<f64> {
    factor.transpose().factor_qr().thin_R().transpose().to_owned()
}
