//! The expression tree.

use std::{ops, sync::Arc};

/// An expression whose value is a number. Copies share their parts.
///
/// ```
/// use fd_sim::equation::Expr;
///
/// let torque = Expr::parse("-d*omega - m*g*l*sin(theta)")?;
/// assert_eq!(torque.to_string(), "-d*omega - m*g*l*sin(theta)");
/// assert_eq!(torque.differentiate("omega").to_string(), "-d");
/// # Ok::<(), fd_sim::equation::SyntaxError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub enum Expr {
    /// A literal.
    Number(f64),
    /// A parameter, state, input, definition or built-in constant.
    Name(String),
    /// A function of one argument, or a change of sign.
    Unary(Unary, Arc<Expr>),
    /// An operator or a function of two arguments.
    Binary(Binary, Arc<Expr>, Arc<Expr>),
    /// `clamp(x, low, high) = min(max(x, low), high)`.
    Clamp(Arc<[Expr; 3]>),
    /// `if(condition, value, otherwise)`.
    If(Arc<Cond>, Arc<Expr>, Arc<Expr>),
    /// The value or slope of a table of the model file.
    Lookup(Lookup, String, Arc<Expr>),
}

/// An expression that is true or false.
#[derive(Clone, Debug, PartialEq)]
pub enum Cond {
    /// Two numbers compared.
    Compare(Comparison, Arc<Expr>, Arc<Expr>),
    /// Both hold.
    And(Arc<Cond>, Arc<Cond>),
    /// At least one holds.
    Or(Arc<Cond>, Arc<Cond>),
    /// It does not hold.
    Not(Arc<Cond>),
}

/// Functions of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Unary {
    /// Change of sign, `-x`.
    Neg,
    /// Sine of an angle in radians.
    Sin,
    /// Cosine of an angle in radians.
    Cos,
    /// Tangent of an angle in radians.
    Tan,
    /// Arc sine, in radians.
    Asin,
    /// Arc cosine, in radians.
    Acos,
    /// Arc tangent, in radians.
    Atan,
    /// Hyperbolic sine.
    Sinh,
    /// Hyperbolic cosine.
    Cosh,
    /// Hyperbolic tangent.
    Tanh,
    /// Exponential.
    Exp,
    /// Natural logarithm.
    Ln,
    /// Decimal logarithm.
    Log10,
    /// Square root.
    Sqrt,
    /// Absolute value.
    Abs,
    /// −1, 0 or 1.
    Sign,
    /// Largest integer that is not greater.
    Floor,
    /// Heaviside step: 0 below zero, 1 from zero on.
    Step,
}

/// Operators and functions of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    /// Sum.
    Add,
    /// Difference.
    Sub,
    /// Product.
    Mul,
    /// Quotient.
    Div,
    /// Power; a literal whole exponent is computed by multiplication.
    Pow,
    /// Angle of the point (second, first argument), in radians.
    Atan2,
    /// The smaller one.
    Min,
    /// The larger one.
    Max,
}

/// Comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Comparison {
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `==`
    Equal,
}

/// What is looked up in a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Lookup {
    /// The interpolated value, `table(x)`.
    Value,
    /// The slope at `x`, `slope(table, x)`; at a knot that of the interval to the right.
    Slope,
}

impl Unary {
    /// Functions with the name they have in a text; the change of sign is an operator.
    pub(crate) const NAMED: [(&'static str, Self); 18] = [
        ("sin", Self::Sin),
        ("cos", Self::Cos),
        ("tan", Self::Tan),
        ("asin", Self::Asin),
        ("acos", Self::Acos),
        ("atan", Self::Atan),
        ("sinh", Self::Sinh),
        ("cosh", Self::Cosh),
        ("tanh", Self::Tanh),
        ("exp", Self::Exp),
        ("ln", Self::Ln),
        ("log10", Self::Log10),
        ("sqrt", Self::Sqrt),
        ("abs", Self::Abs),
        ("sign", Self::Sign),
        ("floor", Self::Floor),
        ("step", Self::Step),
        ("heaviside", Self::Step),
    ];

    pub(crate) fn name(self) -> &'static str {
        Self::NAMED.iter().find(|(_, f)| *f == self).map_or("-", |(name, _)| name)
    }
}

impl Binary {
    /// Functions with the name they have in a text; `pow(a, b)` is another way to write `a^b`.
    pub(crate) const NAMED: [(&'static str, Self); 4] =
        [("atan2", Self::Atan2), ("min", Self::Min), ("max", Self::Max), ("pow", Self::Pow)];
}

impl Expr {
    /// A name.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// assert_eq!((Expr::name("k") * Expr::name("x")).to_string(), "k*x");
    /// ```
    pub fn name(name: impl Into<String>) -> Self {
        Self::Name(name.into())
    }

    /// A function of one argument.
    ///
    /// ```
    /// # use fd_sim::equation::{Expr, Unary};
    /// assert_eq!(Expr::unary(Unary::Tanh, Expr::name("v")).to_string(), "tanh(v)");
    /// ```
    #[must_use]
    pub fn unary(function: Unary, argument: Self) -> Self {
        Self::Unary(function, Arc::new(argument))
    }

    /// An operator or function of two arguments.
    ///
    /// ```
    /// # use fd_sim::equation::{Binary, Expr};
    /// let square = Expr::binary(Binary::Pow, Expr::name("v"), Expr::Number(2.0));
    /// assert_eq!(square.to_string(), "v^2");
    /// ```
    #[must_use]
    pub fn binary(operator: Binary, left: Self, right: Self) -> Self {
        Self::Binary(operator, Arc::new(left), Arc::new(right))
    }

    /// `clamp(x, low, high)`.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// let u = Expr::clamp(Expr::name("u"), Expr::Number(-1.0), Expr::Number(1.0));
    /// assert_eq!(u.to_string(), "clamp(u, -1, 1)");
    /// ```
    #[must_use]
    pub fn clamp(x: Self, low: Self, high: Self) -> Self {
        Self::Clamp(Arc::new([x, low, high]))
    }

    /// `if(condition, value, otherwise)`.
    ///
    /// ```
    /// # use fd_sim::equation::{Comparison, Cond, Expr};
    /// let is_open = Cond::compare(Comparison::Less, Expr::name("x"), Expr::Number(0.0));
    /// let leak = Expr::choice(is_open, Expr::name("x"), Expr::Number(0.0));
    /// assert_eq!(leak.to_string(), "if(x < 0, x, 0)");
    /// ```
    #[must_use]
    pub fn choice(condition: Cond, value: Self, otherwise: Self) -> Self {
        Self::If(Arc::new(condition), Arc::new(value), Arc::new(otherwise))
    }
}

impl Cond {
    /// Two numbers compared.
    ///
    /// ```
    /// # use fd_sim::equation::{Comparison, Cond, Expr};
    /// let c = Cond::compare(Comparison::LessEqual, Expr::name("a"), Expr::name("b"));
    /// assert_eq!(c.to_string(), "a <= b");
    /// ```
    #[must_use]
    pub fn compare(comparison: Comparison, left: Expr, right: Expr) -> Self {
        Self::Compare(comparison, Arc::new(left), Arc::new(right))
    }
}

macro_rules! operator {
    ($($operator:ident :: $method:ident),*) => {$(
        /// Builds the tree as written; nothing is simplified.
        impl ops::$operator for Expr {
            type Output = Self;

            fn $method(self, right: Self) -> Self {
                Self::binary(Binary::$operator, self, right)
            }
        }
    )*};
}

operator!(Add::add, Sub::sub, Mul::mul, Div::div);

/// Builds the tree as written; nothing is simplified.
impl ops::Neg for Expr {
    type Output = Self;

    fn neg(self) -> Self {
        Self::unary(Unary::Neg, self)
    }
}

impl From<f64> for Expr {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}
