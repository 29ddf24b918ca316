//! The state matrix for relative deviations, by central differences.

use faer::Mat;

use super::dynamics::Dynamics;

/// Relative step of the states. With an error of `step²` from curvature and of `eps / step` from
/// rounding, derivatives are consistent to about 1e-7 of the largest rate.
const STATE_STEP: f64 = 2e-6;

/// `∂(ẋ_i / x_i) / ∂(x_j / x_j)` without the change of the denominator, which vanishes with
/// the rates: the state matrix for relative deviations.
pub(super) fn relative_jacobian<const N: usize>(
    engine: &impl Dynamics<f64, N>,
    x: &[f64; N],
    fuel: f64,
) -> Mat<f64> {
    let mut jacobian = Mat::zeros(N, N);
    for j in 0..N {
        let step = STATE_STEP * x[j].abs();
        let (mut up, mut down) = (*x, *x);
        up[j] += step;
        down[j] -= step;
        let (up, down) = (engine.rates(&up, fuel).0, engine.rates(&down, fuel).0);
        for i in 0..N {
            jacobian[(i, j)] = (up[i] - down[i]) / (2.0 * step) * x[j] / x[i];
        }
    }
    jacobian
}
