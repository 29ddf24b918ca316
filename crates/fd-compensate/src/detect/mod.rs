//! From compensated residuals to test statistics.
//!
//! | Detector | Statistic | Good for |
//! |----------|-----------|----------|
//! | [`Magnitude`] | norm of `r_i / s_i`, by default the largest | the paper's rule; abrupt faults, no assumption on noise |
//! | [`NSigma`] | largest `(r_i − m_i) / σ_i` | the same with an offset, in standard deviations |
//! | [`ChiSquare`] | `Σ (r − m)ᵀ Σ⁻¹ (r − m)` over a window | several correlated channels |
//! | [`Cusum`] | two-sided cumulative sum, worst channel | small lasting faults |
//! | [`Sprt`] | log-likelihood ratio of Wald's restarted test | lasting faults of a known least size |
//! | [`Glr`] | generalised likelihood ratio over onsets and sizes | unknown time and size, also with known signatures; gives both |
//! | [`TwoSample`] | mean, variance or distribution of a window against fault-free | dead or noisy sensors, changes of shape |
//! | [`AdaptiveThreshold`] | residual against a bound that follows the input | uncompensated bias of a wrong model |
//!
//! A detector sees `r*` in every phase, including the innovation of the training; it is the [decision
//! rule](crate::decide) that stays silent during training. Detectors with a memory (a window, a sum) therefore
//! carry the last innovations into the first compensated samples.
//!
//! The thresholds that the constructors compute from a formula assume white Gaussian residuals, which
//! a compensated residual seldom is. [`calibrate`](crate::calibrate) finds thresholds from fault-free
//! data instead.

pub mod adaptive;
pub mod chi_square;
pub mod cusum;
pub(crate) mod error;
pub mod glr;
mod magnitude;
mod n_sigma;
mod quadrature;
pub mod sprt;
mod standardize;
pub mod two_sample;
pub mod whiten;

pub use self::{
    adaptive::AdaptiveThreshold,
    chi_square::ChiSquare,
    cusum::Cusum,
    error::DetectorError,
    glr::Glr,
    magnitude::{DEFAULT_MARGIN, Magnitude, Norm},
    n_sigma::NSigma,
    sprt::Sprt,
    standardize::{Spread, Standardizer},
    two_sample::TwoSample,
};

/// Every detector of this module with every statistic that it has, fitted to `healthy` and with thresholds near
/// its edge; those that follow the input need a record that has it.
///
/// # Errors
///
/// Returns an error when `healthy` does not allow one of them: a channel that never moves, channels
/// that depend on each other, or fewer samples than a window.
#[cfg(feature = "testing")]
pub fn every_detector<T: fd_core::Scalar>(
    healthy: crate::DrivenRows<'_>,
) -> Result<Vec<fd_core::testing::Named<dyn fd_core::stage::Detector<T>>>, DetectorError> {
    use self::{
        adaptive::{Bands, Evaluation, InputBound},
        glr::{Course, GlrDesign},
        sprt::{ErrorProbabilities, Sides},
        two_sample::SampleTest,
        whiten::WhitenerDesign,
    };

    let r = healthy.residuals();
    let standard = |spread| Standardizer::from_fault_free(r, spread);
    let deviation = || standard(Spread::StandardDeviation);
    let norm = |norm| Magnitude::above_fault_free_norm(norm, r, 0.05);
    let errors = ErrorProbabilities { false_alarm: 0.01, missed: 0.05 };
    let whitener = WhitenerDesign::from_fault_free(r, 3)?;
    let courses = [Course::Step, Course::Ramp];
    let along: Vec<Vec<f64>> = (0..r.channels())
        .map(|channel| (0..r.channels()).map(|i| if i == channel { 1.0 } else { 0.0 }).collect())
        .collect();
    let any_direction = GlrDesign::any_direction(whitener.clone(), &courses, 9)?;
    let along_sensors = GlrDesign::along(whitener, &along, &courses, 9)?;
    let two_sample = |test| TwoSample::new(test, r, 12, 2.0);
    let peaks = r.per_channel(|v| v.fold(0.0, |peak: f64, v| peak.max(v.abs())));
    let bands = Bands::new(&[0.1], 9.0)?;
    let per_channel = healthy.nu() * bands.count();
    let gains: Vec<f64> = peaks.iter().flat_map(|peak| vec![0.1 * peak; per_channel]).collect();
    let bound = InputBound::new(bands, healthy.nu(), &peaks, &gains)?.known_on(healthy, 0.1)?;
    let follows = |evaluation| AdaptiveThreshold::new(&bound, evaluation, 0.9);
    Ok(vec![
        ("largest magnitude", Box::new(Magnitude::above_fault_free_maximum(r, 0.05)?)),
        ("euclidean norm", Box::new(norm(Norm::Euclidean)?)),
        ("sum of magnitudes", Box::new(norm(Norm::Sum)?)),
        ("n-sigma", Box::new(NSigma::new(deviation()?, 3.0)?)),
        (
            "n-sigma of the median",
            Box::new(NSigma::new(standard(Spread::MedianAbsoluteDeviation)?, 3.0)?),
        ),
        ("chi-square", Box::new(ChiSquare::from_fault_free(r, 1, 9.0)?)),
        ("chi-square over a window", Box::new(ChiSquare::from_fault_free(r, 7, 30.0)?)),
        ("cusum", Box::new(Cusum::new(deviation()?, 0.5, 4.0)?)),
        ("sprt", Box::new(Sprt::new(deviation()?, 1.0, errors, Sides::Both)?)),
        ("sprt, one side", Box::new(Sprt::new(deviation()?, 1.0, errors, Sides::Upper)?)),
        ("glr", Box::new(Glr::new(&any_direction, 10.0)?)),
        ("glr of sensors", Box::new(Glr::new(&along_sensors, 10.0)?)),
        ("two-sample mean", Box::new(two_sample(SampleTest::Mean)?)),
        ("two-sample variance", Box::new(two_sample(SampleTest::Variance)?)),
        ("two-sample distribution", Box::new(two_sample(SampleTest::Distribution)?)),
        ("adaptive threshold", Box::new(follows(Evaluation::Magnitude)?)),
        ("threshold selector", Box::new(follows(Evaluation::RootMeanSquare)?)),
    ])
}
