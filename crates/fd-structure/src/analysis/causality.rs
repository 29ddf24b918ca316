//! The overdetermined part as seen by tests of restricted causality.

use serde::Serialize;

use crate::{
    graph::{Decomposition, Graph},
    model::{EquationSet, StructuralModel},
};

/// In which direction dynamic constraints may be used to compute something.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Causality {
    /// In both: signals may be integrated and differentiated.
    #[default]
    Mixed,
    /// States from rates. Initial values must be known or forgotten; noise does no harm.
    Integral,
    /// Rates from states. No initial values; signals are differentiated, noise and all.
    Derivative,
}

impl Causality {
    /// All three.
    pub const ALL: [Self; 3] = [Self::Mixed, Self::Integral, Self::Derivative];

    /// Its name in texts.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Mixed => "mixed",
            Self::Integral => "integral",
            Self::Derivative => "derivative",
        }
    }
}

/// Equations and unknowns of a model that are still looked at.
struct Rest<'a> {
    model: &'a StructuralModel,
    equations: EquationSet,
    has_unknown: Vec<bool>,
}

impl StructuralModel {
    /// Those of some equations that a test of this causality can use: the part in which faults are
    /// detected.
    ///
    /// Mixed causality gives the overdetermined part `M+`; the others are the largest subsets of it of which all
    /// unknowns can be computed in that way (Frisk, Bregon, Åslund, Krysander, Pulido and Biswas 2012,
    /// algorithms for `M+int` and `M+der`). Numbers out of range are left out.
    #[must_use]
    pub fn overdetermined(&self, equations: &[usize], causality: Causality) -> EquationSet {
        let known = equations.iter().copied().filter(|&equation| equation < self.equations.len());
        let mut equations: EquationSet = known.collect();
        equations.sort_unstable();
        equations.dedup();
        let has_unknown = vec![true; self.unknowns.len()];
        let rest = Rest { model: self, equations, has_unknown };
        match causality {
            Causality::Mixed => rest.over().equations,
            Causality::Integral => rest.integral(),
            Causality::Derivative => rest.derivative(),
        }
    }
}

impl Rest<'_> {
    /// The edges that `keep`s equations and unknowns.
    fn graph(&self, keep: impl Fn(usize, usize) -> bool) -> Graph {
        let keep = &keep;
        let rows = self.equations.iter().map(|&equation| {
            let unknowns = self.model.equations[equation].unknowns.iter().copied();
            unknowns.filter(|&x| self.has_unknown[x] && keep(equation, x)).collect()
        });
        Graph::new(rows, self.model.unknowns.len())
    }

    /// The overdetermined part, with its own unknowns alone.
    fn over(&self) -> Self {
        let over = Decomposition::of(&self.graph(|_, _| true)).over;
        let mut has_unknown = vec![false; self.has_unknown.len()];
        over.columns.iter().for_each(|&x| has_unknown[x] = true);
        let equations = over.rows.iter().map(|&row| self.equations[row]).collect();
        Self { model: self.model, equations, has_unknown }
    }

    /// Without the equations in which any of these unknowns occurs.
    fn without_equations_of(&mut self, is_lost: impl Fn(usize) -> bool) {
        let (model, has_unknown) = (self.model, &self.has_unknown);
        self.equations.retain(|&equation| {
            let mut unknowns = model.equations[equation].unknowns.iter();
            !unknowns.any(|&x| has_unknown[x] && is_lost(x))
        });
    }

    /// What cannot be computed without differentiation is given up, again and again.
    fn integral(mut self) -> EquationSet {
        loop {
            self = self.over();
            let model = self.model;
            let forwards = self.graph(|equation, x| {
                model.equations[equation].dynamics.is_none_or(|dynamics| dynamics.rate != x)
            });
            let mut is_lost = vec![false; self.has_unknown.len()];
            let under = Decomposition::of(&forwards).under;
            for x in under.columns.into_iter().filter(|&x| self.has_unknown[x]) {
                is_lost[x] = true;
            }
            if !is_lost.contains(&true) {
                return self.equations;
            }
            self.without_equations_of(|x| is_lost[x]);
        }
    }

    /// What can be computed without integration is gathered, from known states on.
    fn derivative(mut self) -> EquationSet {
        let all = std::mem::replace(&mut self.has_unknown, vec![true; self.model.unknowns.len()]);
        let mut computed = vec![false; all.len()];
        loop {
            self.has_unknown =
                all.iter().zip(&computed).map(|(&has, &computed)| has && !computed).collect();
            let open: Vec<usize> = (0..self.equations.len())
                .filter(|&row| {
                    let dynamics = self.model.equations[self.equations[row]].dynamics;
                    dynamics.is_none_or(|dynamics| !self.has_unknown[dynamics.state])
                })
                .collect();
            let graph = self.graph(|_, _| true);
            let usable = Graph::new(
                open.iter().map(|&row| graph.rows()[row].clone()),
                self.model.unknowns.len(),
            );
            let parts = Decomposition::of(&usable);
            let new = parts.just.iter().chain([&parts.over]).flat_map(|part| &part.columns);
            let mut is_new = false;
            for &x in new {
                is_new |= !std::mem::replace(&mut computed[x], true);
            }
            if !is_new {
                break;
            }
        }
        self.has_unknown = all;
        self.without_equations_of(|x| !computed[x]);
        self.over().equations
    }
}
