//! H2 and H-infinity norms.

use faer::{Mat, c64};
use fd_numeric::dense::Dense;

use crate::{
    domain::{Continuous, TimeDomain},
    error::ModelError,
    linalg::{balance, eigenvalues, identity_minus, lower, solve},
    state_space::StateSpace,
};

/// The largest gain of a model and where it occurs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PeakGain {
    /// Largest singular value of the transfer matrix at `omega`.
    pub norm: f64,
    /// Frequency in rad/s; infinite when the gain only approaches the peak.
    pub omega: f64,
}

impl<D: TimeDomain> StateSpace<D> {
    /// The H2 norm: standard deviation of the outputs together under white noise of unit
    /// intensity (variance, in discrete time) on each input.
    ///
    /// Infinite for a continuous model with feedthrough.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is unstable or within rounding of it.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// // cb/√(2a)
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// assert!((lag.h2_norm()? - 1.0).abs() < 1e-15);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn h2_norm(&self) -> Result<f64, ModelError> {
        let factors = self.gramian_factors("the H2 norm")?;
        let dynamic = (self.c() * factors.controllability).norm_l2();
        let direct = self.domain().feedthrough_h2_squared(self.d().norm_l2().powi(2));
        Ok(dynamic.hypot(direct.sqrt()))
    }

    /// The H-infinity norm: the largest gain over all frequencies and input directions.
    ///
    /// The gain that is returned is attained at the frequency that is returned; the norm is at
    /// most `1 + tolerance` times as large.
    ///
    /// N. A. Bruinsma and M. Steinbuch, "A fast algorithm to compute the H∞-norm of a transfer
    /// function matrix", Systems & Control Letters 14(4), 1990. Discrete models are searched
    /// through Tustin's map, which keeps the norm, and evaluated as they are.
    ///
    /// # Errors
    ///
    /// Returns an error when the model is unstable, the tolerance is outside `[1e-10, 1)`, or an
    /// iteration does not converge.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// // 1/(s² + 2ζs + 1) peaks with 1/(2ζ√(1 − ζ²)).
    /// let (zeta, a) = (0.1_f64, mat![[0.0, 1.0], [-1.0, -0.2]]);
    /// let mode = StateSpace::new(a, mat![[0.0], [1.0]], mat![[1.0, 0.0]], mat![[0.0]], Continuous)?;
    /// let peak = mode.hinf_norm(1e-6)?.norm;
    /// let expected = 1.0 / (2.0 * zeta * (1.0 - zeta * zeta).sqrt());
    /// assert!((peak / expected - 1.0).abs() < 1e-6);
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn hinf_norm(&self, tolerance: f64) -> Result<PeakGain, ModelError> {
        const STEPS: usize = 60;
        // A better start saves steps, but each costs a solve per frequency.
        const RESONANCES: usize = 8;

        if !(1e-10..1.0).contains(&tolerance) {
            let (role, range) = ("the relative tolerance of the H-infinity norm", "[1e-10, 1)");
            return Err(ModelError::OutOfRange { role, range, value: tolerance });
        }
        self.stable_poles("the H-infinity norm")?;
        let scaling = balance(self.a(), self.b(), self.c());
        let scaled = Self::new(
            scaling.a(self.a()),
            scaling.b(self.b()),
            scaling.c(self.c()),
            self.d().to_owned(),
            self.domain(),
        )?;
        let half_plane = D::half_plane(&scaled)?;
        let domain = self.domain();

        // Both ends of the axis, and the least damped resonances.
        let mut best = PeakGain { norm: 0.0, omega: 0.0 };
        let mut poles = half_plane.poles()?;
        let damping = |pole: &c64| -pole.re / pole.norm();
        poles.sort_by(|p, q| damping(p).total_cmp(&damping(q)));
        let resonances = poles.iter().take(RESONANCES).flat_map(|p| [p.norm(), p.im.abs()]);
        let resonances = resonances.map(|omega| domain.frequency_of_half_plane(omega));
        scaled.climb(&mut best, resonances.chain([0.0, domain.highest_frequency()]))?;

        for _ in 0..STEPS {
            let level = if 0.0 < best.norm {
                best.norm * (1.0 + tolerance)
            } else {
                // The largest Hankel value is a lower bound of the norm.
                match self.hankel_singular_values()?.first() {
                    Some(&largest) if 0.0 < largest => 0.5 * largest,
                    _ => return Ok(best),
                }
            };
            let crossings = half_plane.crossings(level)?;
            let between = crossings.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
            let candidates = crossings.iter().copied().chain(between);
            scaled
                .climb(&mut best, candidates.map(|omega| domain.frequency_of_half_plane(omega)))?;
            if best.norm <= level {
                return Ok(best);
            }
        }
        Err(ModelError::NoConvergence { what: "the H-infinity norm", order: self.nx() })
    }

    /// Moves to the frequency with the largest gain, if it is larger than the best so far.
    fn climb(
        &self,
        best: &mut PeakGain,
        frequencies: impl Iterator<Item = f64>,
    ) -> Result<(), ModelError> {
        for omega in frequencies {
            let response = self.frequency_response(omega)?;
            if response.nrows() == 0 || response.ncols() == 0 {
                continue;
            }
            let gains = response
                .sigmas()
                .map_err(|_| ModelError::NoConvergence { what: "the gain", order: self.nx() })?;
            let norm = gains.iter().copied().fold(0.0, f64::max);
            if best.norm < norm {
                *best = PeakGain { norm, omega };
            }
        }
        Ok(())
    }
}

impl StateSpace<Continuous> {
    /// Frequencies, in ascending order, among which are all where a gain equals `level`.
    ///
    /// These are imaginary eigenvalues of a Hamiltonian matrix (Boyd, Balakrishnan and Kabamba
    /// 1989). Rounding moves them off the axis, so those near it are counted in: one too many
    /// costs an evaluation, one too few the answer.
    fn crossings(&self, level: f64) -> Result<Vec<f64>, ModelError> {
        const NEAR_RELATIVE: f64 = 1e-3;
        const NEAR_ABSOLUTE: f64 = 1e-9;

        let (a, b, c, d) = (self.a(), self.b(), self.c(), self.d());
        let (nx, ny) = (self.nx(), self.ny());
        if nx == 0 {
            return Ok(Vec::new());
        }
        // γ²I − DᵀD is positive definite above the gain at infinity.
        let weight = identity_minus(level * level, (d.transpose() * d).as_ref());
        let role = "γ²I − DᵀD";
        let to_input = solve(role, weight.as_ref(), (d.transpose() * c).as_ref())?;
        let dynamics = a + b * to_input;
        let input = b * solve(role, weight.as_ref(), b.transpose())?;
        let direct = d * solve(role, weight.as_ref(), d.transpose())?;
        let output = -(c.transpose() * (Mat::<f64>::identity(ny, ny) + direct) * c);
        let mut hamiltonian =
            lower(dynamics.as_ref(), output.as_ref(), (-dynamics.transpose()).as_ref());
        hamiltonian.submatrix_mut(0, nx, nx, nx).copy_from(input);

        let values = eigenvalues(hamiltonian.as_ref())?;
        let largest = values.iter().fold(0.0, |largest: f64, value| largest.max(value.norm()));
        let near = |value: &&c64| {
            0.0 <= value.im
                && value.re.abs() <= NEAR_RELATIVE * value.norm() + NEAR_ABSOLUTE * largest
        };
        let mut crossings: Vec<f64> = values.iter().filter(near).map(|value| value.im).collect();
        crossings.sort_by(f64::total_cmp);
        Ok(crossings)
    }
}
