//! The whole structural analysis of a model.

use fd_structure::{
    analysis::{Causality, Isolability},
    design::{Placements, Requirement, Selection, Sensors, select_tests},
    equations::EquationModel,
    generator::Flow,
    graph::Decomposition,
    model::{EquationSet, StructuralModel},
    redundancy::{Family, Supports},
};
use serde::Serialize;

use super::{super::failure::Failure, args::StructureArgs};

/// For so many sets a residual is tried before the smallest set of a signature is taken without one.
const MOST_TRIALS: usize = 20;

/// What the structure of a model says.
#[derive(Debug, Serialize)]
pub(super) struct Study<'a> {
    pub model: &'a StructuralModel,
    /// The equations as text.
    pub texts: Vec<String>,
    pub parts: Decomposition,
    pub causalities: Vec<Judged>,
    pub mso_sets: Family,
    pub test_supports: Family,
    /// Tests that isolate what the listed sets can isolate.
    pub tests: Tests,
    /// What could be measured.
    pub measurable: Vec<usize>,
    pub detecting_sensors: Placed,
    pub isolating_sensors: Placed,
}

/// What tests of one causality can do.
#[derive(Debug, Serialize)]
pub(super) struct Judged {
    pub causality: Causality,
    #[serde(flatten)]
    pub isolability: Isolability,
}

/// Chosen tests.
#[derive(Debug, Serialize)]
pub(super) struct Tests {
    pub residuals: Vec<Test>,
    pub is_smallest: bool,
}

/// A residual.
#[derive(Debug, Serialize)]
pub(super) struct Test {
    pub equations: EquationSet,
    pub residual: usize,
    pub flow: Flow,
    /// Numbers of the faults.
    pub reacts_to: Vec<usize>,
    /// Logged signals, if the residual can be run.
    pub signals: Vec<String>,
    /// Why it cannot be run.
    pub refused: Option<String>,
}

/// Sensors, or why none were placed.
#[derive(Debug, Serialize)]
pub(super) struct Placed {
    pub placements: Option<Placements>,
    pub refused: Option<String>,
}

impl<'a> Study<'a> {
    pub(super) fn of(equations: &'a EquationModel, args: &StructureArgs) -> Result<Self, Failure> {
        let model = equations.structure();
        let measurable = measurable(model, args)?;
        let most = args.most as usize;
        let judged = |causality| Judged { causality, isolability: model.isolability(causality) };
        let mso_sets = model.mso_sets(most);
        let faults = model.faults().len();
        let placed = |requirements: Vec<Requirement>| {
            let candidates = measurable.clone();
            let sensors = Sensors { candidates, may_fail: args.sensors_may_fail };
            match model.place_sensors(&requirements, &sensors) {
                Ok(placements) => Placed { placements: Some(placements), refused: None },
                Err(error) => Placed { placements: None, refused: Some(error.to_string()) },
            }
        };
        Ok(Self {
            texts: (0..model.equations().len()).map(|e| equations.text_of(e)).collect(),
            parts: model.decompose(),
            causalities: Causality::ALL.into_iter().map(judged).collect(),
            test_supports: model.test_supports(Supports::Minimal, most),
            tests: Tests::of(equations, &mso_sets),
            detecting_sensors: placed(Requirement::detect_all(faults)),
            isolating_sensors: placed(Requirement::isolate_all(faults)),
            mso_sets,
            measurable,
            model,
        })
    }

    /// What mixed causality allows.
    pub(super) fn best(&self) -> &Isolability {
        &self.causalities[0].isolability
    }

    pub(super) fn headline(&self) -> String {
        let (model, best) = (self.model, self.best());
        let detectable = best.detectable.iter().filter(|&&detectable| detectable).count();
        let faults = model.faults().len();
        let mut groups = best.groups().len();
        groups -= usize::from(detectable < faults);
        let name = model.name();
        let (equations, unknowns) = (model.equations().len(), model.unknowns().len());
        let redundancy = self.parts.redundancy();
        format!(
            "{name}: {equations} equations, {unknowns} unknowns, redundancy {redundancy}. Of {faults} faults \
             {detectable} can be detected, in {groups} groups that can be told apart."
        )
    }
}

impl Tests {
    /// For each signature a set of which a residual runs, if one is found soon, else the smallest set; then the fewest.
    fn of(equations: &EquationModel, family: &Family) -> Self {
        let model = equations.structure();
        let mut by_size: Vec<&EquationSet> = family.sets.iter().collect();
        by_size.sort_by_key(|set| set.len());
        let mut signatures: Vec<(Vec<bool>, Vec<&EquationSet>)> = Vec::new();
        for set in by_size {
            let signature = model.signature(set);
            match signatures.iter_mut().find(|(known, _)| *known == signature) {
                Some((_, sets)) if sets.len() < MOST_TRIALS => sets.push(set),
                Some(_) => {}
                None => signatures.push((signature, vec![set])),
            }
        }
        let reacts: Vec<Vec<bool>> = signatures.iter().map(|(s, _)| s.clone()).collect();
        let wanted = Requirement::met_by(&Isolability::of_tests(&reacts, model.faults().len()));
        let Selection { tests, is_smallest, .. } = select_tests(&reacts, &wanted);
        let residuals = tests.into_iter().filter_map(|test| {
            let (signature, sets) = &signatures[test];
            let tried = || sets.iter().map(|set| Test::of(equations, set, signature));
            tried()
                .flatten()
                .find(|test| test.refused.is_none())
                .or_else(|| tried().flatten().next())
        });
        Self { residuals: residuals.collect(), is_smallest }
    }
}

impl Test {
    /// The first residual of a set that runs, sensors first; else the first.
    fn of(equations: &EquationModel, set: &EquationSet, signature: &[bool]) -> Option<Self> {
        let model = equations.structure();
        let mut candidates: Vec<usize> = set.clone();
        candidates
            .sort_by_key(|&equation| !model.equations()[equation].name.starts_with("sensor "));
        let mut first = None;
        for residual in candidates {
            let Ok(sequence) = model.sequence(set, residual) else { continue };
            let reacts_to = signature.iter().enumerate().filter(|(_, reacts)| **reacts);
            let mut test = Self {
                equations: set.clone(),
                residual,
                flow: sequence.flow,
                reacts_to: reacts_to.map(|(fault, _)| fault).collect(),
                signals: Vec::new(),
                refused: None,
            };
            match equations.residual(set, residual) {
                Ok(found) => {
                    test.signals = found.knowns().to_vec();
                    return Some(test);
                }
                Err(error) => test.refused = Some(error.to_string()),
            }
            first = first.or(Some(test));
        }
        first
    }
}

fn measurable(model: &StructuralModel, args: &StructureArgs) -> Result<Vec<usize>, Failure> {
    let unknowns = model.unknowns();
    if args.measurable.is_empty() {
        let is_rate = |x: usize| {
            model.equations().iter().any(|e| e.dynamics.is_some_and(|dynamics| dynamics.rate == x))
        };
        return Ok((0..unknowns.len()).filter(|&x| !is_rate(x)).collect());
    }
    let number = |name: &String| {
        unknowns.iter().position(|known| known == name).ok_or_else(|| {
            let known = unknowns.join(", ");
            let reason = format!("--measurable: there is no unknown `{name}`; there are {known}");
            Failure::of_input(reason)
        })
    };
    args.measurable.iter().map(number).collect()
}
