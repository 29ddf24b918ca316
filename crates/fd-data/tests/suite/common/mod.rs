//! Random plants and logs of them.
#![allow(dead_code, unreachable_pub, clippy::unwrap_used, reason = "each test uses its own part")]

use faer::Mat;
use fd_model::{Channel, Record, SampleTime};
use fd_numeric::dense::Dense;
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

pub struct Source(Xoshiro256PlusPlus);

impl Source {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    pub fn matrix(&mut self, rows: usize, columns: usize) -> Mat<f64> {
        Mat::from_fn(rows, columns, |_, _| self.normal())
    }

    /// Rotations of a random matrix.
    pub fn rotation(&mut self, n: usize) -> Mat<f64> {
        self.matrix(n, n).factor_qr().compute_thin_Q()
    }

    /// Singular values between 1/2 and 2.
    pub fn invertible(&mut self, n: usize) -> Mat<f64> {
        let (u, v) = (self.rotation(n), self.rotation(n));
        let d = Mat::from_fn(n, n, |i, j| {
            if i == j { 2.0_f64.powf(self.0.random_range(-1.0..1.0)) } else { 0.0 }
        });
        u * d * v
    }
}

/// `x⁺ = A x + B u + w`, `y = C x + D u + v`.
#[derive(Clone, Debug)]
pub struct Plant {
    pub a: Mat<f64>,
    pub b: Mat<f64>,
    pub c: Mat<f64>,
    pub d: Mat<f64>,
}

impl Plant {
    /// Modes of magnitude 0.2 to 0.9, seen from all outputs and moved by all inputs.
    pub fn random(n: usize, nu: usize, ny: usize, seed: u64) -> Self {
        let mut source = Source::new(seed);
        let modes = Mat::from_fn(n, n, |i, j| {
            if i == j {
                (0.9 - 0.7 * i as f64 / n as f64) * if i % 3 == 1 { -1.0 } else { 1.0 }
            } else {
                0.0
            }
        });
        let t = source.rotation(n);
        let a = &t * modes * t.transpose();
        Self { a, b: source.matrix(n, nu), c: source.matrix(ny, n), d: source.matrix(ny, nu) }
    }

    /// Samples under white inputs, with so much noise on states and outputs.
    pub fn log(&self, samples: usize, noise: f64, seed: u64) -> Record {
        let mut source = Source::new(seed);
        let (nu, ny) = (self.b.ncols(), self.c.nrows());
        let mut x = source.matrix(self.a.nrows(), 1);
        let (mut us, mut ys) = (Vec::new(), Vec::new());
        for _ in 0..samples {
            let u = source.matrix(nu, 1);
            let y = &self.c * &x + &self.d * &u;
            us.extend((0..nu).map(|i| u[(i, 0)]));
            ys.extend((0..ny).map(|i| y[(i, 0)] + noise * source.normal()));
            x = &self.a * &x + &self.b * &u;
            for i in 0..x.nrows() {
                x[(i, 0)] += noise * source.normal();
            }
        }
        record(nu, ny, us, ys)
    }
}

pub fn record(nu: usize, ny: usize, us: Vec<f64>, ys: Vec<f64>) -> Record {
    let ts = SampleTime::new(1.0).unwrap();
    Record::new(Channel::numbered("u", nu), Channel::numbered("y", ny), us, ys, ts).unwrap()
}

/// The same log seen through matrices on its inputs and outputs.
pub fn through(log: &Record, of_u: &Mat<f64>, of_y: &Mat<f64>) -> Record {
    let apply = |m: &Mat<f64>, values: &[f64]| -> Vec<f64> {
        (0..m.nrows()).map(|i| (0..values.len()).map(|j| m[(i, j)] * values[j]).sum()).collect()
    };
    let us = log.samples().flat_map(|(u, _)| apply(of_u, u)).collect();
    let ys = log.samples().flat_map(|(_, y)| apply(of_y, y)).collect();
    record(of_u.nrows(), of_y.nrows(), us, ys)
}
