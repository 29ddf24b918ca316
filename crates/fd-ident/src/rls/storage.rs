//! Where the numbers of a recursive estimator live: on the stack or on the heap.

use std::fmt::Debug;

use fd_core::{Buffer, Heap, Scalar, Shape, ShapeError};

/// A rectangular block of numbers that an estimator owns, seen as one slice: an array of arrays, or a
/// `Vec` that never grows.
///
/// ```
/// use fd_core::Shape;
/// use fd_ident::rls::Grid;
///
/// let mut square: [[f64; 2]; 2] = Grid::zeros("P", Shape::new(2, 2))?;
/// Grid::as_mut_slice(&mut square)[1] = 5.0;
/// assert_eq!(square, [[0.0, 5.0], [0.0, 0.0]]);
/// assert!(<[[f64; 2]; 2] as Grid<f64>>::zeros("P", Shape::new(3, 3)).is_err());
/// # Ok::<(), fd_core::ShapeError>(())
/// ```
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
///
/// ```
/// use fd_core::Heap;
/// use fd_ident::rls::{RlsDesign, RlsKernel, RlsStorage, Static, UdRls};
///
/// fn learned<S: RlsStorage<f64>>() -> Result<[f64; 2], fd_ident::IdentError> {
///     let mut rls = UdRls::<f64, S>::new(2, &RlsDesign::default())?;
///     let mut theta = [0.0; 2];
///     for k in 0..20 {
///         let phi = [1.0, f64::from(k)];
///         rls.update(&phi, 3.0 - 0.1 * phi[1], &mut theta);
///     }
///     Ok(theta)
/// }
///
/// assert_eq!(learned::<Static<2>>()?, learned::<Heap>()?);
/// # Ok::<(), fd_ident::IdentError>(())
/// ```
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
