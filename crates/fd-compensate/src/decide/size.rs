//! The debounced alarm with an estimate of which sensor fault it is and how large.

use fd_core::{
    Scalar, StateVisitor,
    stage::{Decision, DecisionRule, Evidence, Fault, Stage},
};
use fd_numeric::dot;
use serde::{Deserialize, Serialize};

use super::{
    debounce::{Debounce, Debouncing},
    error::RuleError,
    mean::{Alarm, FaultMean},
};

/// What may have happened: a fault with a known lasting effect on the residual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hypothesis {
    /// Name, such as that of the sensor.
    pub name: String,
    /// DC gain from a fault of size 1 to each residual channel.
    pub signature: Vec<f64>,
}

/// How sizes are estimated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sizing {
    /// Samples after the first alarm that are left out, for the transient of the residual to die away;
    /// default 0.
    pub settling: u64,
    /// Time constant in samples of the mean of `r*`; `None` (default) averages all samples since the
    /// alarm, which is right for a constant fault; a growing fault wants a short memory.
    pub memory: Option<f64>,
    /// The best hypothesis is named only if the share of `r̄*` that it leaves unexplained is smaller
    /// than that of each other one by at least this much; default 0.1.
    pub separation: f64,
}

impl Default for Sizing {
    fn default() -> Self {
        Self { settling: 0, memory: None, separation: 0.1 }
    }
}

/// Raises debounced alarms and, from the mean of `r*` since the first of them, estimates the size of
/// each hypothesis by least squares,
///
/// ```text
/// ŝ_i = g_iᵀ r̄* / g_iᵀ g_i,     unexplained_i = ‖r̄* − g_i ŝ_i‖² / ‖r̄*‖²
/// ```
///
/// and names the one that leaves least unexplained.
///
/// # Limits
///
/// * A scalar residual cannot tell one sensor from another: every hypothesis explains it fully, so none
///   is named unless there is only one. [`SizedDebounce::sizes`] still gives the size that each
///   would have, "if it is this sensor".
/// * The signatures are DC gains: right for faults that last, after the transient of the residual
///   generator. While a fault grows, the estimate trails it by the memory of the mean.
/// * One fault at a time. Channels count as they are; scale them to equal noise beforehand.
/// * The compensated residual must be that of [simulation
///   mode](crate::residual_compensation::Mode::Simulation); one-step compensation removes most of a
///   lasting fault.
#[derive(Clone, Debug)]
pub struct SizedDebounce<T> {
    alarm: Debounce,
    signatures: Vec<Vec<T>>,
    separation: T,
    mean: FaultMean<T>,
    sizes: Vec<T>,
}

impl<T: Scalar> SizedDebounce<T> {
    /// A rule for residuals with as many channels as each signature has entries.
    ///
    /// ```
    /// use fd_compensate::decide::{Debouncing, Hypothesis, SizedDebounce, Sizing};
    /// use fd_core::stage::DecisionRule;
    ///
    /// let hypotheses = [Hypothesis { name: "T7".into(), signature: vec![0.8] }];
    /// let rule =
    ///     SizedDebounce::<f64>::new(1, Debouncing::consecutive(3), &hypotheses, &Sizing::default())?;
    /// assert_eq!(rule.residual_len(), 1);
    /// # Ok::<(), fd_compensate::decide::RuleError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a count or number is out of its range, or a signature has another length,
    /// is not finite or vanishes.
    pub fn new(
        residual_len: usize,
        debouncing: Debouncing,
        hypotheses: &[Hypothesis],
        sizing: &Sizing,
    ) -> Result<Self, RuleError> {
        let alarm = Debounce::new(residual_len, debouncing)?;
        for (hypothesis, Hypothesis { name, signature }) in hypotheses.iter().enumerate() {
            let power: f64 = signature.iter().map(|g| g * g).sum();
            if signature.len() != residual_len || !(power > 0.0 && power.is_finite()) {
                let (name, found) = (name.clone(), signature.clone());
                return Err(RuleError::Signature { hypothesis, name, residual_len, found });
            }
        }
        let refuse =
            |parameter, expected, found| Err(RuleError::Number { parameter, expected, found });
        if !(0.0..=1.0).contains(&sizing.separation) {
            return refuse("separation", "between 0 and 1", sizing.separation);
        }
        let signatures: Vec<Vec<T>> = hypotheses
            .iter()
            .map(|h| h.signature.iter().map(|&g| T::from_design(g)).collect())
            .collect();
        Ok(Self {
            alarm,
            separation: T::from_design(sizing.separation),
            mean: FaultMean::new(residual_len, sizing.settling, sizing.memory)?,
            sizes: vec![T::zero(); signatures.len()],
            signatures,
        })
    }

    /// The size that each hypothesis would have, in its unit, if it were the one; zeros while there is
    /// no fault.
    #[must_use]
    pub fn sizes(&self) -> &[T] {
        &self.sizes
    }

    fn forget(&mut self) {
        self.mean.forget();
        self.sizes.fill(T::zero());
    }

    /// Estimates all sizes and names the hypothesis that stands out, if one does.
    fn explain(&mut self) -> Option<usize> {
        let mean = self.mean.values();
        let power = dot(mean, mean);
        let (mut best, mut least, mut second) = (None, T::one(), T::one());
        for (index, (size, g)) in self.sizes.iter_mut().zip(&self.signatures).enumerate() {
            let (along, length) = (dot(g, mean), dot(g, g));
            *size = along / length;
            // ‖r̄‖² − (gᵀr̄)²/gᵀg over ‖r̄‖²; not below 0 but for rounding.
            let unexplained =
                if power > T::zero() { T::one() - along * *size / power } else { T::one() };
            if best.is_none() || unexplained < least {
                second = least;
                (best, least) = (Some(index), unexplained);
            } else {
                second = second.min(unexplained);
            }
        }
        let is_alone = self.signatures.len() == 1;
        best.filter(|_| !self.mean.is_empty() && (is_alone || least + self.separation <= second))
    }
}

impl<T: Scalar> Stage<T> for SizedDebounce<T> {
    fn reset(&mut self) {
        Stage::<T>::reset(&mut self.alarm);
        self.forget();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.alarm.visit_state(visitor);
        self.mean.visit_state(visitor);
        visitor.reals("fault sizes", &mut self.sizes);
    }
}

impl<T: Scalar> DecisionRule<T> for SizedDebounce<T> {
    fn residual_len(&self) -> usize {
        self.mean.values().len()
    }

    fn decide(&mut self, evidence: Evidence<'_, T>) -> Decision<T> {
        let since = match self.mean.follow(&mut self.alarm, evidence) {
            Alarm::None => {
                self.forget();
                return Decision::Nominal;
            }
            Alarm::Pending => return Decision::Nominal,
            Alarm::Raised { since } => since,
        };
        let hypothesis = self.explain();
        let size = hypothesis.map(|index| self.sizes[index]);
        Decision::Fault(Fault { hypothesis, size, ..Fault::since(since) })
    }
}
