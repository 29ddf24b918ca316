//! Thresholds that follow the input: the adaptive threshold and the threshold selector.
//!
//! The bias that a wrong model causes in the residual of a healthy plant is `μ = H_y ΔG u` (Patton & Chen 1992,
//! eq. 9 and 12): it grows with the input. A threshold that covers the uncertainty and nothing more must
//! therefore follow the input too, `J_th(t) ∼ ‖H_y ΔG u‖` (section 2; Emami-Naeini, Akhter & Rock 1988; Ding &
//! Frank 1991). This is *passive* robustness: nothing is subtracted from the residual.
//!
//! ```text
//! J_i(k) = a_i + Σ_jl b_ijl ‖φ_l u_j‖_k          bound of residual channel i
//! ‖x‖_k² = (1 − 1/N) ‖x‖²_(k−1) + x(k)² / N      root mean square over a fading window of N samples
//! ```
//!
//! `φ_0 … φ_L` split the input into frequency bands with `L` first-order filters: `φ_0` is the slowest
//! low-pass, then differences of neighbouring low-passes, last what the fastest one leaves; their sum is
//! one. `a_i` is the part of the noise. The weights `b ≥ 0` come from one of two designs.
//!
//! | Design | From | Covers |
//! |--------|------|--------|
//! | [`InputBound::over_ensemble`] | transfers `H_y ΔG` of perturbed models | all of them: `Σ_l b_ijl |φ_l(ω)| ≥ max |H_y ΔG|_ij(ω)` |
//! | [`InputBound::from_fault_free`] | healthy logs with their inputs | a quantile of the residual, by quantile regression |
//!
//! Why the first is a bound: from `|G(ω)| ≤ Σ_l b_l |φ_l(ω)|` follows, by Parseval and Minkowski,
//! `‖G u‖ ≤ Σ_l b_l ‖φ_l u‖` over all time from rest. Over a fading window it holds up to what the
//! memory of the filters carries across the edge of the window, so `N` should be longer than that.
//!
//! | Detector | Compares with `J_i` |
//! |----------|---------------------|
//! | [`AdaptiveThreshold::of_magnitude`] | each `|r_i(k)|`: quick, the adaptive threshold |
//! | [`AdaptiveThreshold::of_rms`] | `‖r_i‖_k` over the same window: the threshold selector of Emami-Naeini et al. |
//!
//! The statistic is the largest ratio of the two, so that one number, the threshold, scales all bounds.
//! [`calibrate_held_out`](crate::calibrate::calibrate_held_out) sets it for a stated rate of false alarms on
//! runs with other inputs than those that the bound was learned from.
//!
//! [`InputBound::known_on`] tells where the bound was seen to hold: while a norm of an input is larger than in any
//! healthy log (another level, a larger jump, a faster motion), the bound is continued in proportion, which a linear
//! bias obeys, and the detector says that its threshold is [void](fd_core::stage::Detector::is_void): nobody has
//! seen how often it is exceeded there.
//!
//! **Assumptions.** Filters start in the steady state of the first input. The ensemble spans the
//! uncertainty, or the healthy logs span the inputs to come.
//!
//! **Not to be used** in place of learning and subtracting the bias where that can be done: the bound is an order of
//! magnitude wider than the noise, and a fault that hides under it stays hidden. Behind the compensation it bounds
//! what the learned bias model leaves after a step, which is little and soon over.

mod bank;
mod ensemble;
mod learn;
mod non_negative;
mod run;

pub use self::{
    bank::Bands,
    ensemble::noise_levels,
    learn::{Evaluation, LearnedBound},
    run::AdaptiveThreshold,
};

use super::error::{DetectorError, length};
use crate::rows::DrivenRows;

/// Design of `J_i = a_i + Σ_jl b_ijl ‖φ_l u_j‖`, see the [module](self).
#[derive(Clone, Debug, PartialEq)]
pub struct InputBound {
    bands: Bands,
    nu: usize,
    /// `a`, one for each residual channel.
    noise: Vec<f64>,
    /// `b`: for each residual channel, for each input, one for each band.
    gains: Vec<f64>,
    /// Largest norm that was seen: for each input, one for each band.
    largest: Vec<f64>,
    /// How far beyond it holds, relative to it.
    margin: f64,
}

impl InputBound {
    /// From given parts; `gains` are those of residual channel 0 first, within it those of input 0 first.
    ///
    /// ```
    /// use fd_compensate::detect::adaptive::{Bands, InputBound};
    ///
    /// let bands = Bands::new(&[0.1], 50.0)?;
    /// let bound = InputBound::new(bands, 1, &[0.1], &[0.5, 0.2])?;
    /// assert_eq!(bound.gain(0, 0, 0.0), 0.5); // only the slow band passes a constant
    /// # Ok::<(), fd_compensate::detect::DetectorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the numbers of entries do not fit, a noise level is not positive or a gain
    /// is negative.
    pub fn new(
        bands: Bands,
        nu: usize,
        noise: &[f64],
        gains: &[f64],
    ) -> Result<Self, DetectorError> {
        length("gains", noise.len() * nu * bands.count(), gains.len())?;
        noise.iter().try_for_each(|&a| super::error::positive("noise level", a))?;
        if let Some(&found) = gains.iter().find(|b| !(**b >= 0.0 && b.is_finite())) {
            let (parameter, expected) = ("gain", "non-negative and finite");
            return Err(DetectorError::Parameter { parameter, expected, found });
        }
        let largest = vec![f64::INFINITY; nu * bands.count()];
        Ok(Self { bands, nu, noise: noise.to_vec(), gains: gains.to_vec(), largest, margin: 0.0 })
    }

    /// The same bound with another noise level of each residual channel.
    ///
    /// # Errors
    ///
    /// As [`InputBound::new`].
    pub fn with_noise(self, noise: &[f64]) -> Result<Self, DetectorError> {
        let (largest, margin) = (self.largest, self.margin);
        Ok(Self { largest, margin, ..Self::new(self.bands, self.nu, noise, &self.gains)? })
    }

    /// The same bound, said to hold only where the norms of the inputs are not above the largest ones of these logs
    /// by more than `margin` of them: beyond, by a level, a jump or a rate that the logs do not have, the threshold is
    /// [void](fd_core::stage::Detector::is_void), until the norms are below half of the margin again. Without this it
    /// is taken to hold everywhere.
    ///
    /// ```
    /// use fd_compensate::{DrivenRows, SampleRows, detect::{AdaptiveThreshold, adaptive::{Bands, InputBound}}};
    /// use fd_core::stage::Detector;
    ///
    /// let (u, r) = ([1.0, -1.0, 1.0], [0.1, 0.1, 0.1]);
    /// let healthy = DrivenRows::new(SampleRows::new(1, &u)?, SampleRows::new(1, &r)?)?;
    /// let bound = InputBound::new(Bands::new(&[], 1.0)?, 1, &[0.1], &[0.2])?.known_on(healthy, 0.1)?;
    /// let mut detector = AdaptiveThreshold::of_magnitude(&bound, 1.0)?;
    /// detector.update(&[1.05], &[0.0]);
    /// assert!(!detector.is_void());
    /// detector.update(&[-1.2], &[0.0]);
    /// assert!(detector.is_void());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when the logs have other inputs, or the margin is negative or not finite.
    pub fn known_on(mut self, healthy: DrivenRows<'_>, margin: f64) -> Result<Self, DetectorError> {
        length("inputs of the fault-free record", self.nu, healthy.nu())?;
        if !(margin >= 0.0 && margin.is_finite()) {
            let (parameter, expected) = ("margin of the inputs", "non-negative and finite");
            return Err(DetectorError::Parameter { parameter, expected, found: margin });
        }
        self.largest = bank::largest_norms(&self.bands, healthy);
        self.margin = margin;
        Ok(self)
    }

    /// The largest norms of the inputs that were seen, those of input 0 first, and the margin beyond them;
    /// infinite unless [told](Self::known_on).
    #[must_use]
    pub fn largest_norms(&self) -> (&[f64], f64) {
        (&self.largest, self.margin)
    }

    /// Residual channels.
    #[must_use]
    pub fn residual_len(&self) -> usize {
        self.noise.len()
    }

    /// Inputs.
    #[must_use]
    pub fn nu(&self) -> usize {
        self.nu
    }

    /// How the input is split into bands.
    #[must_use]
    pub fn bands(&self) -> &Bands {
        &self.bands
    }

    /// The part `a` of the noise.
    #[must_use]
    pub fn noise(&self) -> &[f64] {
        &self.noise
    }

    /// The weights `b` from one input to one residual channel, a number for each band.
    #[must_use]
    pub fn weights(&self, channel: usize, input: usize) -> &[f64] {
        let count = self.bands.count();
        let start = (channel * self.nu + input) * count;
        &self.gains[start..start + count]
    }

    /// The bound `Σ_l b_l |φ_l(ω)|` of the gain from one input to one residual channel at `omega` in
    /// rad per sample.
    #[must_use]
    pub fn gain(&self, channel: usize, input: usize, omega: f64) -> f64 {
        let bands = self.bands.gains(omega);
        bands.iter().zip(self.weights(channel, input)).map(|(phi, b)| phi * b).sum()
    }
}
