//! The derivative of each function with respect to its arguments.

use super::expr::{Binary, Expr, Unary};

fn one() -> Expr {
    Expr::Number(1.0)
}

fn square(x: Expr) -> Expr {
    Expr::binary(Binary::Pow, x, Expr::Number(2.0))
}

/// `f'(x)`, or `None` where it is zero.
pub(super) fn unary_slope(function: Unary, x: &Expr) -> Option<Expr> {
    let of = |f: Unary| Expr::unary(f, x.clone());
    let x = || x.clone();
    Some(match function {
        Unary::Neg => Expr::Number(-1.0),
        Unary::Sin => of(Unary::Cos),
        Unary::Cos => -of(Unary::Sin),
        Unary::Tan => one() / square(of(Unary::Cos)),
        Unary::Asin => one() / Expr::unary(Unary::Sqrt, one() - square(x())),
        Unary::Acos => Expr::Number(-1.0) / Expr::unary(Unary::Sqrt, one() - square(x())),
        Unary::Atan => one() / (one() + square(x())),
        Unary::Sinh => of(Unary::Cosh),
        Unary::Cosh => of(Unary::Sinh),
        Unary::Tanh => one() - square(of(Unary::Tanh)),
        Unary::Exp => of(Unary::Exp),
        Unary::Ln => one() / x(),
        Unary::Log10 => one() / (x() * Expr::Number(std::f64::consts::LN_10)),
        Unary::Sqrt => Expr::Number(0.5) / of(Unary::Sqrt),
        Unary::Abs => of(Unary::Sign),
        Unary::Sign | Unary::Floor | Unary::Step => return None,
    })
}

/// The derivative of `a ∘ b` when those of `a` and `b` are `da` and `db`, `None` being zero.
///
/// `min` and `max` are differentiated by branch, elsewhere.
pub(super) fn binary_slope(
    operator: Binary,
    a: &Expr,
    b: &Expr,
    da: Option<Expr>,
    db: Option<Expr>,
) -> Option<Expr> {
    let (first, second) = (|| a.clone(), || b.clone());
    match operator {
        Binary::Add => sum(da, db),
        Binary::Sub => difference(da, db),
        Binary::Mul => sum(da.map(|da| da * second()), db.map(|db| first() * db)),
        Binary::Div => {
            difference(da.map(|da| da / second()), db.map(|db| first() * db / square(second())))
        }
        Binary::Pow => {
            let lowered = match b {
                Expr::Number(n) => Expr::Number(n - 1.0),
                _ => second() - one(),
            };
            let in_base = |da| second() * Expr::binary(Binary::Pow, first(), lowered) * da;
            let in_exponent = |db| {
                let log = Expr::unary(Unary::Ln, first());
                Expr::binary(Binary::Pow, first(), second()) * log * db
            };
            sum(da.map(in_base), db.map(in_exponent))
        }
        Binary::Atan2 => {
            let numerator = difference(da.map(|da| second() * da), db.map(|db| first() * db));
            numerator.map(|numerator| numerator / (square(first()) + square(second())))
        }
        Binary::Min | Binary::Max => None,
    }
}

fn sum(a: Option<Expr>, b: Option<Expr>) -> Option<Expr> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a + b),
        (a, b) => a.or(b),
    }
}

fn difference(a: Option<Expr>, b: Option<Expr>) -> Option<Expr> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a - b),
        (None, Some(b)) => Some(-b),
        (a, None) => a,
    }
}
