//! The prediction errors of one residual channel over all its stretches, as a sum of squares.

use faer::Mat;

use super::{
    gauss_newton::SumOfSquares,
    predictor::{Predictor, Stretch},
};
use crate::{arx::reflect, error::IdentError};

/// Parameters are the shared ones of the predictor, then the past of each stretch.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) predictor: Predictor,
    pub(super) stretches: Vec<Stretch>,
}

impl Problem {
    /// Number of all parameters.
    pub(super) fn parameters(&self) -> usize {
        self.predictor.shared() + self.predictor.past() * self.stretches.len()
    }

    /// Number of prediction errors.
    pub(super) fn rows(&self) -> usize {
        let mut rows = 0;
        self.each(&vec![0.0; self.parameters()], false, |_, _, _| rows += 1);
        rows
    }

    /// The past of one stretch.
    fn past<'a>(&self, p: &'a [f64], stretch: usize) -> &'a [f64] {
        let (shared, past) = (self.predictor.shared(), self.predictor.past());
        &p[shared + stretch * past..shared + (stretch + 1) * past]
    }

    fn each(&self, p: &[f64], with_gradient: bool, mut sink: impl FnMut(usize, f64, &[f64])) {
        let shared = &p[..self.predictor.shared()];
        for (index, stretch) in self.stretches.iter().enumerate() {
            let past = self.past(p, index);
            self.predictor.run(shared, past, stretch, with_gradient, |error, gradient| {
                sink(index, error, gradient);
            });
        }
    }
}

impl SumOfSquares for Problem {
    fn cost(&self, p: &[f64]) -> f64 {
        let mut cost = 0.0;
        self.each(p, false, |_, error, _| cost += error * error);
        cost
    }

    fn linearise(&self, p: &[f64]) -> (Mat<f64>, Mat<f64>) {
        let (shared, past, n) = (self.predictor.shared(), self.predictor.past(), self.parameters());
        let (mut errors, mut rows) = (Vec::new(), Vec::new());
        self.each(p, true, |stretch, error, gradient| {
            errors.push(error);
            let start = rows.len();
            rows.resize(start + n, 0.0);
            let row = &mut rows[start..];
            row[..shared].copy_from_slice(&gradient[..shared]);
            row[shared + stretch * past..][..past].copy_from_slice(&gradient[shared..]);
        });
        let jacobian = Mat::from_fn(errors.len(), n, |i, j| rows[i * n + j]);
        (jacobian, Mat::from_fn(errors.len(), 1, |i, _| errors[i]))
    }

    fn admit(&self, mut p: Vec<f64>) -> Result<Vec<f64>, IdentError> {
        let Predictor { orders, nu, noise, .. } = self.predictor;
        if p.iter().any(|v| !v.is_finite()) {
            // The cost there is NaN, so that the step is not taken.
            return Ok(p);
        }
        let n = orders.parameters(nu);
        let (nc, nd) = noise.own();
        let gain = reflect(&mut p[..orders.na])?;
        for b in &mut p[orders.na..n] {
            *b *= gain;
        }
        reflect(&mut p[n..n + nc])?;
        reflect(&mut p[n + nc..n + nc + nd])?;
        Ok(p)
    }
}
