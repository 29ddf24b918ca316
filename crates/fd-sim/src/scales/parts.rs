//! The parts of a sum: of a force that nearly balances others, more than what is left of them all.

use crate::equation::{Binary, Expr, Unary};

/// Most parts that are looked at: those of a balance that somebody wrote down.
const MOST: usize = 16;

/// What an expression without definitions is the sum of, up to signs, products and quotients multiplied out.
pub(super) fn parts(sum: &Expr) -> Vec<Expr> {
    // Each with what it is still to be multiplied by or divided by, the last one first.
    let mut open: Vec<(&Expr, Vec<(Binary, &Expr)>)> = vec![(sum, Vec::new())];
    let mut found = Vec::new();
    while let Some((expr, mut times)) = open.pop() {
        let is_open = found.len() + open.len() + 2 <= MOST;
        match expr {
            Expr::Unary(Unary::Neg, x) => open.push((x, times)),
            Expr::Binary(Binary::Add | Binary::Sub, a, b) if is_open => {
                open.push((b, times.clone()));
                open.push((a, times));
            }
            Expr::Binary(operator @ (Binary::Mul | Binary::Div), a, b) if is_sum(a) => {
                times.push((*operator, b));
                open.push((a, times));
            }
            Expr::Binary(Binary::Mul, a, b) if is_sum(b) => {
                times.push((Binary::Mul, a));
                open.push((b, times));
            }
            leaf => {
                let factors = times.into_iter().rev();
                found.push(factors.fold(leaf.clone(), |part, (operator, factor)| {
                    Expr::binary(operator, part, factor.clone())
                }));
            }
        }
    }
    found
}

/// Whether there is a sum to be multiplied out.
fn is_sum(expr: &Expr) -> bool {
    match expr {
        Expr::Unary(Unary::Neg, x) | Expr::Binary(Binary::Div, x, _) => is_sum(x),
        Expr::Binary(Binary::Add | Binary::Sub, ..) => true,
        Expr::Binary(Binary::Mul, a, b) => is_sum(a) || is_sum(b),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{model::Model, scales::ReplayScales};

    /// A valve that is opened slowly against its spring: what is left to move its mass is nearly nothing.
    #[test]
    fn a_force_is_as_large_as_what_it_holds() {
        let model: Model = r#"
version = 1
kind = "equations"
name = "valve"
sample_time = 0.1
parameters = { m = { unit = "kg", value = 5.0 }, k = { unit = "N/m", value = 1e5 } }
inputs = { push = { unit = "N" } }
states.x = { unit = "m", initial = 0.0, derivative = "v" }
states.v = { unit = "m/s", initial = 0.0, derivative = "net/m" }
outputs = { stem = { unit = "m", value = "x" } }
definitions = { net = "push - k*x - 2e4*v" }
sites = { guide = { unit = "N", enters = { v = "1/m" }, position = "x", velocity = "v" } }
"#
        .parse()
        .unwrap();
        // A ramp to 2000 N in 100 s: its standard deviation is 2000/√12 = 577 N.
        let u: Vec<f64> = (0..1000_u32).map(|k| 2.0 * f64::from(k)).collect();
        let scales = ReplayScales::of(&model, model.sample_time().unwrap(), &u, 1000).unwrap();
        let site = &scales.sites[0];
        assert!((site.force - 577.0).abs() < 1.0, "{}", site.force);
        assert!(site.motion.std / site.mobility < 1.0, "{:?}", site.motion);
    }

    fn parts_of(text: &str) -> Vec<String> {
        parts(&Expr::parse(text).unwrap()).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn sums_are_multiplied_out() {
        assert_eq!(parts_of("(a*p - k*x - d*v)/m"), ["a*p/m", "k*x/m", "d*v/m"]);
        assert_eq!(parts_of("-(a - b)*c + 2*(d + e)/f"), ["a*c", "b*c", "d*2/f", "e*2/f"]);
        assert_eq!(parts_of("sin(a + b)*c"), ["sin(a + b)*c"]);
    }

    #[test]
    fn what_nobody_wrote_down_stays_a_rest() {
        let text = vec!["x"; 40].join(" + ");
        assert_eq!(parts_of(&text).len(), MOST);
    }
}
