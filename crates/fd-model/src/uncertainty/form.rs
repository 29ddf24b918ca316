//! Additive and multiplicative uncertainty, and the residual that each of them causes.

use faer::Mat;

use crate::{domain::TimeDomain, error::ModelError, state_space::StateSpace};

/// The difference between a nominal model `G_u` and the plant `G`, as a model of its own.
///
/// # Examples
///
/// An actuator that is 10 % weaker than nominal, and the residual it leaves with `H_y = 1`:
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace, uncertainty::Uncertainty};
///
/// let nominal = StateSpace::new(mat![[-2.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let weaker = Uncertainty::InputMultiplicative(StateSpace::gain(mat![[-0.1]], Continuous)?);
/// let plant = weaker.perturbed(&nominal)?;
/// assert!((plant.dc_gain()?[(0, 0)] - 0.9).abs() < 1e-15);
/// let h_y = StateSpace::gain(mat![[1.0]], Continuous)?;
/// let bias = weaker.residual_transfer(&h_y, &nominal)?;
/// assert!((bias.dc_gain()?[(0, 0)] + 0.1).abs() < 1e-15);
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug)]
pub enum Uncertainty<D> {
    /// `G = G_u + ΔG_a` (8a), with as many outputs and inputs as the model.
    Additive(StateSpace<D>),
    /// `G = G_u (I + ΔG_i)` (8b), square in the inputs: actuators and their drives.
    InputMultiplicative(StateSpace<D>),
    /// `G = (I + ΔG_o) G_u` (8c), square in the outputs: sensors and their dynamics.
    OutputMultiplicative(StateSpace<D>),
}

impl<D: TimeDomain> Uncertainty<D> {
    /// The additive uncertainty that turns one model into another, `ΔG_a = G − G_u`.
    ///
    /// The way to look at perturbed matrices, reduction errors and operating points: the two
    /// models need not have the same order.
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of inputs or outputs or the sample times differ.
    pub fn between(nominal: &StateSpace<D>, plant: &StateSpace<D>) -> Result<Self, ModelError> {
        Ok(Self::Additive(plant.difference(nominal)?))
    }

    /// The plant `G` (8a to 8c).
    ///
    /// # Errors
    ///
    /// Returns an error when the sizes or sample times of the two models do not fit.
    pub fn perturbed(&self, nominal: &StateSpace<D>) -> Result<StateSpace<D>, ModelError> {
        match self {
            Self::Additive(delta) => nominal.parallel(delta),
            Self::InputMultiplicative(delta) => plus_identity(delta)?.series(nominal),
            Self::OutputMultiplicative(delta) => nominal.series(&plus_identity(delta)?),
        }
    }

    /// The same uncertainty in additive form: `ΔG_a`, `G_u ΔG_i` or `ΔG_o G_u` (9).
    ///
    /// # Errors
    ///
    /// Returns an error when the sizes or sample times of the two models do not fit.
    pub fn additive(&self, nominal: &StateSpace<D>) -> Result<StateSpace<D>, ModelError> {
        match self {
            Self::Additive(delta) => {
                // Adding nothing checks that the sizes fit.
                nominal.parallel(delta)?;
                Ok(delta.clone())
            }
            Self::InputMultiplicative(delta) => delta.series(nominal),
            Self::OutputMultiplicative(delta) => nominal.series(delta),
        }
    }

    /// The transfer `G_ru = H_y ΔG` (9, 12, 13) from the inputs to the residual, where `h_y` is
    /// the part of the residual generator that acts on the outputs.
    ///
    /// This is the bias term that compensation has to learn; its steady-state gain and norms say
    /// how much there is to gain, its order how rich a bias model it takes.
    ///
    /// # Errors
    ///
    /// Returns an error when the sizes or sample times of the models do not fit.
    pub fn residual_transfer(
        &self,
        h_y: &StateSpace<D>,
        nominal: &StateSpace<D>,
    ) -> Result<StateSpace<D>, ModelError> {
        self.additive(nominal)?.series(h_y)
    }
}

/// `I + Δ`.
fn plus_identity<D: TimeDomain>(delta: &StateSpace<D>) -> Result<StateSpace<D>, ModelError> {
    let size = delta.ny();
    delta.parallel(&StateSpace::gain(Mat::identity(size, size), delta.domain())?)
}
