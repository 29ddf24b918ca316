//! The structure of a difference equation and the places of its parameters.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Orders of the difference equation that each residual channel obeys.
///
/// ```text
/// μ(k) + a₁ μ(k−1) + … + a_na μ(k−na) = b₀ u(k−d) + … + b_{nb−1} u(k−d−nb+1) + c
/// ```
///
/// with the delay `d`, a row vector `b_i` over the inputs, and the constant `c` only when asked
/// for. Eq. (14) of Patton & Chen (1992) of order `n` has `na = n`, `nb = n + 1`, `d = 0` and no
/// constant.
///
/// The parameters of one channel are ordered as in eq. (15): `θ = [a₁ … a_na; b₀ … b_{nb−1};
/// c]`, each `b_i` with one entry per input, so that `φ(k) = [−μ(k−1) … −μ(k−na); u(k−d) …
/// u(k−d−nb+1); 1]`.
///
/// # Examples
///
/// ```
/// use fd_ident::arx::ArxOrders;
///
/// let second_order = ArxOrders::paper(2);
/// assert_eq!(second_order, ArxOrders::new(2, 3, 0));
/// assert_eq!(second_order.parameters(1), 5);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArxOrders {
    /// Number of past values of `μ`.
    pub na: usize,
    /// Number of values of each input.
    pub nb: usize,
    /// Samples from an input to its first effect.
    #[serde(default)]
    pub delay: usize,
    /// Whether there is a constant term, for a residual that is not zero at zero input.
    #[serde(default)]
    pub offset: bool,
}

impl ArxOrders {
    /// Orders without a constant term.
    #[must_use]
    pub const fn new(na: usize, nb: usize, delay: usize) -> Self {
        Self { na, nb, delay, offset: false }
    }

    /// The orders of eq. (14).
    #[must_use]
    pub const fn paper(n: usize) -> Self {
        Self::new(n, n + 1, 0)
    }

    /// Adds a constant term.
    #[must_use]
    pub const fn with_offset(self) -> Self {
        Self { offset: true, ..self }
    }

    /// Number of parameters per residual channel with `nu` inputs.
    #[must_use]
    pub const fn parameters(self, nu: usize) -> usize {
        self.na + self.nb * nu + self.offset as usize
    }

    /// How many samples the equation looks back.
    #[must_use]
    pub const fn lag(self) -> usize {
        let inputs = (self.delay + self.nb).saturating_sub(1);
        if self.nb == 0 || inputs < self.na { self.na } else { inputs }
    }
}

impl fmt::Display for ArxOrders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { na, nb, delay, offset } = self;
        write!(f, "na={na} nb={nb} delay={delay}")?;
        if *offset { f.write_str(" with offset") } else { Ok(()) }
    }
}
