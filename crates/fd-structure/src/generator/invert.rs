//! An equation solved for one name, where that can be done for all values.

use fd_sim::equation::{Binary, Expr, Unary};

/// What `name` is if `left = right`; `None` if that cannot be written down.
///
/// Sums, differences, products and quotients in which the name occurs linearly are solved, through `if` with conditions
/// that do not have it, and functions that have an inverse wherever they have a value: `exp`, `ln`, `log10`, `sqrt`,
/// `tanh`, `atan`. A division by a factor that may be zero is written down; where it is zero, the equation does not
/// determine the name, and the result is not finite.
///
/// ```
/// use fd_sim::equation::Expr;
/// use fd_structure::generator::solve_for;
///
/// let (left, right) = (Expr::parse("q")?, Expr::parse("c*sqrt(h - h0)")?);
/// let found = solve_for("h", &left, &right).map(|expr| expr.to_string());
/// assert_eq!(found.as_deref(), Some("(q/c)^2 + h0"));
/// // Two solutions: which one is not in the equation.
/// assert_eq!(solve_for("v", &Expr::parse("F")?, &Expr::parse("c*v^2")?), None);
/// # Ok::<(), fd_sim::equation::SyntaxError>(())
/// ```
#[must_use]
pub fn solve_for(name: &str, left: &Expr, right: &Expr) -> Option<Expr> {
    if let Expr::Name(known) = left
        && known == name
        && !right.mentions(name)
    {
        return Some(right.clone());
    }
    match (left.mentions(name), right.mentions(name)) {
        (true, false) => peel(name, left, right.clone()),
        (false, true) => peel(name, right, left.clone()),
        (true, true) => {
            let difference = linear(name, &(left.clone() - right.clone()))?;
            Some((-difference.rest / difference.factor?).simplify())
        }
        (false, false) => None,
    }
}

/// The name, if `expr = value`.
fn peel(name: &str, expr: &Expr, value: Expr) -> Option<Expr> {
    if let Expr::Name(known) = expr {
        return (known == name).then(|| value.simplify());
    }
    if let Expr::Unary(function, inner) = expr
        && let Some(undone) = undo(*function, value.clone())
    {
        return peel(name, inner, undone);
    }
    if let Expr::Binary(operator, a, b) = expr
        && a.mentions(name) != b.mentions(name)
    {
        let in_first = a.mentions(name);
        let (inner, other) = if in_first { (a, (**b).clone()) } else { (b, (**a).clone()) };
        let rest = match (operator, in_first) {
            (Binary::Add, _) => Some(value.clone() - other),
            (Binary::Sub, true) => Some(value.clone() + other),
            (Binary::Sub, false) => Some(other - value.clone()),
            (Binary::Mul, _) => Some(value.clone() / other),
            (Binary::Div, true) => Some(value.clone() * other),
            (Binary::Div, false) => Some(other / value.clone()),
            _ => None,
        };
        if let Some(rest) = rest {
            return peel(name, inner, rest);
        }
    }
    let found = linear(name, expr)?;
    Some(((value - found.rest) / found.factor?).simplify())
}

/// `x`, if `function(x) = value`, for functions that have at most one such `x`.
fn undo(function: Unary, value: Expr) -> Option<Expr> {
    let one = || Expr::Number(1.0);
    let square = |x: Expr| Expr::binary(Binary::Pow, x, Expr::Number(2.0));
    let ln = |x: Expr| Expr::unary(Unary::Ln, x);
    Some(match function {
        Unary::Neg => -value,
        Unary::Exp => ln(value),
        Unary::Ln => Expr::unary(Unary::Exp, value),
        Unary::Log10 => Expr::binary(Binary::Pow, Expr::Number(10.0), value),
        Unary::Sqrt => square(value),
        Unary::Atan => Expr::unary(Unary::Tan, value),
        Unary::Tanh => Expr::Number(0.5) * ln((one() + value.clone()) / (one() - value)),
        _ => return None,
    })
}

/// `factor*name + rest`; without a factor the name does not occur.
struct Linear {
    factor: Option<Expr>,
    rest: Expr,
}

fn linear(name: &str, expr: &Expr) -> Option<Linear> {
    if !expr.mentions(name) {
        return Some(Linear { factor: None, rest: expr.clone() });
    }
    match expr {
        Expr::Name(_) => Some(Linear { factor: Some(Expr::Number(1.0)), rest: Expr::Number(0.0) }),
        Expr::Unary(Unary::Neg, inner) => {
            let inner = linear(name, inner)?;
            Some(Linear { factor: inner.factor.map(|factor| -factor), rest: -inner.rest })
        }
        Expr::Binary(operator, a, b) => {
            let (a, b) = (linear(name, a)?, linear(name, b)?);
            match operator {
                Binary::Add => {
                    Some(Linear { factor: sum(a.factor, b.factor), rest: a.rest + b.rest })
                }
                Binary::Sub => Some(Linear {
                    factor: sum(a.factor, b.factor.map(|factor| -factor)),
                    rest: a.rest - b.rest,
                }),
                Binary::Mul => match (a.factor, b.factor) {
                    (Some(_), Some(_)) => None,
                    (Some(f), None) => Some(times(f, a.rest, &b.rest)),
                    (None, f) => Some(times(f?, b.rest, &a.rest)),
                },
                Binary::Div if b.factor.is_none() => {
                    let factor = a.factor.map(|factor| factor / b.rest.clone());
                    Some(Linear { factor, rest: a.rest / b.rest })
                }
                _ => None,
            }
        }
        Expr::If(condition, a, b) => {
            // A condition with the name would be decided by what is sought.
            let condition_has =
                Expr::choice((**condition).clone(), 1.0.into(), 0.0.into()).mentions(name);
            let (a, b) = (linear(name, a)?, linear(name, b)?);
            let or_zero = |factor: Option<Expr>| factor.unwrap_or(Expr::Number(0.0));
            let choose = |a, b| Expr::choice((**condition).clone(), a, b);
            (!condition_has).then(|| Linear {
                factor: Some(choose(or_zero(a.factor), or_zero(b.factor))),
                rest: choose(a.rest, b.rest),
            })
        }
        _ => None,
    }
}

fn times(factor: Expr, rest: Expr, by: &Expr) -> Linear {
    Linear { factor: Some(factor * by.clone()), rest: rest * by.clone() }
}

fn sum(a: Option<Expr>, b: Option<Expr>) -> Option<Expr> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a + b),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(expr: &Expr, x: f64) -> f64 {
        let known = |name: &str| Some(if name == "x" { x } else { 0.7 });
        expr.evaluate::<f64>(&known).unwrap()
    }

    #[test]
    fn solutions_solve() {
        for text in [
            "3*x - a*(2 - x)",
            "a/x",
            "a - exp(2*x)",
            "tanh(x/3) + a",
            "log10(x + 3)",
            "ln(x)/a",
            "if(a < 1, 2*x + 1, x)",
            "atan(x/4)",
            "-(a - x)*a + x",
            "sqrt(x + a)",
            "(x + 1)/a - 2*x",
        ] {
            let right = Expr::parse(text).unwrap();
            let solution = solve_for("x", &Expr::name("y"), &right).unwrap();
            let at = 0.9;
            let y = value(&right, at);
            let found = solution
                .evaluate::<f64>(&|name: &str| Some(if name == "y" { y } else { 0.7 }))
                .unwrap();
            // A few roundings of numbers near one, none of them ill conditioned.
            assert!((found - at).abs() < 1e-13, "{text}: {solution}: {found}");
        }
    }

    #[test]
    fn what_has_no_single_solution_is_left_to_iteration() {
        for text in [
            "x^2",
            "sin(x)",
            "x + sign(x)",
            "abs(x)",
            "x*x",
            "if(x < 0, x, 2*x)",
            "x*exp(x)",
            "floor(x)",
        ] {
            assert_eq!(
                solve_for("x", &Expr::name("y"), &Expr::parse(text).unwrap()),
                None,
                "{text}"
            );
        }
    }
}
