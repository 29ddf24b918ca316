//! The meaning of every operator, for any scalar, and evaluation of a tree.
//!
//! Bytecode and tree share these functions, so that they agree to the bit.

use std::any::TypeId;

use fd_core::Scalar;
use fd_numeric::lanes::elementary;
use thiserror::Error;

use super::{
    expr::{Binary, Comparison, Cond, Expr, Lookup, Unary},
    table::Table,
};

/// Largest literal exponent that is computed by multiplication.
const MAX_WHOLE_EXPONENT: f64 = 64.0;

#[inline]
pub(super) fn unary<T: Scalar>(function: Unary, x: T) -> T {
    match function {
        Unary::Neg => -x,
        Unary::Sin => own(x, elementary::sin, T::sin),
        Unary::Cos => own(x, elementary::cos, T::cos),
        Unary::Tan => x.tan(),
        Unary::Asin => x.asin(),
        Unary::Acos => x.acos(),
        Unary::Atan => x.atan(),
        Unary::Sinh => x.sinh(),
        Unary::Cosh => x.cosh(),
        Unary::Tanh => own(x, elementary::tanh, T::tanh),
        Unary::Exp => own(x, elementary::exp, T::exp),
        Unary::Ln => x.ln(),
        Unary::Log10 => x.log10(),
        Unary::Sqrt => x.sqrt(),
        Unary::Abs => x.abs(),
        // Through `f64`, for dual numbers have no `floor`; its derivative is 0.
        Unary::Floor => T::from_design(x.to_report().floor()),
        // What is left is a zero of `sign`, or NaN; the derivative is 0.
        Unary::Sign if T::zero() < x => T::one(),
        Unary::Sign if x < T::zero() => -T::one(),
        Unary::Step if T::zero() <= x => T::one(),
        Unary::Sign | Unary::Step => x * T::zero(),
    }
}

/// For `f64` the function that is computed for several numbers side by side as well, so that both
/// have the same bits; `other` for other scalars.
#[inline]
fn own<T: Scalar>(x: T, ours: fn(f64) -> f64, other: fn(T) -> T) -> T {
    // Known when this is compiled.
    if TypeId::of::<T>() == TypeId::of::<f64>() {
        T::from_design(ours(x.to_report()))
    } else {
        other(x)
    }
}

#[inline]
pub(super) fn binary<T: Scalar>(operator: Binary, a: T, b: T) -> T {
    match operator {
        Binary::Add => a + b,
        Binary::Sub => a - b,
        Binary::Mul => a * b,
        Binary::Div => a / b,
        Binary::Pow => a.powf(b),
        Binary::Atan2 => a.atan2(b),
        Binary::Min => smaller(a, b),
        Binary::Max => larger(a, b),
    }
}

/// The first one when they are equal or cannot be compared.
#[inline]
fn smaller<T: Scalar>(a: T, b: T) -> T {
    if b < a { b } else { a }
}

#[inline]
fn larger<T: Scalar>(a: T, b: T) -> T {
    if a < b { b } else { a }
}

#[inline]
pub(super) fn clamp<T: Scalar>(x: T, low: T, high: T) -> T {
    smaller(larger(x, low), high)
}

#[inline]
pub(super) fn compare<T: Scalar>(comparison: Comparison, a: T, b: T) -> bool {
    match comparison {
        Comparison::Less => a < b,
        Comparison::LessEqual => a <= b,
        Comparison::Greater => b < a,
        Comparison::GreaterEqual => b <= a,
        Comparison::Equal => a == b,
    }
}

/// The literal whole exponent that is computed by multiplication, if `exponent` is one.
pub(super) fn whole_exponent(exponent: &Expr) -> Option<i32> {
    match exponent {
        #[expect(clippy::cast_possible_truncation, reason = "whole and at most 64")]
        Expr::Number(n) if n.fract() == 0.0 && n.abs() <= MAX_WHOLE_EXPONENT => Some(*n as i32),
        _ => None,
    }
}

/// `base^exponent` by squaring, the same on every machine.
#[inline]
pub(super) fn power<T: Scalar>(base: T, exponent: i32) -> T {
    if exponent == 2 {
        return base * base;
    }
    let mut rest = exponent.unsigned_abs();
    let mut square = base;
    let mut product = T::one();
    while rest != 0 {
        if rest & 1 == 1 {
            product *= square;
        }
        square *= square;
        rest >>= 1;
    }
    if exponent < 0 { T::one() / product } else { product }
}

pub(super) fn lookup<T: Scalar>(kind: Lookup, table: &Table, x: T) -> T {
    match kind {
        Lookup::Value => table.value(x),
        Lookup::Slope => table.slope(x),
    }
}

/// What names and tables stand for while a tree is evaluated. Closures from names to numbers are
/// values; a type of one's own can have tables too:
///
/// ```
/// use fd_sim::equation::{Expr, Table, Values};
///
/// struct At<'a> {
///     x: f64,
///     spring: &'a Table,
/// }
///
/// impl Values<f64> for At<'_> {
///     fn value(&self, name: &str) -> Option<f64> {
///         (name == "x").then_some(self.x)
///     }
///
///     fn table(&self, name: &str) -> Option<&Table> {
///         (name == "spring").then_some(self.spring)
///     }
/// }
///
/// let spring = Table::new(vec![0.0, 1.0, 2.0], vec![0.0, 10.0, 40.0], Default::default())?;
/// let force = Expr::parse("-spring(x)")?;
/// assert_eq!(force.evaluate(&At { x: 1.5, spring: &spring })?, -25.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Values<T> {
    /// Value of a name.
    fn value(&self, name: &str) -> Option<T>;

    /// A table; there are none unless this is overridden.
    fn table(&self, _name: &str) -> Option<&Table> {
        None
    }
}

impl<T, F: Fn(&str) -> Option<T>> Values<T> for F {
    fn value(&self, name: &str) -> Option<T> {
        self(name)
    }
}

/// A tree cannot be evaluated.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EvaluationError {
    /// A name has no value.
    #[error("`{0}` has no value")]
    UnknownName(String),
    /// A table does not exist.
    #[error("there is no function or table `{0}`")]
    UnknownTable(String),
}

impl Expr {
    /// Evaluates the tree; slow, for a few evaluations and for tests of the bytecode.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// let kinetic = Expr::parse("m*v^2/2")?;
    /// let values = |name: &str| match name { "m" => Some(3.0), "v" => Some(2.0), _ => None };
    /// assert_eq!(kinetic.evaluate(&values)?, 6.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns the first name or table that `values` does not know; `pi` needs no value.
    pub fn evaluate<T: Scalar>(&self, values: &impl Values<T>) -> Result<T, EvaluationError> {
        Ok(match self {
            Self::Number(value) => T::from_design(*value),
            Self::Name(name) if name == "pi" => T::pi(),
            Self::Name(name) => {
                values.value(name).ok_or_else(|| EvaluationError::UnknownName(name.clone()))?
            }
            Self::Unary(function, x) => unary(*function, x.evaluate(values)?),
            Self::Binary(operator, a, b) => match (operator, whole_exponent(b)) {
                (Binary::Pow, Some(exponent)) => power(a.evaluate(values)?, exponent),
                _ => binary(*operator, a.evaluate(values)?, b.evaluate(values)?),
            },
            Self::Clamp(arguments) => {
                let [x, low, high] = &**arguments;
                clamp(x.evaluate(values)?, low.evaluate(values)?, high.evaluate(values)?)
            }
            Self::If(condition, value, otherwise) => {
                if condition.evaluate(values)? {
                    value.evaluate(values)?
                } else {
                    otherwise.evaluate(values)?
                }
            }
            Self::Lookup(kind, table, x) => {
                let known = values
                    .table(table)
                    .ok_or_else(|| EvaluationError::UnknownTable(table.clone()))?;
                lookup(*kind, known, x.evaluate(values)?)
            }
        })
    }
}

impl Cond {
    /// Evaluates the condition.
    ///
    /// # Errors
    ///
    /// As [`Expr::evaluate`].
    pub fn evaluate<T: Scalar>(&self, values: &impl Values<T>) -> Result<bool, EvaluationError> {
        Ok(match self {
            Self::Compare(comparison, a, b) => {
                compare(*comparison, a.evaluate(values)?, b.evaluate(values)?)
            }
            Self::And(a, b) => a.evaluate(values)? && b.evaluate(values)?,
            Self::Or(a, b) => a.evaluate(values)? || b.evaluate(values)?,
            Self::Not(a) => !a.evaluate(values)?,
        })
    }
}
