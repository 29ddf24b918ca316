//! Where the numbers of a recursive estimator live: on the stack or on the heap.

use std::fmt::Debug;

use fd_core::{Buffer, Heap, Scalar, Shape, ShapeError};

/// A rectangular block of numbers that an estimator owns, seen as one slice.
pub trait Grid<T>: Clone + Debug + Send + Sync {
    /// A block of zeros.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has another shape.
    fn zeros(role: &'static str, shape: Shape) -> Result<Self, ShapeError>;

    /// All numbers, line by line.
    fn as_slice(&self) -> &[T];

    /// All numbers, line by line, to be changed.
    fn as_mut_slice(&mut self) -> &mut [T];
}

impl<T: Scalar, const R: usize, const C: usize> Grid<T> for [[T; C]; R] {
    fn zeros(role: &'static str, found: Shape) -> Result<Self, ShapeError> {
        let expected = Shape::new(R, C);
        if found != expected {
            return Err(ShapeError { role, expected, found });
        }
        Ok([[T::zero(); C]; R])
    }

    fn as_slice(&self) -> &[T] {
        self.as_flattened()
    }

    fn as_mut_slice(&mut self) -> &mut [T] {
        self.as_flattened_mut()
    }
}

impl<T: Scalar> Grid<T> for Vec<T> {
    fn zeros(_role: &'static str, shape: Shape) -> Result<Self, ShapeError> {
        Ok(vec![T::zero(); shape.rows * shape.cols])
    }

    fn as_slice(&self) -> &[T] {
        self
    }

    fn as_mut_slice(&mut self) -> &mut [T] {
        self
    }
}

/// The buffer types of an estimator of `n` parameters that may look back on a window.
///
/// Estimators are written once against this trait. [`Static`] keeps every number inside the
/// estimator, [`Heap`] lets the sizes come from a file; the results are the same to the bit.
pub trait RlsStorage<T: Scalar>: Clone + Debug + Send + Sync {
    /// One number per parameter.
    type Parameters: Buffer<T>;
    /// A square matrix over the parameters.
    type Square: Grid<T>;
    /// One regressor per sample of the window.
    type Regressors: Grid<T>;
    /// One target per sample of the window.
    type Targets: Buffer<T>;
}

/// `N` parameters and a window of `W` samples, known to the compiler. No allocation, ever.
#[derive(Clone, Copy, Debug)]
pub struct Static<const N: usize, const W: usize = 0>;

impl<T: Scalar, const N: usize, const W: usize> RlsStorage<T> for Static<N, W> {
    type Parameters = [T; N];
    type Square = [[T; N]; N];
    type Regressors = [[T; N]; W];
    type Targets = [T; W];
}

impl<T: Scalar> RlsStorage<T> for Heap {
    type Parameters = Vec<T>;
    type Square = Vec<T>;
    type Regressors = Vec<T>;
    type Targets = Vec<T>;
}
