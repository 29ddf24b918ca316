//! How strongly faults and noise reach a residual.

use fd_model::{PeakGain, StateSpace, TimeDomain};

use super::structure::Visibility;
use crate::{
    error::DesignError,
    form::{ResidualForm, peak_gain},
};

/// What one fault does to a residual vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaultEffect {
    /// Largest gain over frequency, `‖R_f,i‖∞`.
    pub peak: PeakGain,
    /// Gain of a constant fault; `None` when the plant has a pole at steady state, even if it
    /// cancels.
    pub steady: Option<f64>,
    /// Whether the fault is detectable: `[H_y G_f]_i ≠ 0` (eq. 6).
    pub detectable: bool,
    /// Whether a constant fault stays visible ("strong detectability": `[H_y G_f]_i ≠ 0` at
    /// steady state); an effect that dies away is easily missed.
    pub lasting: bool,
}

/// Fault-to-noise gap of a residual.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// Largest gain of each fault.
    pub faults: Vec<PeakGain>,
    /// Largest gain of the noise.
    pub noise: PeakGain,
    /// `min_i ‖R_f,i‖∞ / ‖R_w‖∞`; infinite when no noise reaches the residual.
    pub ratio: f64,
}

/// The effect of each fault of `gf` on the residual.
///
/// # Errors
///
/// Returns an error when `gf` has other outputs or another sample time than the plant.
///
/// # Examples
///
/// A sensor fault passes an observer of a lag only in part:
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::{analysis::{UnknownInputs, fault_effects}, observer::ObserverDesign};
///
/// let lag = StateSpace::new(mat![[-1.0]], mat![[1.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let gf = UnknownInputs::none(&lag).sensor(&lag, 0)?.system(&lag)?;
/// let design = ObserverDesign::with_gain(&lag, mat![[3.0]].as_ref())?;
/// let effect = fault_effects(&design.form()?, &gf)?[0]; // R_f = (s + 1)/(s + 4)
/// assert!(effect.detectable && effect.lasting);
/// assert!((effect.steady.unwrap() - 0.25).abs() < 1e-14);
/// assert!((effect.peak.norm - 1.0).abs() < 1e-14);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn fault_effects<D: TimeDomain>(
    form: &ResidualForm<D>,
    gf: &StateSpace<D>,
) -> Result<Vec<FaultEffect>, DesignError> {
    let all = form.residual_of(gf)?;
    let visibility = Visibility::of(form, gf)?;
    (0..gf.nu())
        .map(|fault| {
            let one = column(&all, fault)?;
            let steady = one.frequency_response(0.0).ok().map(|g| g.norm_l2());
            let peak = peak_gain(&one)?;
            let seen = |omega: f64| (0..all.ny()).any(|row| visibility.reacts(row, fault, omega));
            let detectable = (0..all.ny()).any(|row| visibility.reacts_somewhere(row, fault));
            Ok(FaultEffect { peak, steady, detectable, lasting: seen(0.0) })
        })
        .collect()
}

/// How far the weakest fault stands above the noise, over frequency.
///
/// # Errors
///
/// Returns an error when there is no fault, or `gf` or `gw` have other outputs or another sample
/// time than the plant.
///
/// # Examples
///
/// ```
/// use faer::mat;
/// use fd_model::{Continuous, StateSpace};
/// use fd_residual::{analysis::{UnknownInputs, fault_to_noise_gap}, observer::ObserverDesign};
///
/// let lag = StateSpace::new(mat![[-1.0]], mat![[2.0]], mat![[1.0]], mat![[0.0]], Continuous)?;
/// let gf = UnknownInputs::none(&lag).actuator(&lag, 0)?.system(&lag)?;
/// let gw = UnknownInputs::none(&lag).sensor(&lag, 0)?.system(&lag)?;
/// let design = ObserverDesign::with_gain(&lag, mat![[3.0]].as_ref())?;
/// let gap = fault_to_noise_gap(&design.form()?, &gf, &gw)?; // ‖2/(s+4)‖ / ‖(s+1)/(s+4)‖
/// assert!((gap.ratio - 0.5).abs() < 1e-7);
/// # Ok::<(), fd_residual::DesignError>(())
/// ```
pub fn fault_to_noise_gap<D: TimeDomain>(
    form: &ResidualForm<D>,
    gf: &StateSpace<D>,
    gw: &StateSpace<D>,
) -> Result<Gap, DesignError> {
    if gf.nu() == 0 {
        return Err(DesignError::Empty { what: "fault" });
    }
    let rf = form.residual_of(gf)?;
    let faults: Vec<PeakGain> = (0..rf.nu())
        .map(|fault| Ok(peak_gain(&column(&rf, fault)?)?))
        .collect::<Result<_, DesignError>>()?;
    let noise = peak_gain(&form.residual_of(gw)?)?;
    let weakest = faults.iter().map(|peak| peak.norm).fold(f64::INFINITY, f64::min);
    let ratio = if 0.0 < noise.norm { weakest / noise.norm } else { f64::INFINITY };
    Ok(Gap { faults, noise, ratio })
}

/// The part of a system that belongs to one input.
fn column<D: TimeDomain>(
    system: &StateSpace<D>,
    input: usize,
) -> Result<StateSpace<D>, DesignError> {
    Ok(StateSpace::new(
        system.a().to_owned(),
        system.b().subcols(input, 1).to_owned(),
        system.c().to_owned(),
        system.d().subcols(input, 1).to_owned(),
        system.domain(),
    )?)
}
