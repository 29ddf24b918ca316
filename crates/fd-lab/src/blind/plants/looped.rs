//! Plants that an unknown controller drives: which output follows a reference, by which input, and
//! how strongly a controller may act.

use super::{drives, elsewhere, mechanics, plant::Plant, process};

/// A plant with what a controller of it needs to know.
#[derive(Clone, Copy)]
pub(in crate::blind) struct Looped {
    pub plant: &'static Plant,
    /// Places of the input that is driven and of the output that follows.
    pub ends: [usize; 2],
    /// Another output that a state feedback uses.
    pub inner: Option<usize>,
    pub tuning: Tuning,
}

/// How strongly a controller may act.
#[derive(Clone, Copy)]
pub(in crate::blind) enum Tuning {
    /// A stable plant: gains in spreads of input over output in the open loop, times in what its
    /// excitation lasts.
    Relative,
    /// Gain, integral gain, rate gain, largest change of the command; middle and size of the
    /// reference; samples in which an error of the start grows twelvefold, where it does.
    Fixed { gains: [f64; 4], reference: [f64; 2], window: Option<usize> },
}

const fn stable(plant: &'static Plant, output: usize, inner: Option<usize>) -> Looped {
    Looped { plant, ends: [0, output], inner, tuning: Tuning::Relative }
}

/// Plants that are stable by themselves, and an integrator.
pub(in crate::blind) const STABLE: [Looped; 9] = [
    stable(&mechanics::MASS_SPRING_DAMPER, 0, None),
    stable(&mechanics::PENDULUM, 0, None),
    stable(&mechanics::CART_POLE, 0, None),
    stable(&drives::DC_DRIVE, 1, Some(0)),
    stable(&drives::TWO_MASS_DRIVE, 0, Some(1)),
    stable(&process::TANKS, 1, Some(0)),
    stable(&process::TWO_INPUT, 0, None),
    stable(&process::TWO_SPOOL_ENGINE, 0, None),
    Looped {
        plant: &elsewhere::SERVO,
        ends: [0, 0],
        inner: Some(1),
        tuning: Tuning::Fixed { gains: [6.0, 3.0, 0.4, 9.0], reference: [0.0, 1.0], window: None },
    },
];

/// Plants that are not.
pub(in crate::blind) const UNSTABLE: [Looped; 2] = [
    Looped {
        plant: &elsewhere::STANDING_PENDULUM,
        ends: [0, 0],
        inner: None,
        tuning: Tuning::Fixed {
            gains: [6.0, 4.0, 0.8, 3.9],
            reference: [0.0, 0.15],
            window: Some(50),
        },
    },
    Looped {
        plant: &elsewhere::LEVITATION,
        ends: [0, 0],
        inner: None,
        tuning: Tuning::Fixed {
            gains: [-250.0, -1500.0, -4.0, 0.9],
            reference: [0.01, 0.0008],
            window: Some(28),
        },
    },
];

/// The entry of a plant.
pub(in crate::blind) fn looped(plant: &Plant) -> Option<&'static Looped> {
    STABLE.iter().chain(&UNSTABLE).find(|looped| looped.plant.name == plant.name)
}
