//! Generators whose model a diagnosis completes, engine by engine.

use std::borrow::Cow;

use fdiag::spec::{GeneratorSpec, ModelSource};

use super::{config::CompareConfig, method::Generator, plants::Runs};
use crate::engine::joined::name;

/// The generator as it watches this engine: with the causes in its model that a diagnosis of the beginning of the
/// training run names, if that is asked for. The first calibration run judges them.
pub(super) fn completed<'a>(
    config: &CompareConfig,
    generator: &'a Generator,
    runs: &Runs,
) -> Result<Cow<'a, Generator>, String> {
    let Some(seconds) = generator.diagnose_s else { return Ok(Cow::Borrowed(generator)) };
    let mut completed = generator.clone();
    let GeneratorSpec::Patched { model: ModelSource::Text { text }, .. } = &mut completed.spec
    else {
        return Err("diagnose_s: the generator has no model to be completed".to_owned());
    };
    let Some(judge) = runs.calibration.first() else {
        return Err("diagnose_s: there is no calibration run".to_owned());
    };
    let samples = config.samples(seconds);
    let [log, judge] = [&runs.training, judge].map(|run| run.slice(0, samples.min(run.len())));
    *text = name(text, &log, &judge, &runs.scaling)?.text;
    Ok(Cow::Owned(completed))
}
