//! Points of the grid, and what says where between them the plant is.

use fd_model::{Discrete, StateSpace};

/// The channel that says where the plant is, and over how many samples it is smoothed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SchedulingVariable {
    /// An input, by its index.
    Input {
        /// Index from 0.
        index: usize,
        /// Time constant of a low-pass, in samples; 0 takes it as it is.
        smoothing: f64,
    },
    /// An output, by its index.
    Output {
        /// Index from 0.
        index: usize,
        /// Time constant of a low-pass, in samples; 0 takes it as it is.
        smoothing: f64,
    },
}

/// A linear model about a steady state.
#[derive(Clone, Debug)]
pub struct ScheduledPoint {
    /// Value of the scheduling variable.
    pub at: f64,
    /// The model in deviations from the steady state.
    pub model: StateSpace<Discrete>,
    /// States there.
    pub x0: Vec<f64>,
    /// Inputs there.
    pub u0: Vec<f64>,
    /// Outputs there.
    pub y0: Vec<f64>,
}

impl ScheduledPoint {
    /// A model in absolute coordinates, or whose steady state is zero.
    #[must_use]
    pub fn about_zero(at: f64, model: StateSpace<Discrete>) -> Self {
        let (x0, u0, y0) = (vec![0.0; model.nx()], vec![0.0; model.nu()], vec![0.0; model.ny()]);
        Self { at, model, x0, u0, y0 }
    }
}

/// The point below a value, and how far it is to the next one; the ends hold outside. NaN counts as the first.
pub(super) fn position(points: impl Iterator<Item = f64>, value: f64) -> (usize, f64) {
    let (mut index, mut below, mut found) = (0, f64::NAN, (0, 0.0));
    for at in points {
        if index == 0 {
            below = at;
        } else if below <= value {
            found = (index - 1, ((value - below) / (at - below)).min(1.0));
            below = at;
        }
        index += 1;
    }
    found
}
