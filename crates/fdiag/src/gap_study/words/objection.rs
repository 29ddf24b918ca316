//! What speaks against an answer.

use fd_gap::diagnose::Objection;

use super::{
    labels::{label, list},
    numbers::four,
};

/// What speaks against an answer, as half a sentence.
#[must_use]
pub fn objection(objection: &Objection) -> String {
    match objection {
        Objection::FaintStrength { cause, errors, .. } => {
            format!("the strength of {} is only {errors:.1} times its standard error", label(cause))
        }
        Objection::NoBetterThanConstant => {
            "with it the model forecasts held-out data worse than a constant does".to_owned()
        }
        Objection::NoBetterThanLastValue => {
            "with it the model forecasts held-out data worse than the last measured value does"
                .to_owned()
        }
        Objection::WorseThanNominal => {
            "with it the model forecasts held-out data worse than as it came".to_owned()
        }
        Objection::WorseThanRefitted => {
            "with it the model forecasts held-out data worse than with refitted parameters alone"
                .to_owned()
        }
        Objection::NotShown => {
            "it may follow anything in the log that it is fitted to, and held-out data do not show it"
                .to_owned()
        }
        Objection::ParametersAtEdges { names, of, .. } => format!(
            "{} of {of} refitted parameters lie at the edges of their tolerances ({})",
            names.len(),
            list(&names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>(), "and")
        ),
        Objection::ReadsBeyondLimit { limit, reads } => format!(
            "the log reads {}, which a sensor that ends at {} cannot show",
            four(*reads),
            four(*limit)
        ),
    }
}
