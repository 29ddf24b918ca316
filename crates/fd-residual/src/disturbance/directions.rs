//! Principal directions of modelling errors.

use faer::{Mat, MatRef, Scale};
use fd_core::Shape;
use fd_model::{Discrete, ModelError, Record, StateSpace, TimeDomain};
use fd_numeric::dense::Dense;

use super::estimate::{Expectation, check_record, second_moment};
use crate::{
    error::DesignError,
    matrix::{blocks, check_shape},
};

/// Directions in the state space, strongest first.
#[derive(Clone, Debug)]
pub struct Directions {
    /// Orthonormal columns.
    columns: Mat<f64>,
    /// Root mean square of the error along each, in units of the state per sample or second.
    sizes: Vec<f64>,
}

impl Directions {
    /// The directions in which `perturbed` models differ from the nominal one.
    ///
    /// `energy` holds the root mean squares that are expected of the states, then of the inputs.
    /// Differences in `C` and `D` are not looked at: no `E` describes them.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no perturbed model, one has other sizes or another time
    /// axis, or `energy` has not one value per state and input.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_model::{Continuous, StateSpace};
    /// use fd_residual::disturbance::Directions;
    ///
    /// let model = |slow: f64| {
    ///     let (a, b) = (mat![[-1.0, slow], [0.0, -2.0]], mat![[0.0], [1.0]]);
    ///     StateSpace::new(a, b, Mat::identity(2, 2), Mat::zeros(2, 1), Continuous)
    /// };
    /// let others = [model(0.8)?, model(1.3)?];
    /// let found = Directions::from_models(&model(1.0)?, &others, &[1.0, 1.0, 1.0])?;
    /// // Only the first state's equation is uncertain: √((0.2² + 0.3²)/2).
    /// assert!((found.sizes()[0] - 0.065_f64.sqrt()).abs() < 1e-15 && found.sizes()[1] < 1e-15);
    /// assert!((found.columns(1)?[(0, 0)].abs() - 1.0).abs() < 1e-15);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn from_models<D: TimeDomain>(
        nominal: &StateSpace<D>,
        perturbed: &[StateSpace<D>],
        energy: &[f64],
    ) -> Result<Self, DesignError> {
        let (n, nu) = (nominal.nx(), nominal.nu());
        if perturbed.is_empty() {
            return Err(DesignError::Empty { what: "perturbed model" });
        }
        let sizes = Mat::from_fn(energy.len(), 1, |i, _| energy[i]);
        check_shape("root mean squares of x and u", sizes.as_ref(), Shape::new(n + nu, 1))?;
        let mut errors = Mat::zeros(n, 0);
        for model in perturbed {
            nominal.domain().join(model.domain())?;
            check_shape("perturbed A", model.a(), Shape::new(n, n))?;
            check_shape("perturbed B", model.b(), Shape::new(n, nu))?;
            let (da, db) = (model.a() - nominal.a(), model.b() - nominal.b());
            errors = blocks(&[&[errors.as_ref(), da.as_ref(), db.as_ref()]]);
        }
        let weighted =
            Mat::from_fn(n, errors.ncols(), |i, j| errors[(i, j)] * energy[j % (n + nu)]);
        let count = f64::from(u32::try_from(perturbed.len()).unwrap_or(u32::MAX));
        Self::principal((Scale(count.recip()) * (&weighted * weighted.transpose())).as_ref())
    }

    /// What [`from_models`](Self::from_models) takes as `energy`: root mean squares of the states of
    /// a model that is driven by the inputs of logs from rest, then of those inputs. Missing inputs
    /// count as zero.
    ///
    /// # Errors
    ///
    /// Returns an error when a log has other inputs or another sample time than the model, or there
    /// is no sample.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Channel, Discrete, Record, SampleTime, StateSpace};
    /// use fd_residual::disturbance::Directions;
    ///
    /// let ts = SampleTime::new(1.0)?;
    /// let (a, domain) = (mat![[0.0]], Discrete { ts });
    /// let model = StateSpace::new(a, mat![[2.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let (u, y) = (Channel::numbered("u", 1), Channel::numbered("y", 1));
    /// let log = Record::new(u, y, vec![1.0; 4], vec![0.0; 4], ts)?;
    /// // x = 0, 2, 2, 2
    /// assert_eq!(Directions::energy(&model, &[log])?, [3.0_f64.sqrt(), 1.0]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn energy(
        model: &StateSpace<Discrete>,
        records: &[Record],
    ) -> Result<Vec<f64>, DesignError> {
        let (n, nu) = (model.nx(), model.nu());
        let (mut squares, mut count) = (vec![0.0; n + nu], 0_u32);
        for record in records {
            check_record(model, record)?;
            let mut x = Mat::<f64>::zeros(n, 1);
            for k in 0..record.len() {
                let present = |u: f64| if u.is_finite() { u } else { 0.0 };
                let u = Mat::from_fn(nu, 1, |i, _| present(record.u(k)[i]));
                let signals = (0..n).map(|i| x[(i, 0)]).chain((0..nu).map(|i| u[(i, 0)]));
                squares.iter_mut().zip(signals).for_each(|(sum, value)| *sum += value * value);
                count += 1;
                x = model.a() * &x + model.b() * &u;
            }
        }
        if count == 0 {
            return Err(DesignError::Empty { what: "sample of a healthy log" });
        }
        Ok(squares.into_iter().map(|sum| (sum / f64::from(count)).sqrt()).collect())
    }

    /// The directions of the disturbances that explain healthy logs, see [`Expectation`].
    ///
    /// # Errors
    ///
    /// Returns an error when a log has other channels or another sample time than the model, no
    /// complete sample is left after settling, or the filter for the disturbances does not exist.
    pub fn from_records(
        model: &StateSpace<Discrete>,
        records: &[Record],
        expected: &Expectation,
    ) -> Result<Self, DesignError> {
        Self::principal(second_moment(model, records, expected)?.as_ref())
    }

    /// Eigenvectors of a second moment, largest first.
    fn principal(moment: MatRef<'_, f64>) -> Result<Self, DesignError> {
        let n = moment.nrows();
        let failed = ModelError::NoConvergence { what: "principal directions", order: n };
        let eigen = moment.symmetric_eigen().map_err(|_| failed)?;
        let (u, values) = (eigen.U(), eigen.S().column_vector());
        // faer sorts eigenvalues in ascending order.
        let columns = Mat::from_fn(n, n, |i, j| u[(i, n - 1 - j)]);
        let sizes = (0..n).map(|j| values[n - 1 - j].max(0.0).sqrt()).collect();
        Ok(Self { columns, sizes })
    }

    /// Root mean squares of the error along all directions, largest first.
    #[must_use]
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// The first `rank` directions as orthonormal columns (states × rank).
    ///
    /// # Errors
    ///
    /// Returns an error when the rank is zero or more than there are states.
    pub fn columns(&self, rank: usize) -> Result<MatRef<'_, f64>, DesignError> {
        if rank == 0 {
            return Err(DesignError::Empty { what: "direction" });
        }
        let count = self.columns.ncols();
        if count < rank {
            return Err(DesignError::Index { what: "direction", index: rank - 1, count });
        }
        Ok(self.columns.subcols(0, rank))
    }

    /// The first `rank` directions, each as long as its root mean square: the factor `E` whose
    /// `E Eᵀ` is nearest to the second moment of the errors.
    ///
    /// # Errors
    ///
    /// Fails as [`columns`](Self::columns) does.
    pub fn scaled(&self, rank: usize) -> Result<Mat<f64>, DesignError> {
        let columns = self.columns(rank)?;
        Ok(Mat::from_fn(columns.nrows(), rank, |i, j| columns[(i, j)] * self.sizes[j]))
    }

    /// Part of the errors' energy that the first `rank` directions hold; one when there is none.
    #[must_use]
    pub fn explained(&self, rank: usize) -> f64 {
        let energy = |sizes: &[f64]| sizes.iter().map(|s| s * s).sum::<f64>();
        let (kept, all) = (energy(&self.sizes[..rank.min(self.sizes.len())]), energy(&self.sizes));
        if 0.0 < all { kept / all } else { 1.0 }
    }

    /// The least rank that holds `share` of the errors' energy.
    #[must_use]
    pub fn rank_for(&self, share: f64) -> usize {
        let all = self.sizes.len();
        (0..all).find(|&rank| share <= self.explained(rank)).unwrap_or(all)
    }
}
