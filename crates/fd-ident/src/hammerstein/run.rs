//! Functions of the inputs at run time, before any bias model or identifier.

use fd_core::{
    Scalar, StateVisitor,
    stage::{BiasModel, GuardReport, Identifier, Stage},
};

use super::{Curve, Expansion};
use crate::error::IdentError;

/// The functions of all inputs.
#[derive(Clone, Debug)]
pub struct Expander<T> {
    curves: Vec<RunningCurve<T>>,
}

#[derive(Clone, Debug)]
struct RunningCurve<T> {
    degree: usize,
    knots: Vec<T>,
    low: T,
    high: T,
}

impl Expansion {
    /// Moves the functions to run time.
    #[must_use]
    pub fn freeze<T: Scalar>(&self) -> Expander<T> {
        Expander::new(&self.curves)
    }
}

impl<T: Scalar> Expander<T> {
    pub(super) fn new(curves: &[Curve]) -> Self {
        let t = T::from_design;
        let running = |curve: &Curve| RunningCurve {
            degree: curve.degree,
            knots: curve.knots.iter().map(|&knot| t(knot)).collect(),
            low: t(curve.low),
            high: t(curve.high),
        };
        Self { curves: curves.iter().map(running).collect() }
    }

    /// Writes the functions of all inputs, those of input 0 first. NaN gives NaN.
    pub fn expand_into(&self, u: &[T], x: &mut [T]) {
        let mut rest = x;
        for (curve, &u) in self.curves.iter().zip(u) {
            let (now, later) = rest.split_at_mut(curve.degree + curve.knots.len());
            curve.write(u, now);
            rest = later;
        }
    }
}

impl<T: Scalar> RunningCurve<T> {
    fn write(&self, u: T, x: &mut [T]) {
        let (powers, hinges) = x.split_at_mut(self.degree);
        // Beyond the range each power goes on along its tangent at the end of the range.
        let inside = if u < self.low {
            self.low
        } else if u > self.high {
            self.high
        } else {
            u
        };
        let (mut power, mut exponent) = (T::one(), T::zero());
        for x in powers {
            exponent += T::one();
            let slope = exponent * power;
            power *= inside;
            *x = power + slope * (u - inside);
        }
        for (x, &knot) in hinges.iter_mut().zip(&self.knots) {
            let beyond = u - knot;
            *x = if beyond < T::zero() { T::zero() } else { beyond };
        }
    }
}

/// A bias model or identifier that sees functions of the inputs in their place.
///
/// # Examples
///
/// A recursive Hammerstein model of second degree:
///
/// ```
/// use fd_core::stage::Identifier;
/// use fd_ident::{
///     arx::{ArxOrders, RecursiveArx},
///     hammerstein::{Basis, Expanded, Expansion},
///     rls::{RlsDesign, UdRls},
/// };
/// use fd_model::{Channel, Record, SampleTime};
///
/// let (one, ts) = (Channel::numbered("c", 1), SampleTime::new(0.1)?);
/// let training = Record::new(one.clone(), one, vec![-1.0, 1.0], vec![0.0; 2], ts)?;
/// let curve = Expansion::from_training(Basis::Polynomial { degree: 2 }, &[training])?;
/// let orders = ArxOrders::new(1, 1, 0);
/// let kernel = UdRls::<f64>::new(orders.parameters(2), &RlsDesign::default())?;
/// let arx = RecursiveArx::new(orders, 2, 1, kernel)?;
/// let mut identifier = Expanded::new(&curve, arx)?;
/// identifier.update(&[0.5], &[0.25]);
/// assert_eq!(Identifier::<f64>::nu(&identifier), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Expanded<T, S> {
    expander: Expander<T>,
    nu: usize,
    inner: S,
    x: Vec<T>,
}

impl<T: Scalar, S: Stage<T>> Expanded<T, S> {
    /// Puts functions of the inputs before a stage that takes as many inputs as there are
    /// functions.
    ///
    /// # Errors
    ///
    /// Returns an error when there are no functions.
    pub fn new(expansion: &Expansion, inner: S) -> Result<Self, IdentError> {
        let width = expansion.expanded_len();
        if width == 0 {
            let (setting, expected) = ("number of input functions", "at least 1");
            return Err(IdentError::Setting { setting, expected, found: 0.0 });
        }
        let x = vec![T::zero(); width];
        Ok(Self { expander: expansion.freeze(), nu: expansion.nu(), inner, x })
    }

    /// The stage behind the functions.
    pub fn inner(&self) -> &S {
        &self.inner
    }
}

impl<T: Scalar, S: Stage<T>> Stage<T> for Expanded<T, S> {
    fn reset(&mut self) {
        self.inner.reset();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.inner.visit_state(visitor);
    }
}

impl<T: Scalar, S: BiasModel<T>> BiasModel<T> for Expanded<T, S> {
    fn nu(&self) -> usize {
        self.nu
    }

    fn residual_len(&self) -> usize {
        self.inner.residual_len()
    }

    fn theta_len(&self) -> usize {
        self.inner.theta_len()
    }

    fn load(&mut self, theta: &[T]) {
        self.inner.load(theta);
    }

    fn observe(&mut self, u: &[T], mu: &[T]) {
        self.expander.expand_into(u, &mut self.x);
        self.inner.observe(&self.x, mu);
    }

    fn simulate(&mut self, u: &[T], mu_hat: &mut [T]) {
        self.expander.expand_into(u, &mut self.x);
        self.inner.simulate(&self.x, mu_hat);
    }

    fn predict(&mut self, u: &[T], r: &[T], mu_hat: &mut [T]) {
        self.expander.expand_into(u, &mut self.x);
        self.inner.predict(&self.x, r, mu_hat);
    }
}

impl<T: Scalar, S: Identifier<T>> Identifier<T> for Expanded<T, S> {
    fn nu(&self) -> usize {
        self.nu
    }

    fn residual_len(&self) -> usize {
        self.inner.residual_len()
    }

    fn update(&mut self, u: &[T], mu: &[T]) {
        self.expander.expand_into(u, &mut self.x);
        self.inner.update(&self.x, mu);
    }

    fn theta(&self) -> &[T] {
        self.inner.theta()
    }

    fn variance_into(&self, variance: &mut [T]) {
        self.inner.variance_into(variance);
    }

    fn guard(&self) -> GuardReport {
        self.inner.guard()
    }

    fn retrain(&mut self, theta: &[T]) -> bool {
        self.inner.retrain(theta)
    }
}
