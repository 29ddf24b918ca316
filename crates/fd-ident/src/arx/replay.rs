//! Difference equations run over a whole record, by prediction and by simulation.

use faer::Mat;
use fd_core::stage::BiasModel;
use fd_model::Record;
use fd_numeric::dot;

use crate::{
    arx::{ArxModel, regression::regressor},
    error::IdentError,
    least_squares::{Deficient, LeastSquares},
};

/// What a simulation takes for the bias before the record begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// Inputs and bias are zero before the first sample, as in
    /// [`ArxSimulator`](crate::arx::ArxSimulator).
    #[default]
    Rest,
    /// The first samples of the record, as many as the equation looks back, are taken as they
    /// were measured.
    Measured,
    /// The input was that of the first sample all along, and the past bias is what makes the
    /// simulation fit the record best in the sense of least squares.
    Estimated,
}

impl ArxModel {
    /// One-step predictions `φᵀ(k) θ` from measured past, row-major like the outputs of a
    /// record. NaN where the past is not known: in the first samples and after missing ones.
    ///
    /// # Panics
    ///
    /// Panics when the record has fewer channels than the model, as indexing does.
    #[must_use]
    pub fn predict_record(&self, record: &Record) -> Vec<f64> {
        let mut predictions = vec![f64::NAN; record.len() * self.residual_len()];
        let rows = predictions.chunks_exact_mut(self.residual_len());
        for (k, row) in rows.enumerate().skip(self.orders().lag()) {
            for (channel, prediction) in row.iter_mut().enumerate() {
                let phi = regressor(self.orders(), record, channel, k);
                *prediction = phi.zip(self.channel(channel)).map(|(phi, theta)| phi * theta).sum();
            }
        }
        predictions
    }

    /// Simulates the record from its inputs alone, row-major like the outputs of a record.
    ///
    /// A missing input is held at its last value (its first value before that, zero if there is
    /// none), since a simulation cannot leave a sample out.
    ///
    /// # Errors
    ///
    /// Returns an error when the record has other channels than the model, when
    /// [`Start::Measured`] meets a missing sample, or when [`Start::Estimated`] has too few
    /// samples.
    pub fn simulate_record(&self, record: &Record, start: Start) -> Result<Vec<f64>, IdentError> {
        self.check_channels(record)?;
        let inputs = held_inputs(record);
        let ny = self.residual_len();
        let mut simulated = vec![0.0; record.len() * ny];
        let mut simulator = self.freeze::<f64>()?;
        let rows = simulated.chunks_exact_mut(ny).zip(inputs.chunks_exact(self.nu().max(1)));
        match start {
            Start::Rest => rows.for_each(|(mu, u)| simulator.simulate(u, mu)),
            Start::Measured => {
                for (k, (mu, u)) in rows.enumerate() {
                    if k < self.orders().lag() {
                        check_measured(k, record.y(k))?;
                        mu.copy_from_slice(record.y(k));
                        simulator.observe(u, mu);
                    } else {
                        simulator.simulate(u, mu);
                    }
                }
            }
            Start::Estimated => {
                let zero = vec![0.0; ny];
                if let Some(first) = inputs.chunks_exact(self.nu().max(1)).next() {
                    (0..self.orders().lag()).for_each(|_| simulator.observe(first, &zero));
                }
                rows.for_each(|(mu, u)| simulator.simulate(u, mu));
                for channel in 0..ny {
                    self.add_free_response(channel, record, &mut simulated)?;
                }
            }
        }
        Ok(simulated)
    }

    /// Root mean square of `μ − μ̂` in each channel for a simulation of the record, over the
    /// samples that are there and not used as the start. Infinite when the simulation overflows.
    ///
    /// # Errors
    ///
    /// As [`ArxModel::simulate_record`].
    pub fn simulation_rms(&self, record: &Record, start: Start) -> Result<Vec<f64>, IdentError> {
        let simulated = self.simulate_record(record, start)?;
        let ny = self.residual_len();
        let from = if start == Start::Measured { self.orders().lag() } else { 0 };
        let rms = |channel: usize| {
            let errors = (from..record.len())
                .filter(|&k| record.y(k)[channel].is_finite())
                .map(|k| record.y(k)[channel] - simulated[k * ny + channel]);
            let (count, sum) =
                errors.fold((0, 0.0), |(count, sum), e| (count + 1, sum + e.powi(2)));
            if sum.is_nan() { f64::INFINITY } else { (sum / f64::from(count.max(1))).sqrt() }
        };
        Ok((0..ny).map(rms).collect())
    }

    /// Adds the free response to the past bias that fits the record best.
    fn add_free_response(
        &self,
        channel: usize,
        record: &Record,
        simulated: &mut [f64],
    ) -> Result<(), IdentError> {
        let (na, ny) = (self.orders().na, self.residual_len());
        let there: Vec<usize> =
            (0..record.len()).filter(|&k| record.y(k)[channel].is_finite()).collect();
        if na == 0 {
            return Ok(());
        }
        let free: Vec<Vec<f64>> =
            (0..na).map(|j| free_response(self.a(channel), j, record.len())).collect();
        let x = Mat::from_fn(there.len(), na, |i, j| free[j][there[i]]);
        let y: Vec<f64> =
            there.iter().map(|&k| record.y(k)[channel] - simulated[k * ny + channel]).collect();
        // Free responses of fast or nearly equal modes are hard to tell apart, and then need
        // not be.
        let solver = LeastSquares::new().when_deficient(Deficient::MinimumNorm);
        let past = solver.solve(x.as_ref(), &y)?.coefficients;
        for k in 0..record.len() {
            simulated[k * ny + channel] +=
                past.iter().zip(&free).map(|(past, free)| past * free[k]).sum::<f64>();
        }
        Ok(())
    }

    pub(crate) fn check_channels(&self, record: &Record) -> Result<(), IdentError> {
        let pairs = [
            ("number of inputs", self.nu(), record.inputs().len()),
            ("number of residuals", self.residual_len(), record.outputs().len()),
        ];
        for (what, expected, found) in pairs {
            if expected != found {
                return Err(IdentError::ModelMismatch { what, expected, found });
            }
        }
        Ok(())
    }
}

/// Response to `μ(−1−j) = 1` with all else zero.
fn free_response(a: &[f64], j: usize, len: usize) -> Vec<f64> {
    let mut past = vec![0.0; a.len()];
    past[j] = 1.0;
    let step = |_| {
        let value = -dot(a, &past);
        past.rotate_right(1);
        past[0] = value;
        value
    };
    (0..len).map(step).collect()
}

/// Inputs of a record, row-major, with missing values held. One value per sample without inputs.
pub(crate) fn held_inputs(record: &Record) -> Vec<f64> {
    let nu = record.inputs().len();
    let mut held = vec![0.0; nu.max(1)];
    for (input, held) in held.iter_mut().enumerate().take(nu) {
        *held = record.input(input).find(|v| v.is_finite()).unwrap_or(0.0);
    }
    let mut inputs = Vec::with_capacity(record.len() * nu);
    for k in 0..record.len() {
        for (held, &u) in held.iter_mut().zip(record.u(k)) {
            if u.is_finite() {
                *held = u;
            }
        }
        inputs.extend_from_slice(&held);
    }
    inputs
}

fn check_measured(row: usize, mu: &[f64]) -> Result<(), IdentError> {
    match mu.iter().position(|v| !v.is_finite()) {
        Some(col) => {
            Err(IdentError::NonFinite { role: "measured start", row, col, value: mu[col] })
        }
        None => Ok(()),
    }
}
