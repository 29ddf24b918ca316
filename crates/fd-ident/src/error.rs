//! What can go wrong while a bias model is designed or fitted.

use fd_core::ShapeError;
use fd_model::ModelError;
use thiserror::Error;

use crate::arx::ArxOrders;

/// A model cannot be identified, or an identifier cannot be built.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IdentError {
    /// Matrices, parameters or channels do not fit together.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// A model or record refused an operation.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A setting is outside the range in which the method is defined.
    #[error("{setting} must be {expected}, got {found}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Range in words.
        expected: &'static str,
        /// Value that was given.
        found: f64,
    },
    /// The orders leave nothing to estimate.
    #[error("orders {orders} leave no parameter to estimate for {nu} inputs")]
    NoParameters {
        /// Orders that were asked for.
        orders: ArxOrders,
        /// Number of inputs.
        nu: usize,
    },
    /// No record was given.
    #[error("at least one record is needed, got none")]
    NoRecords,
    /// The records do not have the same channels or sample time.
    #[error("record {record}: {what} is {found}, but record 0 has {expected}")]
    RecordMismatch {
        /// Index of the record.
        record: usize,
        /// What differs: `"number of inputs"`, `"number of residuals"`, `"sample time in s"`.
        what: &'static str,
        /// Value in record 0.
        expected: f64,
        /// Value in this record.
        found: f64,
    },
    /// A record does not have the channels of the model.
    #[error("{what} of the record is {found}, the model has {expected}")]
    ModelMismatch {
        /// What differs: `"number of inputs"` or `"number of residuals"`.
        what: &'static str,
        /// Value in the model.
        expected: usize,
        /// Value in the record.
        found: usize,
    },
    /// There are fewer complete rows than parameters.
    #[error(
        "residual {channel}: {parameters} parameters need more than {found} complete rows \
         ({skipped} rows were skipped for missing samples)"
    )]
    TooFewRows {
        /// Index of the residual channel.
        channel: usize,
        /// Number of parameters.
        parameters: usize,
        /// Rows without missing samples.
        found: usize,
        /// Rows skipped because a sample is missing.
        skipped: usize,
    },
    /// The data do not excite all parameters.
    #[error(
        "residual {channel}: the data do not excite all parameters, the regressor matrix \
         ({rows} rows) has rank {rank} of {parameters} and condition {condition:.1e}; excite the \
         input more, lower the orders, or accept the minimum-norm solution"
    )]
    RankDeficient {
        /// Index of the residual channel.
        channel: usize,
        /// Numerical rank.
        rank: usize,
        /// Number of parameters.
        parameters: usize,
        /// Rows used.
        rows: usize,
        /// Condition number of the regressor matrix with columns of equal length.
        condition: f64,
    },
    /// The regressor or the target holds an infinity or a NaN where none may be.
    #[error("{role}[{row}, {col}] must be finite, got {value}")]
    NonFinite {
        /// Role of the matrix.
        role: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        col: usize,
        /// Value that was found.
        value: f64,
    },
    /// A decomposition or an iteration did not converge.
    #[error("{what} did not converge")]
    NoConvergence {
        /// What was computed.
        what: &'static str,
    },
}

impl IdentError {
    /// The same error, seen from a problem with several residual channels.
    pub(crate) fn in_channel(self, channel: usize) -> Self {
        match self {
            Self::TooFewRows { parameters, found, skipped, .. } => {
                Self::TooFewRows { channel, parameters, found, skipped }
            }
            Self::RankDeficient { rank, parameters, rows, condition, .. } => {
                Self::RankDeficient { channel, rank, parameters, rows, condition }
            }
            other => other,
        }
    }

    /// The same error, with the number of rows that a compressed problem stands for.
    pub(crate) fn with_rows(self, rows: usize) -> Self {
        match self {
            Self::RankDeficient { channel, rank, parameters, condition, .. } => {
                Self::RankDeficient { channel, rank, parameters, rows, condition }
            }
            other => other,
        }
    }
}
