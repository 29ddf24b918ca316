//! Running the observer between grid points.

use faer::{Mat, MatRef};
use fd_core::{
    Frame, IoDims, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

use super::grid::{ScheduledPoint, SchedulingVariable, position};

/// A point of the grid at run time.
#[derive(Clone, Debug)]
pub(super) struct Local {
    at: f64,
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
    d: Vec<f64>,
    gain: Vec<f64>,
    x0: Vec<f64>,
    u0: Vec<f64>,
    y0: Vec<f64>,
}

impl Local {
    pub(super) fn of(point: &ScheduledPoint, gain: &Mat<f64>) -> Self {
        let rows = |m: MatRef<'_, f64>| {
            let all = (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| (i, j)));
            all.map(|at| m[at]).collect::<Vec<f64>>()
        };
        let m = &point.model;
        Self {
            at: point.at,
            a: rows(m.a()),
            b: rows(m.b()),
            c: rows(m.c()),
            d: rows(m.d()),
            gain: rows(gain.as_ref()),
            x0: point.x0.clone(),
            u0: point.u0.clone(),
            y0: point.y0.clone(),
        }
    }
}

/// An observer that interpolates its model; neither allocates nor fails per sample.
#[derive(Clone, Debug)]
pub struct ScheduledObserver {
    io: IoDims,
    locals: Vec<Local>,
    variable: SchedulingVariable,
    /// The smoothed variable; NaN before the first sample.
    value: f64,
    x: Vec<f64>,
    x_next: Vec<f64>,
    /// Deviations from the interpolated steady state.
    dx: Vec<f64>,
    du: Vec<f64>,
}

impl ScheduledObserver {
    pub(super) fn new(locals: Vec<Local>, variable: SchedulingVariable) -> Self {
        let first = &locals[0];
        let (x, du) = (first.x0.clone(), vec![0.0; first.u0.len()]);
        let io = IoDims { nu: first.u0.len(), ny: first.y0.len() };
        let value = f64::NAN;
        Self { io, variable, value, x_next: x.clone(), dx: x.clone(), du, x, locals }
    }

    /// The smoothed scheduling variable; NaN before the first sample.
    #[must_use]
    pub fn value(&self) -> f64 {
        self.value
    }

    fn follow(&mut self, frame: &Frame<'_, f64>) {
        let (now, smoothing) = match self.variable {
            SchedulingVariable::Input { index, smoothing } => (frame.u()[index], smoothing),
            SchedulingVariable::Output { index, smoothing } => (frame.y()[index], smoothing),
        };
        self.value = if self.value.is_nan() {
            now
        } else {
            self.value + (now - self.value) / (1.0 + smoothing)
        };
    }
}

/// `out += share · M v`, with `M` by rows.
fn add(out: &mut [f64], share: f64, m: &[f64], v: &[f64]) {
    if v.is_empty() {
        return;
    }
    for (out, row) in out.iter_mut().zip(m.chunks_exact(v.len())) {
        *out += share * row.iter().zip(v).map(|(m, v)| m * v).sum::<f64>();
    }
}

/// `out = now − mix(low, high)`.
fn deviation(out: &mut [f64], now: &[f64], [low, high]: [&[f64]; 2], share: f64) {
    for (((out, now), low), high) in out.iter_mut().zip(now).zip(low).zip(high) {
        *out = now - ((1.0 - share) * low + share * high);
    }
}

impl Stage for ScheduledObserver {
    fn reset(&mut self) {
        self.x.copy_from_slice(&self.locals[0].x0);
        self.value = f64::NAN;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<f64>) {
        visitor.reals("observer state", &mut self.x);
        // Nothing is known of it before the first sample.
        visitor.reals_with_holes("scheduling variable", std::slice::from_mut(&mut self.value));
    }
}

impl ResidualGenerator for ScheduledObserver {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.io.ny
    }

    fn step(&mut self, frame: Frame<'_, f64>, r: &mut [f64]) {
        self.follow(&frame);
        let (low, share) = position(self.locals.iter().map(|local| local.at), self.value);
        let high = (low + 1).min(self.locals.len() - 1);
        let (one, two) = (&self.locals[low], &self.locals[high]);
        deviation(&mut self.dx, &self.x, [&one.x0, &two.x0], share);
        deviation(&mut self.du, frame.u(), [&one.u0, &two.u0], share);
        deviation(r, frame.y(), [&one.y0, &two.y0], share);
        let sides = [(one, 1.0 - share), (two, share)];
        for (local, share) in sides {
            add(r, -share, &local.c, &self.dx);
            add(r, -share, &local.d, &self.du);
        }
        // x₀(ρ) = x − dx
        for ((next, x), dx) in self.x_next.iter_mut().zip(&self.x).zip(&self.dx) {
            *next = x - dx;
        }
        for (local, share) in sides {
            add(&mut self.x_next, share, &local.a, &self.dx);
            add(&mut self.x_next, share, &local.b, &self.du);
            add(&mut self.x_next, share, &local.gain, r);
        }
        std::mem::swap(&mut self.x, &mut self.x_next);
    }
}
