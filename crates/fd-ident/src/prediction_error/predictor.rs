//! One-step predictors of all structures, with their sensitivities to every parameter.

use serde::{Deserialize, Serialize};

use crate::arx::{ArxOrders, Start};

/// How noise enters the bias.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum NoiseStructure {
    /// White noise on the bias itself: `μ = B/A u + e`.
    #[default]
    OutputError,
    /// Coloured noise on the bias: `μ = B/A u + C/D e`.
    BoxJenkins {
        /// Order of `C`.
        nc: usize,
        /// Order of `D`.
        nd: usize,
    },
    /// Moving-average noise in the equation: `A μ = B u + C e`.
    Armax {
        /// Order of `C`.
        nc: usize,
    },
}

impl NoiseStructure {
    /// Number of `c` and of `d` that are parameters of their own.
    pub(super) fn own(self) -> (usize, usize) {
        match self {
            Self::OutputError => (0, 0),
            Self::BoxJenkins { nc, nd } => (nc, nd),
            Self::Armax { nc } => (nc, 0),
        }
    }
}

/// One residual channel of one record.
#[derive(Clone, Debug)]
pub(super) struct Stretch {
    /// Inputs, row by row, missing ones held.
    pub u: Vec<f64>,
    /// Bias, NaN where it is missing.
    pub mu: Vec<f64>,
}

/// The predictor of one residual channel.
///
/// Shared parameters are `[a, b, offset, c, d]`; each stretch may add its own past
/// `μ̂(−1) … μ̂(−na)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Predictor {
    pub orders: ArxOrders,
    pub nu: usize,
    pub noise: NoiseStructure,
    /// What a simulation takes for the past; without meaning for ARMAX, which begins as soon as
    /// the measured past is there.
    pub start: Start,
}

/// The last values of a signal, newest first, each with its gradient.
///
/// They move towards the front of a longer buffer, and back to its end once in [`Past::ROOM`] samples.
struct Past {
    values: Vec<f64>,
    gradients: Vec<f64>,
    len: usize,
    width: usize,
    /// Where the newest is.
    at: usize,
}

impl Past {
    const ROOM: usize = 64;

    fn new(len: usize, width: usize) -> Self {
        let (rows, at) = (Self::ROOM + len, Self::ROOM);
        Self { values: vec![0.0; rows], gradients: vec![0.0; rows * width], len, width, at }
    }

    fn values(&self) -> &[f64] {
        &self.values[self.at..self.at + self.len]
    }

    fn set(&mut self, i: usize, value: f64) {
        self.values[self.at + i] = value;
    }

    fn gradient_mut(&mut self, i: usize) -> &mut [f64] {
        let at = (self.at + i) * self.width;
        &mut self.gradients[at..at + self.width]
    }

    fn push(&mut self, value: f64, gradient: impl Iterator<Item = f64>) {
        if self.len == 0 {
            return;
        }
        if self.at == 0 {
            let kept = self.len - 1;
            self.at = Self::ROOM + 1;
            self.values.copy_within(..kept, self.at);
            self.gradients.copy_within(..kept * self.width, self.at * self.width);
        }
        self.at -= 1;
        self.set(0, value);
        self.gradient_mut(0).iter_mut().zip(gradient).for_each(|(to, from)| *to = from);
    }

    /// Adds `Σ weights_i · signal(k−i)` to a value and to its gradient.
    fn add_to(&self, weights: &[f64], sign: f64, value: &mut f64, gradient: &mut [f64]) {
        for (weight, past) in weights.iter().zip(self.values()) {
            *value += sign * weight * past;
        }
        if self.width == 0 {
            return;
        }
        let rows = self.gradients[self.at * self.width..].chunks_exact(self.width);
        for (weight, row) in weights.iter().zip(rows.take(self.len)) {
            let weight = sign * weight;
            for (sum, g) in gradient.iter_mut().zip(row) {
                *sum += weight * g;
            }
        }
    }
}

impl Predictor {
    fn is_armax(&self) -> bool {
        matches!(self.noise, NoiseStructure::Armax { .. })
    }

    /// Number of parameters that all stretches share.
    pub(super) fn shared(&self) -> usize {
        let (nc, nd) = self.noise.own();
        self.orders.parameters(self.nu) + nc + nd
    }

    /// Number of parameters of each stretch.
    pub(super) fn past(&self) -> usize {
        if self.start == Start::Estimated && !self.is_armax() { self.orders.na } else { 0 }
    }

    /// Runs over a stretch and hands each prediction error to `sink` with the sample, and its
    /// gradient over the shared parameters and the past of this stretch; the gradient is empty
    /// unless `with_gradient`.
    pub(super) fn run(
        &self,
        shared: &[f64],
        past: &[f64],
        stretch: &Stretch,
        with_gradient: bool,
        mut sink: impl FnMut(f64, &[f64]),
    ) {
        let (orders, nu) = (self.orders, self.nu);
        let (n, na) = (orders.parameters(nu), orders.na);
        let (nc, _) = self.noise.own();
        let (theta, noise) = shared.split_at(n);
        let (a, c) = (&theta[..na], &noise[..nc]);
        // The columns of D: those of A for ARMAX, its own otherwise.
        let (d, d_columns) = if self.is_armax() { (a, 0) } else { (&noise[nc..], n + nc) };
        let width = if with_gradient { self.shared() + self.past() } else { 0 };
        let first = if self.is_armax() { orders.lag() } else { 0 };
        let before = if self.start == Start::Estimated { stretch.u.get(..nu) } else { None };

        let (mut w, mut v, mut e) =
            (Past::new(na, width), Past::new(d.len(), width), Past::new(nc, width));
        for (i, &value) in past.iter().enumerate() {
            w.set(i, value);
            if with_gradient {
                w.gradient_mut(i)[self.shared() + i] = 1.0;
            }
        }
        let (mut dw, mut dx) = (vec![0.0; width], vec![0.0; width]);
        for (k, &mu) in stretch.mu.iter().enumerate() {
            dw.fill(0.0);
            let mut simulated = 0.0;
            w.add_to(a, -1.0, &mut simulated, &mut dw);
            for (slope, past) in dw.iter_mut().zip(w.values()) {
                *slope -= past;
            }
            for i in 0..orders.nb {
                let row = match k.checked_sub(orders.delay + i) {
                    Some(at) => Some(&stretch.u[at * nu..(at + 1) * nu]),
                    None => before,
                };
                for (input, u) in row.unwrap_or_default().iter().enumerate() {
                    let place = na + i * nu + input;
                    simulated += theta[place] * u;
                    if let Some(slope) = dw.get_mut(place) {
                        *slope += u;
                    }
                }
            }
            if orders.offset {
                simulated += theta[n - 1];
                if let Some(slope) = dw.get_mut(n - 1) {
                    *slope += 1.0;
                }
            }

            // Expected noise v̂ = Σ c_i ε(k−i) − Σ d_i v(k−i), and its gradient.
            dx.fill(0.0);
            let mut expected = 0.0;
            e.add_to(c, 1.0, &mut expected, &mut dx);
            v.add_to(d, -1.0, &mut expected, &mut dx);
            if with_gradient {
                for (slope, past) in dx[n..n + nc].iter_mut().zip(e.values()) {
                    *slope += past;
                }
                for (slope, past) in dx[d_columns..].iter_mut().zip(v.values()) {
                    *slope -= past;
                }
            }

            let found = if mu.is_finite() {
                v.push(mu - simulated, dw.iter().map(|slope| -slope));
                k >= first
            } else {
                v.push(expected, dx.iter().copied());
                false
            };
            if found {
                let error = mu - simulated - expected;
                for (slope, simulated) in dx.iter_mut().zip(&dw) {
                    *slope = -*slope - simulated;
                }
                e.push(error, dx.iter().copied());
                sink(error, &dx);
            } else {
                dx.fill(0.0);
                e.push(0.0, dx.iter().copied());
            }
            w.push(simulated, dw.iter().copied());
        }
    }
}
