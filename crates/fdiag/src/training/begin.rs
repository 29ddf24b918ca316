//! How a running diagnosis begins: what a fitted bias was fitted on, and how long the generator settles.

use fd_compensate::{SampleRows, residual_compensation::PreFitted};
use fd_model::{Discrete, Record, StateSpace};
use fd_residual::GeneratorDesign;

use super::error::TrainingError;
use crate::spec::{NominalPlant, PipelineSpec};

/// Ranges of the learning data, complete samples only.
pub(super) fn pre_fitted(theta: Vec<f64>, records: &[Record]) -> Result<PreFitted, TrainingError> {
    let (mut u, mut r) = (Vec::new(), Vec::new());
    for record in records {
        for k in (0..record.len()).filter(|&k| record.is_complete(k)) {
            u.extend_from_slice(record.u(k));
            r.extend_from_slice(record.y(k));
        }
    }
    let (nu, channels) = (records[0].inputs().len(), records[0].outputs().len());
    if nu == 0 {
        let residual_peak = r.iter().fold(0.0_f64, |peak, r| peak.max(r.abs()));
        let (input_low, input_high) = (Vec::new(), Vec::new());
        return Ok(PreFitted { theta, input_low, input_high, residual_peak, filling: 0 });
    }
    Ok(PreFitted::from_training(theta, SampleRows::new(nu, &u)?, SampleRows::new(channels, &r)?))
}

/// Samples until the generator has forgotten where it started.
pub(super) fn settling_samples(
    spec: &PipelineSpec,
    design: &dyn GeneratorDesign,
    model: &StateSpace<Discrete>,
) -> Result<usize, TrainingError> {
    let ts = model.domain().ts.seconds();
    if let Some(found) = spec.settle_s {
        if !(found >= 0.0 && found.is_finite()) {
            let (setting, expected) = ("settle_s", "finite and not negative");
            return Err(TrainingError::Setting { setting, expected, found });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "checked, not negative"
        )]
        return Ok((found / ts).round() as usize);
    }
    let radius = design.form()?.system().poles()?.iter().map(|p| p.norm()).fold(0.0, f64::max);
    Ok(forgotten_after(radius))
}

/// Seconds that a diagnosis waits for its residual generator to settle, as the spec says or as the model needs: five time
/// constants of its slowest pole.
///
/// ```
/// use faer::mat;
/// use fdiag::{model::{Discrete, SampleTime, StateSpace}, spec::PipelineSpec, training::settling_time};
///
/// let domain = Discrete { ts: SampleTime::new(0.1)? };
/// let model = StateSpace::new(mat![[0.9]], mat![[0.1]], mat![[1.0]], mat![[0.0]], domain)?;
/// // −5 / ln 0.9 is 47.5 samples.
/// assert!((settling_time(&PipelineSpec::default(), &model)? - 4.8).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// Returns an error when the generator cannot be designed for the model, or is learned from logs.
pub fn settling_time(
    spec: &PipelineSpec,
    model: &StateSpace<Discrete>,
) -> Result<f64, TrainingError> {
    let design =
        spec.generator.design(NominalPlant::from(model), spec.weighting.as_deref(), &[])?;
    let samples = settling_samples(spec, design.as_ref(), model)?;
    Ok(samples as f64 * model.domain().ts.seconds())
}

/// Five time constants of a pole in samples, which leave e⁻⁵ = 0.7 % of an initial error; none for one that never
/// forgets.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "positive, and a cast saturates"
)]
pub(super) fn forgotten_after(radius: f64) -> usize {
    if radius > 0.0 && radius < 1.0 { (-5.0 / radius.ln()).ceil() as usize } else { 0 }
}
