//! Residual generators of equation models: what is solved for what, and how.

use fd_sim::{
    equation::{CompileError, Expr, Program, Scope},
    simulate::{EquationSimulator, SimulateError},
};
use thiserror::Error;

use super::{
    guess::guesses,
    invert::solve_for,
    newton::Block,
    sequence::{Flow, SequenceError},
};
use crate::{
    equations::{EquationModel, Relation},
    graph::Part,
    model::{Dynamics, EquationSet},
};

/// How a step of a generator is solved.
#[derive(Clone, Debug, PartialEq)]
pub enum How {
    /// By a formula.
    Formula(Expr),
    /// By Newton's method.
    Newton,
}

/// Equations that are solved for unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Solve {
    /// The equations, by number.
    pub equations: EquationSet,
    /// Names of the unknowns.
    pub unknowns: Vec<String>,
    /// How.
    pub how: How,
}

/// A state that is integrated or updated.
#[derive(Clone, Debug)]
pub(super) struct Integrated {
    /// Place of the state among the fast inputs.
    pub state: usize,
    /// Place of its rate.
    pub rate: usize,
    pub initial: f64,
    /// Whether the rate is the next value, not a derivative.
    pub is_update: bool,
}

/// A residual generator that can run.
#[derive(Clone, Debug)]
pub struct Residual {
    pub(super) name: String,
    pub(super) flow: Flow,
    pub(super) knowns: Vec<String>,
    pub(super) solves: Vec<Solve>,
    pub(super) states: Vec<Integrated>,
    pub(super) state_names: Vec<String>,
    pub(super) scope: Scope,
    pub(super) parameters: Vec<f64>,
    pub(super) sample_time: f64,
    pub(super) substeps: usize,
    /// Whether each known signal is drawn as a straight line between samples, or held.
    pub(super) is_linear: Vec<bool>,
    pub(super) blocks: Vec<Block>,
    pub(super) difference: Program,
    /// Values of the fast inputs near which iterations start.
    pub(super) guess: Program,
}

/// No generator can be made that runs.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum GeneratorError {
    /// There is no order of computation.
    #[error(transparent)]
    Sequence(#[from] SequenceError),
    /// The residual would be a dynamic constraint.
    #[error(
        "`{0}` as a residual compares a state with the integral of its rate, which drifts; take another equation of the set"
    )]
    DynamicResidual(String),
    /// Some states would have to be differentiated.
    #[error(
        "with `{residual}` as the residual {} would have to be differentiated; take another equation of the set, or differentiate \
         and smooth outside", states.join(", ")
    )]
    NeedsDerivatives {
        /// Name of the residual equation.
        residual: String,
        /// Names of the states.
        states: Vec<String>,
    },
    /// An equation is of a kind that generators do not compute.
    #[error(
        "`{equation}` is {what}, which a residual generator does not compute; take a set without it"
    )]
    NotSupported {
        /// Name of the equation.
        equation: String,
        /// What it is.
        what: &'static str,
    },
    /// An expression cannot be compiled.
    #[error(transparent)]
    Compile(#[from] CompileError),
    /// The model has no integration step.
    #[error(transparent)]
    Simulate(#[from] SimulateError),
}

/// Time and whether it is the first step: the fast inputs before all signals.
pub(super) const FIRST_SIGNAL: usize = 2;

impl EquationModel {
    /// A residual generator from a minimal overdetermined set, with one of its equations as the residual.
    ///
    /// States are integrated with the steps of a simulation, from their initial values; all other unknowns are solved for
    /// at every stage, by formulas where an equation can be inverted, else by Newton's method.
    ///
    /// ```
    /// use fd_sim::model::Model;
    /// use fd_structure::equations::{EquationModel, FaultPlaces};
    ///
    /// let tank: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "tank"
    /// sample_time = 0.1
    /// inputs = { pump = { unit = "l/s" } }
    /// states = { h = { unit = "dm", initial = 1.0, derivative = "pump - out" } }
    /// definitions = { out = "0.5*sqrt(h)" }
    /// outputs = { level = { unit = "dm", value = "h" }, flow = { unit = "l/s", value = "out" } }
    /// "#.parse()?;
    /// let model = EquationModel::new(&tank, &FaultPlaces::default())?;
    /// let structure = model.structure();
    /// // The level from the measured flow, compared with the measured level: no integral is needed.
    /// let sets = structure.mso_sets(10).sets;
    /// let set = sets.iter().find(|set| set.len() == 3).ok_or("no such set")?;
    /// assert_eq!(structure.names_of(set), ["definition out", "sensor level", "sensor flow"]);
    /// let residual = model.residual(set, set[1])?;
    /// assert_eq!(residual.knowns(), ["level", "flow"]);
    ///
    /// let mut running = residual.start();
    /// assert!(running.step(&[1.44, 0.6])?.abs() < 1e-12);
    /// assert!((running.step(&[1.5, 0.6])? - 0.06).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the set is no minimal overdetermined one, when states would have to be differentiated, and for
    /// delays and sampled controllers in the set.
    pub fn residual(&self, set: &[usize], residual: usize) -> Result<Residual, GeneratorError> {
        let structure = &self.structure;
        let sequence = structure.sequence(set, residual)?;
        let name_of = |equation: usize| structure.equations[equation].name.clone();
        let mut others: EquationSet = set.iter().copied().filter(|&e| e != residual).collect();
        others.sort_unstable();
        others.dedup();
        for &equation in others.iter().chain([&residual]) {
            let what = match self.relations[equation] {
                Relation::Delay => "a delay",
                Relation::Sampled { .. } => "part of a sampled controller",
                _ => continue,
            };
            return Err(GeneratorError::NotSupported { equation: name_of(equation), what });
        }
        let Relation::Equal { left, right } = &self.relations[residual] else {
            return Err(GeneratorError::DynamicResidual(name_of(residual)));
        };

        let (dynamic, algebraic): (EquationSet, EquationSet) =
            others.iter().partition(|&&equation| structure.equations[equation].dynamics.is_some());
        let dynamics: Vec<Dynamics> =
            dynamic.iter().filter_map(|&equation| structure.equations[equation].dynamics).collect();
        let is_state = |x: usize| dynamics.iter().any(|dynamics| dynamics.state == x);
        if structure.rank_in(&algebraic, |x| !is_state(x)) < algebraic.len() {
            let mut states: Vec<usize> = sequence
                .steps
                .iter()
                .flat_map(|step| step.differentiated.iter().copied())
                .collect();
            states.sort_unstable();
            let states = states.into_iter().map(|x| structure.unknowns[x].clone()).collect();
            return Err(GeneratorError::NeedsDerivatives { residual: name_of(residual), states });
        }

        let knowns = self.knowns_of(set);
        let scope = self.scope(&knowns);
        let solves = self.solves(&algebraic, &is_state);
        let blocks: Result<Vec<Block>, CompileError> =
            solves.iter().map(|solve| self.block(solve, &scope)).collect();
        let states = dynamic.iter().zip(&dynamics).map(|(&equation, dynamics)| {
            let (initial, is_update) = match self.relations[equation] {
                Relation::Derivative { initial } => (initial, false),
                Relation::Update { initial } => (initial, true),
                _ => (0.0, false),
            };
            let place = |unknown: usize| FIRST_SIGNAL + unknown;
            let (state, rate) = (place(dynamics.state), place(dynamics.rate));
            Integrated { state, rate, initial, is_update }
        });
        let ts = self.source.sample_time().map_err(SimulateError::from)?;
        // What holds between samples: inputs as the model says, measurements go on a straight line.
        let is_input =
            |name: &String| self.source.external_inputs().iter().any(|c| c.name == *name);
        let holds = self.source.hold == fd_sim::model::Hold::Zero;
        Ok(Residual {
            name: name_of(residual),
            flow: sequence.flow,
            is_linear: knowns.iter().map(|name| !(holds && is_input(name))).collect(),
            states: states.collect(),
            state_names: dynamics.iter().map(|d| structure.unknowns[d.state].clone()).collect(),
            parameters: self.source.nominal(),
            sample_time: ts.seconds(),
            substeps: if dynamics.is_empty() {
                1
            } else {
                EquationSimulator::<f64>::at(&self.source, ts)?.substeps()
            },
            blocks: blocks?,
            difference: Program::compile(&scope, &[left.clone() - right.clone()])?,
            guess: guesses(self, &knowns)?,
            knowns,
            solves,
            scope,
        })
    }

    /// Logged signals in these equations.
    fn knowns_of(&self, set: &[usize]) -> Vec<String> {
        let known = set.iter().flat_map(|&e| self.structure.equations[e].knowns.iter().copied());
        let mut known: Vec<usize> = known.collect();
        known.sort_unstable();
        known.dedup();
        let name = |z: usize| self.structure.knowns[z].trim_start_matches("log.").to_owned();
        known.into_iter().map(name).collect()
    }

    /// Slow: parameters and `dt`. Fast: time, `first`, all unknowns of the model, then the known signals.
    fn scope(&self, knowns: &[String]) -> Scope {
        let parameters = self.source.parameters.iter().map(|parameter| parameter.name.clone());
        let fast = ["t".to_owned(), "first".to_owned()].into_iter();
        let signals = self.structure.unknowns.iter().cloned();
        let logged = knowns.iter().map(|name| crate::equations::logged(name));
        Scope {
            slow: parameters.chain(["dt".to_owned()]).collect(),
            fast: fast.chain(signals).chain(logged).collect(),
            definitions: self.constants.clone(),
            tables: self.source.tables.iter().map(|t| (t.name.clone(), t.table.clone())).collect(),
        }
    }

    /// The blocks of these equations when states are known, in order.
    fn solves(&self, algebraic: &[usize], is_state: &dyn Fn(usize) -> bool) -> Vec<Solve> {
        let rows = algebraic.iter().map(|&equation| {
            let unknowns = self.structure.equations[equation].unknowns.iter().copied();
            unknowns.filter(|&x| !is_state(x)).collect()
        });
        let graph = crate::graph::Graph::new(rows, self.structure.unknowns.len());
        let solve = |block: Part| {
            let equations: EquationSet = block.rows.into_iter().map(|row| algebraic[row]).collect();
            let names = block.columns.iter().map(|&x| self.structure.unknowns[x].clone());
            let unknowns: Vec<String> = names.collect();
            let formula = match (equations.as_slice(), unknowns.as_slice()) {
                ([equation], [unknown]) => match &self.relations[*equation] {
                    Relation::Equal { left, right } => solve_for(unknown, left, right),
                    _ => None,
                },
                _ => None,
            };
            Solve { equations, unknowns, how: formula.map_or(How::Newton, How::Formula) }
        };
        crate::graph::Decomposition::of(&graph).just.into_iter().map(solve).collect()
    }

    fn block(&self, solve: &Solve, scope: &Scope) -> Result<Block, CompileError> {
        let places = solve
            .unknowns
            .iter()
            .map(|name| scope.fast.iter().position(|fast| fast == name).unwrap_or(FIRST_SIGNAL));
        let places: Vec<usize> = places.collect();
        match &solve.how {
            How::Formula(expr) => Ok(Block {
                program: Program::compile(scope, std::slice::from_ref(expr))?,
                places,
                is_formula: true,
            }),
            How::Newton => {
                let differences =
                    solve.equations.iter().filter_map(|&e| match &self.relations[e] {
                        Relation::Equal { left, right } => Some(left.clone() - right.clone()),
                        _ => None,
                    });
                let mut all: Vec<Expr> = differences.collect();
                let slopes: Vec<Expr> = all
                    .iter()
                    .flat_map(|expr| solve.unknowns.iter().map(|name| expr.differentiate(name)))
                    .collect();
                all.extend(slopes);
                Ok(Block { program: Program::compile(scope, &all)?, places, is_formula: false })
            }
        }
    }
}

impl Residual {
    /// The residual equation.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it does with time: algebraic or integral.
    #[must_use]
    pub fn flow(&self) -> Flow {
        self.flow
    }

    /// Names of the logged signals that it takes, in the order in which it takes them.
    #[must_use]
    pub fn knowns(&self) -> &[String] {
        &self.knowns
    }

    /// Names of the states that it integrates.
    #[must_use]
    pub fn states(&self) -> &[String] {
        &self.state_names
    }

    /// What is solved at every instant, in order.
    #[must_use]
    pub fn solves(&self) -> &[Solve] {
        &self.solves
    }
}
