//! Exact derivatives of trees.

use super::{
    derivative_rules::{binary_slope, unary_slope},
    expr::{Binary, Comparison, Cond, Expr, Lookup},
};

impl Expr {
    /// The partial derivative with respect to `name`, all other names held, simplified.
    ///
    /// Piecewise functions are differentiated piece by piece, and at a kink as the piece that the
    /// evaluation takes there: `abs' = sign`; `sign' = step' = floor' = 0` everywhere (their jumps
    /// have no derivative); `min`, `max`, `clamp` and `if` as the branch taken; a table has the
    /// slope of the interval, at a knot the one to the right. Where the expression itself is
    /// singular (`sqrt(0)`, `0^0.5`), so is the derivative.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// let drag = Expr::parse("c*abs(v)*v")?;
    /// assert_eq!(drag.differentiate("v").to_string(), "c*sign(v)*v + c*abs(v)");
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    #[must_use]
    pub fn differentiate(&self, name: &str) -> Self {
        self.differentiate_with(&|known| (known == name).then_some(Self::Number(1.0)))
            .unwrap_or(Self::Number(0.0))
    }

    /// The total derivative when every name has the derivative that `of_name` gives, `None`
    /// standing for zero. With a name for the derivative of each definition this is the chain rule
    /// through definitions, without writing any of them out.
    #[must_use]
    pub fn differentiate_with(&self, of_name: &impl Fn(&str) -> Option<Self>) -> Option<Self> {
        self.slope(of_name).map(|derivative| derivative.simplify())
    }

    fn slope(&self, of_name: &impl Fn(&str) -> Option<Self>) -> Option<Self> {
        match self {
            Self::Name(name) => of_name(name),
            Self::Unary(function, x) => {
                let inner = x.slope(of_name)?;
                unary_slope(*function, x).map(|outer| outer * inner)
            }
            Self::Binary(Binary::Min, a, b) => {
                choose(less(b, a), b.slope(of_name), a.slope(of_name))
            }
            Self::Binary(Binary::Max, a, b) => {
                choose(less(a, b), b.slope(of_name), a.slope(of_name))
            }
            Self::Binary(operator, a, b) => {
                binary_slope(*operator, a, b, a.slope(of_name), b.slope(of_name))
            }
            Self::Clamp(arguments) => {
                let [x, low, high] = &**arguments;
                let raised = Self::binary(Binary::Max, x.clone(), low.clone());
                let below = choose(less(x, low), low.slope(of_name), x.slope(of_name));
                choose(less(high, &raised), high.slope(of_name), below)
            }
            Self::If(condition, value, otherwise) => {
                choose((**condition).clone(), value.slope(of_name), otherwise.slope(of_name))
            }
            Self::Number(_) | Self::Lookup(Lookup::Slope, ..) => None,
            Self::Lookup(Lookup::Value, table, x) => {
                let inner = x.slope(of_name)?;
                Some(Self::Lookup(Lookup::Slope, table.clone(), x.clone()) * inner)
            }
        }
    }
}

fn less(a: &Expr, b: &Expr) -> Cond {
    Cond::compare(Comparison::Less, a.clone(), b.clone())
}

/// `if(condition, a, b)` where nothing stands for zero.
fn choose(condition: Cond, a: Option<Expr>, b: Option<Expr>) -> Option<Expr> {
    if a.is_none() && b.is_none() {
        return None;
    }
    let or_zero = |x: Option<Expr>| x.unwrap_or(Expr::Number(0.0));
    Some(Expr::choice(condition, or_zero(a), or_zero(b)))
}
