//! Bytecode: a list of instructions on numbered slots.
#![expect(
    clippy::inline_always,
    reason = "what is not inlined into code for wide registers is compiled for narrow ones"
)]

use super::{
    instruction::Instruction,
    interpret::interpret,
    table::Table,
    value::{Kernel, Value, Work},
};

/// A set of expressions, compiled.
///
/// Values live in the slots of a [`Workspace`], in this order: slow inputs (parameters), fast
/// inputs (time, states, inputs), constants, results of instructions. Instructions that need slow
/// inputs alone run in [`Program::prepare`], the others in [`Program::run`].
///
/// A condition is a slot that holds 1 or 0, and `if` computes both branches and takes one: there
/// are no jumps.
///
/// ```
/// use fd_sim::equation::{Expr, Program, Scope};
///
/// let scope = Scope { slow: vec!["k".into()], fast: vec!["x".into()], ..Scope::default() };
/// let program = Program::compile(&scope, &[Expr::parse("-k*x")?, Expr::parse("k*x^2/2")?])?;
///
/// let mut workspace = program.workspace::<f64>();
/// workspace.slow_mut().copy_from_slice(&[4.0]);
/// program.prepare(&mut workspace);
/// workspace.fast_mut().copy_from_slice(&[3.0]);
/// let mut results = [0.0; 2];
/// program.run(&mut workspace, &mut results);
/// assert_eq!(results, [-12.0, 18.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Program {
    pub(super) slow: usize,
    pub(super) fast: usize,
    pub(super) constants: Vec<f64>,
    pub(super) slots: usize,
    pub(super) prologue: Vec<Instruction>,
    pub(super) body: Vec<Instruction>,
    pub(super) results: Vec<u32>,
    pub(super) tables: Vec<Table>,
}

/// The slots of a running [`Program`].
#[derive(Clone, Debug)]
pub struct Workspace<V> {
    slots: Vec<V>,
    slow: usize,
    fast: usize,
}

impl<V> Workspace<V> {
    /// Slow inputs, in the order of [`Scope::slow`](super::Scope::slow).
    pub fn slow_mut(&mut self) -> &mut [V] {
        &mut self.slots[..self.slow]
    }

    /// Fast inputs, in the order of [`Scope::fast`](super::Scope::fast).
    pub fn fast_mut(&mut self) -> &mut [V] {
        &mut self.slots[self.slow..self.slow + self.fast]
    }
}

impl Program {
    /// Slots for one run at a time, with all inputs zero. Allocates.
    #[must_use]
    pub fn workspace<V: Value>(&self) -> Workspace<V> {
        let mut slots = vec![V::constant(0.0); self.slots];
        let first = self.slow + self.fast;
        for (slot, value) in slots[first..].iter_mut().zip(&self.constants) {
            *slot = V::constant(*value);
        }
        Workspace { slots, slow: self.slow, fast: self.fast }
    }

    /// Whether results may depend on a fast input.
    pub(crate) fn reads(&self, fast: usize) -> bool {
        let slot = u32::try_from(self.slow + fast).unwrap_or(u32::MAX);
        let reads = |i: &Instruction| [i.a, i.b, i.c].contains(&slot);
        self.results.contains(&slot) || self.body.iter().any(reads)
    }

    /// Computes what depends on slow inputs alone, to be called whenever they have changed.
    pub fn prepare<V: Value>(&self, workspace: &mut Workspace<V>) {
        V::vectorized(Prepare { program: self, workspace });
    }

    /// Computes the rest and writes the values of the expressions. Allocates nothing.
    ///
    /// # Panics
    ///
    /// Panics when the workspace belongs to another program.
    pub fn run<V: Value>(&self, workspace: &mut Workspace<V>, results: &mut [V]) {
        V::vectorized(Run { program: self, workspace, results });
    }

    /// As [`Program::run`], within other work with the same kernel.
    #[inline(always)]
    pub(crate) fn run_with<V: Value>(
        &self,
        kernel: impl Kernel<V>,
        workspace: &mut Workspace<V>,
        results: &mut [V],
    ) {
        interpret(kernel, &self.body, &self.tables, &mut workspace.slots);
        for i in 0..results.len().min(self.results.len()) {
            results[i] = workspace.slots[self.results[i] as usize];
        }
    }

    /// Number of expressions.
    #[must_use]
    pub fn results(&self) -> usize {
        self.results.len()
    }

    /// Instructions per run, after common parts were merged and slow ones taken out.
    #[must_use]
    pub fn instructions(&self) -> usize {
        self.body.len()
    }
}

struct Prepare<'a, V> {
    program: &'a Program,
    workspace: &'a mut Workspace<V>,
}

impl<V: Value> Work<V> for Prepare<'_, V> {
    #[inline(always)]
    fn run(self, kernel: impl Kernel<V>) {
        let Program { prologue, tables, .. } = self.program;
        interpret(kernel, prologue, tables, &mut self.workspace.slots);
    }
}

struct Run<'a, V> {
    program: &'a Program,
    workspace: &'a mut Workspace<V>,
    results: &'a mut [V],
}

impl<V: Value> Work<V> for Run<'_, V> {
    #[inline(always)]
    fn run(self, kernel: impl Kernel<V>) {
        self.program.run_with(kernel, self.workspace, self.results);
    }
}
