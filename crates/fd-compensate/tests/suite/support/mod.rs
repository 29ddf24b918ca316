//! A small bias model with its recursive least squares, just enough to drive a compensator.
#![allow(clippy::unwrap_used, dead_code, unreachable_pub, reason = "shared by several tests")]

use fd_compensate::residual_compensation::{CompensationPlan, ResidualCompensator};
use fd_core::{
    EventKind, Frame, IoDims, Scalar, StateVisitor,
    stage::{BiasModel, Compensator, GuardReport, Identifier, Phase, Stage},
};

/// `μ(k) = −a₁ μ(k−1) − a₂ μ(k−2) + b₀ u(k) + b₁ u(k−1) + b₂ u(k−2)`, one input and one channel.
pub type Arx2<T = f64> = Arx<T, 2>;

/// Difference equation of order `N` with `θ = [a₁ … a_N b₀ … b_N]`.
#[derive(Clone, Debug)]
pub struct Arx<T, const N: usize> {
    theta: Vec<T>,
    regressor: Regressor<T, N>,
}

#[derive(Clone, Debug)]
struct Regressor<T, const N: usize> {
    mu: [T; N],
    u: [T; N],
}

impl<T: Scalar, const N: usize> Regressor<T, N> {
    fn new() -> Self {
        Self { mu: [T::zero(); N], u: [T::zero(); N] }
    }

    /// φ(k) of eq. (15) without allocation, entry by entry.
    fn entry(&self, i: usize, u: T) -> T {
        match i.checked_sub(N) {
            None => -self.mu[i],
            Some(0) => u,
            Some(lag) => self.u[lag - 1],
        }
    }

    fn push(&mut self, u: T, mu: T) {
        self.mu.rotate_right(1);
        self.u.rotate_right(1);
        self.mu[0] = mu;
        self.u[0] = u;
    }

    fn visit(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("past mu", &mut self.mu);
        visitor.reals("past u", &mut self.u);
    }
}

impl<T: Scalar, const N: usize> Arx<T, N> {
    pub fn new() -> Self {
        Self { theta: vec![T::zero(); 2 * N + 1], regressor: Regressor::new() }
    }

    pub fn with(theta: &[f64]) -> Self {
        let mut model = Self::new();
        model.load(&theta.iter().map(|&v| T::from_design(v)).collect::<Vec<_>>());
        model
    }

    fn value(&self, u: T) -> T {
        let terms = self.theta.iter().enumerate().map(|(i, &v)| v * self.regressor.entry(i, u));
        terms.fold(T::zero(), |sum, v| sum + v)
    }
}

impl<T: Scalar, const N: usize> Stage<T> for Arx<T, N> {
    fn reset(&mut self) {
        self.theta.fill(T::zero());
        self.regressor = Regressor::new();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("theta", &mut self.theta);
        self.regressor.visit(visitor);
    }
}

impl<T: Scalar, const N: usize> BiasModel<T> for Arx<T, N> {
    fn nu(&self) -> usize {
        1
    }

    fn residual_len(&self) -> usize {
        1
    }

    fn theta_len(&self) -> usize {
        2 * N + 1
    }

    fn load(&mut self, theta: &[T]) {
        self.theta.copy_from_slice(theta);
    }

    fn observe(&mut self, u: &[T], mu: &[T]) {
        self.regressor.push(u[0], mu[0]);
    }

    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]) {
        mu_hat[0] = self.value(u[0]);
        self.regressor.push(u[0], mu_hat[0]);
    }

    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]) {
        mu_hat[0] = self.value(u[0]);
        self.regressor.push(u[0], r[0]);
    }
}

/// Recursive least squares (eq. 18 with α = 1) for [`Arx`], plain form with exact symmetry.
#[derive(Clone, Debug)]
pub struct Rls<T, const N: usize> {
    theta: Vec<T>,
    p: Vec<T>,
    phi: Vec<T>,
    gain: Vec<T>,
    regressor: Regressor<T, N>,
    /// Samples in the regressor; nothing is learned before it is full.
    filled: u64,
}

/// Prior variance of the parameters: next to no prior.
const PRIOR: f64 = 1e6;

impl<T: Scalar, const N: usize> Rls<T, N> {
    pub fn new() -> Self {
        let n = 2 * N + 1;
        let zeros = vec![T::zero(); n];
        let mut rls = Self {
            theta: zeros.clone(),
            p: vec![T::zero(); n * n],
            phi: zeros.clone(),
            gain: zeros,
            regressor: Regressor::new(),
            filled: 0,
        };
        Stage::<T>::reset(&mut rls);
        rls
    }
}

impl<T: Scalar, const N: usize> Stage<T> for Rls<T, N> {
    fn reset(&mut self) {
        let n = self.theta.len();
        self.theta.fill(T::zero());
        self.p.fill(T::zero());
        (0..n).for_each(|i| self.p[i * n + i] = T::from_design(PRIOR));
        self.regressor = Regressor::new();
        self.filled = 0;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("rls theta", &mut self.theta);
        visitor.reals("rls p", &mut self.p);
        visitor.counts("rls filled", std::slice::from_mut(&mut self.filled));
        self.regressor.visit(visitor);
    }
}

impl<T: Scalar, const N: usize> Identifier<T> for Rls<T, N> {
    fn nu(&self) -> usize {
        1
    }

    fn residual_len(&self) -> usize {
        1
    }

    fn update(&mut self, u: &[T], mu: &[T]) {
        let n = self.theta.len();
        if self.filled < N as u64 {
            self.filled += 1;
            self.regressor.push(u[0], mu[0]);
            return;
        }
        for i in 0..n {
            self.phi[i] = self.regressor.entry(i, u[0]);
        }
        for i in 0..n {
            self.gain[i] = (0..n).fold(T::zero(), |sum, j| sum + self.p[i * n + j] * self.phi[j]);
        }
        let dot = |a: &[T], b: &[T]| a.iter().zip(b).fold(T::zero(), |s, (&a, &b)| s + a * b);
        let scale = (T::one() + dot(&self.gain, &self.phi)).recip();
        let error = mu[0] - dot(&self.theta, &self.phi);
        for i in 0..n {
            self.theta[i] += self.gain[i] * scale * error;
            for j in 0..n {
                self.p[i * n + j] -= (self.gain[i] * self.gain[j]) * scale;
            }
        }
        self.regressor.push(u[0], mu[0]);
    }

    fn theta(&self) -> &[T] {
        &self.theta
    }

    fn variance_into(&self, variance: &mut [T]) {
        let n = self.theta.len();
        (0..n).for_each(|i| variance[i] = self.p[i * n + i]);
    }

    fn guard(&self) -> GuardReport {
        GuardReport::default()
    }
}

/// The compensator under test.
pub type Subject<T = f64> = ResidualCompensator<T, Rls<T, 2>, Arx2<T>>;

pub fn subject<T: Scalar>(plan: &CompensationPlan) -> Subject<T> {
    ResidualCompensator::new(Rls::new(), Arx::new(), plan).unwrap()
}

/// One sample through a compensator: `r*`, phase, events.
pub fn push<T: Scalar>(
    compensator: &mut impl Compensator<T>,
    k: usize,
    u: T,
    r: T,
) -> (T, Phase, Vec<EventKind>) {
    let (u, y, mut star) = ([u], [T::zero()], [T::zero()]);
    let io = IoDims { nu: 1, ny: 1 };
    let frame = Frame::new(io, k as u64, &u, &y).unwrap();
    let outcome = compensator.step(frame, &[r], &mut star);
    (star[0], outcome.phase, outcome.events.iter().collect())
}

/// A run through a compensator: `r*` of each sample and all events with their sample.
pub fn run<T: Scalar>(
    compensator: &mut impl Compensator<T>,
    u: &[T],
    r: &[T],
) -> (Vec<T>, Vec<(usize, EventKind)>) {
    let (mut stars, mut log) = (Vec::new(), Vec::new());
    for (k, (&u, &r)) in u.iter().zip(r).enumerate() {
        let (star, _, events) = push(compensator, k, u, r);
        stars.push(star);
        log.extend(events.into_iter().map(|kind| (k, kind)));
    }
    (stars, log)
}

/// The paper's input: a step with a sinusoid of several frequencies on top.
pub fn paper_input(n: usize) -> Vec<f64> {
    (0..n)
        .map(|k| {
            let t = k as f64;
            1.0 + 0.5 * (0.05 * t).sin() + 0.3 * (0.31 * t).sin() + 0.2 * (1.1 * t).sin()
        })
        .collect()
}

/// What `theta` makes of `u` from rest.
pub fn response<const N: usize>(theta: &[f64], u: &[f64]) -> Vec<f64> {
    let mut model = Arx::<f64, N>::with(theta);
    let mut mu = [0.0];
    u.iter()
        .map(|&u| {
            model.simulate(&[u], &mut mu);
            mu[0]
        })
        .collect()
}

/// Parameters that the paper reports for its engine (section 4).
pub const PAPER_THETA: [f64; 5] = [-1.430_808, 0.432_895, -0.002_161, 0.002_153, 0.0];

pub fn kinds(log: &[(usize, EventKind)]) -> Vec<EventKind> {
    log.iter().map(|&(_, kind)| kind).collect()
}

pub fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}
