//! The names in an expression of a column map.

use fd_sim::equation::Expr;

/// The time of a row, in the language of model files.
pub(super) const TIME: &str = "t";

/// Names of columns in an expression; none where it is no expression, which is said when it is compiled.
pub(super) fn names(text: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    if let Ok(expression) = Expr::parse(text) {
        expression.visit_names(&mut |name| {
            if name != TIME && name != "pi" && !names.iter().any(|known| known == name) {
                names.push(name.to_owned());
            }
        });
    }
    names
}
