//! Where iterations start: the values that the model itself has at the start of a run.

use std::collections::HashSet;

use fd_sim::equation::{CompileError, Expr, Program, Scope};

use crate::equations::{EquationModel, Relation, logged};

/// A program for all unknowns of a model, from parameters, `dt`, time, `first`, and the known signals, with states at
/// their initial values and signals that are not known at zero.
pub(super) fn guesses(model: &EquationModel, knowns: &[String]) -> Result<Program, CompileError> {
    let structure = &model.structure;
    let mut definitions = model.constants.clone();
    let mut defined: HashSet<String> = HashSet::new();
    for (equation, relation) in structure.equations.iter().zip(&model.relations) {
        let dynamics = equation.dynamics.map(|d| {
            let name = |of: usize| structure.unknowns[of].clone();
            (name(d.state), name(d.rate))
        });
        let definition = match (relation, dynamics) {
            (Relation::Equal { left, right } | Relation::Sampled { left, right }, _) => {
                match left {
                    Expr::Name(name) if structure.unknowns.contains(name) => {
                        Some((name.clone(), right.clone()))
                    }
                    _ => None,
                }
            }
            (Relation::Derivative { initial } | Relation::Update { initial }, Some((state, _))) => {
                Some((state, Expr::Number(*initial)))
            }
            // Nothing has moved yet.
            (Relation::Delay, Some((state, rate))) => Some((state, Expr::Name(rate))),
            _ => None,
        };
        if let Some((name, expr)) = definition
            && defined.insert(name.clone())
        {
            definitions.push((name, expr));
        }
    }
    let unknown_logs =
        structure.knowns.iter().filter(|log| !knowns.iter().any(|k| logged(k) == **log));
    definitions.extend(unknown_logs.map(|log| (log.clone(), Expr::Number(0.0))));
    let parameters = model.source.parameters.iter().map(|parameter| parameter.name.clone());
    let time = ["t".to_owned(), "first".to_owned()].into_iter();
    let scope = Scope {
        slow: parameters.chain(["dt".to_owned()]).collect(),
        fast: time.chain(knowns.iter().map(|name| logged(name))).collect(),
        definitions,
        tables: model.source.tables.iter().map(|t| (t.name.clone(), t.table.clone())).collect(),
    };
    let all: Vec<Expr> = structure.unknowns.iter().map(Expr::name).collect();
    Program::compile(&scope, &all)
}
