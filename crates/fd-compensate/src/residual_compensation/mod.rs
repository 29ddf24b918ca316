//! Two-stage on-line residual compensation of Patton & Chen (1992), section 3.
//!
//! Modelling errors leave a bias in the residual that is driven by the input (eq. 13-14),
//!
//! ```text
//! μ(k) + a₁ μ(k−1) + … + aₙ μ(k−n) = b₀ u(k) + … + bₙ u(k−n),      θ = [a₁ … aₙ b₀ … bₙ]
//! ```
//!
//! and while the plant is healthy that bias *is* the residual, `μ(k) = r(k)`. Hence two stages:
//!
//! 1. **Training.** The identifier learns `θ` from `(u, r)` (eq. 18) until it has converged, see below. A
//!    threshold for `r*` applies to no sample of this stage; decision rules are muted by
//!    [`Phase::Training`](fd_core::stage::Phase).
//! 2. **Compensation.** The switch opens (event `Frozen`), `θ* = θ` stays fixed, `μ̂` is *simulated*
//!    from `u` and its own past (eq. 16), and `r* = r − μ̂` (eq. 17). The histories of the model
//!    run on from the measured bias, so that opening the switch causes no transient.
//!
//! The sample that carries the event `Frozen` still belongs to the training; the next one is the first
//! that is compensated.
//!
//! # The convergence test
//!
//! The paper's equation is garbled in print. What can be read is the change of the parameters,
//! `‖θ(k+1) − θ(k)‖ ≤ μ`, after a factor that ends in the exponent −1, and "where `ε` and `μ` are small
//! positive constants which are chosen a priori". [`ConvergenceRule::TwoConstants`] reads it as a relative
//! change below `ε` with `μ` as a bound on the change itself:
//!
//! ```text
//! ‖θ(k+1) − θ(k)‖ ≤ ε ‖θ(k)‖   and   ‖θ(k+1) − θ(k)‖ ≤ μ
//! ```
//!
//! The factor may have been `[‖θ(k)‖ + ε]⁻¹`, which makes `μ` the bound of the relative change and `ε` a
//! guard against a division by zero. That is the same test with `ε` in the place of `μ` and a large `μ`, but
//! for parameters of the size of that guard. Either passes in the first sample with a small innovation;
//! [`ConvergenceRule::InARow`], the default, asks for many such samples in a row.
//!
//! # A plant that changes
//!
//! "When the system operating conditions change or the system characteristics vary, the parameter
//! identification will be started again." The first is watched by [`OperatingPoint`], the second by
//! [`PlantChange`]. A change is distinguished from a fault by the rule of section 3: while parameters adapt,
//! only hard faults can be seen, as jumps ([`HardFault`]); incipient ones only while the switch is open. So a
//! change of the plant, too, is looked for only while the switch is open, when `θ*` is fixed and `r*` shows
//! what has changed since. What a changed plant adds to `r*` is driven by `u`, as the bias is; what a sensor
//! fault adds is not. Training starts again only when `r*` has grown *and* the inputs explain it by a relation
//! that was found in one window and holds in the next; everything else is left to the detector. A fault that
//! acts through the inputs, such as a loss of gain, is a change of the plant and would be learned, which is
//! what [`ChangePolicy::Warn`] is for.
//!
//! # What `r*` is during training
//!
//! The innovation `r(k) − φᵀ(k) θ(k−1)`: what the one-step prediction with the newest parameters
//! leaves. It is what the paper's figure 3 shows behind the still closed switch, and the quantity in
//! which a hard fault jumps ("the detection is also possible even if the adaptive parameter
//! identification is not switched off").
//!
//! # Why simulation and not one-step prediction
//!
//! With the bias model `A(z) μ = B(z) u` and a fault that adds `f_r` to the residual,
//! `r = B/A u + f_r`:
//!
//! ```text
//! simulated:  r* = r − B/A u               = f_r                [`Mode::Simulation`]
//! one step:   r* = r − (1 − A) r − B u     = A(z) f_r           [`Mode::OneStep`]
//! ```
//!
//! The one-step prediction has seen the fault in `r(k−1) … r(k−n)` and explains it away. A lasting
//! fault keeps only `A(1)` of its effect. With the parameters that the paper reports
//! (`a₁ = −1.430808, a₂ = 0.432895`) that is `A(1) = 0.002087`: the fault is attenuated 479-fold, and
//! an incipient fault vanishes. `Mode::OneStep` exists only to show this.
//!
//! # Assumptions, and when not to use it
//!
//! * The plant is healthy during training. A fault that is present then is learned as bias and is
//!   never seen; an abrupt one is caught by the hard-fault test, an incipient one cannot be.
//! * The bias is a stable linear function of `u` near the operating point of the training. The guard
//!   of [`OperatingPoint`] watches that `u` stays there, that of [`PlantChange`] that the plant does.
//! * Faults do not act through `u`. A fault of the *measured* `u` (or a controller that reacts to a
//!   sensor fault) moves `μ̂` as well.
//! * Re-training forgets what was learned elsewhere, except by an identifier of local models
//!   (`fd_ident::scheduled`), which forgets only where it is.
//! * Re-training is itself a training: under [`RangePolicy::Retrain`] and [`ChangePolicy::Retrain`] a fault
//!   that is present when training starts again is learned as bias.
//! * The paper's convergence test is weak: the gain of recursive least squares falls like `1/k`, so it passes
//!   sooner or later whether or not `θ` is any good. Hence the least number of samples, the requirement that
//!   the input moves, the optional bound on the standard error, and the [`Trial`]: a candidate `θ*` is
//!   simulated next to the still healthy residual before the switch opens.

mod activities;
mod convergence;
mod design;
mod error;
mod fixed;
mod jump;
mod operating_point;
mod plant_change;
mod plant_watch;
mod run;
mod trial;

pub use self::{
    design::{
        CompensationPlan, Convergence, ConvergenceRule, HardFault, Mode, OperatingPoint, PreFitted,
        RangePolicy, Timeout, Trial,
    },
    error::CompensationError,
    fixed::FixedParameters,
    plant_change::{ChangePolicy, PlantChange},
    run::ResidualCompensator,
};

/// Every way to compensate, with the same identifier and bias model: not at all, trained on line in
/// either mode and with re-training, and fitted beforehand with the parameters that the identifier has
/// now. All learn for as few samples as they may.
///
/// # Errors
///
/// Returns an error when the two do not fit together.
#[cfg(feature = "testing")]
pub fn every_compensator<T, I, M>(
    identifier: &I,
    model: &M,
) -> Result<Vec<fd_core::testing::Named<dyn fd_core::stage::Compensator<T>>>, CompensationError>
where
    T: fd_core::Scalar,
    I: fd_core::stage::Identifier<T> + Clone + 'static,
    M: fd_core::stage::BiasModel<T> + Clone + 'static,
{
    use fd_core::stage::Uncompensated;

    let mut simulated = CompensationPlan::default();
    simulated.convergence.least_samples = 50;
    simulated.trial.samples = 20;
    let one_step = CompensationPlan { mode: Mode::OneStep, ..simulated.clone() };
    let mut trains_again = simulated.clone();
    trains_again.operating_point.policy = RangePolicy::Retrain;
    let mut follows = simulated.clone();
    follows.convergence.rule = ConvergenceRule::TwoConstants { epsilon: 1e-2, mu: 1.0 };
    follows.plant_change =
        PlantChange { policy: ChangePolicy::Retrain, window: 40, ..PlantChange::default() };
    let on_line = |plan| ResidualCompensator::new(identifier.clone(), model.clone(), plan);
    let fit = PreFitted {
        theta: identifier.theta().iter().map(|v| v.to_report()).collect(),
        input_low: vec![-1.0; model.nu()],
        input_high: vec![1.0; model.nu()],
        residual_peak: 1.0,
        filling: 5,
    };
    let fitted =
        ResidualCompensator::pre_fitted(identifier.clone(), model.clone(), fit, &simulated);
    Ok(vec![
        ("none", Box::new(Uncompensated::new(model.residual_len()))),
        ("simulation", Box::new(on_line(&simulated)?)),
        ("one step", Box::new(on_line(&one_step)?)),
        ("training again", Box::new(on_line(&trains_again)?)),
        ("following the plant", Box::new(on_line(&follows)?.settling(10))),
        ("fitted beforehand", Box::new(fitted?)),
    ])
}
