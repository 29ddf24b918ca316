//! Courses of faults after whitening, and their information.

use faer::Mat;
use fd_numeric::dense::Dense;

use crate::detect::{
    error::{DetectorError, positive},
    whiten::WhitenerDesign,
};
use serde::{Deserialize, Serialize};

/// How a fault develops from its onset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Course {
    /// At once, and stays: size in the unit of the residual (or of the fault, with a signature).
    Step,
    /// Evenly: size per sample.
    Ramp,
}

/// What to look for.
#[derive(Clone, Debug)]
pub struct GlrDesign {
    pub(super) whitener: WhitenerDesign,
    pub(super) window: usize,
    pub(super) patterns: Vec<Pattern>,
}

/// One course along one signature, or along all directions.
#[derive(Clone, Debug)]
pub(super) struct Pattern {
    pub course: Course,
    pub signature: Option<usize>,
    /// `F(t)` for each age, channels by sizes.
    pub effect: Vec<Mat<f64>>,
    /// `L⁻¹` with `J = L Lᵀ`, for each age: `cᵀ J⁻¹ c = ‖L⁻¹ c‖²`.
    pub root: Vec<Mat<f64>>,
}

impl GlrDesign {
    /// Looks for the courses in any direction of the residual, over onsets within `window` samples.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no course or no window.
    pub fn any_direction(
        whitener: WhitenerDesign,
        courses: &[Course],
        window: usize,
    ) -> Result<Self, DetectorError> {
        let channels = whitener.channels();
        let axes: Vec<Vec<f64>> = (0..channels)
            .map(|i| (0..channels).map(|c| f64::from(u8::from(c == i))).collect())
            .collect();
        let axes: Vec<&[f64]> = axes.iter().map(Vec::as_slice).collect();
        Self::build(whitener, courses, window, &[(None, axes)])
    }

    /// Looks for the courses along given signatures: the effects of faults of size 1 on the residual.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no course, no signature or no window, or a signature has another
    /// length than the residual or vanishes.
    pub fn along(
        whitener: WhitenerDesign,
        signatures: &[Vec<f64>],
        courses: &[Course],
        window: usize,
    ) -> Result<Self, DetectorError> {
        positive("number of signatures", signatures.len() as f64)?;
        let directions: Vec<(Option<usize>, Vec<&[f64]>)> =
            signatures.iter().enumerate().map(|(i, s)| (Some(i), vec![s.as_slice()])).collect();
        Self::build(whitener, courses, window, &directions)
    }

    fn build(
        whitener: WhitenerDesign,
        courses: &[Course],
        window: usize,
        directions: &[(Option<usize>, Vec<&[f64]>)],
    ) -> Result<Self, DetectorError> {
        positive("window", window as f64)?;
        positive("number of courses", courses.len() as f64)?;
        let mut patterns = Vec::new();
        for &course in courses {
            let profile: Vec<f64> = (1..=window)
                .map(|age| if course == Course::Step { 1.0 } else { age as f64 })
                .collect();
            for (signature, columns) in directions {
                let responses: Vec<Vec<Vec<f64>>> = columns
                    .iter()
                    .map(|gain| whitener.response(gain, &profile))
                    .collect::<Result<_, _>>()?;
                let effect: Vec<Mat<f64>> = (0..window)
                    .map(|t| {
                        Mat::from_fn(whitener.channels(), columns.len(), |i, j| responses[j][t][i])
                    })
                    .collect();
                let root = roots(&effect)?;
                patterns.push(Pattern { course, signature: *signature, effect, root });
            }
        }
        Ok(Self { whitener, window, patterns })
    }
}

/// The inverse Cholesky factors of the growing information.
fn roots(effect: &[Mat<f64>]) -> Result<Vec<Mat<f64>>, DetectorError> {
    let sizes = effect.first().map_or(0, Mat::ncols);
    let mut information = Mat::<f64>::zeros(sizes, sizes);
    effect
        .iter()
        .map(|effect| {
            information += effect.transpose() * effect;
            let factor = information.cholesky().map_err(|_| DetectorError::Parameter {
                parameter: "information of a signature",
                expected: "positive and finite",
                found: (0..sizes).map(|i| information[(i, i)]).fold(f64::NAN, f64::min),
            })?;
            let mut inverse = Mat::identity(sizes, sizes);
            factor.L().solve_lower_triangular_in_place(inverse.as_mut());
            Ok(inverse)
        })
        .collect()
}
