//! Running a map of a window, and the window itself.

use fd_core::{
    Frame, HeapMap, IoDims, LinMap, Scalar, StateVisitor,
    stage::{ResidualGenerator, Stage},
};

/// The last samples of `[u; y]`, oldest first.
#[derive(Clone, Debug)]
pub(crate) struct SlidingWindow<T> {
    samples: Vec<T>,
    width: usize,
    missing: u64,
    length: u64,
}

impl<T: Scalar> SlidingWindow<T> {
    pub(crate) fn new(io: IoDims, order: usize) -> Self {
        let (width, length) = (io.nu + io.ny, order as u64 + 1);
        Self { samples: vec![T::zero(); (order + 1) * width], width, missing: length, length }
    }

    /// Drops the oldest sample and appends the newest; the whole window when it is full.
    pub(crate) fn push(&mut self, frame: Frame<'_, T>) -> Option<&[T]> {
        self.samples.copy_within(self.width.., 0);
        let start = self.samples.len() - self.width;
        let (u, y) = (frame.u(), frame.y());
        self.samples[start..start + u.len()].copy_from_slice(u);
        self.samples[start + u.len()..].copy_from_slice(y);
        self.missing = self.missing.saturating_sub(1);
        (self.missing == 0).then_some(&self.samples)
    }

    pub(crate) fn reset(&mut self) {
        self.samples.fill(T::zero());
        self.missing = self.length;
    }

    pub(crate) fn visit(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("window of samples", &mut self.samples);
        visitor.counts("samples missing in the window", std::slice::from_mut(&mut self.missing));
    }
}

/// A residual that is linear in the last samples; zero until there are enough of them.
#[derive(Clone, Debug)]
pub struct WindowMap<T: Scalar> {
    io: IoDims,
    map: HeapMap<T>,
    constant: Vec<T>,
    window: SlidingWindow<T>,
}

impl<T: Scalar> WindowMap<T> {
    pub(super) fn new(io: IoDims, order: usize, map: HeapMap<T>, constant: &[f64]) -> Self {
        let constant = constant.iter().map(|&c| T::from_design(c)).collect();
        Self { io, map, constant, window: SlidingWindow::new(io, order) }
    }
}

impl<T: Scalar> Stage<T> for WindowMap<T> {
    fn reset(&mut self) {
        self.window.reset();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.window.visit(visitor);
    }
}

impl<T: Scalar> ResidualGenerator<T> for WindowMap<T> {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.constant.len()
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        let Some(window) = self.window.push(frame) else {
            r.fill(T::zero());
            return;
        };
        r.copy_from_slice(&self.constant);
        self.map.mul_add_into(window, r);
    }
}
