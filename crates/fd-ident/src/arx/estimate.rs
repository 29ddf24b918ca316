//! How far a fitted difference equation can be trusted.

use std::borrow::Borrow;

use fd_model::Record;

use crate::{
    arx::{ArxModel, check::check_records},
    diagnostics::{Independence, Stretch, Whiteness, independence, whiteness},
    error::IdentError,
    least_squares::LinearFit,
};

/// A fitted model and, per residual channel, the least-squares problem that gave it.
#[derive(Clone, Debug, PartialEq)]
pub struct ArxEstimate {
    /// The difference equations.
    pub model: ArxModel,
    /// Covariance, noise variance, rows, rank and condition of each residual channel.
    pub channels: Vec<LinearFit>,
}

/// Tests of the one-step errors of one residual channel.
#[derive(Clone, Debug, PartialEq)]
pub struct ArxDiagnosis {
    /// Whether the errors are white.
    pub whiteness: Whiteness,
    /// Whether they depend on inputs older than those in the regressor, per input.
    pub independence: Vec<Independence>,
}

impl ArxEstimate {
    /// Standard errors of all parameters, in the order of [`ArxModel::theta`].
    #[must_use]
    pub fn standard_errors(&self) -> Vec<f64> {
        self.channels.iter().flat_map(LinearFit::standard_errors).collect()
    }
}

impl ArxModel {
    /// Tests the one-step errors on records for whiteness over `lags` lags, and for dependence
    /// on the `lags` inputs before those in the regressor.
    ///
    /// # Errors
    ///
    /// Returns an error when the records do not have the channels of the model, or are too short
    /// for this many lags.
    pub fn diagnose<R: Borrow<Record>>(
        &self,
        records: &[R],
        lags: usize,
    ) -> Result<Vec<ArxDiagnosis>, IdentError> {
        self.check_channels(check_records(records)?)?;
        let ny = self.residual_len();
        let predictions: Vec<Vec<f64>> =
            records.iter().map(|record| self.predict_record(record.borrow())).collect();
        let inputs = |input: usize| -> Vec<Stretch> {
            records.iter().map(|record| record.borrow().input(input).collect()).collect()
        };
        let first = self.orders().delay + self.orders().nb;
        let diagnose = |channel: usize| {
            let errors_of = |(record, predictions): (&R, &Vec<f64>)| -> Stretch {
                let measured = record.borrow().output(channel);
                measured.zip(predictions.chunks(ny)).map(|(mu, row)| mu - row[channel]).collect()
            };
            let errors: Vec<Stretch> = records.iter().zip(&predictions).map(errors_of).collect();
            let independence = (0..self.nu())
                .map(|input| independence(&errors, &inputs(input), first..=first + lags - 1))
                .collect::<Result<_, _>>()?;
            let whiteness = whiteness(&errors, lags, self.orders().na)?;
            Ok(ArxDiagnosis { whiteness, independence })
        };
        (0..ny).map(diagnose).collect()
    }
}
