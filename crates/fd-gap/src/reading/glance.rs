//! A mistake that is seen before any cause is tried.

use super::{
    mistake::Mistake,
    suspicion::{Explained, Suspicion},
};
use crate::{
    diagnose::Case,
    fit::{FitError, Horizon},
    quality::EXPLAINED,
};

/// A log as it is read is out of reach if its errors are so many times the noise.
const OUT_OF_REACH: f64 = 10.0;

/// A mistake of reading that leaves nothing but noise once it is mended, where the log as it is read is far from the
/// model: signs, units, swapped columns and time, which no cause does. A gain that no honest device has costs more than
/// such a mistake, and so does any cause, for being one of many, if it explains no more. So causes need not be tried on
/// the log as it is read, which far from the noise takes long: [`Suspicion::judged`] and a diagnosis of the mended log
/// that finds no gap are enough. Where they are not, [`suspect`](super::suspect) is to be asked after the diagnosis, as always.
///
/// ```
/// use fd_effect::Candidate;
/// use fd_gap::{diagnose::Case, fit::Horizon, reading::{Mistake, glance}};
/// use fd_model::Record;
/// use fd_sim::model::Model;
///
/// let model: Model = r#"
/// version = 1
/// kind = "equations"
/// name = "lag"
/// sample_time = 0.1
/// inputs = { u = { unit = "rad" } }
/// outputs = { y = { unit = "V", value = "x", noise = 0.01 } }
/// states = { x = { unit = "V", initial = 0.0, derivative = "sin(u) - x" } }
/// "#.parse()?;
/// let ts = model.sample_time()?;
/// let suspects: Vec<Candidate> = Vec::new();
/// let at_a_glance = |unit: f64| -> Result<Option<Mistake>, Box<dyn std::error::Error>> {
///     let (mut x, mut rows) = (0.0, Vec::new());
///     for k in 0..300_u32 {
///         let u = (0.05 * f64::from(k)).sin() + 0.3;
///         rows.push(([u], [unit * (x + 0.014 * f64::from(k * k).sin())]));
///         x = u.sin() + (-0.1_f64).exp() * (x - u.sin());
///     }
///     let log = Record::from_rows(model.external_inputs(), model.output_channels(), rows, ts)?;
///     let case = Case { nominal: &model, suspects: &suspects, logs: &[log], held_out: &[] };
///     Ok(glance(&case, Horizon::FreeRun)?.map(|suspicion| suspicion.mistake().clone()))
/// };
/// assert_eq!(at_a_glance(1e3)?, Some(Mistake::unit("y", 1e3)));
/// assert_eq!(at_a_glance(1.0)?, None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// As [`suspect`](super::suspect).
pub fn glance(case: &Case<'_>, horizon: Horizon) -> Result<Option<Suspicion>, FitError> {
    let Some(explained) = Explained::of(case, horizon, None)? else { return Ok(None) };
    if explained.fitted.as_ref().is_some_and(|misfit| misfit.is_noise(OUT_OF_REACH)) {
        return Ok(None);
    }
    Ok(explained.suspected(case, horizon)?.filter(|suspicion| {
        let has_no_peer = matches!(
            suspicion.mistake(),
            Mistake::Sign { .. }
                | Mistake::Unit { .. }
                | Mistake::Swap { .. }
                | Mistake::Time { .. }
        );
        has_no_peer && suspicion.mended.is_noise(EXPLAINED)
    }))
}
