//! What a difference equation does to its inputs: frequency response and state-space form.

use std::f64::consts::PI;

use faer::{Mat, c64};
use fd_model::{Discrete, StateSpace};

use crate::{arx::ArxModel, error::IdentError};

impl ArxModel {
    /// Response of one residual channel to one input at a frequency in rad/s:
    /// `B(z)/A(z)` with `z = exp(jω Ts)`.
    #[must_use]
    pub fn frequency_response(&self, channel: usize, input: usize, omega: f64) -> c64 {
        // Powers of z⁻¹, so that high orders cannot overflow.
        let (sin, cos) = (omega * self.ts().seconds()).sin_cos();
        let backward = c64::new(cos, -sin);
        let horner = |coefficients: &[f64]| {
            coefficients
                .iter()
                .rev()
                .fold(c64::new(0.0, 0.0), |sum, &c| sum * backward + c64::new(c, 0.0))
        };
        let b: Vec<f64> = self.b(channel, input).collect();
        let delay = (0..self.orders().delay).fold(c64::new(1.0, 0.0), |z, _| z * backward);
        let one = c64::new(1.0, 0.0);
        delay * horner(&b) / (one + backward * horner(self.a(channel)))
    }

    /// Gain of one residual channel for a constant input; infinite for an integrator.
    #[must_use]
    pub fn dc_gain(&self, channel: usize, input: usize) -> f64 {
        self.b(channel, input).sum::<f64>() / (1.0 + self.a(channel).iter().sum::<f64>())
    }

    /// Largest difference of the frequency responses of two models over all channels and inputs,
    /// relative to the largest response of this one, on 100 frequencies up to half the sampling
    /// rate.
    ///
    /// Models of different orders, or with nearly cancelling poles and zeros, are compared by
    /// this and never by their parameters.
    ///
    /// # Panics
    ///
    /// Panics when `other` has fewer channels or inputs.
    #[must_use]
    pub fn response_distance(&self, other: &Self) -> f64 {
        const POINTS: i32 = 100;
        let nyquist = PI / self.ts().seconds();
        let (mut largest, mut difference) = (0.0_f64, 0.0_f64);
        for channel in 0..self.residual_len() {
            for input in 0..self.nu() {
                for i in 0..POINTS {
                    // Four decades below half the sampling rate.
                    let omega = nyquist * 10_f64.powf(-4.0 * f64::from(i) / f64::from(POINTS - 1));
                    let mine = self.frequency_response(channel, input, omega);
                    let others = other.frequency_response(channel, input, omega);
                    largest = largest.max(mine.norm());
                    difference = difference.max((mine - others).norm());
                }
            }
        }
        if difference > 0.0 { difference / largest } else { 0.0 }
    }

    /// The model in observer canonical form, one block of states per residual channel.
    ///
    /// The constant term is not part of a linear model and is left out; in steady state it adds
    /// `c / (1 + Σ aᵢ)` to the output.
    ///
    /// # Errors
    ///
    /// Never fails for a model that was checked by [`ArxModel::new`].
    pub fn to_state_space(&self) -> Result<StateSpace<Discrete>, IdentError> {
        let (lag, nu, ny) = (self.orders().lag(), self.nu(), self.residual_len());
        let a_of = |channel: usize, i: usize| self.a(channel).get(i).copied().unwrap_or(0.0);
        // Coefficient of z^−i, with the delay in it.
        let b_of = |channel: usize, input: usize, i: usize| {
            i.checked_sub(self.orders().delay)
                .and_then(|i| self.b(channel, input).nth(i))
                .unwrap_or(0.0)
        };
        let block = |row: usize| (row / lag.max(1), row % lag.max(1));

        let a = Mat::from_fn(lag * ny, lag * ny, |row, col| {
            let ((channel, i), (other, j)) = (block(row), block(col));
            match (channel == other, j) {
                (true, 0) => -a_of(channel, i),
                (true, _) => f64::from(u8::from(i + 1 == j)),
                (false, _) => 0.0,
            }
        });
        let b = Mat::from_fn(lag * ny, nu, |row, input| {
            let (channel, i) = block(row);
            b_of(channel, input, i + 1) - a_of(channel, i) * b_of(channel, input, 0)
        });
        let c = Mat::from_fn(ny, lag * ny, |channel, col| {
            f64::from(u8::from(block(col) == (channel, 0)))
        });
        let d = Mat::from_fn(ny, nu, |channel, input| b_of(channel, input, 0));
        Ok(StateSpace::new(a, b, c, d, Discrete { ts: self.ts() })?)
    }
}
