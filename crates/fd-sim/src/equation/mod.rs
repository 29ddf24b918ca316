//! Equations as text: parsed, printed, differentiated and compiled.
//!
//! A model is written by people, patched by a diagnosis and printed in a report, so an expression is kept as a
//! syntax tree of what was written ([`Expr`], [`Cond`]); a condition in place of a number cannot be
//! represented. For speed there is [`Program`], the bytecode of a set of expressions, in which every value is
//! computed once, and values that depend on parameters alone are computed once per parameter set.
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
//!
//! # Tree or program
//!
//! [`Expr::evaluate`] walks the tree and looks names up as strings. Use it for a handful of values, for bounds
//! and initial values, and in tests: it is the definition of what an expression means. A [`Program`] gives the
//! same numbers *to the bit*, looks nothing up while it runs, and allocates nothing. Use it for everything that
//! is computed per sample.
//!
//! Compile expressions *together*. Parts that occur in several of them are computed once, also across
//! expressions, so a model is one program for all derivatives and one for all outputs, not a program per
//! equation. Merging never reassociates and never replaces a division by a product, because a diagnosis takes
//! differences of runs and relies on the last digits.
//!
//! # Slow and fast names
//!
//! A [`Scope`] sorts names by how often their values change. *Slow* ones are parameters: whatever depends only
//! on them is moved out of the body and computed by [`Program::prepare`], once per parameter set. *Fast* ones
//! are time, states and inputs. If `prepare` is not called after a slow value has changed, the body continues
//! with the old results. Named *definitions* are neither slow nor fast: they are expressions, in any order;
//! unused ones cost nothing.
//!
//! # Memory, threads, lanes
//!
//! A program is immutable and may be shared between threads. A [`Workspace`] is the memory of one run: create
//! it once, because creating it is the only thing here that allocates. A workspace of [`Lanes<N>`](Lanes)
//! processes `N` runs per instruction. Multiples of eight fill the widest registers. Sums, products, roots,
//! comparisons, sines and exponentials are vectorised; powers and inverse functions go lane by lane.
//!
//! There are no jumps: `if` computes both branches and selects one. The other branch may therefore be infinite
//! or NaN without harm, but its cost is always paid.
//!
//! # Derivatives
//!
//! | to get | use |
//! |---|---|
//! | an expression for people to read, or for another program | [`Expr::differentiate`]; through definitions [`Expr::differentiate_with`] |
//! | one number, exact | a program on dual numbers, which are a [`Scalar`](fd_core::Scalar) |
//! | derivatives of a whole simulation with respect to many parameters | finite differences in lanes, as the fits do |
//!
//! A derivative at a kink (`abs`, `min`, a table, a comparison) is one-sided.
//!
//! # Errors
//!
//! Text that does not parse gives a [`SyntaxError`] with its [`Span`], which [`picture`] draws under the text,
//! and [`nearest`](fd_model::nearest()) suggests the name that was probably meant. [`Program::compile`] finds
//! names that are not in the scope and cyclic definitions. Running cannot fail: a logarithm of a negative
//! number is NaN, and the code that steps a simulation checks for that.
//!
//! # When not to use it
//!
//! For equations that are known at compile time: a Rust function is shorter and faster. For matrices: use
//! `fd_model::StateSpace` for a linear model. For algorithms with loops or memory: implement a
//! [`Simulator`](crate::simulate::Simulator).
//!
//! # A worked example
//!
//! A pendulum from its text to one step of several pendulums at once:
//!
//! ```
//! use fd_sim::equation::{Expr, Lanes, Program, Scope};
//!
//! // What a person writes. The square of the natural frequency is a definition.
//! let acceleration = Expr::parse("-w2*sin(angle) - d*speed")?;
//! let scope = Scope {
//!     slow: vec!["g".into(), "length".into(), "d".into()],
//!     fast: vec!["angle".into(), "speed".into()],
//!     definitions: vec![("w2".into(), Expr::parse("g/length")?)],
//!     ..Scope::default()
//! };
//!
//! // How fast it changes with the angle, as a person would write it; other names are held.
//! let stiffness = acceleration.differentiate("angle");
//! assert_eq!(stiffness.to_string(), "-(w2*cos(angle))");
//!
//! // Both in one program: w2 is made once, from slow names alone.
//! let program = Program::compile(&scope, &[acceleration, stiffness])?;
//! let mut workspace = program.workspace::<Lanes<8>>();
//! let lengths = Lanes([0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0]);
//! workspace.slow_mut().copy_from_slice(&[Lanes([9.81; 8]), lengths, Lanes([0.0; 8])]);
//! program.prepare(&mut workspace);
//!
//! workspace.fast_mut().copy_from_slice(&[Lanes([0.1; 8]), Lanes([0.0; 8])]);
//! let mut results = [Lanes([0.0; 8]); 2];
//! program.run(&mut workspace, &mut results);
//! let [acceleration, stiffness] = results;
//! for lane in 0..8 {
//!     let w2 = 9.81 / lengths.0[lane];
//!     assert!((acceleration.0[lane] + w2 * 0.1_f64.sin()).abs() < 1e-14);
//!     assert!((stiffness.0[lane] + w2 * 0.1_f64.cos()).abs() < 1e-13);
//! }
//!
//! // What is wrong is said before anything runs.
//! let typo = Program::compile(&scope, &[Expr::parse("angel + 1")?]);
//! assert_eq!(typo.map_err(|error| error.to_string()).err().as_deref(), Some("`angel` is not defined"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod compile;
mod definitions;
mod derivative_rules;
mod differentiate;
mod error;
mod evaluate;
mod expr;
mod fuse;
mod instruction;
mod interpret;
mod kernel;
mod lanes;
mod order;
mod parse;
mod place;
mod print;
mod program;
mod registers;
mod simplify;
mod table;
mod token;
mod value;
mod walk;

pub use self::{
    compile::{CompileError, Scope},
    definitions::{Definitions, Size},
    error::{Found, Span, SyntaxError, SyntaxProblem, picture},
    evaluate::{EvaluationError, Values},
    expr::{Binary, Comparison, Cond, Expr, Lookup, Unary},
    program::{Program, Workspace},
    table::{Outside, Table, TableError},
    token::{RESERVED, is_name, locate},
    value::{Lanes, Value},
};
pub(crate) use self::{
    definitions::Slopes,
    order::in_order_of_use,
    parse::MAX_DEPTH,
    value::{Kernel, Work},
};
