//! Simplification that keeps the value.

use std::sync::Arc;

use super::expr::{Binary, Cond, Expr, Unary};

impl Expr {
    /// The tree with constants folded and neutral elements removed.
    ///
    /// The value stays the same wherever all parts of the expression are finite: constants are
    /// folded with the very operations of the evaluation, and only when the result is finite;
    /// `x + 0`, `x*1`, `x/1`, `x^1`, `--x`, `-1*x` and moving a sign out of a product are exact in
    /// floating point (but for the sign of a zero). `0*x` becomes 0, which hides an `x` that is
    /// infinite or NaN. Nothing is reordered or regrouped.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// assert_eq!(Expr::parse("2*3*x^1 + 0*y")?.simplify().to_string(), "6*x");
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    #[must_use]
    pub fn simplify(&self) -> Self {
        match self {
            Self::Number(_) | Self::Name(_) => self.clone(),
            Self::Unary(Unary::Neg, x) => negated(x.simplify()),
            Self::Unary(function, x) => folded(Self::unary(*function, x.simplify())),
            Self::Binary(operator, a, b) => binary(*operator, a.simplify(), b.simplify()),
            Self::Clamp(arguments) => {
                folded(Self::Clamp(Arc::new(arguments.each_ref().map(Self::simplify))))
            }
            Self::Lookup(kind, table, x) => {
                Self::Lookup(*kind, table.clone(), Arc::new(x.simplify()))
            }
            Self::If(condition, value, otherwise) => {
                let condition = condition.map(&Self::simplify);
                let (value, otherwise) = (value.simplify(), otherwise.simplify());
                match constant_truth(&condition) {
                    Some(true) => value,
                    Some(false) => otherwise,
                    None if value == otherwise => value,
                    None => Self::choice(condition, value, otherwise),
                }
            }
        }
    }

    fn is(&self, number: f64) -> bool {
        #[expect(clippy::float_cmp, reason = "neutral elements are exact")]
        let is_it = matches!(self, Self::Number(value) if *value == number);
        is_it
    }
}

fn no_values(_: &str) -> Option<f64> {
    None
}

fn constant_truth(condition: &Cond) -> Option<bool> {
    condition.evaluate::<f64>(&no_values).ok()
}

/// Replaces a node whose children are all literals by its value, if that is finite. `pi` stays a
/// name: it has another value for another scalar.
fn folded(expr: Expr) -> Expr {
    let is_number = |x: &Expr| matches!(x, Expr::Number(_));
    let is_constant = match &expr {
        Expr::Unary(_, x) => is_number(x),
        Expr::Binary(_, a, b) => is_number(a) && is_number(b),
        Expr::Clamp(arguments) => arguments.iter().all(is_number),
        _ => false,
    };
    match is_constant.then(|| expr.evaluate::<f64>(&no_values)) {
        Some(Ok(value)) if value.is_finite() => Expr::Number(value),
        _ => expr,
    }
}

fn negated(x: Expr) -> Expr {
    match x {
        Expr::Number(value) => Expr::Number(-value),
        Expr::Unary(Unary::Neg, inner) => Arc::unwrap_or_clone(inner),
        other => -other,
    }
}

fn binary(operator: Binary, a: Expr, b: Expr) -> Expr {
    match operator {
        Binary::Add | Binary::Sub if b.is(0.0) => a,
        Binary::Mul | Binary::Div | Binary::Pow if b.is(1.0) => a,
        Binary::Mul | Binary::Div if b.is(-1.0) => negated(a),
        Binary::Pow if b.is(0.0) => Expr::Number(1.0),
        Binary::Add if a.is(0.0) => b,
        Binary::Sub if a.is(0.0) => negated(b),
        Binary::Mul if a.is(0.0) || b.is(0.0) => Expr::Number(0.0),
        Binary::Mul if a.is(1.0) => b,
        Binary::Mul if a.is(-1.0) => negated(b),
        Binary::Add => match b {
            Expr::Unary(Unary::Neg, b) => a - Arc::unwrap_or_clone(b),
            b => folded(a + b),
        },
        Binary::Sub => match b {
            Expr::Unary(Unary::Neg, b) => a + Arc::unwrap_or_clone(b),
            b => folded(a - b),
        },
        Binary::Mul => match (a, b) {
            (Expr::Unary(Unary::Neg, a), Expr::Unary(Unary::Neg, b)) => {
                Arc::unwrap_or_clone(a) * Arc::unwrap_or_clone(b)
            }
            (Expr::Unary(Unary::Neg, a), b) => -(Arc::unwrap_or_clone(a) * b),
            (a, Expr::Unary(Unary::Neg, b)) => -(a * Arc::unwrap_or_clone(b)),
            (a, b) => folded(a * b),
        },
        _ => folded(Expr::binary(operator, a, b)),
    }
}
