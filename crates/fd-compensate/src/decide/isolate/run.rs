//! The running rule.

use fd_core::{
    HeapMap, LinMap, Scalar, StateVisitor,
    stage::{Decision, DecisionRule, Evidence, Fault, Stage},
};
use statrs::distribution::{ContinuousCDF, Normal};

use super::design::{Candidate, Effect, FaultFree, Isolation};
use crate::decide::{
    debounce::{Debounce, Debouncing},
    error::RuleError,
    mean::{Alarm, FaultMean},
};

/// Raises debounced alarms and says which candidate explains them, with what probability, and how large it
/// is; see the [module](super).
#[derive(Clone, Debug)]
pub struct IsolatingDebounce<T: Scalar> {
    alarm: Debounce,
    mean: FaultMean<T>,
    centre: Vec<T>,
    whitening: HeapMap<T>,
    /// `1/τ`.
    independent: T,
    /// `ε²/c`.
    tolerance: T,
    naming: T,
    /// Normal quantile of the interval.
    quantile: T,
    /// The candidates, then none of these, then no fault.
    explanations: Vec<Explanation<T>>,
    centred: Vec<T>,
    white: Vec<T>,
    projected: Vec<T>,
    probabilities: Vec<T>,
    sizes: Vec<T>,
}

/// One thing that may have happened, in whitened coordinates.
#[derive(Clone, Debug)]
struct Explanation<T: Scalar> {
    /// Orthonormal rows.
    directions: HeapMap<T>,
    /// Length of the whitened signature, if there is one.
    length: Option<T>,
    /// Logarithm of the prior weight, minus infinity for none.
    prior: T,
}

impl<T: Scalar> IsolatingDebounce<T> {
    /// A rule for residuals like the fault-free ones.
    ///
    /// ```
    /// use fd_compensate::decide::{
    ///     Candidate, Debouncing, Effect, FaultFree, IsolatingDebounce, Isolation,
    /// };
    /// use fd_core::stage::{Decision, DecisionRule, Evidence, Phase, Verdict};
    ///
    /// let signature = |name: &str, g: [f64; 2]| Candidate {
    ///     name: name.into(),
    ///     effect: Effect::Signature(g.to_vec()),
    ///     weight: 1.0,
    /// };
    /// let candidates = [signature("T7", [1.0, 0.0]), signature("P6", [0.5, 1.0])];
    /// let noise = FaultFree::new(&[0.0, 0.0], &[0.01, 0.0, 0.0, 0.01], 1.0)?;
    /// let mut rule = IsolatingDebounce::<f64>::new(
    ///     &noise,
    ///     &candidates,
    ///     Debouncing::default(),
    ///     &Isolation::default(),
    /// )?;
    /// let verdict = Verdict { statistic: 2.0, threshold: 1.0 };
    /// let (phase, r_star) = (Phase::Compensating, &[1.0, 2.0][..]);
    /// let decision = rule.decide(Evidence { k: 0, phase, verdict, r_star });
    /// let Decision::Fault(fault) = decision else { return Ok(()) };
    /// assert_eq!(fault.hypothesis, Some(1));
    /// assert!(fault.confidence.is_some_and(|p| p > 0.9));
    /// assert!(fault.size.is_some_and(|size| (size - 2.0).abs() < 1e-12));
    /// # Ok::<(), fd_compensate::decide::RuleError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// Returns an error when a count or number is out of its range, or an effect does not fit the residual or
    /// vanishes.
    pub fn new(
        fault_free: &FaultFree,
        candidates: &[Candidate],
        debouncing: Debouncing,
        isolation: &Isolation,
    ) -> Result<Self, RuleError> {
        isolation.check()?;
        let channels = fault_free.channels();
        let freeze = |m: &faer::Mat<f64>| {
            HeapMap::from_fn(m.nrows(), m.ncols(), |i, j| T::from_design(m[(i, j)]))
        };
        let mut explanations = Vec::with_capacity(candidates.len() + 2);
        for (hypothesis, Candidate { name, effect, weight }) in candidates.iter().enumerate() {
            if !(*weight >= 0.0 && weight.is_finite()) {
                let (parameter, expected) = ("weight of a candidate", "non-negative and finite");
                return Err(RuleError::Number { parameter, expected, found: *weight });
            }
            let Some((directions, length)) = fault_free.directions(effect) else {
                let (name, found) = (name.clone(), gains(effect));
                let residual_len = channels;
                return Err(RuleError::Signature { hypothesis, name, residual_len, found });
            };
            explanations.push(Explanation {
                directions: freeze(&directions),
                length: length.map(T::from_design),
                prior: T::from_design(weight.ln()),
            });
        }
        for (rows, weight) in [(channels, isolation.unknown), (0, isolation.false_alarm)] {
            explanations.push(Explanation {
                directions: freeze(&faer::Mat::identity(rows, channels)),
                length: None,
                prior: T::from_design(weight.ln()),
            });
        }
        if explanations.iter().all(|e| !e.prior.is_finite()) {
            let (parameter, expected) = ("sum of all prior weights", "positive");
            return Err(RuleError::Number { parameter, expected, found: 0.0 });
        }
        let quantile = Normal::standard().inverse_cdf(0.5 + 0.5 * isolation.coverage);
        let zeros = |n: usize| vec![T::zero(); n];
        Ok(Self {
            alarm: Debounce::new(channels, debouncing)?,
            mean: FaultMean::new(channels, isolation.settling, isolation.memory)?,
            centre: fault_free.mean.iter().map(|&m| T::from_design(m)).collect(),
            whitening: freeze(&fault_free.whitening),
            independent: T::from_design(fault_free.time.recip()),
            tolerance: T::from_design(isolation.tolerance.powi(2) / channels as f64),
            naming: T::from_design(isolation.naming),
            quantile: T::from_design(quantile),
            centred: zeros(channels),
            white: zeros(channels),
            projected: zeros(channels),
            probabilities: zeros(explanations.len()),
            sizes: zeros(candidates.len()),
            explanations,
        })
    }

    /// The probability of each candidate, then that of a fault that is none of them, then that of a false
    /// alarm; zeros while there is no fault.
    #[must_use]
    pub fn probabilities(&self) -> &[T] {
        &self.probabilities
    }

    /// The size that each candidate with a signature would have if it were the one; zeros for the others
    /// and while there is no fault.
    #[must_use]
    pub fn sizes(&self) -> &[T] {
        &self.sizes
    }

    fn forget(&mut self) {
        self.mean.forget();
        self.probabilities.fill(T::zero());
        self.sizes.fill(T::zero());
    }

    /// Weighs all explanations of the mean and says what is known of the fault.
    fn explain(&mut self, since: u64) -> Fault<T> {
        if self.mean.is_empty() {
            return Fault::since(since);
        }
        let half = T::from_design(0.5);
        for ((centred, &mean), &centre) in
            self.centred.iter_mut().zip(self.mean.values()).zip(&self.centre)
        {
            *centred = mean - centre;
        }
        self.whitening.mul_into(&self.centred, &mut self.white);
        let power = square(&self.white);
        let independent = self.mean.worth() * self.independent;
        // ν, the precision of each component of z.
        let precision = (independent.recip() + self.tolerance * power).recip();
        let energy = precision * power;

        let mut largest = None;
        for (index, explanation) in self.explanations.iter().enumerate() {
            let rows = explanation.directions.nrows();
            let projected = &mut self.projected[..rows];
            let mut evidence = explanation.prior - half * energy;
            if rows > 0 {
                explanation.directions.mul_into(&self.white, projected);
                let allowed = precision * square(projected);
                let freedom = T::from_design(rows as f64);
                let strength = energy / freedom;
                evidence += half * allowed * strength / (T::one() + strength)
                    - half * freedom * (T::one() + strength).ln();
                if let Some(length) = explanation.length {
                    self.sizes[index] = projected[0] / length;
                }
            }
            self.probabilities[index] = evidence;
            largest = Some(largest.map_or(evidence, |largest: T| largest.max(evidence)));
        }
        let largest = largest.unwrap_or(T::zero());
        let mut total = T::zero();
        for p in &mut self.probabilities {
            *p = (*p - largest).exp();
            total += *p;
        }
        for p in &mut self.probabilities {
            *p /= total;
        }
        self.name(since, precision)
    }

    /// Names the likeliest explanation if it is a candidate that is likely enough.
    fn name(&self, since: u64, precision: T) -> Fault<T> {
        let known = self.sizes.len();
        let fault = T::one() - self.probabilities[known + 1];
        let best = (0..known).reduce(|best, other| {
            if self.probabilities[best] < self.probabilities[other] { other } else { best }
        });
        let named = best.filter(|&best| {
            let p = self.probabilities[best];
            let others = self.probabilities[known..].iter().all(|&other| other < p);
            // Two candidates that are alike are not told apart by their order.
            let rivals = (0..known).filter(|&i| i != best).all(|i| self.probabilities[i] < p);
            self.naming <= p && others && rivals
        });
        let Some(index) = named else {
            return Fault { confidence: Some(fault), ..Fault::since(since) };
        };
        let size = self.explanations[index].length.map(|_| self.sizes[index]);
        let size_interval = self.explanations[index].length.map(|length| {
            let width = self.quantile / (precision.sqrt() * length);
            [self.sizes[index] - width, self.sizes[index] + width]
        });
        let confidence = Some(self.probabilities[index]);
        Fault { since, hypothesis: Some(index), size, size_interval, confidence }
    }
}

fn gains(effect: &Effect) -> Vec<f64> {
    match effect {
        Effect::Signature(gains) => gains.clone(),
        Effect::Responds(responds) => responds.iter().map(|&r| f64::from(u8::from(r))).collect(),
    }
}

fn square<T: Scalar>(values: &[T]) -> T {
    values.iter().fold(T::zero(), |sum, &v| sum + v * v)
}

impl<T: Scalar> Stage<T> for IsolatingDebounce<T> {
    fn reset(&mut self) {
        Stage::<T>::reset(&mut self.alarm);
        self.forget();
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor<T>) {
        self.alarm.visit_state(visitor);
        self.mean.visit_state(visitor);
        visitor.reals("fault probabilities", &mut self.probabilities);
        visitor.reals("fault sizes", &mut self.sizes);
    }
}

impl<T: Scalar> DecisionRule<T> for IsolatingDebounce<T> {
    fn residual_len(&self) -> usize {
        self.centre.len()
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
        Decision::Fault(self.explain(since))
    }
}
