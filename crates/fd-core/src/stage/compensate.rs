//! From primary to compensated residuals.

use crate::{event::Events, frame::Frame, scalar::Scalar, snapshot::StateVisitor, stage::Stage};

/// Removes the estimated bias from the residual, `r* = r − μ̂`.
pub trait Compensator<T: Scalar = f64>: Stage<T> {
    /// Number of inputs `u`, or `None` if any number will do.
    fn nu(&self) -> Option<usize>;

    /// Number of residual channels.
    fn residual_len(&self) -> usize;

    /// Consumes one sample with its primary residual and writes the compensated residual.
    fn step(&mut self, frame: Frame<'_, T>, r: &[T], r_star: &mut [T]) -> Compensation;
}

/// What a compensator did with one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Compensation {
    /// Phase in which the sample was treated.
    pub phase: Phase,
    /// What happened.
    pub events: Events,
}

/// The two stages of Patton & Chen (1992), section 3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The switch is closed: the plant is taken as healthy and the bias is being learned.
    Training {
        /// Samples learned from in this phase.
        samples: u64,
    },
    /// The switch is open: parameters are frozen and the bias is subtracted.
    Compensating,
}

/// The compensator that does nothing, `r* = r`: the baseline that others are compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Uncompensated {
    residual_len: usize,
}

impl Uncompensated {
    /// A compensator for `residual_len` channels.
    ///
    /// ```
    /// # use fd_core::stage::{Compensator, Uncompensated};
    /// assert_eq!(Compensator::<f64>::residual_len(&Uncompensated::new(2)), 2);
    /// ```
    #[must_use]
    pub const fn new(residual_len: usize) -> Self {
        Self { residual_len }
    }
}

impl<T: Scalar> Stage<T> for Uncompensated {
    fn reset(&mut self) {}

    fn visit_state(&mut self, _visitor: &mut dyn StateVisitor<T>) {}
}

impl<T: Scalar> Compensator<T> for Uncompensated {
    fn nu(&self) -> Option<usize> {
        None
    }

    fn residual_len(&self) -> usize {
        self.residual_len
    }

    fn step(&mut self, _frame: Frame<'_, T>, r: &[T], r_star: &mut [T]) -> Compensation {
        r_star.copy_from_slice(r);
        Compensation { phase: Phase::Compensating, events: Events::none() }
    }
}
