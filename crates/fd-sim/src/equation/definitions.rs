//! Named expressions that use each other: written out where that is short, else differentiated and
//! replaced through their names.
//!
//! A model is a graph: a definition may be used in many places, by definitions that are used in many
//! places themselves. Written out, twenty-two definitions that double the one before are four million
//! terms. Whoever walks over definitions therefore walks over this graph, each definition once, in
//! the order of their use; only what is short is written out.

use std::collections::HashMap;

use super::{
    expr::Expr,
    order::{Cycle, in_order_of_use},
};

/// How large a tree is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Numbers, names, functions and operators.
    pub nodes: u64,
    /// Levels, as [`Expr::depth`] counts them.
    pub levels: u64,
}

impl Size {
    /// A number or name.
    pub(super) const LEAF: Self = Self { nodes: 1, levels: 1 };

    /// What two parts have together.
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            nodes: self.nodes.saturating_add(other.nodes),
            levels: self.levels.max(other.levels),
        }
    }

    /// A node above parts of this size.
    pub(super) fn below_a_node(self) -> Self {
        Self { nodes: self.nodes.saturating_add(1), levels: self.levels.saturating_add(1) }
    }

    /// Whether it is nowhere larger.
    #[must_use]
    pub fn is_within(self, most: Self) -> bool {
        self.nodes <= most.nodes && self.levels <= most.levels
    }
}

/// Named expressions, in any order.
#[derive(Clone, Debug)]
pub struct Definitions<'a> {
    named: Vec<(&'a str, &'a Expr)>,
    places: HashMap<&'a str, usize>,
}

impl<'a> Definitions<'a> {
    /// Definitions with these names; of two with the same name the later one counts.
    ///
    /// ```
    /// use fd_sim::equation::{Definitions, Expr};
    ///
    /// let (a, b) = (Expr::parse("x + x")?, Expr::parse("a*a")?);
    /// let definitions = Definitions::new([("a", &a), ("b", &b)]);
    /// assert_eq!(definitions.size(&Expr::parse("b - 1")?).map(|size| size.nodes), Some(9));
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    pub fn new(named: impl IntoIterator<Item = (&'a str, &'a Expr)>) -> Self {
        let named: Vec<_> = named.into_iter().collect();
        let places = named.iter().enumerate().map(|(i, (name, _))| (*name, i)).collect();
        Self { named, places }
    }

    /// Those that `roots` need, each after all that it uses.
    pub(crate) fn in_order<'r>(
        &self,
        roots: impl IntoIterator<Item = &'r Expr>,
    ) -> Result<Vec<(&'a str, &'a Expr)>, Cycle> {
        let order = in_order_of_use(&self.named, roots)?;
        Ok(order.into_iter().map(|i| self.named[i]).collect())
    }

    /// How large an expression is with everything written out, which it is not for this; `None` when
    /// definitions go round in a circle.
    #[must_use]
    pub fn size(&self, expr: &Expr) -> Option<Size> {
        let mut sizes: HashMap<&str, Size> = HashMap::new();
        for (name, value) in self.in_order([expr]).ok()? {
            let size = value.size_with(&|name| sizes.get(name).copied());
            sizes.insert(name, size);
        }
        Some(expr.size_with(&|name| sizes.get(name).copied()))
    }

    /// The expression with all definitions written out, if that is within `most`.
    ///
    /// ```
    /// use fd_sim::equation::{Definitions, Expr, Size};
    ///
    /// let (a, b) = (Expr::parse("x + x")?, Expr::parse("a*a")?);
    /// let definitions = Definitions::new([("a", &a), ("b", &b)]);
    /// let written = definitions.written_out(&Expr::name("b"), Size { nodes: 7, levels: 3 });
    /// assert_eq!(written.map(|expr| expr.to_string()).as_deref(), Some("(x + x)*(x + x)"));
    /// assert_eq!(definitions.written_out(&Expr::name("b"), Size { nodes: 6, levels: 3 }), None);
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    #[must_use]
    pub fn written_out(&self, expr: &Expr, most: Size) -> Option<Expr> {
        self.size(expr)?.is_within(most).then(|| self.write_out(expr))
    }

    /// Recurses as deeply as the result is nested, which was looked at before.
    fn write_out(&self, expr: &Expr) -> Expr {
        expr.substitute(&|name| {
            let place = self.places.get(name)?;
            Some(self.write_out(self.named[*place].1))
        })
    }
}

/// The derivatives of definitions with respect to one variable, as definitions of their own.
///
/// This is the chain rule: an expression is differentiated once, whatever uses it.
#[derive(Clone, Debug)]
pub(crate) struct Slopes<'a> {
    variable: &'a str,
    /// Definitions that depend on the variable, and what their derivatives are called.
    names: HashMap<&'a str, String>,
    /// The derivatives, each after all that it uses.
    pub definitions: Vec<(String, Expr)>,
}

impl<'a> Slopes<'a> {
    /// Of definitions in the order of their use; `called` gives the derivative of one a name.
    pub(crate) fn of(
        in_order: &[(&'a str, &'a Expr)],
        variable: &'a str,
        mut called: impl FnMut(&str) -> String,
    ) -> Self {
        let mut slopes = Self { variable, names: HashMap::new(), definitions: Vec::new() };
        for (name, expr) in in_order {
            if let Some(slope) = slopes.slope(expr) {
                let slope_name = called(name);
                slopes.definitions.push((slope_name.clone(), slope));
                slopes.names.insert(name, slope_name);
            }
        }
        slopes
    }

    /// The derivative of an expression that uses the definitions; `None` is zero.
    pub(crate) fn slope(&self, expr: &Expr) -> Option<Expr> {
        expr.differentiate_with(&|name| {
            if name == self.variable {
                Some(Expr::Number(1.0))
            } else {
                self.names.get(name).map(Expr::name)
            }
        })
    }
}
