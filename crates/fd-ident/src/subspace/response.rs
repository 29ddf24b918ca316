//! Inputs to outputs for known dynamics: a linear problem in `B`, `D`, the constant and the
//! initial states.

use std::borrow::Borrow;

use faer::{Mat, MatRef};
use fd_model::Record;

use crate::{
    arx::held_inputs,
    error::IdentError,
    least_squares::{Deficient, LeastSquares},
};

/// What least squares finds for given `A` and `C`.
pub(super) struct Response {
    pub b: Mat<f64>,
    pub d: Mat<f64>,
    pub offset: Vec<f64>,
    /// Mean squared error of each output.
    pub error: Vec<f64>,
}

pub(super) fn fit_response<R: Borrow<Record>>(
    a: MatRef<'_, f64>,
    c: MatRef<'_, f64>,
    records: &[R],
    offset: bool,
    from_rest: bool,
) -> Result<Response, IdentError> {
    let first = records[0].borrow();
    let (n, nu, ny) = (a.nrows(), first.inputs().len(), first.outputs().len());
    let constants = if offset { ny } else { 0 };
    let starts = if from_rest { 0 } else { n };
    let shared = n * nu + ny * nu + constants;
    let parameters = shared + starts * records.len();
    let (mut rows, mut target, mut channel_of) = (Vec::new(), Vec::new(), Vec::new());
    for (index, record) in records.iter().enumerate() {
        let record = record.borrow();
        let u = held_inputs(record);
        // One state vector per entry of B and per initial state.
        let mut states = Mat::<f64>::zeros(n, n * nu + starts);
        (0..starts).for_each(|i| states[(i, n * nu + i)] = 1.0);
        for k in 0..record.len() {
            let now = &u[k * nu..(k + 1) * nu];
            let seen = c * &states;
            for channel in 0..ny {
                let y = record.y(k)[channel];
                if !y.is_finite() {
                    continue;
                }
                let start = rows.len();
                rows.resize(start + parameters, 0.0);
                let row = &mut rows[start..];
                for i in 0..n * nu {
                    row[i] = seen[(channel, i)];
                }
                for (input, u) in now.iter().enumerate() {
                    row[n * nu + channel * nu + input] = *u;
                }
                if offset {
                    row[n * nu + ny * nu + channel] = 1.0;
                }
                for i in 0..starts {
                    row[shared + starts * index + i] = seen[(channel, n * nu + i)];
                }
                target.push(y);
                channel_of.push(channel);
            }
            states = a * &states;
            for i in 0..n {
                for (input, u) in now.iter().enumerate() {
                    states[(i, i * nu + input)] += u;
                }
            }
        }
    }
    let x = Mat::from_fn(target.len(), parameters, |i, j| rows[i * parameters + j]);
    // Modes that hardly show in the record leave their initial state open, which does not matter.
    let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
    let theta = solver.solve(x.as_ref(), &target)?.coefficients;

    let (mut error, mut count) = (vec![0.0; ny], vec![0.0; ny]);
    for ((row, y), &channel) in rows.chunks_exact(parameters).zip(&target).zip(&channel_of) {
        let predicted: f64 = row.iter().zip(&theta).map(|(x, theta)| x * theta).sum();
        error[channel] += (y - predicted).powi(2);
        count[channel] += 1.0;
    }
    error.iter_mut().zip(count).for_each(|(sum, count)| *sum /= f64::max(count, 1.0));
    let constant = |channel: usize| if offset { theta[n * nu + ny * nu + channel] } else { 0.0 };
    Ok(Response {
        b: Mat::from_fn(n, nu, |i, input| theta[i * nu + input]),
        d: Mat::from_fn(ny, nu, |channel, input| theta[n * nu + channel * nu + input]),
        offset: (0..ny).map(constant).collect(),
        error,
    })
}
