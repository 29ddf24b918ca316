//! The prediction errors of one residual channel over all its stretches, as a sum of squares.

use super::{
    bordered::Bordered,
    gauss_newton::SumOfSquares,
    predictor::{Predictor, Stretch},
};
use crate::{arx::reflect, columns::from_rows, error::IdentError};

/// Parameters are the shared ones of the predictor, then the past of each stretch.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub predictor: Predictor,
    pub stretches: Vec<Stretch>,
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

    fn linearise(&self, p: &[f64]) -> Bordered {
        let (shared, own) = (self.predictor.shared(), self.predictor.past());
        let width = own + shared + 1;
        let mut rows: Vec<Vec<f64>> = vec![Vec::new(); self.stretches.len()];
        self.each(p, true, |stretch, error, gradient| {
            let rows = &mut rows[stretch];
            rows.extend_from_slice(&gradient[shared..]);
            rows.extend_from_slice(&gradient[..shared]);
            rows.push(error);
        });
        let block = |rows: &Vec<f64>| from_rows(rows, rows.len() / width, width);
        Bordered { own, shared, blocks: rows.iter().map(block).collect() }
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
