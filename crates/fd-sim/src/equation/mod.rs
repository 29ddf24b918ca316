//! Equations as text: parsed, printed, differentiated and compiled.
//!
//! A model is written by people, patched by a diagnosis and printed in a report, so an expression
//! is kept as a tree of what was written ([`Expr`], [`Cond`]); a condition in the place of a
//! number cannot be represented. Speed comes from [`Program`], the bytecode of a set of
//! expressions, in which every value is computed once and what depends on parameters alone is
//! computed once per parameter set.
//!
//! | from | to | by |
//! |---|---|---|
//! | text | tree | [`Expr::parse`] |
//! | tree | text | `Display`; `parse(print(e)) == e` |
//! | tree | tree | [`Expr::differentiate`], [`Expr::simplify`], [`Expr::substitute`] |
//! | trees | bytecode | [`Program::compile`] |
//! | bytecode | numbers | [`Program::run`], for any [`Scalar`](fd_core::Scalar), dual numbers included, or several numbers at once ([`Lanes`]) |
//!
//! The grammar is in `docs/model-equations.md`.

mod compile;
mod derivative_rules;
mod differentiate;
mod error;
mod evaluate;
mod exponential;
mod expr;
mod fuse;
mod interpret;
mod kernel;
mod nearest;
mod order;
mod parse;
mod print;
mod program;
mod registers;
mod simplify;
mod sine;
mod table;
mod token;
mod value;
mod walk;

pub use self::{
    compile::{CompileError, Scope},
    error::{Found, Span, SyntaxError, SyntaxProblem, picture},
    evaluate::{EvaluationError, Values},
    expr::{Binary, Comparison, Cond, Expr, Lookup, Unary},
    nearest::nearest,
    program::{Program, Workspace},
    table::{Outside, Table, TableError},
    token::{RESERVED, is_name, locate},
    value::{Lanes, Value},
};
pub(crate) use self::{
    kernel::{Kernel, Work},
    order::in_order_of_use,
    parse::MAX_DEPTH,
};
