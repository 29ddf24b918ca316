//! Effects that a simulator has in itself.

use crate::model::Parameter;

/// An effect that a simulator has in itself and that rests: a parameter at its neutral value.
///
/// A physics engine knows friction, springs and backlash at its joints, most of them switched off. Such a law is exact
/// where a force that a shell holds over a step is not, and the simulator's own file can keep it.
#[derive(Clone, Debug, PartialEq)]
pub struct NativeEffect {
    /// Name of the effect, such as `coulomb-friction`: one of the library means the same cause there.
    pub label: String,
    /// The mechanism, wider than the label; empty for that of the library's effect of this label, or the label.
    pub family: String,
    /// Where it is: the name of a port, an input or an output, or of any other part of the simulator.
    pub place: String,
    /// Its parameter, with the neutral value, and exact.
    pub parameter: Parameter,
    /// Change of the parameter that is noticed, in its unit.
    pub size: f64,
    /// Whether `1/value` is what a person would call it: a limit that is infinite where the parameter is zero.
    pub is_reciprocal: bool,
}

impl NativeEffect {
    /// An effect with a parameter at its neutral value, of which a change by `size` is noticed.
    ///
    /// ```
    /// use fd_sim::{model::Parameter, simulate::NativeEffect};
    ///
    /// let damping = Parameter::new("elbow_damping", "N m s/rad", 0.0);
    /// let effect = NativeEffect::new("viscous-friction", "elbow", damping, 0.1);
    /// assert_eq!((effect.parameter.tolerance, effect.is_reciprocal), (0.0, false));
    /// ```
    #[must_use]
    pub fn new(
        label: impl Into<String>,
        place: impl Into<String>,
        parameter: Parameter,
        size: f64,
    ) -> Self {
        Self {
            label: label.into(),
            family: String::new(),
            place: place.into(),
            parameter: Parameter { tolerance: 0.0, ..parameter },
            size,
            is_reciprocal: false,
        }
    }
}
