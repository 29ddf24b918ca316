//! Where faults, disturbances and noise enter a plant.

use faer::Mat;
use fd_core::Shape;
use fd_model::{StateSpace, TimeDomain, fault::Site};

use crate::{
    error::DesignError,
    matrix::{blocks, check_shape},
};

/// Unknown signals `f` in `x⁺ = A x + B u + B_f f`, `y = C x + D u + D_f f`.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::analysis::UnknownInputs;
///
/// let lag = StateSpace::new(mat![[-2.0]], mat![[3.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let faults = UnknownInputs::none(&lag)
///     .sensor(&lag, 0)?
///     .actuator(&lag, 0)?
///     .component("leak", &[-1.0], &[0.0])?;
/// assert_eq!(faults.names(), ["sensor 1", "actuator 1", "leak"]);
/// let gf = faults.system(&lag)?; // G_f(0) = [1, 3/2, −1/2]
/// assert_eq!(gf.dc_gain()?, mat![[1.0, 1.5, -0.5]]);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
#[derive(Clone, Debug)]
pub struct UnknownInputs {
    names: Vec<String>,
    b: Mat<f64>,
    d: Mat<f64>,
}

impl UnknownInputs {
    /// No unknown inputs, to begin with.
    #[must_use]
    pub fn none<D: TimeDomain>(model: &StateSpace<D>) -> Self {
        Self { names: Vec::new(), b: Mat::zeros(model.nx(), 0), d: Mat::zeros(model.ny(), 0) }
    }

    /// All unknown inputs at once: `B_f` (states × faults) and `D_f` (outputs × faults), named
    /// `name 1`, `name 2`, ….
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of columns differ or an entry is not finite.
    pub fn new(name: &str, b: Mat<f64>, d: Mat<f64>) -> Result<Self, DesignError> {
        check_shape("unknown input matrix B_f", b.as_ref(), Shape::new(b.nrows(), b.ncols()))?;
        check_shape("unknown input matrix D_f", d.as_ref(), Shape::new(d.nrows(), b.ncols()))?;
        let names = (1..=b.ncols()).map(|i| format!("{name} {i}")).collect();
        Ok(Self { names, b, d })
    }

    /// Adds an offset of a sensor: a unit vector on `y`.
    ///
    /// # Errors
    ///
    /// Returns an error when the model has no such output.
    pub fn sensor<D: TimeDomain>(
        self,
        model: &StateSpace<D>,
        output: usize,
    ) -> Result<Self, DesignError> {
        if model.ny() <= output {
            let count = model.ny();
            return Err(DesignError::Index { what: "output", index: output, count });
        }
        let mut d = vec![0.0; model.ny()];
        d[output] = 1.0;
        self.component(&format!("sensor {}", output + 1), &vec![0.0; model.nx()], &d)
    }

    /// Adds an offset of an actuator: a column of `G_u`.
    ///
    /// # Errors
    ///
    /// Returns an error when the model has no such input.
    pub fn actuator<D: TimeDomain>(
        self,
        model: &StateSpace<D>,
        input: usize,
    ) -> Result<Self, DesignError> {
        if model.nu() <= input {
            let count = model.nu();
            return Err(DesignError::Index { what: "input", index: input, count });
        }
        let b: Vec<f64> = model.b().col(input).iter().copied().collect();
        let d: Vec<f64> = model.d().col(input).iter().copied().collect();
        self.component(&format!("actuator {}", input + 1), &b, &d)
    }

    /// Adds a signal with given directions into states and outputs.
    ///
    /// # Errors
    ///
    /// Returns an error when a direction has the wrong length or is not finite.
    pub fn component(mut self, name: &str, b: &[f64], d: &[f64]) -> Result<Self, DesignError> {
        let column = |v: &[f64]| Mat::from_fn(v.len(), 1, |i, _| v[i]);
        let (b, d) = (column(b), column(d));
        check_shape("direction into the states", b.as_ref(), Shape::new(self.b.nrows(), 1))?;
        check_shape("direction into the outputs", d.as_ref(), Shape::new(self.d.nrows(), 1))?;
        self.b = blocks(&[&[self.b.as_ref(), b.as_ref()]]);
        self.d = blocks(&[&[self.d.as_ref(), d.as_ref()]]);
        self.names.push(name.to_owned());
        Ok(self)
    }

    /// The faults of a simulation as unknown inputs: sensors and actuators by name or index, among the channels of the
    /// model, so that what is simulated ([`FaultSpec`](fd_model::fault::FaultSpec)) and what a residual is designed and
    /// judged for are one list.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such channel, or a site is a parameter of the plant: where that enters depends on the
    /// model, see [`component`](Self::component).
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace, fault::Site};
    /// use fd_residual::analysis::UnknownInputs;
    ///
    /// let lag = StateSpace::new(mat![[-2.0]], mat![[3.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
    /// let sites = [Site::sensor("speed"), Site::actuator(0)];
    /// let faults = UnknownInputs::at(&lag, &sites, [&["voltage"], &["speed"]])?;
    /// assert_eq!(faults.names(), ["sensor `speed`", "actuator `0`"]);
    /// # Ok::<(), fd_residual::DesignError>(())
    /// ```
    pub fn at<D: TimeDomain>(
        model: &StateSpace<D>,
        sites: &[Site],
        [inputs, outputs]: [&[&str]; 2],
    ) -> Result<Self, DesignError> {
        let mut all = Self::none(model);
        for site in sites {
            all = match site {
                Site::Sensor(_) => all.sensor(model, site.index_among(outputs)?)?,
                Site::Actuator(_) => all.actuator(model, site.index_among(inputs)?)?,
                _ => return Err(DesignError::Empty { what: "channel of a component fault" }),
            };
            if let Some(name) = all.names.last_mut() {
                *name = site.to_string();
            }
        }
        Ok(all)
    }

    /// Some of the signals, in the given order.
    ///
    /// # Errors
    ///
    /// Returns an error when an index does not exist.
    pub fn select(&self, signals: &[usize]) -> Result<Self, DesignError> {
        let count = self.len();
        if let Some(&index) = signals.iter().find(|&&i| count <= i) {
            return Err(DesignError::Index { what: "unknown input", index, count });
        }
        let pick = |m: &Mat<f64>| Mat::from_fn(m.nrows(), signals.len(), |i, j| m[(i, signals[j])]);
        let names = signals.iter().map(|&i| self.names[i].clone()).collect();
        Ok(Self { names, b: pick(&self.b), d: pick(&self.d) })
    }

    /// These signals followed by others of the same plant.
    ///
    /// # Errors
    ///
    /// Returns an error when the others belong to a plant of other sizes.
    pub fn and(&self, others: &Self) -> Result<Self, DesignError> {
        let b = Shape::new(self.b.nrows(), others.len());
        let d = Shape::new(self.d.nrows(), others.len());
        check_shape("unknown input matrix B_f", others.b.as_ref(), b)?;
        check_shape("unknown input matrix D_f", others.d.as_ref(), d)?;
        Ok(Self {
            names: [self.names.as_slice(), others.names.as_slice()].concat(),
            b: blocks(&[&[self.b.as_ref(), others.b.as_ref()]]),
            d: blocks(&[&[self.d.as_ref(), others.d.as_ref()]]),
        })
    }

    /// Names in order.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Number of signals.
    #[must_use]
    pub fn len(&self) -> usize {
        self.names.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.names.is_empty()
    }

    /// The transfer function `G_f` from these signals to the outputs of `model`.
    ///
    /// # Errors
    ///
    /// Returns an error when the model has other numbers of states or outputs.
    pub fn system<D: TimeDomain>(
        &self,
        model: &StateSpace<D>,
    ) -> Result<StateSpace<D>, DesignError> {
        let (a, c) = (model.a().to_owned(), model.c().to_owned());
        Ok(StateSpace::new(a, self.b.clone(), c, self.d.clone(), model.domain())?)
    }
}
