//! Difference equations as design-time models.

use fd_core::{Scalar, Shape, ShapeError, stage::BiasModel};
use fd_model::SampleTime;

use crate::{
    arx::{ArxOrders, ArxSimulator},
    error::IdentError,
};

/// A difference equation (14) for each residual channel, with known parameters.
///
/// # Examples
///
/// The model printed in section 4 of Patton & Chen (1992), which has a pole near a zero:
///
/// ```
/// use fd_ident::arx::{ArxModel, ArxOrders};
/// use fd_model::SampleTime;
///
/// let theta = vec![-1.430808, 0.432895, -0.002161, 0.002153, 0.0];
/// let model = ArxModel::new(ArxOrders::paper(2), 1, 1, theta, SampleTime::new(0.02)?)?;
/// assert!(model.is_stable()?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ArxModel {
    orders: ArxOrders,
    nu: usize,
    ny: usize,
    theta: Vec<f64>,
    ts: SampleTime,
}

impl ArxModel {
    /// A model from parameters in the order of [`ArxOrders`], those of residual channel 0 first.
    ///
    /// # Errors
    ///
    /// Returns an error when the orders leave no parameters, when `theta` has another length, or
    /// when a parameter is not finite.
    pub fn new(
        orders: ArxOrders,
        nu: usize,
        ny: usize,
        theta: Vec<f64>,
        ts: SampleTime,
    ) -> Result<Self, IdentError> {
        let n = orders.checked_parameters(nu)?;
        if theta.len() != n * ny {
            let (expected, found) = (Shape::new(n * ny, 1), Shape::new(theta.len(), 1));
            return Err(ShapeError { role: "parameters theta", expected, found }.into());
        }
        if let Some(row) = theta.iter().position(|v| !v.is_finite()) {
            let (role, col, value) = ("parameters theta", 0, theta[row]);
            return Err(IdentError::NonFinite { role, row, col, value });
        }
        Ok(Self { orders, nu, ny, theta, ts })
    }

    /// Orders of every channel.
    #[must_use]
    pub fn orders(&self) -> ArxOrders {
        self.orders
    }

    /// Number of inputs.
    #[must_use]
    pub fn nu(&self) -> usize {
        self.nu
    }

    /// Number of residual channels.
    #[must_use]
    pub fn residual_len(&self) -> usize {
        self.ny
    }

    /// Time between samples.
    #[must_use]
    pub fn ts(&self) -> SampleTime {
        self.ts
    }

    /// All parameters, those of residual channel 0 first.
    #[must_use]
    pub fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Parameters of one residual channel.
    ///
    /// # Panics
    ///
    /// Panics when there is no such channel, as indexing a slice does; so do the other accessors.
    #[must_use]
    pub fn channel(&self, channel: usize) -> &[f64] {
        let n = self.orders.parameters(self.nu);
        &self.theta[channel * n..(channel + 1) * n]
    }

    /// `a₁ … a_na` of one residual channel.
    #[must_use]
    pub fn a(&self, channel: usize) -> &[f64] {
        &self.channel(channel)[..self.orders.na]
    }

    /// `b₀ … b_{nb−1}` from one input to one residual channel; the delay is not in it.
    #[must_use]
    pub fn b(&self, channel: usize, input: usize) -> impl ExactSizeIterator<Item = f64> + '_ {
        let start = self.orders.na;
        (0..self.orders.nb).map(move |i| self.channel(channel)[start + i * self.nu + input])
    }

    /// Constant term of one residual channel, zero when the orders have none.
    #[must_use]
    pub fn offset(&self, channel: usize) -> f64 {
        match self.channel(channel).last() {
            Some(&constant) if self.orders.offset => constant,
            _ => 0.0,
        }
    }

    pub(crate) fn channel_mut(&mut self, channel: usize) -> &mut [f64] {
        let n = self.orders.parameters(self.nu);
        &mut self.theta[channel * n..(channel + 1) * n]
    }

    /// Moves the model to run time.
    ///
    /// # Errors
    ///
    /// Never fails for a model that was checked by [`ArxModel::new`].
    pub fn freeze<T: Scalar>(&self) -> Result<ArxSimulator<T>, IdentError> {
        let mut simulator = ArxSimulator::new(self.orders, self.nu, self.ny)?;
        let theta: Vec<T> = self.theta.iter().map(|&v| T::from_design(v)).collect();
        simulator.load(&theta);
        Ok(simulator.keeping_parameters())
    }
}
