//! Choosing a weighting.

use faer::{Mat, MatRef};
use fd_core::{
    Buffer, Heap, HeapMap, IoDims, LinMap, Scalar, Shape, ShapeError, Storage,
    stage::ResidualGenerator,
};
use fd_model::{Discrete, StateSpace, TimeDomain, freeze};

use super::run::{Filtered, Weighted};
use crate::{
    error::DesignError,
    form::{GeneratorDesign, ResidualForm},
    matrix::check_shape,
    simulation::check_stable,
};

/// A generator followed by a constant matrix.
#[derive(Clone, Debug)]
pub struct WeightedDesign<G> {
    inner: G,
    weight: Mat<f64>,
}

impl<G: GeneratorDesign> WeightedDesign<G> {
    /// The residual `W r` of `inner`.
    ///
    /// # Errors
    ///
    /// Returns an error when `W` has not one column per residual channel of `inner`.
    ///
    /// # Examples
    ///
    /// The sum of two channels, as with the paper's `W = [1 1 1 1 1]`:
    ///
    /// ```
    /// use faer::{Mat, mat};
    /// use fd_core::{Frame, stage::ResidualGenerator};
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{GeneratorDesign, simulation::SimulationDesign, weighted::WeightedDesign};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let (b, c) = (mat![[1.0]], mat![[1.0], [2.0]]);
    /// let model = StateSpace::new(mat![[0.5]], b, c, Mat::zeros(2, 1), domain)?;
    /// let inner = SimulationDesign::new(&model)?;
    /// let design = WeightedDesign::new(inner, mat![[1.0, 1.0]].as_ref())?;
    /// let mut generator = design.build()?;
    /// let mut r = [0.0];
    /// generator.step(Frame::new(generator.io(), 0, &[1.0], &[0.25, 0.5])?, &mut r);
    /// assert_eq!(r, [0.75]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(inner: G, weight: MatRef<'_, f64>) -> Result<Self, DesignError> {
        check_shape("weighting W", weight, Shape::new(weight.nrows(), inner.residual_len()))?;
        if weight.nrows() == 0 {
            return Err(DesignError::Empty { what: "row of the weighting W" });
        }
        Ok(Self { inner, weight: weight.to_owned() })
    }

    /// Puts the weighting behind a running generator, in any scalar and storage.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has other sizes.
    pub fn behind<T, I, W, R>(&self, running: I) -> Result<Weighted<T, I, W, R>, DesignError>
    where
        T: Scalar,
        I: ResidualGenerator<T>,
        W: LinMap<T>,
        R: Buffer<T>,
    {
        Ok(Weighted::new(running, freeze("weighting W", self.weight())?)?)
    }

    /// The weighting `W`.
    #[must_use]
    pub fn weight(&self) -> MatRef<'_, f64> {
        self.weight.as_ref()
    }

    /// The generator in front of the weighting.
    #[must_use]
    pub fn inner(&self) -> &G {
        &self.inner
    }
}

impl<G: GeneratorDesign> GeneratorDesign for WeightedDesign<G> {
    fn io(&self) -> IoDims {
        self.inner.io()
    }

    fn residual_len(&self) -> usize {
        self.weight.nrows()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        self.inner.form()?.weighted(self.weight())
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        let weighted: Weighted<f64, _, HeapMap<f64>, Vec<f64>> =
            self.behind(self.inner.build()?)?;
        Ok(Box::new(weighted))
    }
}

/// A generator followed by a stable filter `W(z)`.
#[derive(Clone, Debug)]
pub struct FilteredDesign<G> {
    inner: G,
    filter: StateSpace<Discrete>,
}

impl<G: GeneratorDesign> FilteredDesign<G> {
    /// The residual `W(z) r` of `inner`.
    ///
    /// # Errors
    ///
    /// Returns an error when the filter has not one input per residual channel of `inner`, is
    /// unstable, or has another sample time.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Discrete, SampleTime, StateSpace};
    /// use fd_residual::{GeneratorDesign, simulation::SimulationDesign, weighted::FilteredDesign};
    ///
    /// let domain = Discrete { ts: SampleTime::new(0.1)? };
    /// let lag = StateSpace::new(mat![[0.5]], mat![[1.0]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let smooth = StateSpace::new(mat![[0.8]], mat![[0.2]], mat![[1.0]], mat![[0.0]], domain)?;
    /// let design = FilteredDesign::new(SimulationDesign::new(&lag)?, &smooth)?;
    /// assert!((design.form()?.hy()?.dc_gain()?[(0, 0)] - 1.0).abs() < 1e-14);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn new(inner: G, filter: &StateSpace<Discrete>) -> Result<Self, DesignError> {
        if filter.nu() != inner.residual_len() {
            let expected = Shape::new(filter.ny(), inner.residual_len());
            let found = Shape::new(filter.ny(), filter.nu());
            return Err(ShapeError { role: "filter W(z)", expected, found }.into());
        }
        inner.form()?.system().domain().join(filter.domain())?;
        check_stable("a residual filter", filter)?;
        Ok(Self { inner, filter: filter.clone() })
    }

    /// Puts the filter behind a running generator, in any scalar and storage.
    ///
    /// # Errors
    ///
    /// Returns an error when the storage is fixed and has other sizes.
    pub fn behind<T, I, S, R>(&self, running: I) -> Result<Filtered<T, I, S, R>, DesignError>
    where
        T: Scalar,
        I: ResidualGenerator<T>,
        S: Storage<T>,
        R: Buffer<T>,
    {
        Ok(Filtered::new(running, self.filter.freeze()?)?)
    }
}

impl<G: GeneratorDesign> GeneratorDesign for FilteredDesign<G> {
    fn io(&self) -> IoDims {
        self.inner.io()
    }

    fn residual_len(&self) -> usize {
        self.filter.ny()
    }

    fn form(&self) -> Result<ResidualForm, DesignError> {
        let form = self.inner.form()?;
        let system = form.system().series(&self.filter)?;
        ResidualForm::new(form.io(), system)
    }

    fn build(&self) -> Result<Box<dyn ResidualGenerator>, DesignError> {
        let filtered: Filtered<f64, _, Heap, Vec<f64>> = self.behind(self.inner.build()?)?;
        Ok(Box::new(filtered))
    }
}
