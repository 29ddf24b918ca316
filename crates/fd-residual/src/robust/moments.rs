//! Covariances of a window, healthy and faulty.

use faer::{Mat, MatRef, Scale};
use fd_model::{Discrete, StateSpace, lyapunov};

use crate::{
    analysis::UnknownInputs,
    error::DesignError,
    matrix::blocks,
    model_detection::PlantModel,
    parity::{input_map, observability},
};

/// What faults look like within a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultShape {
    /// Anything, as white as noise.
    White,
    /// Constant, and for so long that the plant has settled: incipient faults. Not for plants that integrate.
    Lasting,
}

/// Of one model.
pub(super) struct Moments {
    /// Covariance of `[Y; U]` without a fault.
    pub healthy: Mat<f64>,
    /// What faults of unit size add, each by itself, summed.
    pub faulty: Mat<f64>,
}

impl Moments {
    pub(super) fn of(
        model: &PlantModel<Discrete>,
        faults: &UnknownInputs,
        order: usize,
        shape: FaultShape,
    ) -> Result<Self, DesignError> {
        let plant = model.plant();
        let nu = (order + 1) * plant.nu();
        let noise = model.disturbances().and(model.noise())?.system(plant)?;
        let all_b = blocks(&[&[plant.b(), noise.b()]]);
        let start = lyapunov::discrete(plant.a(), (&all_b * all_b.transpose()).as_ref())?;

        let map = |g: &StateSpace<Discrete>| input_map(g.a(), g.b(), g.c(), g.d(), order);
        let (gamma, t, tw) = (observability(plant.a(), plant.c(), order), map(plant), map(&noise));
        let y = &gamma * start * gamma.transpose() + &t * t.transpose() + &tw * tw.transpose();
        let healthy = blocks(&[
            &[y.as_ref(), t.as_ref()],
            &[t.transpose(), Mat::<f64>::identity(nu, nu).as_ref()],
        ]);

        let gf = faults.system(plant)?;
        let entry = match shape {
            FaultShape::White => Scale(((order + 1) as f64).sqrt().recip()) * map(&gf),
            FaultShape::Lasting => repeated(gf.dc_gain()?.as_ref(), order + 1),
        };
        let rows = y.nrows() + nu;
        let mut faulty = Mat::zeros(rows, rows);
        faulty.submatrix_mut(0, 0, y.nrows(), y.nrows()).copy_from(&entry * entry.transpose());
        Ok(Self { healthy, faulty })
    }
}

fn repeated(gain: MatRef<'_, f64>, times: usize) -> Mat<f64> {
    let ny = gain.nrows();
    Mat::from_fn(times * ny, gain.ncols(), |i, j| gain[(i % ny, j)])
}
