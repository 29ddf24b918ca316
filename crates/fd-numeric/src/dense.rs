//! faer's decompositions, compiled once: an optimised crate compiles generic code again for itself, and a decomposition takes
//! seconds to compile. Results are bit for bit those of faer.

#![allow(non_snake_case)]

use std::ops::Deref;

use faer::{
    Accum, Conj, Mat, MatMut, MatRef, Par, Side, Spec, c64,
    dyn_stack::{MemBuffer, MemStack},
    linalg::matmul::triangular::{self, BlockStructure},
    linalg::qr::no_pivoting::factor::{
        QrParams, qr_in_place, qr_in_place_scratch, recommended_block_size,
    },
    linalg::solvers::{
        self, DenseSolveCore, EvdError, LltError, ShapeCore, SolveCore, SolveLstsqCore, SvdError,
    },
    linalg::triangular_solve::solve_lower_triangular_in_place,
    mat::AsMatRef,
    traits::ComplexField,
};

/// Decompositions of a dense matrix of [`f64`] or [`c64`], under names that faer does not have.
///
/// ```
/// use faer::{mat, prelude::Solve};
/// use fd_numeric::dense::Dense;
///
/// let a = mat![[2.0, 0.0], [0.0, 4.0]];
/// assert_eq!(a.lu().solve(mat![[1.0], [1.0]]), mat![[0.5], [0.25]]);
/// assert_eq!(a.sigmas()?, [4.0, 2.0]);
/// # Ok::<(), faer::linalg::solvers::SvdError>(())
/// ```
pub trait Dense<T: Number> {
    /// `partial_piv_lu`
    fn lu(&self) -> Lu<T>;
    /// `llt` of the lower half
    ///
    /// # Errors
    ///
    /// Of faer.
    fn cholesky(&self) -> Result<Cholesky<T>, LltError>;
    /// `qr`
    fn factor_qr(&self) -> Qr<T>;
    /// `col_piv_qr`
    fn pivoted_qr(&self) -> PivotedQr<T>;
    /// `svd`
    ///
    /// # Errors
    ///
    /// Of faer.
    fn full_svd(&self) -> Result<Svd<T>, SvdError>;
    /// `thin_svd`
    ///
    /// # Errors
    ///
    /// Of faer.
    fn economic_svd(&self) -> Result<Svd<T>, SvdError>;
    /// `singular_values`
    ///
    /// # Errors
    ///
    /// Of faer.
    fn sigmas(&self) -> Result<Vec<f64>, SvdError>;
    /// `self_adjoint_eigen` of the lower half
    ///
    /// # Errors
    ///
    /// Of faer.
    fn symmetric_eigen(&self) -> Result<solvers::SelfAdjointEigen<T>, EvdError>;
}

/// Decompositions of a dense matrix of [`f64`].
pub trait DenseReal {
    /// `eigenvalues`
    ///
    /// # Errors
    ///
    /// Of faer.
    fn modes(&self) -> Result<Vec<c64>, EvdError>;
    /// `self_adjoint_eigenvalues` of the lower half
    ///
    /// # Errors
    ///
    /// Of faer.
    fn symmetric_eigenvalues(&self) -> Result<Vec<f64>, EvdError>;
}

macro_rules! factor {
    ($name:ident, $of:ident, $what:literal) => {
        #[doc = $what]
        #[derive(Clone, Debug)]
        pub struct $name<T>(solvers::$of<T>);

        impl<T> Deref for $name<T> {
            type Target = solvers::$of<T>;

            fn deref(&self) -> &Self::Target {
                &self.0
            }
        }

        impl<T: Number> ShapeCore for $name<T> {
            fn nrows(&self) -> usize {
                self.0.nrows()
            }

            fn ncols(&self) -> usize {
                self.0.ncols()
            }
        }
    };
}

factor!(Lu, PartialPivLu, "`P A = L U`.");
factor!(Cholesky, Llt, "`A = L Lᵀ`.");
factor!(Qr, Qr, "`A = Q R`.");
factor!(PivotedQr, ColPivQr, "`A P = Q R`.");
factor!(Svd, Svd, "`A = U S Vᵀ`.");

impl<T: Number> Svd<T> {
    /// As faer's.
    #[must_use]
    pub fn pseudoinverse(&self) -> Mat<T> {
        T::pseudoinverse(&self.0)
    }
}

impl Cholesky<f64> {
    /// `x ← L⁻¹ x`.
    pub fn solve_half(&self, x: MatMut<'_, f64>) {
        solve_lower_triangular_in_place(self.0.L(), x, Par::Seq);
    }
}

/// The lower half of `A ← A + X Xᵀ`.
pub fn add_gram(a: MatMut<'_, f64>, x: MatRef<'_, f64>) {
    use BlockStructure::{Rectangular, TriangularLower};
    let other = x.transpose();
    triangular::matmul(
        a,
        TriangularLower,
        Accum::Add,
        x,
        Rectangular,
        other,
        Rectangular,
        1.0,
        Par::Seq,
    );
}

/// `R` of a thin QR, in place: most of the time of `Mat::qr` on many rows would go into copies of all of them.
#[must_use]
pub fn triangle(mut rows: Mat<f64>) -> Mat<f64> {
    let (m, n) = rows.shape();
    let (size, block) = (m.min(n), recommended_block_size::<f64>(m, n));
    let how = Spec::<QrParams, f64>::default();
    let mut memory = MemBuffer::new(qr_in_place_scratch::<f64>(m, n, block, Par::Seq, how));
    let mut q = Mat::zeros(block, size);
    qr_in_place(rows.as_mut(), q.as_mut(), Par::Seq, MemStack::new(&mut memory), how);
    Mat::from_fn(size, n, |i, j| if i <= j { rows[(i, j)] } else { 0.0 })
}

impl<T: Number> Qr<T> {
    /// As faer's.
    #[must_use]
    pub fn compute_thin_Q(&self) -> Mat<T> {
        T::thin_q(&self.0)
    }
}

impl<T: Number> PivotedQr<T> {
    /// As faer's.
    #[must_use]
    pub fn compute_thin_Q(&self) -> Mat<T> {
        T::pivoted_thin_q(&self.0)
    }
}

impl<T: Number> Lu<T> {
    /// As faer's.
    #[must_use]
    pub fn inverse(&self) -> Mat<T> {
        T::inverse(&self.0)
    }
}

macro_rules! solves {
    ($name:ident, $solve:ident, $transposed:ident) => {
        impl<T: Number> SolveCore<T> for $name<T> {
            fn solve_in_place_with_conj(&self, conj: Conj, rhs: MatMut<'_, T>) {
                T::$solve(&self.0, conj, rhs);
            }

            fn solve_transpose_in_place_with_conj(&self, conj: Conj, rhs: MatMut<'_, T>) {
                T::$transposed(&self.0, conj, rhs);
            }
        }
    };
}

solves!(Lu, solve_lu, solve_lu_transposed);
solves!(Cholesky, solve_cholesky, solve_cholesky_transposed);

macro_rules! solves_least_squares {
    ($name:ident, $solve:ident) => {
        impl<T: Number> SolveLstsqCore<T> for $name<T> {
            fn solve_lstsq_in_place_with_conj(&self, conj: Conj, rhs: MatMut<'_, T>) {
                T::$solve(&self.0, conj, rhs);
            }
        }
    };
}

solves_least_squares!(Qr, solve_qr);
solves_least_squares!(PivotedQr, solve_pivoted_qr);

/// [`f64`] or [`c64`]: what is asked of them is compiled in this crate.
#[doc(hidden)]
#[allow(missing_docs, clippy::missing_errors_doc)]
pub trait Number: ComplexField<Real = f64> {
    fn lu(a: MatRef<'_, Self>) -> solvers::PartialPivLu<Self>;
    fn cholesky(a: MatRef<'_, Self>) -> Result<solvers::Llt<Self>, LltError>;
    fn qr(a: MatRef<'_, Self>) -> solvers::Qr<Self>;
    fn pivoted_qr(a: MatRef<'_, Self>) -> solvers::ColPivQr<Self>;
    fn full_svd(a: MatRef<'_, Self>) -> Result<solvers::Svd<Self>, SvdError>;
    fn thin_svd(a: MatRef<'_, Self>) -> Result<solvers::Svd<Self>, SvdError>;
    fn sigmas(a: MatRef<'_, Self>) -> Result<Vec<f64>, SvdError>;
    fn symmetric_eigen(a: MatRef<'_, Self>) -> Result<solvers::SelfAdjointEigen<Self>, EvdError>;
    fn inverse(of: &solvers::PartialPivLu<Self>) -> Mat<Self>;
    fn pseudoinverse(of: &solvers::Svd<Self>) -> Mat<Self>;
    fn thin_q(of: &solvers::Qr<Self>) -> Mat<Self>;
    fn pivoted_thin_q(of: &solvers::ColPivQr<Self>) -> Mat<Self>;
    fn solve_lu(of: &solvers::PartialPivLu<Self>, conj: Conj, x: MatMut<'_, Self>);
    fn solve_lu_transposed(of: &solvers::PartialPivLu<Self>, conj: Conj, x: MatMut<'_, Self>);
    fn solve_cholesky(of: &solvers::Llt<Self>, conj: Conj, x: MatMut<'_, Self>);
    fn solve_cholesky_transposed(of: &solvers::Llt<Self>, conj: Conj, x: MatMut<'_, Self>);
    fn solve_qr(of: &solvers::Qr<Self>, conj: Conj, x: MatMut<'_, Self>);
    fn solve_pivoted_qr(of: &solvers::ColPivQr<Self>, conj: Conj, x: MatMut<'_, Self>);
}

macro_rules! number {
    ($t:ty) => {
        impl Number for $t {
            fn lu(a: MatRef<'_, Self>) -> solvers::PartialPivLu<Self> {
                a.partial_piv_lu()
            }

            fn cholesky(a: MatRef<'_, Self>) -> Result<solvers::Llt<Self>, LltError> {
                a.llt(Side::Lower)
            }

            fn qr(a: MatRef<'_, Self>) -> solvers::Qr<Self> {
                a.qr()
            }

            fn pivoted_qr(a: MatRef<'_, Self>) -> solvers::ColPivQr<Self> {
                a.col_piv_qr()
            }

            fn full_svd(a: MatRef<'_, Self>) -> Result<solvers::Svd<Self>, SvdError> {
                a.svd()
            }

            fn thin_svd(a: MatRef<'_, Self>) -> Result<solvers::Svd<Self>, SvdError> {
                a.thin_svd()
            }

            fn sigmas(a: MatRef<'_, Self>) -> Result<Vec<f64>, SvdError> {
                a.singular_values()
            }

            fn symmetric_eigen(
                a: MatRef<'_, Self>,
            ) -> Result<solvers::SelfAdjointEigen<Self>, EvdError> {
                a.self_adjoint_eigen(Side::Lower)
            }

            fn inverse(of: &solvers::PartialPivLu<Self>) -> Mat<Self> {
                DenseSolveCore::inverse(of)
            }

            fn pseudoinverse(of: &solvers::Svd<Self>) -> Mat<Self> {
                of.pseudoinverse()
            }

            fn thin_q(of: &solvers::Qr<Self>) -> Mat<Self> {
                of.compute_thin_Q()
            }

            fn pivoted_thin_q(of: &solvers::ColPivQr<Self>) -> Mat<Self> {
                of.compute_thin_Q()
            }

            fn solve_lu(of: &solvers::PartialPivLu<Self>, conj: Conj, x: MatMut<'_, Self>) {
                of.solve_in_place_with_conj(conj, x);
            }

            fn solve_lu_transposed(
                of: &solvers::PartialPivLu<Self>,
                conj: Conj,
                x: MatMut<'_, Self>,
            ) {
                of.solve_transpose_in_place_with_conj(conj, x);
            }

            fn solve_cholesky(of: &solvers::Llt<Self>, conj: Conj, x: MatMut<'_, Self>) {
                of.solve_in_place_with_conj(conj, x);
            }

            fn solve_cholesky_transposed(of: &solvers::Llt<Self>, conj: Conj, x: MatMut<'_, Self>) {
                of.solve_transpose_in_place_with_conj(conj, x);
            }

            fn solve_qr(of: &solvers::Qr<Self>, conj: Conj, x: MatMut<'_, Self>) {
                of.solve_lstsq_in_place_with_conj(conj, x);
            }

            fn solve_pivoted_qr(of: &solvers::ColPivQr<Self>, conj: Conj, x: MatMut<'_, Self>) {
                of.solve_lstsq_in_place_with_conj(conj, x);
            }
        }
    };
}

number!(f64);
number!(c64);

impl<T: Number, M: AsMatRef<T = T, Rows = usize, Cols = usize>> Dense<T> for M {
    fn lu(&self) -> Lu<T> {
        Lu(T::lu(plain(self)))
    }

    fn cholesky(&self) -> Result<Cholesky<T>, LltError> {
        T::cholesky(plain(self)).map(Cholesky)
    }

    fn factor_qr(&self) -> Qr<T> {
        Qr(T::qr(plain(self)))
    }

    fn pivoted_qr(&self) -> PivotedQr<T> {
        PivotedQr(T::pivoted_qr(plain(self)))
    }

    fn full_svd(&self) -> Result<Svd<T>, SvdError> {
        T::full_svd(plain(self)).map(Svd)
    }

    fn economic_svd(&self) -> Result<Svd<T>, SvdError> {
        T::thin_svd(plain(self)).map(Svd)
    }

    fn sigmas(&self) -> Result<Vec<f64>, SvdError> {
        T::sigmas(plain(self))
    }

    fn symmetric_eigen(&self) -> Result<solvers::SelfAdjointEigen<T>, EvdError> {
        T::symmetric_eigen(plain(self))
    }
}

impl<M: AsMatRef<T = f64, Rows = usize, Cols = usize>> DenseReal for M {
    fn modes(&self) -> Result<Vec<c64>, EvdError> {
        eigenvalues(plain(self))
    }

    fn symmetric_eigenvalues(&self) -> Result<Vec<f64>, EvdError> {
        symmetric_eigenvalues(plain(self))
    }
}

fn plain<T, M: AsMatRef<T = T, Rows = usize, Cols = usize>>(matrix: &M) -> MatRef<'_, T> {
    matrix.as_mat_ref().as_dyn_stride()
}

fn eigenvalues(a: MatRef<'_, f64>) -> Result<Vec<c64>, EvdError> {
    a.eigenvalues()
}

fn symmetric_eigenvalues(a: MatRef<'_, f64>) -> Result<Vec<f64>, EvdError> {
    a.self_adjoint_eigenvalues(Side::Lower)
}
