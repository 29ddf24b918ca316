//! The tables of a structural analysis.

use fd_report::Table;
use fd_structure::generator::Flow;

use super::study::{Placed, Study};

/// Sets that are shown; all are in `report.json`.
const MOST_ROWS: usize = 20;

impl Study<'_> {
    pub(super) fn tables(&self) -> Vec<Table> {
        let supports = self.supports();
        let mut tables = vec![self.faults(), self.equations(), supports, self.residuals()];
        tables.push(self.sensors("Sensors to detect all faults", &self.detecting_sensors));
        tables.push(self.sensors("Sensors to isolate all faults", &self.isolating_sensors));
        tables.retain(|table| !table.rows.is_empty());
        tables
    }

    fn fault_names(&self, faults: impl IntoIterator<Item = usize>) -> String {
        let names = faults.into_iter().map(|fault| self.model.faults()[fault].name.as_str());
        names.collect::<Vec<_>>().join(", ")
    }

    fn faults(&self) -> Table {
        let header = ["fault", "enters", "detected", "integral", "derivative", "not told from"];
        let mut table =
            Table::new("Faults, by tests of any, integral and derivative causality", &header);
        for (i, fault) in self.model.faults().iter().enumerate() {
            let mut row =
                vec![fault.name.clone(), self.model.equations()[fault.equation].name.clone()];
            for judged in &self.causalities {
                let word = if judged.isolability.detectable[i] { "yes" } else { "no" };
                row.push(word.to_owned());
            }
            let alike = self.best().isolable[i].iter().enumerate();
            let alike = alike.filter(|(j, told)| *j != i && !**told).map(|(j, _)| j);
            row.push(self.fault_names(alike));
            table.push(row);
        }
        table
    }

    fn equations(&self) -> Table {
        let mut table = Table::new("Equations", &["equation", "text", "part", "faults"]);
        for (e, equation) in self.model.equations().iter().enumerate() {
            let part = if self.parts.over.rows.contains(&e) {
                "over"
            } else if self.parts.under.rows.contains(&e) {
                "under"
            } else {
                "just"
            };
            let faults = self.model.faults().iter().enumerate();
            let faults = faults.filter(|(_, fault)| fault.equation == e).map(|(i, _)| i);
            let names = self.fault_names(faults);
            table.push([equation.name.clone(), self.texts[e].clone(), part.to_owned(), names]);
        }
        table
    }

    fn supports(&self) -> Table {
        let (sets, all) = (self.mso_sets.sets.len(), self.mso_sets.is_complete);
        let supports = self.test_supports.sets.len();
        let or_more = |complete: bool| if complete { "" } else { " or more" };
        let title = format!(
            "Minimal test supports: {supports}{} ({sets}{} minimal overdetermined sets)",
            or_more(self.test_supports.is_complete),
            or_more(all)
        );
        let mut table = Table::new(title, &["support", "equations", "reacts to"]);
        for (number, set) in self.test_supports.sets.iter().take(MOST_ROWS).enumerate() {
            let signature = self.model.signature(set).into_iter().enumerate();
            let reacts = signature.filter(|(_, reacts)| *reacts).map(|(fault, _)| fault);
            let equations = self.model.names_of(set).join(", ");
            table.push([(number + 1).to_string(), equations, self.fault_names(reacts)]);
        }
        table
    }

    fn residuals(&self) -> Table {
        let how =
            if self.tests.is_smallest { "the fewest" } else { "few, perhaps not the fewest," };
        let title = format!("Residuals: {how} that isolate what all sets isolate");
        let mut table = Table::new(title, &["residual", "flow", "reacts to", "computed from"]);
        for test in &self.tests.residuals {
            let flow = match test.flow {
                Flow::Algebraic => "algebraic",
                Flow::Integral => "integral",
                Flow::Derivative => "derivative",
                Flow::Mixed => "mixed",
            };
            let name = self.model.equations()[test.residual].name.clone();
            let from = match &test.refused {
                None => test.signals.join(", "),
                Some(reason) => format!("not run: {reason}"),
            };
            let faults = self.fault_names(test.reacts_to.iter().copied());
            table.push([name, flow.to_owned(), faults, from]);
        }
        table
    }

    fn sensors(&self, title: &str, placed: &Placed) -> Table {
        let Some(found) = &placed.placements else {
            let mut table = Table::new(title, &["not placed"]);
            table.rows.extend(placed.refused.iter().map(|reason| vec![reason.clone()]));
            return table;
        };
        let more = if found.is_complete { "" } else { ", not all of them" };
        let title = format!("{title}: minimal sets{more}");
        let mut table = Table::new(title, &["set", "measure", "remark"]);
        let unmet: Vec<String> =
            found.impossible.iter().map(|unmet| unmet.describe(self.model)).collect();
        let mut remark = match unmet.as_slice() {
            [] => String::new(),
            few if few.len() <= 5 => format!("no sensors of these can {}", few.join(", ")),
            many => format!("no sensors of these can meet {} requirements", many.len()),
        };
        if found.sets.is_empty() {
            table.push(["-".to_owned(), "none found".to_owned(), remark.clone()]);
        }
        for (number, set) in found.sets.iter().take(MOST_ROWS).enumerate() {
            let names = set.iter().map(|&x| self.model.unknowns()[x].as_str());
            let names: Vec<&str> = names.collect();
            let names = if names.is_empty() { "nothing more".to_owned() } else { names.join(", ") };
            table.push([(number + 1).to_string(), names, std::mem::take(&mut remark)]);
        }
        table
    }
}
