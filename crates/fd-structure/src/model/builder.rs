//! Structural models by hand.

use super::{Dynamics, Equation, Fault, StructuralModel, StructureError};

/// Collects the equations of a [`StructuralModel`].
///
/// Unknowns and known signals are made when they are first named.
#[derive(Clone, Debug, Default)]
pub struct Builder {
    model: StructuralModel,
    /// Faults with the equations that they enter.
    faults: Vec<(String, Vec<String>)>,
}

impl StructuralModel {
    /// A model to be put together by hand.
    ///
    /// ```
    /// use fd_structure::model::{StructuralModel, StructureError};
    ///
    /// let model = StructuralModel::builder("typo").equation("e1", ["x"], ["y"]).fault("f", "e2");
    /// assert!(matches!(model.build(), Err(StructureError::NoSuchEquation { .. })));
    /// ```
    pub fn builder(name: impl Into<String>) -> Builder {
        Builder::new(name)
    }
}

impl Builder {
    fn new(name: impl Into<String>) -> Self {
        Self {
            model: StructuralModel { name: name.into(), ..StructuralModel::default() },
            faults: Vec::new(),
        }
    }

    /// An equation between unknowns and known signals.
    #[must_use]
    pub fn equation<'a>(
        mut self,
        name: impl Into<String>,
        unknowns: impl IntoIterator<Item = &'a str>,
        knowns: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let unknowns = unknowns.into_iter().map(|x| numbered(&mut self.model.unknowns, x));
        let mut unknowns: Vec<usize> = unknowns.collect();
        unknowns.sort_unstable();
        unknowns.dedup();
        let knowns = knowns.into_iter().map(|z| numbered(&mut self.model.knowns, z)).collect();
        let name = name.into();
        self.model.equations.push(Equation { name, unknowns, knowns, dynamics: None });
        self
    }

    /// The differential constraint `d/dt state = rate`, called `d/dt state`.
    #[must_use]
    pub fn differential(self, state: &str, rate: &str) -> Self {
        let name = format!("d/dt {state}");
        self.dynamic(name, state, rate)
    }

    /// A constraint by which a rate determines a state in the course of time, as integrals do: see
    /// [`Dynamics`].
    #[must_use]
    pub fn dynamic(mut self, name: impl Into<String>, state: &str, rate: &str) -> Self {
        let dynamics = Dynamics {
            state: numbered(&mut self.model.unknowns, state),
            rate: numbered(&mut self.model.unknowns, rate),
        };
        let mut unknowns = vec![dynamics.state, dynamics.rate];
        unknowns.sort_unstable();
        self.model.equations.push(Equation {
            name: name.into(),
            unknowns,
            knowns: Vec::new(),
            dynamics: Some(dynamics),
        });
        self
    }

    /// A fault that enters one equation.
    #[must_use]
    pub fn fault(mut self, name: impl Into<String>, equation: impl Into<String>) -> Self {
        self.faults.push((name.into(), vec![equation.into()]));
        self
    }

    /// A fault that enters several equations.
    ///
    /// It becomes an unknown in all of them, with an equation of its own that says that it is zero and
    /// is the only one the fault violates (Krysander and Frisk 2008, section II).
    #[must_use]
    pub fn fault_in<'a>(
        mut self,
        name: impl Into<String>,
        equations: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let equations = equations.into_iter().map(str::to_owned).collect();
        self.faults.push((name.into(), equations));
        self
    }

    /// Checks the model.
    ///
    /// # Errors
    ///
    /// Returns an error for names that are used twice, faults in equations that do not exist, signals
    /// that are both known and unknown, and rates that belong to several states.
    pub fn build(mut self) -> Result<StructuralModel, StructureError> {
        for (name, equations) in std::mem::take(&mut self.faults) {
            self.place(name, &equations)?;
        }
        let model = self.model;
        let equations = model.equations.iter().map(|equation| &equation.name);
        unique("equation", equations)?;
        unique("fault", model.faults.iter().map(|fault| &fault.name))?;
        if let Some(name) = model.knowns.iter().find(|name| model.unknowns.contains(name)) {
            return Err(StructureError::KnownAndUnknown(name.clone()));
        }
        let mut used = vec![[false; 2]; model.unknowns.len()];
        for Dynamics { state, rate } in model.equations.iter().filter_map(|e| e.dynamics) {
            if state == rate || used[state][0] || used[rate][1] {
                let name = |of: usize| model.unknowns[of].clone();
                return Err(StructureError::Rate { state: name(state), rate: name(rate) });
            }
            (used[state][0], used[rate][1]) = (true, true);
        }
        Ok(model)
    }

    fn place(&mut self, name: String, equations: &[String]) -> Result<(), StructureError> {
        let all = &mut self.model.equations;
        let find = |equation: &String| {
            all.iter().position(|known| known.name == *equation).ok_or_else(|| {
                let known: Vec<&str> = all.iter().map(|known| known.name.as_str()).collect();
                StructureError::NoSuchEquation {
                    fault: name.clone(),
                    equation: equation.clone(),
                    known: known.join(", "),
                }
            })
        };
        let places: Vec<usize> = equations.iter().map(find).collect::<Result<_, _>>()?;
        let equation = match places.as_slice() {
            [] => return Err(StructureError::FaultNowhere(name)),
            [equation] => *equation,
            several => {
                let unknown = numbered(&mut self.model.unknowns, &name);
                for &place in several {
                    let unknowns = &mut all[place].unknowns;
                    if let Err(at) = unknowns.binary_search(&unknown) {
                        unknowns.insert(at, unknown);
                    }
                }
                let (knowns, dynamics) = (Vec::new(), None);
                let (name, unknowns) = (format!("no {name}"), vec![unknown]);
                all.push(Equation { name, unknowns, knowns, dynamics });
                all.len() - 1
            }
        };
        self.model.faults.push(Fault { name, equation });
        Ok(())
    }
}

/// The number of a name, which is put on the list if it is not there.
fn numbered(names: &mut Vec<String>, name: &str) -> usize {
    names.iter().position(|known| known == name).unwrap_or_else(|| {
        names.push(name.to_owned());
        names.len() - 1
    })
}

fn unique<'a>(
    what: &'static str,
    names: impl Iterator<Item = &'a String>,
) -> Result<(), StructureError> {
    let mut names: Vec<&String> = names.collect();
    names.sort_unstable();
    match names.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(StructureError::Twice { what, name: pair[0].clone() }),
        None => Ok(()),
    }
}
