//! The cause of an engine's bias, named and patched into its simulator.

use fd_effect::EverySite;
use fd_gap::{
    diagnose::{Case as GapCase, Settings, Verdict, diagnose},
    road::road,
};
use fd_jetengine::engine17::{input_channels, output_channels};
use fd_model::{Record, Scaling};
use fd_sim::model::Model;
use fdiag::engine_plant::{EngineFile, engine_effects};

/// Most causes that are named.
const MOST_CAUSES: usize = 4;

/// What a diagnosis makes of a training log.
pub(super) struct Named {
    /// The causes in words, and how sure.
    pub(super) words: String,
    /// The model file with them in it.
    pub(super) text: String,
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

/// Names what the simulator lacks of a log that begins at rest. `held_out` judges what is named.
pub(super) fn name(
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
    let nominal = file.nominal(log.ts()).map_err(|e| said(&e))?;
    let u: Vec<f64> = log.samples().flat_map(|(u, _)| u.to_vec()).collect();
    let scales = nominal.scales(log.ts(), &u, log.len()).map_err(|e| said(&e))?;
    let suspects = EverySite::new(engine_effects(), nominal.model(), scales);
    let (logs, held_out) = ([log], [held_out]);
    let case =
        GapCase { nominal: &*nominal, suspects: &suspects, logs: &logs, held_out: &held_out };
    let settings = Settings::default();
    let found = diagnose(&case, &settings, &()).map_err(|e| said(&e))?;
    let road = road(&case, &found, &settings, MOST_CAUSES, &()).map_err(|e| said(&e))?;
    let of = |cause: &fd_gap::diagnose::Cause| {
        format!("{} {}", cause.label, cause.site.name().unwrap_or("everywhere"))
    };
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
    Ok(Named { words, text: file.text(model) })
}
