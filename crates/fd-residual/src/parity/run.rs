//! Running the parity relations.

use std::fmt::Debug;

use fd_core::{
    Buffer, Fixed, Frame, Heap, HeapMap, IoDims, LinMap, Scalar, Shape, ShapeError, StateVisitor,
    Storage,
    stage::{ResidualGenerator, Stage},
};

/// Where a window of samples and its parity matrices live: on the [`Heap`], or with sizes known to the
/// compiler ([`FixedWindow`]).
///
/// ```
/// use faer::mat;
/// use fd_core::Heap;
/// use fd_model::{Discrete, SampleTime, StateSpace};
/// use fd_residual::{
///     DesignError,
///     parity::{FixedWindow, Parity, ParityDesign, Window},
/// };
///
/// fn running<S: Window<f32>>(design: &ParityDesign) -> Result<Parity<f32, S>, DesignError> {
///     design.freeze()
/// }
///
/// // Order 1: two outputs and two inputs in the window, one relation between them.
/// let domain = Discrete { ts: SampleTime::new(0.1)? };
/// let lag = StateSpace::new(mat![[0.9]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
/// let design = ParityDesign::all(&lag, 1)?;
/// assert!(running::<Heap>(&design).is_ok());
/// assert!(running::<FixedWindow<1, 2, 2>>(&design).is_ok());
/// assert!(running::<FixedWindow<1, 3, 3>>(&design).is_err());
/// # Ok::<(), DesignError>(())
/// ```
pub trait Window<T: Scalar>: Clone + Debug + Send + Sync {
    /// Outputs of the window.
    type Ys: Buffer<T>;
    /// Inputs of the window.
    type Us: Buffer<T>;
    /// Residual from outputs.
    type FromY: LinMap<T>;
    /// Residual from inputs.
    type FromU: LinMap<T>;
}

impl<T: Scalar> Window<T> for Heap {
    type Ys = Vec<T>;
    type Us = Vec<T>;
    type FromY = HeapMap<T>;
    type FromU = HeapMap<T>;
}

/// Window of `YS = (s + 1) · ny` output and `US = (s + 1) · nu` input values for `ROWS` parity
/// vectors, all known to the compiler.
#[derive(Clone, Copy, Debug)]
pub struct FixedWindow<const ROWS: usize, const YS: usize, const US: usize>;

impl<T: Scalar, const ROWS: usize, const YS: usize, const US: usize> Window<T>
    for FixedWindow<ROWS, YS, US>
{
    type Ys = [T; YS];
    type Us = [T; US];
    type FromY = <Fixed<YS, US, ROWS> as Storage<T>>::Yx;
    type FromU = <Fixed<YS, US, ROWS> as Storage<T>>::Yu;
}

/// A sliding window of samples multiplied by the parity matrices.
///
/// The residual is zero until the window is full.
#[derive(Clone, Debug)]
pub struct Parity<T: Scalar, S: Window<T> = Heap> {
    io: IoDims,
    from_y: S::FromY,
    from_u: S::FromU,
    ys: S::Ys,
    us: S::Us,
    /// Samples that are still missing in the window.
    missing: u64,
    order: u64,
}

impl<T: Scalar, S: Window<T>> Parity<T, S> {
    pub(super) fn new(
        io: IoDims,
        order: usize,
        from_y: S::FromY,
        from_u: S::FromU,
    ) -> Result<Self, ShapeError> {
        let rows = from_y.dims().rows;
        for (role, found, width) in [
            ("parity matrix W", from_y.dims(), io.ny),
            ("parity matrix −W T", from_u.dims(), io.nu),
        ] {
            let expected = Shape::new(rows, (order + 1) * width);
            if found != expected {
                return Err(ShapeError { role, expected, found });
            }
        }
        let ys = S::Ys::zeros("window of outputs", from_y.dims().cols)?;
        let us = S::Us::zeros("window of inputs", from_u.dims().cols)?;
        let order = order as u64;
        Ok(Self { io, from_y, from_u, ys, us, missing: order, order })
    }
}

impl<T: Scalar, S: Window<T>> Stage<T> for Parity<T, S> {
    fn reset(&mut self) {
        self.ys.as_mut().fill(T::zero());
        self.us.as_mut().fill(T::zero());
        self.missing = self.order;
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        visitor.reals("window of outputs", self.ys.as_mut());
        visitor.reals("window of inputs", self.us.as_mut());
        visitor.counts("samples missing in the window", std::slice::from_mut(&mut self.missing));
    }
}

impl<T: Scalar, S: Window<T>> ResidualGenerator<T> for Parity<T, S> {
    fn io(&self) -> IoDims {
        self.io
    }

    fn residual_len(&self) -> usize {
        self.from_y.dims().rows
    }

    fn step(&mut self, frame: Frame<'_, T>, r: &mut [T]) {
        shift_in(self.ys.as_mut(), frame.y());
        shift_in(self.us.as_mut(), frame.u());
        if 0 < self.missing {
            self.missing -= 1;
            r.fill(T::zero());
            return;
        }
        self.from_y.mul_into(self.ys.as_ref(), r);
        self.from_u.mul_add_into(self.us.as_ref(), r);
    }
}

/// Drops the oldest sample and appends the newest.
fn shift_in<T: Copy>(window: &mut [T], newest: &[T]) {
    window.copy_within(newest.len().., 0);
    let start = window.len() - newest.len();
    window[start..].copy_from_slice(newest);
}
