//! The cause of an engine's bias, named and patched into its simulator.

use fd_effect::EverySite;
use fd_gap::{
    diagnose::{Case as GapCase, Cause, Diagnosis, Settings, Verdict, diagnose},
    few_runs::{Effort, FewRuns, with_few_runs},
    road::{Bounds, road},
};
use fd_jetengine::engine17::{input_channels, output_channels};
use fd_model::{Record, Scaling};
use fd_sim::{
    model::Model,
    simulate::{Nominal, Shell},
};
use fdiag::engine_plant::{EngineFile, engine_effects};

use crate::engine_gap::engine_as_black_box;

/// Most causes that are named: valve, three sensors and the metal are five.
const MOST_CAUSES: usize = 6;

/// What a diagnosis makes of a training log.
pub(crate) struct Named {
    /// The causes in words.
    pub words: String,
    /// The model file with them in it.
    pub text: String,
    /// Runs of the engine through the log.
    pub runs: f64,
}

/// The text of a file of the engine: what its user knows, and the noise of its sensors.
pub(super) fn engine_text(fuel: f64, scaling: &Scaling, noise: f64, scatter: f64) -> String {
    let names = output_channels();
    let sigmas = names.iter().zip(&scaling.outputs);
    let sigmas: Vec<String> =
        sigmas.map(|(c, s)| format!("{} = {:e}", c.name, noise * s.scale.unwrap_or(1.0))).collect();
    format!(
        "version = 1\nkind = \"engine17\"\nfuel_flow = {fuel}\n\
         tolerances = {{ modules = {scatter}, heating_value = 0.0 }}\nnoise = {{ {} }}\n",
        sigmas.join(", ")
    )
}

/// Names what the simulator in a file lacks of a log that begins at rest, with few runs of it: its linear stand-in
/// proposes. `held_out` judges what is named.
pub(crate) fn name(
    text: &str,
    log: &Record,
    held_out: &Record,
    scaling: &Scaling,
) -> Result<Named, String> {
    let said = |error: &dyn std::fmt::Display| error.to_string();
    let (inputs, outputs) = (input_channels(), output_channels());
    let physical = |record: &Record| record.unscaled(scaling, &inputs, &outputs);
    let (log, held_out) =
        (physical(log).map_err(|e| said(&e))?, physical(held_out).map_err(|e| said(&e))?);
    let file = EngineFile::parse("engine17", text).map_err(|e| said(&e))?;
    let known = file.known(log.ts()).map_err(|e| said(&e))?;
    let black_box = engine_as_black_box(&known, file.noise_of_outputs()).map_err(|e| said(&e))?;
    let shell = black_box.shell().map_err(|e| said(&e))?;
    let u: Vec<f64> = log.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let scales = shell.scales(log.ts(), &u, log.len()).map_err(|e| said(&e))?;
    let suspects = EverySite::new(engine_effects(), shell.model(), scales);
    let (samples, logs, held_out) = (log.len(), [log], [held_out]);
    let case = GapCase { nominal: &shell, suspects: &suspects, logs: &logs, held_out: &held_out };
    let settings = Settings::default();
    let (found, lent) = diagnosed(&shell, &case, &settings).map_err(|e| said(&e))?;
    let going_on = GapCase { nominal: &lent, ..case };
    let bounds = Bounds { most: MOST_CAUSES, is_dear: true };
    let road = road(&going_on, &found, &settings, bounds, &()).map_err(|e| said(&e))?;
    let of =
        |cause: &Cause| format!("{} {}", cause.label, cause.site.name().unwrap_or("everywhere"));
    let (words, model): (String, &Model) = match (&road, found.verdict, found.pairs.first()) {
        (Some(road), ..) => {
            let causes: Vec<String> = road.causes.iter().map(|m| of(&m.cause)).collect();
            (causes.join(" + "), &road.model)
        }
        (None, Verdict::NoGap, _) => ("no gap".to_owned(), &found.best.model),
        (None, Verdict::Pair, Some(pair)) => {
            let causes: Vec<String> = pair.causes.iter().map(of).collect();
            (causes.join(" + "), &found.best.model)
        }
        _ => (found.causes.first().map(of).unwrap_or_default(), &found.best.model),
    };
    Ok(Named { words, text: file.text(model), runs: black_box.runs(samples) })
}

/// The diagnosis, and the simulator for further questions to the same logs.
fn diagnosed(
    shell: &Shell,
    case: &GapCase<'_>,
    settings: &Settings,
) -> Result<(Diagnosis, Shell), fd_gap::fit::FitError> {
    Ok(match with_few_runs(shell, &[], case, settings, Effort::default(), &())? {
        Some(FewRuns { diagnosis, lent, .. }) => (diagnosis, lent),
        None => (diagnose(case, settings, &())?, shell.clone()),
    })
}
