//! A bias model of any structure, at run time.

use fd_core::{
    StateVisitor,
    stage::{BiasModel, Stage},
};
use fd_ident::{
    arx::ArxSimulator, hammerstein::Expanded, scheduled::ScheduledSimulator,
    subspace::StateSpaceSimulator,
};

/// A running bias model; unlike a `Box<dyn BiasModel>` it can be copied, which the compensator
/// needs for its predictor.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum RunningBias {
    /// One difference equation per residual channel.
    Linear(ArxSimulator),
    /// Functions of the inputs before the equations.
    Hammerstein(Expanded<f64, ArxSimulator>),
    /// Local equations, blended over the operating range.
    Scheduled(ScheduledSimulator),
    /// One state-space model for all channels.
    StateSpace(StateSpaceSimulator),
}

impl RunningBias {
    fn get(&self) -> &dyn BiasModel {
        match self {
            Self::Linear(model) => model,
            Self::Hammerstein(model) => model,
            Self::Scheduled(model) => model,
            Self::StateSpace(model) => model,
        }
    }

    fn get_mut(&mut self) -> &mut dyn BiasModel {
        match self {
            Self::Linear(model) => model,
            Self::Hammerstein(model) => model,
            Self::Scheduled(model) => model,
            Self::StateSpace(model) => model,
        }
    }
}

impl Stage for RunningBias {
    fn reset(&mut self) {
        self.get_mut().reset();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        self.get_mut().visit_state(visitor);
    }
}

impl BiasModel for RunningBias {
    fn nu(&self) -> usize {
        self.get().nu()
    }

    fn residual_len(&self) -> usize {
        self.get().residual_len()
    }

    fn theta_len(&self) -> usize {
        self.get().theta_len()
    }

    fn load(&mut self, theta: &[f64]) {
        self.get_mut().load(theta);
    }

    fn observe(&mut self, u: &[f64], mu: &[f64]) {
        self.get_mut().observe(u, mu);
    }

    fn simulate(&mut self, u: &[f64], mu_hat: &mut [f64]) {
        self.get_mut().simulate(u, mu_hat);
    }

    fn predict(&mut self, u: &[f64], r: &[f64], mu_hat: &mut [f64]) {
        self.get_mut().predict(u, r, mu_hat);
    }
}
