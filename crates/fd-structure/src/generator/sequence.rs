//! The order in which the unknowns of a set are computed, and in which direction of time.

use serde::Serialize;
use thiserror::Error;

use crate::{
    graph::{Decomposition, Graph, Matching, Part},
    model::{EquationSet, StructuralModel},
};

/// What a computation does with time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Flow {
    /// Nothing.
    #[default]
    Algebraic,
    /// It integrates.
    Integral,
    /// It differentiates.
    Derivative,
    /// It does both.
    Mixed,
}

impl Flow {
    fn of(integrates: bool, differentiates: bool) -> Self {
        match (integrates, differentiates) {
            (false, false) => Self::Algebraic,
            (true, false) => Self::Integral,
            (false, true) => Self::Derivative,
            (true, true) => Self::Mixed,
        }
    }
}

/// Equations that are solved together.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Step {
    /// The equations.
    pub equations: EquationSet,
    /// The unknowns that they determine. More than one: a loop.
    pub unknowns: Vec<usize>,
    /// States that are integrated.
    pub integrated: Vec<usize>,
    /// States that are differentiated.
    pub differentiated: Vec<usize>,
}

/// A residual equation, and how everything in it is computed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Sequence {
    /// The equation that is left over.
    pub residual: usize,
    /// The others, each step after those that it needs.
    pub steps: Vec<Step>,
    /// What the whole does with time. A dynamic constraint as the residual counts as an integral.
    pub flow: Flow,
}

/// A set of equations has no sequence.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SequenceError {
    /// The residual is not in the set.
    #[error("equation number {0} is not one of the set, so it cannot be its residual")]
    NotInSet(usize),
    /// The set without the residual does not determine its unknowns exactly.
    #[error(
        "without `{residual}` there are {equations} equations with {unknowns} unknowns that do not determine each other: \
         expected a minimal overdetermined set"
    )]
    NotDetermined {
        /// Name of the residual equation.
        residual: String,
        /// Number of the other equations.
        equations: usize,
        /// Number of the unknowns in them.
        unknowns: usize,
    },
}

impl StructuralModel {
    /// In which order the unknowns of a minimal overdetermined set are computed when this equation is the residual.
    ///
    /// States are integrated wherever a block allows it, and differentiated elsewhere (Frisk et al. 2012).
    ///
    /// ```
    /// use fd_structure::{generator::Flow, model::StructuralModel};
    ///
    /// let lag = StructuralModel::builder("lag")
    ///     .equation("law", ["x", "x'"], ["u"])
    ///     .differential("x", "x'")
    ///     .equation("sensor", ["x"], ["y"])
    ///     .build()?;
    /// // The model beside the plant, or the law asked of the differentiated measurement.
    /// assert_eq!(lag.sequence(&[0, 1, 2], 2)?.flow, Flow::Integral);
    /// assert_eq!(lag.sequence(&[0, 1, 2], 0)?.flow, Flow::Derivative);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the residual is not in the set, or the others do not determine their unknowns.
    pub fn sequence(&self, set: &[usize], residual: usize) -> Result<Sequence, SequenceError> {
        if !set.contains(&residual) || self.equations.len() <= residual {
            return Err(SequenceError::NotInSet(residual));
        }
        let mut others: EquationSet = set
            .iter()
            .copied()
            .filter(|&equation| equation != residual && equation < self.equations.len())
            .collect();
        others.sort_unstable();
        others.dedup();
        let blocks = self.blocks_of(&others).ok_or_else(|| {
            let mut unknowns: Vec<usize> =
                others.iter().flat_map(|&e| self.equations[e].unknowns.iter().copied()).collect();
            unknowns.sort_unstable();
            unknowns.dedup();
            SequenceError::NotDetermined {
                residual: self.equations[residual].name.clone(),
                equations: others.len(),
                unknowns: unknowns.len(),
            }
        })?;
        let steps: Vec<Step> = blocks.into_iter().map(|block| self.step_of(block)).collect();
        let is_dynamic = self.equations[residual].dynamics.is_some();
        let integrates = is_dynamic || steps.iter().any(|step| !step.integrated.is_empty());
        let differentiates = steps.iter().any(|step| !step.differentiated.is_empty());
        Ok(Sequence { residual, steps, flow: Flow::of(integrates, differentiates) })
    }

    /// Blocks of equations, by number in the model, if they determine all their unknowns and no more.
    pub(crate) fn blocks_of(&self, equations: &[usize]) -> Option<Vec<Part>> {
        let parts = Decomposition::of(&self.graph_of(equations));
        let mut occurs = vec![false; self.unknowns.len()];
        equations.iter().flat_map(|&e| &self.equations[e].unknowns).for_each(|&x| occurs[x] = true);
        // Unknowns that occur nowhere count as underdetermined.
        let is_exact = parts.over.rows.is_empty()
            && parts.under.rows.is_empty()
            && parts.under.columns.iter().all(|&x| !occurs[x]);
        let in_model = |part: Part| Part {
            rows: part.rows.into_iter().map(|row| equations[row]).collect(),
            columns: part.columns,
        };
        is_exact.then(|| parts.just.into_iter().map(in_model).collect())
    }

    fn step_of(&self, block: Part) -> Step {
        let mut step = Step { equations: block.rows, unknowns: block.columns, ..Step::default() };
        let dynamics = |equation: usize| self.equations[equation].dynamics;
        // Integrals first: whatever equation has its state in an irreducible block may compute it.
        let mut rest = Part { rows: step.equations.clone(), columns: step.unknowns.clone() };
        while let Some((equation, state)) = self.integrable(&rest) {
            rest.rows.retain(|&row| row != equation);
            rest.columns.retain(|&column| column != state);
            step.integrated.push(state);
        }
        let others = rest.rows.iter().filter_map(|&equation| dynamics(equation));
        step.differentiated = others.map(|dynamics| dynamics.state).collect();
        step
    }

    /// An equation and a state of it that can be matched, and all others still be matched as well.
    fn integrable(&self, rest: &Part) -> Option<(usize, usize)> {
        let rows = rest.rows.iter().map(|&equation| {
            let unknowns = self.equations[equation].unknowns.iter().copied();
            unknowns.filter(|x| rest.columns.contains(x)).collect::<Vec<_>>()
        });
        let graph = Graph::new(rows, self.unknowns.len());
        Decomposition::of(&graph).just.into_iter().find_map(|block| {
            let mut equations = block.rows.iter().map(|&row| rest.rows[row]);
            equations.find_map(|equation| {
                let state = self.equations[equation].dynamics?.state;
                block.columns.contains(&state).then_some((equation, state))
            })
        })
    }

    /// Whether these equations can be solved for as many of these unknowns.
    pub(crate) fn rank_in(&self, equations: &[usize], is_wanted: impl Fn(usize) -> bool) -> usize {
        let rows = equations.iter().map(|&equation| {
            let unknowns = self.equations[equation].unknowns.iter().copied();
            unknowns.filter(|&x| is_wanted(x)).collect::<Vec<_>>()
        });
        Matching::maximum(&Graph::new(rows, self.unknowns.len())).size()
    }
}
