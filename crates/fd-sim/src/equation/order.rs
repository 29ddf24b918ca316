//! Definitions in an order in which each one uses only those before it.

use std::collections::HashMap;

use super::expr::Expr;

/// Definitions that need themselves, in the order in which one uses the next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Cycle(pub(crate) Vec<String>);

/// Indices of those of `definitions` that `roots` need, each after all that it uses.
///
/// Depth-first with a stack of its own, so that a long chain of definitions is no danger.
pub(crate) fn in_order_of_use<'a>(
    definitions: &[(&str, &Expr)],
    roots: impl IntoIterator<Item = &'a Expr>,
) -> Result<Vec<usize>, Cycle> {
    let index: HashMap<&str, usize> =
        definitions.iter().enumerate().map(|(i, (name, _))| (*name, i)).collect();
    let uses = |expr: &Expr| {
        let mut used = Vec::new();
        expr.visit_names(&mut |name| used.extend(index.get(name)));
        used
    };

    let mut is_done = vec![false; definitions.len()];
    let mut is_open = vec![false; definitions.len()];
    let mut order = Vec::new();
    for root in roots {
        let mut stack: Vec<(Option<usize>, Vec<usize>)> = vec![(None, uses(root))];
        while let Some((node, pending)) = stack.last_mut() {
            match pending.pop() {
                Some(next) if is_open[next] => return Err(cycle(definitions, &stack, next)),
                Some(next) if is_done[next] => {}
                Some(next) => {
                    is_open[next] = true;
                    stack.push((Some(next), uses(definitions[next].1)));
                }
                None => {
                    if let Some(node) = *node {
                        is_open[node] = false;
                        is_done[node] = true;
                        order.push(node);
                    }
                    stack.pop();
                }
            }
        }
    }
    Ok(order)
}

fn cycle(
    definitions: &[(&str, &Expr)],
    stack: &[(Option<usize>, Vec<usize>)],
    closing: usize,
) -> Cycle {
    let path = stack.iter().filter_map(|(node, _)| *node).skip_while(|node| *node != closing);
    Cycle(path.chain([closing]).map(|node| definitions[node].0.to_owned()).collect())
}
