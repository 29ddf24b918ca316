//! Structural models: which unknowns, known signals and faults occur in which equation, and no more.

mod builder;
mod error;

use serde::Serialize;

pub use self::{builder::Builder, error::StructureError};
use crate::graph::{Decomposition, Graph};

/// A set of equations, by number, in order.
pub type EquationSet = Vec<usize>;

/// Which variables occur in which equation.
///
/// ```
/// use fd_structure::model::StructuralModel;
///
/// // A tank with an inflow that is known and a level that is measured twice.
/// let tank = StructuralModel::builder("tank")
///     .equation("balance", ["h'", "q"], ["u"])
///     .equation("outflow", ["h", "q"], [])
///     .differential("h", "h'")
///     .equation("sensor 1", ["h"], ["y1"])
///     .equation("sensor 2", ["h"], ["y2"])
///     .fault("leak", "balance")
///     .fault("clogging", "outflow")
///     .fault("f1", "sensor 1")
///     .fault("f2", "sensor 2")
///     .build()?;
/// assert_eq!(tank.decompose().redundancy(), 2);
/// // The two sensors against each other, and each with the model of the tank.
/// assert_eq!(tank.mso_sets(100).sets, [vec![0, 1, 2, 3], vec![0, 1, 2, 4], vec![3, 4]]);
/// # Ok::<(), fd_structure::model::StructureError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct StructuralModel {
    pub(crate) name: String,
    pub(crate) equations: Vec<Equation>,
    pub(crate) unknowns: Vec<String>,
    pub(crate) knowns: Vec<String>,
    pub(crate) faults: Vec<Fault>,
}

/// An equation.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Equation {
    /// Its name.
    pub name: String,
    /// Unknowns in it, by number, in order.
    pub unknowns: Vec<usize>,
    /// Known signals in it, by number.
    pub knowns: Vec<usize>,
    /// The state and the rate of a dynamic constraint, which are then its only unknowns.
    pub dynamics: Option<Dynamics>,
}

/// A constraint by which a rate determines a state in the course of time: `d/dt state = rate`.
///
/// The state follows from the rate by integration and a known initial value (*integral causality*),
/// the rate from the state by differentiation (*derivative causality*). A state that is updated from step to
/// step, and a delayed signal, are of the same kind: forwards one remembers, backwards one would have
/// to know the future.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Dynamics {
    /// Number of the unknown that is remembered.
    pub state: usize,
    /// Number of the unknown that moves it.
    pub rate: usize,
}

/// A fault: the equation that it enters does not hold while it is there.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Fault {
    /// Its name.
    pub name: String,
    /// Number of the equation.
    pub equation: usize,
}

impl StructuralModel {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The equations.
    #[must_use]
    pub fn equations(&self) -> &[Equation] {
        &self.equations
    }

    /// Names of the unknowns.
    #[must_use]
    pub fn unknowns(&self) -> &[String] {
        &self.unknowns
    }

    /// Names of the known signals.
    #[must_use]
    pub fn knowns(&self) -> &[String] {
        &self.knowns
    }

    /// The faults.
    #[must_use]
    pub fn faults(&self) -> &[Fault] {
        &self.faults
    }

    /// Names of some equations.
    #[must_use]
    pub fn names_of(&self, equations: &[usize]) -> Vec<&str> {
        let known = equations.iter().filter_map(|&equation| self.equations.get(equation));
        known.map(|equation| equation.name.as_str()).collect()
    }

    /// Which unknowns occur in these equations; numbers out of range are left out.
    #[must_use]
    pub fn graph_of(&self, equations: &[usize]) -> Graph {
        let known = equations.iter().filter_map(|&equation| self.equations.get(equation));
        Graph::new(known.map(|equation| equation.unknowns.clone()), self.unknowns.len())
    }

    /// Which unknowns occur in which equation.
    #[must_use]
    pub fn graph(&self) -> Graph {
        let rows = self.equations.iter().map(|equation| equation.unknowns.clone());
        Graph::new(rows, self.unknowns.len())
    }

    /// The Dulmage-Mendelsohn decomposition; rows are equations, columns unknowns.
    #[must_use]
    pub fn decompose(&self) -> Decomposition {
        Decomposition::of(&self.graph())
    }

    /// Equations less unknowns of the overdetermined part of some equations.
    #[must_use]
    pub fn redundancy(&self, equations: &[usize]) -> usize {
        Decomposition::of(&self.graph_of(equations)).redundancy()
    }
}
