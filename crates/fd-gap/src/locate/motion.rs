//! What the refitted model does along the logs.

use fd_sim::{
    equation::Expr,
    model::{Model, Output},
};

use super::bench::{Bench, Rows, settled};
use crate::{
    diagnose::{Case, Diagnosis},
    fit::FitError,
};

/// The signals of the refitted model: inputs are in the logs.
#[derive(Debug)]
pub(super) struct Motion {
    /// Outputs, then velocities of the sites, row by row.
    pub outputs: Rows,
    /// Name of the site and unit of each velocity, if it is that of a state.
    pub velocities: Vec<(String, String)>,
    pub states: Rows,
}

/// Runs the refitted model with sensors of the velocities at all sites, or without them when such a
/// model cannot be simulated.
pub(super) fn motion(
    case: &Case<'_>,
    diagnosis: &Diagnosis,
    bench: &Bench,
) -> Result<Motion, FitError> {
    let refit = &diagnosis.refit;
    let mut draft = refit.model.clone().into_draft();
    let mut velocities = Vec::new();
    for site in &refit.model.sites {
        let Some(value) = &site.velocity else { continue };
        let name = draft.fresh_name("site_velocity");
        let state = refit.model.states.iter().find(|s| *value == Expr::name(&s.name));
        let unit = state.map_or_else(String::new, |state| state.unit.clone());
        velocities.push((site.name.clone(), unit.clone()));
        draft.outputs.push(Output::new(name, unit, value.clone()));
    }
    let ts = bench.simulator.ts();
    let shown = Model::try_from(draft).ok().and_then(|m| case.nominal.patched(&m, ts).ok());
    let mut simulator = if let Some(simulator) = shown {
        simulator
    } else {
        velocities.clear();
        case.nominal.patched(&refit.model, ts)?
    };
    let theta = settled(&*simulator);
    let run = bench.run(&mut *simulator, &theta, &refit.starts, &Vec::new());
    let (outputs, states) = run.ok_or(FitError::Diverged)?;
    Ok(Motion { outputs, velocities, states })
}
