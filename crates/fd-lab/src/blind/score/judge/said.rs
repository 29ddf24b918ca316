//! What a diagnosis calls the effects of the bench that have names of their own.

use crate::blind::truth::Effect;

/// What a diagnosis calls an effect: on a signal inside the model it has the name that it has at inputs.
pub(super) fn said_of(effect: &Effect) -> &str {
    match effect.label.as_str() {
        "inner-gain" => "input-gain",
        "inner-offset" => "input-offset",
        "inner-saturation" => "input-saturation",
        "inner-dead-zone" => "input-dead-zone",
        "inner-curve" => "input-map",
        "inner-delay" => "input-delay",
        "inner-lag" => "input-lag",
        "wandering-parameter" => "parameter-wander",
        label => label,
    }
}

/// The same of a mechanism.
pub(super) fn mechanism_of(effect: &Effect) -> &str {
    match effect.family.as_str() {
        "inner-gain" => "actuator-gain",
        "inner-offset" => "actuator-offset",
        "inner-nonlinearity" => "actuator-nonlinearity",
        "inner-dynamics" => "actuator-dynamics",
        family => family,
    }
}
