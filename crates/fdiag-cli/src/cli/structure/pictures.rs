//! The matrices of a structural analysis.

use fd_report::{Frame, Mark, Matrix};

use super::study::Study;

/// Caption of [`structure`].
pub(super) const STRUCTURE: &str = "Which unknown is in which equation, in the order of the Dulmage-Mendelsohn decomposition: what has \
     more unknowns than equations, then blocks that are just determined, then (last, bottom right) what \
     has more equations than unknowns. I: a state, D: its rate in a dynamic constraint. Right of the \
     unknowns: faults.";
/// Caption of [`isolability`].
pub(super) const ISOLABILITY: &str = "A mark where the fault of the row cannot be isolated from that of the column: by no test (dark), or \
     not by integration (I), not by differentiation (D) alone. Rows that are dark throughout cannot be \
     detected.";

/// Equations by unknowns, in the order of their parts.
pub(super) fn structure(study: &Study<'_>) -> Matrix {
    let (model, parts) = (study.model, &study.parts);
    // Each block after those that it needs would be below the diagonal; turned round it is above.
    let blocks = [&parts.under].into_iter().chain(parts.just.iter().rev()).chain([&parts.over]);
    let (mut rows, mut columns): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
    let mut frames = Vec::new();
    for (number, part) in blocks.enumerate() {
        let (first_row, first_column) = (rows.len(), columns.len());
        rows.extend(&part.rows);
        columns.extend(&part.columns);
        let colour = match number {
            0 => 4,
            last if last == parts.just.len() + 1 => 2,
            _ => 0,
        };
        let (rows, columns) = (first_row..rows.len(), first_column..columns.len());
        if !rows.is_empty() {
            frames.push(Frame { rows, columns, colour });
        }
    }
    let mut marks = Vec::new();
    for (row, &equation) in rows.iter().enumerate() {
        let equation_of = &model.equations()[equation];
        for &x in &equation_of.unknowns {
            let column = columns.iter().position(|&column| column == x).unwrap_or_default();
            let text = match equation_of.dynamics {
                Some(dynamics) if dynamics.state == x => "I",
                Some(_) => "D",
                None => "",
            };
            marks.push(Mark { row, column, text: text.to_owned(), colour: 0 });
        }
        let faults = model.faults().iter().enumerate();
        for (fault, _) in faults.filter(|(_, fault)| fault.equation == equation) {
            let column = columns.len() + fault;
            marks.push(Mark { row, column, text: String::new(), colour: 1 });
        }
    }
    let faults = model.faults().iter().map(|fault| fault.name.clone());
    Matrix {
        title: format!("Structure of {}", model.name()),
        rows: rows.iter().map(|&equation| model.equations()[equation].name.clone()).collect(),
        columns: columns.iter().map(|&x| model.unknowns()[x].clone()).chain(faults).collect(),
        marks,
        frames,
    }
}

/// Faults by faults, in groups.
pub(super) fn isolability(study: &Study<'_>) -> Matrix {
    let model = study.model;
    let groups = study.best().groups();
    let (mut order, mut frames): (Vec<usize>, Vec<Frame>) = (Vec::new(), Vec::new());
    for group in groups {
        let first = order.len();
        order.extend(group);
        let place = first..order.len();
        frames.push(Frame { rows: place.clone(), columns: place, colour: 0 });
    }
    let mut marks = Vec::new();
    for (row, &i) in order.iter().enumerate() {
        for (column, &j) in order.iter().enumerate() {
            let told: Vec<bool> =
                study.causalities.iter().map(|judged| judged.isolability.isolable[i][j]).collect();
            let (text, colour) = match told.as_slice() {
                [true, true, true] => continue,
                [true, false, true] => ("I", 4),
                [true, true, false] => ("D", 4),
                [true, ..] => ("ID", 4),
                _ => ("", 0),
            };
            marks.push(Mark { row, column, text: text.to_owned(), colour });
        }
    }
    let names: Vec<String> = order.iter().map(|&i| model.faults()[i].name.clone()).collect();
    let title = format!("Isolability of faults of {}", model.name());
    Matrix { title, rows: names.clone(), columns: names, marks, frames }
}
