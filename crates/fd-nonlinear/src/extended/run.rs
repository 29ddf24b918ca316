//! Running the extended Kalman filter.

use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

use super::{
    kept::KeptSlopes,
    slopes::{moved, slope, step_along},
};
use crate::{
    gaussian::{Deviations, Estimate, GaussianFilter},
    model::StateEquations,
    noise::NoisyModel,
};

/// A running extended Kalman filter; its residual is the innovation.
#[derive(Clone, Debug)]
pub struct ExtendedKalman {
    equations: Box<dyn StateEquations>,
    io: IoDims,
    estimate: Estimate,
    deviations: Deviations,
    /// A state to be asked about, and what is answered at both ends of a step: states, or outputs.
    asked: Vec<f64>,
    ends: [Vec<f64>; 2],
    next: Vec<f64>,
    /// Slopes that are renewed in turns; without them all are new at every sample.
    kept: Option<KeptSlopes>,
}

impl ExtendedKalman {
    pub(super) fn new(model: &NoisyModel, samples: usize) -> Self {
        let (nx, io) = (model.nx(), model.io());
        let longest = nx.max(io.ny);
        Self {
            equations: model.equations(),
            io,
            estimate: Estimate::new(model, nx),
            deviations: Deviations::new(nx, io.ny, nx),
            asked: vec![0.0; nx],
            ends: [vec![0.0; longest], vec![0.0; longest]],
            next: vec![0.0; nx],
            kept: (1 < samples).then(|| KeptSlopes::new(nx, samples)),
        }
    }

    /// Estimate of the state from all samples so far.
    #[must_use]
    pub fn state(&self) -> &[f64] {
        &self.estimate.x
    }
}

impl GaussianFilter for ExtendedKalman {
    fn predict(&mut self, u: &[f64]) -> bool {
        let Self { equations, estimate, deviations, asked, ends, next, kept, .. } = self;
        let (sample, Some(before)) = estimate.at() else {
            // It begins anew, maybe far from where the slopes were taken.
            kept.iter_mut().for_each(KeptSlopes::forget);
            return true;
        };
        let nx = estimate.nx();
        equations.advance(sample - 1, &estimate.x, before, u, next);
        if let Some(kept) = kept {
            let at = (&*estimate, [before, u]);
            kept.along_the_factor(equations, at, (asked, ends), &mut deviations.x);
        } else {
            for column in 0..nx {
                let step = step_along(&estimate.x, &estimate.s, column);
                for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
                    if let Some(step) = step {
                        moved(&estimate.x, &estimate.s, column, sign * step, asked);
                        equations.advance(sample - 1, asked, before, u, &mut end[..nx]);
                    }
                }
                for i in 0..nx {
                    deviations.x[i * nx + column] = slope(ends, i, step);
                }
            }
        }
        let is_finite = next.iter().chain(&deviations.x).all(|value| value.is_finite());
        if is_finite {
            estimate.x.copy_from_slice(next);
            estimate.predict(deviations);
        } else {
            kept.iter_mut().for_each(KeptSlopes::forget);
        }
        is_finite
    }

    fn innovate(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) -> bool {
        let Self { equations, estimate, deviations, asked, ends, io, .. } = self;
        let (nx, ny, u) = (estimate.nx(), io.ny, frame.u());
        let (sample, _) = estimate.at();
        equations.output(sample, &estimate.x, u, r);
        r.iter_mut().zip(frame.y()).for_each(|(r, y)| *r = y - *r);
        for column in 0..nx {
            let step = step_along(&estimate.x, &estimate.s, column);
            for (end, sign) in ends.iter_mut().zip([1.0, -1.0]) {
                if let Some(step) = step {
                    moved(&estimate.x, &estimate.s, column, sign * step, asked);
                    equations.output(sample, asked, u, &mut end[..ny]);
                }
            }
            for i in 0..ny {
                deviations.y[i * nx + column] = slope(ends, i, step);
            }
        }
        deviations.x.copy_from_slice(&estimate.s);
        r.iter().chain(&deviations.y).all(|value| value.is_finite())
    }

    fn carried(&mut self) -> (&mut Estimate, &Deviations) {
        (&mut self.estimate, &self.deviations)
    }
}

impl Stage for ExtendedKalman {
    fn reset(&mut self) {
        self.estimate.restart();
        self.kept.iter_mut().for_each(KeptSlopes::forget);
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        self.estimate.visit_state(visitor);
        if let Some(kept) = &mut self.kept {
            kept.visit_state(visitor);
        }
    }
}

impl ResidualGenerator for ExtendedKalman {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.io.ny
    }

    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        self.filter(frame, r);
    }
}
