//! From test statistics to decisions.
//!
//! Rules are silent while the compensator trains: a threshold for `r*` does not apply to an innovation.
//!
//! | Rule | Reports |
//! |------|------|
//! | [`Debounce`] | that there is a fault, and since when |
//! | [`SizedDebounce`] | the same, which of the known faults explains it best, and how large it is |
//! | [`IsolatingDebounce`] | the same, with the probability of each known fault, of an unknown one and of none, and an interval of the size |

mod debounce;
mod error;
pub mod isolate;
mod mean;
mod size;

pub use self::{
    debounce::{Debounce, Debouncing},
    error::RuleError,
    isolate::{Candidate, Effect, FaultFree, IsolatingDebounce, Isolation},
    size::{Hypothesis, SizedDebounce, Sizing},
};

/// Every rule of this module, for residuals like `healthy` and a fault of each channel.
///
/// # Errors
///
/// Returns an error when a channel of `healthy` is constant or a combination of the others.
#[cfg(feature = "testing")]
pub fn every_rule<T: fd_core::Scalar>(
    healthy: crate::SampleRows<'_>,
) -> Result<Vec<fd_core::testing::Named<dyn fd_core::stage::DecisionRule<T>>>, RuleError> {
    let channels = healthy.channels();
    let is_on = |channel: usize| (0..channels).map(move |i| i == channel);
    let hypotheses: Vec<Hypothesis> = (0..channels)
        .map(|channel| Hypothesis {
            name: format!("sensor {channel}"),
            signature: is_on(channel).map(|on| if on { 1.0 } else { 0.0 }).collect(),
        })
        .collect();
    let signatures: Vec<Candidate> = hypotheses.iter().cloned().map(Candidate::from).collect();
    let responses: Vec<Candidate> = signatures
        .iter()
        .enumerate()
        .map(|(channel, candidate)| Candidate {
            effect: Effect::Responds(is_on(channel).collect()),
            ..candidate.clone()
        })
        .collect();
    let normal = FaultFree::from_samples(healthy)?;
    let two_of_three = Debouncing { raise: 2, out_of: 3, clear: 2, latch: false };
    let latching = Debouncing { latch: true, ..two_of_three };
    let sizing = Sizing { settling: 2, memory: Some(10.0), ..Sizing::default() };
    let isolation = Isolation { settling: 2, memory: Some(10.0), ..Isolation::default() };
    let isolating =
        |candidates: &[_]| IsolatingDebounce::new(&normal, candidates, two_of_three, &isolation);
    Ok(vec![
        ("debounce", Box::new(Debounce::new(channels, two_of_three)?)),
        ("debounce, latching", Box::new(Debounce::new(channels, latching)?)),
        ("nearest", Box::new(SizedDebounce::new(channels, two_of_three, &hypotheses, &sizing)?)),
        ("bayes", Box::new(isolating(&signatures)?)),
        ("bayes of responses", Box::new(isolating(&responses)?)),
    ])
}
