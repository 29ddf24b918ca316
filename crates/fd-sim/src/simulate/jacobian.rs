//! Exact Jacobians of expressions through their definitions.

use crate::equation::{CompileError, Expr, Program, Scope, in_order_of_use};

/// Compiles the derivatives of `functions` with respect to `variables`, row by row.
///
/// Every definition gets a derivative of its own per variable, so that no expression is written
/// out more than once and the compiler shares what is common.
pub(super) fn jacobian(
    scope: &Scope,
    functions: &[Expr],
    variables: &[String],
) -> Result<Program, CompileError> {
    let named: Vec<(&str, &Expr)> =
        scope.definitions.iter().map(|(name, expr)| (name.as_str(), expr)).collect();
    let order = in_order_of_use(&named, functions)
        .map_err(|cycle| CompileError::Cycle { path: cycle.0 })?;

    let mut with_slopes = scope.clone();
    let mut rows: Vec<Vec<Expr>> = functions.iter().map(|_| Vec::new()).collect();
    for variable in variables {
        let mut with_slope: Vec<&str> = Vec::new();
        let slope = |with_slope: &[&str], expr: &Expr| {
            expr.differentiate_with(&|name| {
                if name == variable {
                    Some(Expr::Number(1.0))
                } else {
                    with_slope.contains(&name).then(|| Expr::Name(slope_name(name, variable)))
                }
            })
        };
        for &index in &order {
            let (name, expr) = named[index];
            if let Some(derivative) = slope(&with_slope, expr) {
                with_slopes.definitions.push((slope_name(name, variable), derivative));
                with_slope.push(name);
            }
        }
        for (row, function) in rows.iter_mut().zip(functions) {
            row.push(slope(&with_slope, function).unwrap_or(Expr::Number(0.0)));
        }
    }
    Program::compile(&with_slopes, &rows.concat())
}

/// A name that no model can have.
fn slope_name(name: &str, variable: &str) -> String {
    format!("d {name}|d {variable}")
}
