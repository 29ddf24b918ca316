//! Sensor placement: which unknowns to measure so that faults can be detected and isolated.

use std::collections::BTreeSet;

use serde::Serialize;
use thiserror::Error;

use super::Requirement;
use crate::{
    analysis::Causality,
    graph::{Decomposition, Graph, Matching},
    model::{Equation, Fault, StructuralModel},
};

/// How many equations are decomposed, each time anew, before the search for all sets is given up: seconds at most.
const MOST_WORK: usize = 100_000;
/// So many sensors of the same unknown do all that sensors of it can do: one may have failed, and the
/// other two test each other.
const COPIES: usize = 3;

/// Which sensors may be added.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Sensors {
    /// Unknowns that could be measured, by number.
    pub candidates: Vec<usize>,
    /// Whether new sensors may fail: their faults must then be detected and isolated as well, each from every
    /// other fault and the other way round.
    pub may_fail: bool,
}

/// Sets of sensors that meet the requirements.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Placements {
    /// Minimal sets of unknowns to be measured, the smallest first. An unknown may have to be measured more than once.
    pub sets: Vec<Vec<usize>>,
    /// Whether these are all minimal sets. Otherwise the search was given up; if it had found nothing, the one set is
    /// that of the greedy rule, minimal but perhaps not the smallest.
    pub is_complete: bool,
    /// Requirements that no sensors of the candidates meet. The sets meet the others.
    pub impossible: Vec<Requirement>,
}

/// No sensors can be placed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum PlacementError {
    /// A part of the model has more unknowns than equations.
    #[error(
        "sensors are placed in models without an underdetermined part; these unknowns are in one: {}",
        .0.join(", ")
    )]
    Underdetermined(Vec<String>),
    /// There is no such unknown, or no such fault.
    #[error("there is no {what} number {number}; there are {count}")]
    OutOfRange {
        /// `unknown` or `fault`.
        what: &'static str,
        /// The number asked for.
        number: usize,
        /// How many there are.
        count: usize,
    },
}

impl StructuralModel {
    /// With a sensor `sensor <unknown>` for each of these unknowns, and a fault `f_<unknown>` in it if it may fail.
    /// Names get a number where they are taken.
    #[must_use]
    pub fn with_sensors(&self, unknowns: &[usize], may_fail: bool) -> Self {
        let mut model = self.clone();
        for &unknown in unknowns.iter().filter(|&&unknown| unknown < self.unknowns.len()) {
            let of = &self.unknowns[unknown];
            let name =
                fresh(&format!("sensor {of}"), |n| model.equations.iter().any(|e| e.name == n));
            let known = fresh(&format!("y_{of}"), |n| model.knowns.iter().any(|known| known == n));
            if may_fail {
                let name = fresh(&format!("f_{of}"), |n| model.faults.iter().any(|f| f.name == n));
                model.faults.push(Fault { name, equation: model.equations.len() });
            }
            let knowns = vec![model.knowns.len()];
            model.knowns.push(known);
            model.equations.push(Equation {
                name,
                unknowns: vec![unknown],
                knowns,
                dynamics: None,
            });
        }
        model
    }

    /// All minimal sets of additional sensors with which the requirements are met, in mixed causality.
    ///
    /// For a requirement that is not met, the unknowns one of which has to be measured are read from the just
    /// determined part: those whose computation needs the equation of the fault (Krysander and Frisk 2008). The search
    /// branches over them, small sets first, so that every minimal set is reached.
    ///
    /// ```
    /// use fd_structure::{design::{Requirement, Sensors}, model::StructuralModel};
    ///
    /// let chain = StructuralModel::builder("chain")
    ///     .equation("a", ["x"], ["u"])
    ///     .equation("b", ["x", "z"], [])
    ///     .fault("fa", "a")
    ///     .fault("fb", "b")
    ///     .build()?;
    /// let sensors = Sensors { candidates: vec![0, 1], may_fail: false };
    /// let detect = chain.place_sensors(&Requirement::detect_all(2), &sensors)?;
    /// assert_eq!(detect.sets, [[1]]);
    /// let isolate = chain.place_sensors(&Requirement::isolate_all(2), &sensors)?;
    /// assert_eq!(isolate.sets, [[0, 1]]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the model has an underdetermined part, and for numbers out of range.
    pub fn place_sensors(
        &self,
        requirements: &[Requirement],
        sensors: &Sensors,
    ) -> Result<Placements, PlacementError> {
        self.check(requirements, sensors)?;
        let three_of_each = sensors.candidates.repeat(COPIES);
        let at_best = self.with_sensors(&three_of_each, false).isolability(Causality::Mixed);
        let (possible, impossible): (Vec<_>, Vec<_>) =
            requirements.iter().copied().partition(|requirement| requirement.is_met_by(&at_best));
        let search = Search { model: self, sensors, requirements: possible };
        let (mut sets, mut is_complete) = search.all();
        if sets.is_empty() && !is_complete {
            sets.extend(search.greedy());
        }
        is_complete &= !sets.is_empty();
        Ok(Placements { sets, is_complete, impossible })
    }

    fn check(&self, requirements: &[Requirement], sensors: &Sensors) -> Result<(), PlacementError> {
        let faults = requirements.iter().flat_map(|requirement| match *requirement {
            Requirement::Detect(i) => [i, i],
            Requirement::Isolate(i, j) => [i, j],
        });
        let (faults, unknowns) = (faults.max(), sensors.candidates.iter().copied().max());
        let ranges =
            [("fault", faults, self.faults.len()), ("unknown", unknowns, self.unknowns.len())];
        for (what, largest, count) in ranges {
            if let Some(number) = largest.filter(|&number| count <= number) {
                return Err(PlacementError::OutOfRange { what, number, count });
            }
        }
        let under = self.decompose().under.columns;
        if under.is_empty() {
            return Ok(());
        }
        let names = under.into_iter().map(|x| self.unknowns[x].clone()).collect();
        Err(PlacementError::Underdetermined(names))
    }
}

fn fresh(name: &str, is_taken: impl Fn(&str) -> bool) -> String {
    let numbered = (2..).map(|number| format!("{name} {number}"));
    std::iter::once(name.to_owned()).chain(numbered).find(|n| !is_taken(n)).unwrap_or_default()
}

struct Search<'a> {
    model: &'a StructuralModel,
    sensors: &'a Sensors,
    requirements: Vec<Requirement>,
}

impl Search<'_> {
    /// All minimal sets, the smallest first, and whether the search came to its end.
    fn all(&self) -> (Vec<Vec<usize>>, bool) {
        let mut found: Vec<Vec<usize>> = Vec::new();
        let mut level = BTreeSet::from([Vec::new()]);
        let mut work = 0;
        while !level.is_empty() {
            let mut next = BTreeSet::new();
            for set in level {
                if found.iter().any(|smaller| is_part(smaller, &set)) {
                    continue;
                }
                if MOST_WORK < work {
                    return (found, false);
                }
                let mut first = None;
                self.visit_open(&set, &mut work, &mut |choices| {
                    first = choices.into_iter().min_by_key(Vec::len);
                    false
                });
                match first {
                    None => found.push(set),
                    Some(choices) => next.extend(choices.into_iter().map(|x| with(&set, x))),
                }
            }
            level = next;
        }
        (found, true)
    }

    /// Adds what helps most, then takes out what is not needed.
    fn greedy(&self) -> Option<Vec<usize>> {
        let mut set = Vec::new();
        loop {
            let open = self.open(&set);
            if open.is_empty() {
                break;
            }
            let helps = |x: &usize| open.iter().filter(|choices| choices.contains(x)).count();
            let best = self.sensors.candidates.iter().copied().max_by_key(helps)?;
            if helps(&best) == 0 || self.sensors.candidates.len() * COPIES < set.len() {
                return None;
            }
            set = with(&set, best);
        }
        let mut at = 0;
        while at < set.len() {
            let mut without = set.clone();
            without.remove(at);
            if self.open(&without).is_empty() { set = without } else { at += 1 }
        }
        Some(set)
    }

    /// For each requirement that is not met with these sensors, the candidates one of which has to be added.
    fn open(&self, set: &[usize]) -> Vec<Vec<usize>> {
        let mut open = Vec::new();
        self.visit_open(set, &mut 0, &mut |choices| {
            open.extend(choices);
            true
        });
        open
    }

    /// As [`Search::open`], in groups, until `goes_on` has seen enough. Isolation is looked at when everything is detected.
    fn visit_open(
        &self,
        set: &[usize],
        work: &mut usize,
        goes_on: &mut dyn FnMut(Vec<Vec<usize>>) -> bool,
    ) {
        let model = self.model.with_sensors(set, self.sensors.may_fail);
        let (old, all) = (self.model.faults.len(), model.faults.len());
        let new =
            Requirement::isolate_all(all).into_iter().filter(|requirement| match *requirement {
                Requirement::Detect(i) => old <= i,
                Requirement::Isolate(i, j) => old <= i.max(j),
            });
        let equation = |fault: usize| model.faults[fault].equation;
        // What is left out, and what has to have redundancy then; first nothing is.
        let mut wanted: Vec<(Option<usize>, usize)> = Vec::new();
        for requirement in self.requirements.iter().copied().chain(new) {
            match requirement {
                Requirement::Detect(i) => wanted.push((None, equation(i))),
                Requirement::Isolate(i, j) => {
                    wanted.extend([(None, equation(i)), (Some(equation(j)), equation(i))]);
                }
            }
        }
        wanted.sort_unstable();
        wanted.dedup();
        for group in wanted.chunk_by(|a, b| a.0 == b.0) {
            let left_out = group.first().and_then(|(left_out, _)| *left_out);
            *work += model.equations.len();
            let choices = self.situation(&model, left_out).helpful(group.iter().map(|pair| pair.1));
            let is_detection = left_out.is_none();
            if !choices.is_empty() && (!goes_on(choices) || is_detection) {
                return;
            }
        }
    }

    fn situation(&self, model: &StructuralModel, left_out: Option<usize>) -> Situation<'_> {
        let equations: Vec<usize> =
            (0..model.equations.len()).filter(|&equation| Some(equation) != left_out).collect();
        let graph = model.graph_of(&equations);
        let matching = Matching::maximum(&graph);
        let mut is_over = vec![false; model.equations.len()];
        for row in Decomposition::of(&graph).over.rows {
            is_over[equations[row]] = true;
        }
        Situation { candidates: &self.sensors.candidates, equations, graph, matching, is_over }
    }
}

/// A model without one equation.
struct Situation<'a> {
    candidates: &'a [usize],
    equations: Vec<usize>,
    graph: Graph,
    matching: Matching,
    is_over: Vec<bool>,
}

impl Situation<'_> {
    /// For each of these equations without redundancy, the unknowns whose measurement would give it some.
    fn helpful(&self, equations: impl Iterator<Item = usize>) -> Vec<Vec<usize>> {
        let open: Vec<usize> = equations.filter(|&equation| !self.is_over[equation]).collect();
        if open.is_empty() {
            return Vec::new();
        }
        let reached = |x: &usize| {
            let from = self.matching.row_of().get(*x).copied().flatten();
            self.matching.reach(&self.graph, from)
        };
        let reached: Vec<Vec<bool>> = self.candidates.iter().map(reached).collect();
        let of = |equation: usize| {
            let row = self.equations.binary_search(&equation);
            let helps = |place: &usize| row.is_ok_and(|row| reached[*place][row]);
            let places = (0..self.candidates.len()).filter(helps);
            places.map(|place| self.candidates[place]).collect()
        };
        open.into_iter().map(of).collect()
    }
}

fn with(set: &[usize], x: usize) -> Vec<usize> {
    let mut larger = set.to_vec();
    larger.insert(set.partition_point(|&y| y <= x), x);
    larger
}

/// Whether all of the first are in the second, as often.
fn is_part(part: &[usize], whole: &[usize]) -> bool {
    let mut rest = whole.iter();
    part.iter().all(|x| rest.any(|y| y == x))
}
