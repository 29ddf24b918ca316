//! Instrumental variables sample by sample.

use fd_core::{
    Scalar, StateVisitor,
    stage::{GuardReport, Identifier, Stage},
};
use fd_numeric::dot;
use serde::{Deserialize, Serialize};

use super::stability::is_stable;
use crate::{
    arx::{ArxOrders, History},
    error::IdentError,
    rls::{add_scaled, positive},
};

/// Settings of [`RecursiveIv`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct IvDesign {
    /// Variance of each parameter before the first sample, relative to a noise of variance 1.
    pub prior_variance: f64,
    /// Samples learned by least squares until there is a model that can make instruments.
    pub warm_up: u64,
    /// Share of the newest estimate in the model that makes the instruments, per sample; the
    /// slower, the less the instruments know of the noise.
    pub smoothing: f64,
    /// Forgetting factor, 1 for none.
    pub forgetting: f64,
}

impl Default for IvDesign {
    fn default() -> Self {
        Self { prior_variance: 1e8, warm_up: 200, smoothing: 0.01, forgetting: 1.0 }
    }
}

/// Recursive instrumental variables with a simulated instrument, one estimator per channel.
///
/// ```text
/// K = P z / (λ + φᵀ P z),   θ ← θ + K (μ − φᵀθ),   P ← (P − K φᵀ P) / λ
/// ```
///
/// Source: Söderström & Stoica (1989), *System identification*, eq. (9.27); the instrument as in
/// Young (1984), from a slowly followed and stable copy of `θ`. After the warm-up by least
/// squares, `P` starts anew, so that the bias of the warm-up is forgotten.
///
/// # When not to use it
///
/// `P` is not symmetric and not factorised: not in `f32` with slow poles, and not for the tracking
/// of abrupt changes. Noise-free data are better learned by
/// [`RecursiveArx`](crate::arx::RecursiveArx).
///
/// # Examples
///
/// ```
/// use fd_core::stage::Identifier;
/// use fd_ident::{arx::ArxOrders, instrumental::{IvDesign, RecursiveIv}};
///
/// let mut iv = RecursiveIv::<f64>::new(ArxOrders::paper(2), 1, 1, &IvDesign::default())?;
/// iv.update(&[1.0], &[0.0]);
/// assert_eq!(iv.theta().len(), 5);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
#[derive(Clone, Debug)]
pub struct RecursiveIv<T: Scalar = f64> {
    design: IvDesign,
    measured: History<T>,
    simulated: History<T>,
    channels: Vec<Channel<T>>,
    theta: Vec<T>,
    /// Simulated bias of the present sample.
    mu_hat: Vec<T>,
    phi: Vec<T>,
    z: Vec<T>,
    scratch: Scratch<T>,
    report: GuardReport,
}

#[derive(Clone, Debug)]
struct Scratch<T> {
    p_z: Vec<T>,
    phi_p: Vec<T>,
    candidate: Vec<T>,
    a: Vec<T>,
}

#[derive(Clone, Debug)]
struct Channel<T> {
    /// `P`, row by row.
    p: Vec<T>,
    /// `Σ z zᵀ`, for the covariance `P Σ z zᵀ Pᵀ`.
    zz: Vec<T>,
    /// Parameters of the model that makes the instruments.
    auxiliary: Vec<T>,
    samples: u64,
    /// 1 once the instruments are simulated.
    running: u64,
}

impl<T: Scalar> RecursiveIv<T> {
    /// An identifier for `nu` inputs and `residual_len` residual channels.
    ///
    /// # Errors
    ///
    /// Returns an error when the orders leave no parameters or a setting is out of range.
    pub fn new(
        orders: ArxOrders,
        nu: usize,
        residual_len: usize,
        design: &IvDesign,
    ) -> Result<Self, IdentError> {
        let n = orders.checked_parameters(nu)?;
        positive("prior variance", design.prior_variance)?;
        for (setting, found) in
            [("smoothing", design.smoothing), ("forgetting factor", design.forgetting)]
        {
            if !(0.0 < found && found <= 1.0) {
                let expected = "above 0 and at most 1";
                return Err(IdentError::Setting { setting, expected, found });
            }
        }
        let zeros = |len: usize| vec![T::zero(); len];
        let channel = Channel {
            p: zeros(n * n),
            zz: zeros(n * n),
            auxiliary: zeros(n),
            samples: 0,
            running: 0,
        };
        let mut identifier = Self {
            design: *design,
            measured: History::new(orders, nu, residual_len),
            simulated: History::new(orders, nu, residual_len),
            channels: vec![channel; residual_len],
            theta: zeros(n * residual_len),
            mu_hat: zeros(residual_len),
            phi: zeros(n),
            z: zeros(n),
            scratch: Scratch {
                p_z: zeros(n),
                phi_p: zeros(n),
                candidate: zeros(n),
                a: zeros(orders.na),
            },
            report: GuardReport::default(),
        };
        let variance = T::from_design(design.prior_variance);
        identifier.channels.iter_mut().for_each(|channel| channel.restart(variance));
        Ok(identifier)
    }
}

impl<T: Scalar> Channel<T> {
    fn restart(&mut self, variance: T) {
        // p has n² entries, its diagonal every n + 1.
        let n = self.auxiliary.len();
        self.p.fill(T::zero());
        self.p.iter_mut().step_by(n + 1).for_each(|p| *p = variance);
        self.zz.fill(T::zero());
        self.zz.iter_mut().step_by(n + 1).for_each(|s| *s = T::one() / variance);
    }

    /// One step; false when the sample had to be skipped.
    fn learn(
        &mut self,
        (phi, z): (&[T], &[T]),
        target: T,
        lambda: T,
        theta: &mut [T],
        scratch: &mut Scratch<T>,
    ) -> bool {
        let n = theta.len();
        let Scratch { p_z, phi_p, .. } = scratch;
        phi_p.fill(T::zero());
        for (i, row) in self.p.chunks_exact(n).enumerate() {
            p_z[i] = dot(row, z);
            add_scaled(phi_p, phi[i], row);
        }
        let total = lambda + dot(phi, p_z);
        let innovation = target - dot(phi, theta);
        // Unlike with least squares the denominator may vanish or change its sign: such a sample
        // says nothing.
        let least = lambda * T::from_design(1e-3);
        if !(total.abs() > least && total.is_finite() && innovation.is_finite()) {
            return false;
        }
        add_scaled(theta, innovation / total, p_z);
        for (i, row) in self.p.chunks_exact_mut(n).enumerate() {
            let factor = -(p_z[i] / total);
            for (p, &v) in row.iter_mut().zip(phi_p.iter()) {
                *p = (*p + factor * v) / lambda;
            }
        }
        for (i, row) in self.zz.chunks_exact_mut(n).enumerate() {
            for (s, &zj) in row.iter_mut().zip(z) {
                *s = lambda * *s + z[i] * zj;
            }
        }
        true
    }

    /// Lets the instruments follow the estimate, as long as they stay stable.
    fn follow(&mut self, theta: &[T], share: T, na: usize, scratch: &mut Scratch<T>) -> bool {
        let Scratch { candidate, a, .. } = scratch;
        for ((new, &old), &theta) in candidate.iter_mut().zip(&self.auxiliary).zip(theta) {
            *new = old + share * (theta - old);
        }
        let stable = candidate.iter().all(T::is_finite)
            && is_stable(&candidate[..na], T::from_design(0.9999), a);
        if stable {
            self.auxiliary.copy_from_slice(candidate);
        }
        stable
    }
}

impl<T: Scalar> Identifier<T> for RecursiveIv<T> {
    fn nu(&self) -> usize {
        self.measured.nu()
    }

    fn residual_len(&self) -> usize {
        self.measured.ny()
    }

    fn update(&mut self, u: &[T], mu: &[T]) {
        self.measured.push_input(u);
        self.simulated.push_input(u);
        let (n, na) = (self.phi.len(), self.measured.orders().na);
        let full = self.measured.is_full();
        let lambda = T::from_design(self.design.forgetting);
        let channels = self.channels.iter_mut().zip(self.theta.chunks_exact_mut(n)).zip(mu);
        for (index, ((channel, theta), &mu)) in channels.enumerate() {
            self.mu_hat[index] = if channel.running == 1 {
                self.simulated.bias(index, &channel.auxiliary)
            } else {
                mu
            };
            if !full {
                continue;
            }
            self.measured.regressor_into(index, &mut self.phi);
            // Until the instruments run, the simulated past is the measured one.
            self.simulated.regressor_into(index, &mut self.z);
            let rows = (self.phi.as_slice(), self.z.as_slice());
            if !channel.learn(rows, mu, lambda, theta, &mut self.scratch) {
                self.report.skipped += 1;
                continue;
            }
            channel.samples = channel.samples.saturating_add(1);
            if channel.running == 1 {
                let share = T::from_design(self.design.smoothing);
                channel.follow(theta, share, na, &mut self.scratch);
            } else if channel.samples >= self.design.warm_up
                && channel.follow(theta, T::one(), na, &mut self.scratch)
            {
                channel.running = 1;
                channel.restart(T::from_design(self.design.prior_variance));
            }
        }
        self.measured.push_bias(mu);
        self.simulated.push_bias(&self.mu_hat);
    }

    fn theta(&self) -> &[T] {
        &self.theta
    }

    fn variance_into(&self, variance: &mut [T]) {
        let n = self.phi.len();
        for (channel, variance) in self.channels.iter().zip(variance.chunks_exact_mut(n)) {
            for (row, variance) in channel.p.chunks_exact(n).zip(variance) {
                *variance = channel
                    .zz
                    .chunks_exact(n)
                    .zip(row)
                    .fold(T::zero(), |sum, (zz, &p)| sum + p * dot(zz, row));
            }
        }
    }

    fn guard(&self) -> GuardReport {
        self.report
    }
}

impl<T: Scalar> Stage<T> for RecursiveIv<T> {
    fn reset(&mut self) {
        self.measured.clear();
        self.simulated.clear();
        let variance = T::from_design(self.design.prior_variance);
        for channel in &mut self.channels {
            channel.restart(variance);
            channel.auxiliary.fill(T::zero());
            (channel.samples, channel.running) = (0, 0);
        }
        self.theta.fill(T::zero());
        self.report = GuardReport::default();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.measured.visit(visitor);
        self.simulated.visit(visitor);
        for channel in &mut self.channels {
            visitor.reals("instrumental P", &mut channel.p);
            visitor.reals("instrumental sum of z z'", &mut channel.zz);
            visitor.reals("auxiliary model", &mut channel.auxiliary);
            let mut counts = [channel.samples, channel.running];
            visitor.counts("samples, instruments running", &mut counts);
            [channel.samples, channel.running] = counts;
        }
        visitor.reals("parameters theta", &mut self.theta);
        let mut counts = [self.report.skipped, self.report.bounded];
        visitor.counts("skipped, bounded", &mut counts);
        [self.report.skipped, self.report.bounded] = counts;
    }
}
