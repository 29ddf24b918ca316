//! Exact Jacobians of expressions through their definitions.

use crate::equation::{CompileError, Definitions, Expr, Program, Scope, Slopes};

/// Compiles the derivatives of `functions` with respect to `variables`, row by row.
///
/// Every definition gets a derivative of its own per variable, so that no expression is written
/// out more than once and the compiler shares what is common.
pub(super) fn jacobian(
    scope: &Scope,
    functions: &[Expr],
    variables: &[String],
) -> Result<Program, CompileError> {
    let named = scope.definitions.iter().map(|(name, expr)| (name.as_str(), expr));
    let in_order = Definitions::new(named).in_order(functions)?;

    let mut with_slopes = scope.clone();
    let mut rows: Vec<Vec<Expr>> = functions.iter().map(|_| Vec::new()).collect();
    for variable in variables {
        let slopes = Slopes::of(&in_order, variable, |name| slope_name(name, variable));
        for (row, function) in rows.iter_mut().zip(functions) {
            row.push(slopes.slope(function).unwrap_or(Expr::Number(0.0)));
        }
        with_slopes.definitions.extend(slopes.definitions);
    }
    Program::compile(&with_slopes, &rows.concat())
}

/// A name that no model can have.
fn slope_name(name: &str, variable: &str) -> String {
    format!("d {name}|d {variable}")
}
