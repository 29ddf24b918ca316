//! Walks over a tree: names, replacement, depth.

use std::sync::Arc;

use super::{
    definitions::Size,
    expr::{Cond, Expr},
};

impl Expr {
    /// Calls `visit` for every name in the tree (not for tables), in the order of the text.
    pub fn visit_names<'a>(&'a self, visit: &mut impl FnMut(&'a str)) {
        match self {
            Self::Number(_) => {}
            Self::Name(name) => visit(name),
            Self::Unary(_, x) | Self::Lookup(_, _, x) => x.visit_names(visit),
            Self::Binary(_, a, b) => {
                a.visit_names(visit);
                b.visit_names(visit);
            }
            Self::Clamp(arguments) => arguments.iter().for_each(|x| x.visit_names(visit)),
            Self::If(condition, value, otherwise) => {
                condition.visit(&mut |x| x.visit_names(visit));
                value.visit_names(visit);
                otherwise.visit_names(visit);
            }
        }
    }

    /// Calls `visit` for the name of every table in the tree.
    pub fn visit_tables<'a>(&'a self, visit: &mut impl FnMut(&'a str)) {
        match self {
            Self::Number(_) | Self::Name(_) => {}
            Self::Unary(_, x) => x.visit_tables(visit),
            Self::Lookup(_, table, x) => {
                visit(table);
                x.visit_tables(visit);
            }
            Self::Binary(_, a, b) => {
                a.visit_tables(visit);
                b.visit_tables(visit);
            }
            Self::Clamp(arguments) => arguments.iter().for_each(|x| x.visit_tables(visit)),
            Self::If(condition, value, otherwise) => {
                condition.visit(&mut |x| x.visit_tables(visit));
                value.visit_tables(visit);
                otherwise.visit_tables(visit);
            }
        }
    }

    /// Whether `name` occurs.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// assert!(Expr::parse("a*exp(b)")?.mentions("b"));
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    #[must_use]
    pub fn mentions(&self, name: &str) -> bool {
        let mut found = false;
        self.visit_names(&mut |known| found |= known == name);
        found
    }

    /// The tree with every name for which `replacement` has an expression replaced by it.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// let delayed = Expr::parse("k*u")?.substitute(&|name| (name == "u").then(|| Expr::name("u") + Expr::name("b")));
    /// assert_eq!(delayed.to_string(), "k*(u + b)");
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    #[must_use]
    pub fn substitute(&self, replacement: &impl Fn(&str) -> Option<Self>) -> Self {
        self.map(&|leaf| match leaf {
            Self::Name(name) => replacement(name),
            _ => None,
        })
    }

    /// The tree with a name or table renamed.
    ///
    /// ```
    /// # use fd_sim::equation::Expr;
    /// assert_eq!(Expr::parse("a*f(a)")?.rename("a", "c").to_string(), "c*f(c)");
    /// # Ok::<(), fd_sim::equation::SyntaxError>(())
    /// ```
    #[must_use]
    pub fn rename(&self, from: &str, to: &str) -> Self {
        let renamed = |known: &String| (known == from).then(|| to.to_owned());
        self.map(&|node| match node {
            Self::Name(name) => renamed(name).map(Self::Name),
            Self::Lookup(kind, table, x) => {
                let table = renamed(table)?;
                Some(Self::Lookup(*kind, table, Arc::new(x.rename(from, to))))
            }
            _ => None,
        })
    }

    /// Number of levels of the tree, conditions included.
    #[must_use]
    pub fn depth(&self) -> usize {
        1 + match self {
            Self::Number(_) | Self::Name(_) => 0,
            Self::Unary(_, x) | Self::Lookup(_, _, x) => x.depth(),
            Self::Binary(_, a, b) => a.depth().max(b.depth()),
            Self::Clamp(arguments) => arguments.iter().map(Self::depth).max().unwrap_or(0),
            Self::If(condition, value, otherwise) => {
                condition.depth().max(value.depth()).max(otherwise.depth())
            }
        }
    }

    /// Size of the tree when every name for which `of_name` answers has that size; a name without an
    /// answer is a leaf.
    pub(super) fn size_with(&self, of_name: &dyn Fn(&str) -> Option<Size>) -> Size {
        let join = |parts: &mut dyn Iterator<Item = Size>| {
            let nothing = Size { nodes: 0, levels: 0 };
            parts.fold(nothing, Size::and).below_a_node()
        };
        match self {
            Self::Number(_) => Size::LEAF,
            Self::Name(name) => of_name(name).unwrap_or(Size::LEAF),
            Self::Unary(_, x) | Self::Lookup(_, _, x) => x.size_with(of_name).below_a_node(),
            Self::Binary(_, a, b) => join(&mut [a, b].into_iter().map(|x| x.size_with(of_name))),
            Self::Clamp(arguments) => join(&mut arguments.iter().map(|x| x.size_with(of_name))),
            Self::If(condition, value, otherwise) => {
                let parts = [value, otherwise].into_iter().map(|x| x.size_with(of_name));
                join(&mut parts.chain([condition.size_with(of_name)]))
            }
        }
    }

    /// The tree with every node for which `replace` answers replaced; the rest is shared.
    fn map(&self, replace: &impl Fn(&Self) -> Option<Self>) -> Self {
        self.changed(replace).unwrap_or_else(|| self.clone())
    }

    /// The same; `None` where no node is replaced.
    fn changed(&self, replace: &impl Fn(&Self) -> Option<Self>) -> Option<Self> {
        if let Some(replaced) = replace(self) {
            return Some(replaced);
        }
        let change = |x: &Arc<Self>| x.changed(replace).map(Arc::new);
        Some(match self {
            Self::Number(_) | Self::Name(_) => return None,
            Self::Unary(function, x) => Self::Unary(*function, change(x)?),
            Self::Lookup(kind, table, x) => Self::Lookup(*kind, table.clone(), change(x)?),
            Self::Binary(operator, a, b) => {
                let [a, b] = any([a, b], [change(a), change(b)])?;
                Self::Binary(*operator, a, b)
            }
            Self::Clamp(arguments) => {
                let found = arguments.each_ref().map(|x| x.changed(replace));
                Self::Clamp(Arc::new(any(arguments.each_ref(), found)?))
            }
            Self::If(condition, value, otherwise) => {
                let found = condition.changed(&|x| x.changed(replace)).map(Arc::new);
                let branches = any([value, otherwise], [change(value), change(otherwise)]);
                if found.is_none() && branches.is_none() {
                    return None;
                }
                let [value, otherwise] =
                    branches.unwrap_or_else(|| [Arc::clone(value), Arc::clone(otherwise)]);
                Self::If(found.unwrap_or_else(|| Arc::clone(condition)), value, otherwise)
            }
        })
    }
}

/// What was found, and what was there where nothing was; `None` where nothing was found at all.
fn any<T: Clone, const N: usize>(there: [&T; N], mut found: [Option<T>; N]) -> Option<[T; N]> {
    let is_any = found.iter().any(Option::is_some);
    let either = |i: usize| found[i].take().unwrap_or_else(|| there[i].clone());
    is_any.then(|| std::array::from_fn(either))
}

impl Cond {
    /// Calls `visit` for every compared expression.
    fn visit<'a>(&'a self, visit: &mut dyn FnMut(&'a Expr)) {
        match self {
            Self::Compare(_, a, b) => {
                visit(a);
                visit(b);
            }
            Self::And(a, b) | Self::Or(a, b) => {
                a.visit(visit);
                b.visit(visit);
            }
            Self::Not(a) => a.visit(visit),
        }
    }

    /// The condition with every compared expression replaced.
    pub(super) fn map(&self, replace: &dyn Fn(&Expr) -> Expr) -> Self {
        self.changed(&|x| Some(replace(x))).unwrap_or_else(|| self.clone())
    }

    /// The condition with those compared expressions replaced for which `replace` answers; `None` where there are none.
    fn changed(&self, replace: &dyn Fn(&Expr) -> Option<Expr>) -> Option<Self> {
        let change = |condition: &Arc<Self>| condition.changed(replace).map(Arc::new);
        let both = |a, b| any([a, b], [change(a), change(b)]);
        Some(match self {
            Self::Compare(comparison, a, b) => {
                let [a, b] = any([a, b], [a, b].map(|x| replace(x).map(Arc::new)))?;
                Self::Compare(*comparison, a, b)
            }
            Self::And(a, b) => both(a, b).map(|[a, b]| Self::And(a, b))?,
            Self::Or(a, b) => both(a, b).map(|[a, b]| Self::Or(a, b))?,
            Self::Not(a) => Self::Not(change(a)?),
        })
    }

    fn size_with(&self, of_name: &dyn Fn(&str) -> Option<Size>) -> Size {
        let parts = match self {
            Self::Compare(_, a, b) => a.size_with(of_name).and(b.size_with(of_name)),
            Self::And(a, b) | Self::Or(a, b) => a.size_with(of_name).and(b.size_with(of_name)),
            Self::Not(a) => a.size_with(of_name),
        };
        parts.below_a_node()
    }

    fn depth(&self) -> usize {
        1 + match self {
            Self::Compare(_, a, b) => a.depth().max(b.depth()),
            Self::And(a, b) | Self::Or(a, b) => a.depth().max(b.depth()),
            Self::Not(a) => a.depth(),
        }
    }
}
