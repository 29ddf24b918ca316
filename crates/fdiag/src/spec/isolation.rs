//! Isolation and sizing of a fault, as a line of a spec.

use fd_compensate::{
    SampleRows,
    decide::{
        Candidate, Debounce, Debouncing, FaultFree, Hypothesis, IsolatingDebounce, Isolation,
        RuleError, SizedDebounce, Sizing,
    },
};
use fd_core::stage::DecisionRule;
use fd_residual::{DesignError, GeneratorDesign};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::signature::FaultSites;

/// Which fault it is, and how large.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum IsolationSpec {
    /// Alarms only.
    None {},
    /// The fault whose signature is nearest to the mean residual, with its size by least squares; how, says
    /// [`Sizing`].
    Nearest {
        /// Which faults are thought of.
        #[serde(default)]
        faults: FaultSites,
    },
    /// The probability of each fault, of an unknown one and of a false alarm, with the size and its
    /// interval.
    Bayes {
        /// Which faults are thought of.
        #[serde(default)]
        faults: FaultSites,
        /// How sure one has to be.
        #[serde(default)]
        settings: Isolation,
    },
}

impl Default for IsolationSpec {
    fn default() -> Self {
        Self::None {}
    }
}

/// A decision rule cannot be made for this generator and these fault-free residuals.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum IsolationSpecError {
    /// Its settings, signatures or scales.
    #[error(transparent)]
    Rule(#[from] RuleError),
    /// The generator has no steady response to the faults.
    #[error(transparent)]
    Generator(#[from] DesignError),
}

impl IsolationSpec {
    /// The rule for residuals of `design` that look like `healthy` without a fault.
    ///
    /// # Errors
    ///
    /// Returns an error when the generator has no steady response to one of the faults, the residuals do not
    /// say what is normal, or a setting is out of its range.
    pub fn rule(
        &self,
        debouncing: Debouncing,
        sizing: &Sizing,
        design: &dyn GeneratorDesign,
        healthy: SampleRows<'_>,
    ) -> Result<Box<dyn DecisionRule>, IsolationSpecError> {
        let channels = design.residual_len();
        let hypotheses = |faults: FaultSites| -> Result<Vec<Hypothesis>, DesignError> {
            let named = faults.names(design).into_iter().zip(faults.signatures(design)?);
            Ok(named.map(|(name, signature)| Hypothesis { name, signature }).collect())
        };
        Ok(match self {
            Self::None {} => Box::new(Debounce::new(channels, debouncing)?),
            Self::Nearest { faults } => Box::new(SizedDebounce::<f64>::new(
                channels,
                debouncing,
                &hypotheses(*faults)?,
                sizing,
            )?),
            Self::Bayes { faults, settings } => {
                let candidates: Vec<Candidate> =
                    hypotheses(*faults)?.into_iter().map(Candidate::from).collect();
                let normal = FaultFree::from_samples(healthy)?;
                Box::new(IsolatingDebounce::<f64>::new(&normal, &candidates, debouncing, settings)?)
            }
        })
    }
}
