//! Transfer functions as ratios of polynomials: written down, realised, evaluated, printed.

use std::fmt;

use faer::{Mat, MatRef, c64};
use fd_core::{Shape, ShapeError};

use crate::{
    domain::TimeDomain,
    error::ModelError,
    linalg::{balance, eigenvalues},
    state_space::StateSpace,
};

/// A proper ratio of two polynomials, highest power first, in `s` or in `z`.
///
/// The coefficients of a polynomial of order ten and more no longer say where its roots are; take
/// [`StateSpace`] for models of that size and this for what people write down.
///
/// # Examples
///
/// ```
/// use faer::c64;
/// use fd_model::{Continuous, TransferFunction};
///
/// // (s + 3)/(s² + 3 s + 2)
/// let g = TransferFunction::new(&[1.0, 3.0], &[1.0, 3.0, 2.0])?;
/// assert_eq!(g.to_string(), "(x + 3)/(x^2 + 3 x + 2)");
/// assert_eq!(g.at(c64::new(1.0, 0.0)).re, 4.0 / 6.0);
/// let system = g.realise(Continuous)?;
/// assert_eq!((system.nx(), system.dc_gain()?[(0, 0)]), (2, 1.5));
/// # Ok::<(), fd_model::ModelError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction {
    numerator: Vec<f64>,
    denominator: Vec<f64>,
}

impl TransferFunction {
    /// A ratio from its coefficients, highest power first; leading zeros are dropped.
    ///
    /// # Errors
    ///
    /// Returns an error when a coefficient is not finite, the denominator is zero, or the ratio is improper:
    /// such a system differentiates, and no [`StateSpace`] does.
    pub fn new(numerator: &[f64], denominator: &[f64]) -> Result<Self, ModelError> {
        for (role, polynomial) in [("numerator", numerator), ("denominator", denominator)] {
            if let Some(col) = polynomial.iter().position(|c| !c.is_finite()) {
                let value = polynomial[col];
                return Err(ModelError::NonFinite { role, row: 0, col, value });
            }
        }
        let trimmed = |p: &[f64]| {
            let first = p.iter().position(|&c| c.abs() > 0.0).unwrap_or(p.len());
            p[first..].to_vec()
        };
        let (mut numerator, denominator) = (trimmed(numerator), trimmed(denominator));
        if denominator.is_empty() {
            return Err(ModelError::Singular { role: "the denominator of a transfer function" });
        }
        if numerator.is_empty() {
            numerator.push(0.0);
        }
        let (requested, available) = (numerator.len() - 1, denominator.len() - 1);
        if available < requested {
            let what = "powers in the denominator: the transfer function would differentiate";
            return Err(ModelError::Order { requested, available, what });
        }
        Ok(Self { numerator, denominator })
    }

    /// A constant.
    ///
    /// # Errors
    ///
    /// Returns an error when the gain is not finite.
    ///
    /// ```
    /// # use fd_model::TransferFunction;
    /// assert_eq!(TransferFunction::gain(2.0)?.to_string(), "2");
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn gain(gain: f64) -> Result<Self, ModelError> {
        Self::new(&[gain], &[1.0])
    }

    /// Coefficients of the numerator, highest power first.
    #[must_use]
    pub fn numerator(&self) -> &[f64] {
        &self.numerator
    }

    /// Coefficients of the denominator, highest power first.
    #[must_use]
    pub fn denominator(&self) -> &[f64] {
        &self.denominator
    }

    /// Degree of the denominator.
    #[must_use]
    pub fn order(&self) -> usize {
        self.denominator.len() - 1
    }

    /// The value at a point of the complex plane; infinite or NaN at a pole.
    #[must_use]
    pub fn at(&self, point: c64) -> c64 {
        horner(&self.numerator, point) / horner(&self.denominator, point)
    }

    /// A realisation, in controllable canonical form with balanced units of its states.
    ///
    /// # Errors
    ///
    /// Never fails for a checked ratio with moderate coefficients; returns an error when they overflow.
    pub fn realise<D: TimeDomain>(&self, domain: D) -> Result<StateSpace<D>, ModelError> {
        let order = self.order();
        let lead = self.denominator[0];
        let missing = order + 1 - self.numerator.len();
        let padded = |k: usize| if k < missing { 0.0 } else { self.numerator[k - missing] / lead };
        let below = |k: usize| self.denominator[k] / lead;
        // States are derivatives, lowest first; num = direct · den + remainder.
        let direct = padded(0);
        let a = Mat::from_fn(order, order, |i, j| match i + 1 {
            row if row == order => -below(order - j),
            row if row == j => 1.0,
            _ => 0.0,
        });
        let b = Mat::from_fn(order, 1, |i, _| if i + 1 == order { 1.0 } else { 0.0 });
        let c = Mat::from_fn(1, order, |_, j| padded(order - j) - direct * below(order - j));
        let scaling = balance(a.as_ref(), b.as_ref(), c.as_ref());
        StateSpace::new(
            scaling.a(a.as_ref()),
            scaling.b(b.as_ref()),
            scaling.c(c.as_ref()),
            Mat::from_fn(1, 1, |_, _| direct),
            domain,
        )
    }

    /// A matrix of transfer functions, one row per output: every entry with states of its own.
    ///
    /// Entries that share poles are realised more than once; residual generators and
    /// [`minimal`](StateSpace::minimal) drop what is double.
    ///
    /// # Errors
    ///
    /// Returns an error when the rows have different lengths, or as [`realise`](Self::realise).
    ///
    /// # Examples
    ///
    /// ```
    /// use fd_model::{Continuous, TransferFunction};
    ///
    /// let ratio = |num: &[f64], den: &[f64]| TransferFunction::new(num, den);
    /// let rows = vec![
    ///     vec![ratio(&[1.0, 1.0], &[1.0, 2.0])?, ratio(&[0.0], &[1.0])?],
    ///     vec![ratio(&[1.0], &[1.0, 3.0])?, TransferFunction::gain(1.0)?],
    /// ];
    /// let system = TransferFunction::realise_matrix(&rows, Continuous)?;
    /// assert_eq!((system.nx(), system.nu(), system.ny()), (2, 2, 2));
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn realise_matrix<D: TimeDomain>(
        rows: &[Vec<Self>],
        domain: D,
    ) -> Result<StateSpace<D>, ModelError> {
        let width = rows.first().map_or(0, Vec::len);
        if let Some(row) = rows.iter().find(|row| row.len() != width) {
            let (expected, found) = (Shape::new(1, width), Shape::new(1, row.len()));
            return Err(ShapeError { role: "row of transfer functions", expected, found }.into());
        }
        let mut all = StateSpace::gain(Mat::zeros(0, width), domain)?;
        for row in rows {
            let mut line = StateSpace::gain(Mat::zeros(1, 0), domain)?;
            for entry in row {
                line = line.beside(&entry.realise(domain)?)?;
            }
            all = all.above(&line)?;
        }
        Ok(all)
    }

    fn written(&self, f: &mut fmt::Formatter<'_>, variable: char) -> fmt::Result {
        let (num, den) = (Written(&self.numerator, variable), Written(&self.denominator, variable));
        if self.order() == 0 {
            let gain = self.numerator[0] / self.denominator[0];
            return write!(f, "{}", Written(&[gain], variable));
        }
        let wrapped = |p: &Written<'_>| {
            let terms = p.0.iter().filter(|c| c.abs() > 0.0).count();
            if 1 < terms { format!("({p})") } else { p.to_string() }
        };
        write!(f, "{}/{}", wrapped(&num), wrapped(&den))
    }
}

/// In the neutral variable `x`; [`StateSpace::transfer_function`] says which one it is.
impl fmt::Display for TransferFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.written(f, if f.alternate() { 's' } else { 'x' })
    }
}

impl<D: TimeDomain> StateSpace<D> {
    /// The transfer function from one input to one output, of the order of the model: poles that
    /// the signals do not see are in both polynomials.
    ///
    /// By characteristic polynomials from eigenvalues,
    /// `num = det(sI − A + b c) − (1 − d) det(sI − A)`; good for a handful of states.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no such channel, or eigenvalues do not converge.
    ///
    /// # Examples
    ///
    /// ```
    /// use faer::mat;
    /// use fd_model::{Continuous, StateSpace};
    ///
    /// let lead = StateSpace::new(mat![[-1.0]], mat![[2.0]], mat![[1.0]], mat![[1.0]], Continuous)?;
    /// assert_eq!(lead.transfer_function(0, 0)?.to_string(), "(x + 3)/(x + 1)");
    /// # Ok::<(), fd_model::ModelError>(())
    /// ```
    pub fn transfer_function(
        &self,
        output: usize,
        input: usize,
    ) -> Result<TransferFunction, ModelError> {
        let one = self.select(&[output], &[input])?;
        // b and c of one size, so that neither drowns A in b c.
        let scaling = balance(one.a(), one.b(), one.c());
        let (a, b, c) = (scaling.a(one.a()), scaling.b(one.b()), scaling.c(one.c()));
        let denominator = characteristic(a.as_ref())?;
        let moved = characteristic((&a - &b * &c).as_ref())?;
        let direct = one.d()[(0, 0)];
        let terms = moved.iter().zip(&denominator);
        let size = |m: &f64, d: &f64| m.abs() + (1.0 + direct.abs()) * d.abs();
        // What cancels to rounding is zero, or the degree would be wrong.
        let clean = |(m, d): (&f64, &f64)| {
            let value = m - (1.0 - direct) * d;
            if value.abs() <= 64.0 * f64::EPSILON * size(m, d) { 0.0 } else { value }
        };
        let numerator: Vec<f64> = terms.map(clean).collect();
        TransferFunction::new(&numerator, &denominator)
    }
}

/// `det(sI − A)`, highest power first.
fn characteristic(a: MatRef<'_, f64>) -> Result<Vec<f64>, ModelError> {
    let mut polynomial = vec![c64::new(1.0, 0.0)];
    for root in eigenvalues(a)? {
        polynomial.push(c64::new(0.0, 0.0));
        for k in (1..polynomial.len()).rev() {
            let before = polynomial[k - 1];
            polynomial[k] -= root * before;
        }
    }
    Ok(polynomial.into_iter().map(|c| c.re).collect())
}

fn horner(polynomial: &[f64], point: c64) -> c64 {
    polynomial.iter().fold(c64::new(0.0, 0.0), |sum, &c| sum * point + c64::new(c, 0.0))
}

/// A polynomial as text.
struct Written<'a>(&'a [f64], char);

impl fmt::Display for Written<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self(polynomial, variable) = self;
        let mut first = true;
        for (k, &c) in polynomial.iter().enumerate() {
            let power = polynomial.len() - 1 - k;
            if c.abs() <= 0.0 {
                continue;
            }
            let sign = match (first, c < 0.0) {
                (true, true) => "-",
                (true, false) => "",
                (false, true) => " - ",
                (false, false) => " + ",
            };
            first = false;
            write!(f, "{sign}")?;
            let size = c.abs();
            let shown = (size * 1e6).round() / 1e6;
            let shown =
                if (1e-3..1e6).contains(&size) { shown.to_string() } else { format!("{size:e}") };
            match power {
                0 => write!(f, "{shown}")?,
                _ if shown == "1" => write!(f, "{variable}")?,
                _ => write!(f, "{shown} {variable}")?,
            }
            if 1 < power {
                write!(f, "^{power}")?;
            }
        }
        if first { write!(f, "0") } else { Ok(()) }
    }
}
