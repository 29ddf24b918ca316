//! What stands for the real engine: a perturbed linear one, or the nonlinear one.

use fd_core::{Heap, IoDims, stage::Plant};
use fd_jetengine::engine17::{Engine17, NX, NY, Sampled, Trim};
use fd_model::Lti;

/// An engine that is driven and measured in relative deviations from where it stands.
#[derive(Clone, Debug)]
pub(super) enum Reality {
    /// A linear model.
    Linear(Lti<f64, Heap>),
    /// The nonlinear engine about one of its equilibria.
    Nonlinear(Box<Relative>),
}

/// The nonlinear engine in relative deviations from an equilibrium of its own.
#[derive(Clone, Debug)]
pub(super) struct Relative {
    plant: Sampled<Engine17<f64>, NX>,
    fuel: f64,
    y: [f64; NY],
}

impl Relative {
    pub(super) fn new(plant: Sampled<Engine17<f64>, NX>, trim: &Trim) -> Self {
        Self { plant, fuel: trim.fuel, y: trim.outputs() }
    }
}

impl Plant for Relative {
    fn nx(&self) -> usize {
        NX
    }

    fn io(&self) -> IoDims {
        self.plant.io()
    }

    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        self.plant.advance(x, &[self.fuel * (1.0 + u[0])], x_next);
    }

    fn output(&self, x: &[f64], u: &[f64], y: &mut [f64]) {
        self.plant.output(x, u, y);
        for (y, reference) in y.iter_mut().zip(self.y) {
            *y = *y / reference - 1.0;
        }
    }
}

impl Plant for Reality {
    fn nx(&self) -> usize {
        match self {
            Self::Linear(plant) => plant.nx(),
            Self::Nonlinear(plant) => plant.nx(),
        }
    }

    fn io(&self) -> IoDims {
        match self {
            Self::Linear(plant) => plant.io(),
            Self::Nonlinear(plant) => plant.io(),
        }
    }

    fn advance(&self, x: &[f64], u: &[f64], x_next: &mut [f64]) {
        match self {
            Self::Linear(plant) => plant.advance(x, u, x_next),
            Self::Nonlinear(plant) => plant.advance(x, u, x_next),
        }
    }

    fn output(&self, x: &[f64], u: &[f64], y: &mut [f64]) {
        match self {
            Self::Linear(plant) => plant.output(x, u, y),
            Self::Nonlinear(plant) => plant.output(x, u, y),
        }
    }
}
