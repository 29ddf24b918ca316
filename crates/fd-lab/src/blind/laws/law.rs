//! A law, what it is built from, and what it is at work.

use serde::{Deserialize, Serialize};

use super::origin::Origin;
use crate::blind::{
    random::Random,
    scales::{Scales, Signal, SiteScale},
};

/// What a law acts on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// An input of the plant.
    Input,
    /// A site for forces.
    Force,
    /// A parameter of the plant.
    Parameter,
    /// An output.
    Output,
    /// A signal inside the plant.
    Inside,
}

/// What a site must offer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::blind) enum Needs {
    Nothing,
    /// A velocity, or what drives like one: the current of a winding.
    Velocity,
    /// A velocity that the model calls so: something that can carry something else.
    Carrier,
    Position,
    Motion,
    /// A velocity that changes its sign.
    Reversal,
    /// A position without velocity: what fills up.
    Level,
    /// A position in radians.
    Angle,
    /// Another input, state or output.
    Partner,
    /// What corrupts the measurement and not the simulation.
    Measurement,
}

/// A law.
#[derive(Clone, Copy)]
pub(in crate::blind) struct Law {
    pub label: &'static str,
    pub name: &'static str,
    pub family: &'static str,
    pub place: Place,
    pub origin: Origin,
    pub needs: Needs,
    /// Least and largest strength, dimensionless.
    pub range: [f64; 2],
    pub build: fn(&Setting<'_>) -> Mechanism,
}

/// All that a law needs to know to be built.
pub(in crate::blind) struct Setting<'a> {
    pub strength: f64,
    /// Uniform draws in `0..1` for shapes.
    pub shape: [f64; 3],
    pub index: usize,
    pub partner: usize,
    pub scales: &'a Scales,
    pub seed: u64,
}

impl Setting<'_> {
    pub(super) fn sign(&self) -> f64 {
        if self.shape[0] < 0.5 { -1.0 } else { 1.0 }
    }

    /// A shape between two values; the first one is also what [`Setting::sign`] uses.
    pub(super) fn shape(&self, i: usize, low: f64, high: f64) -> f64 {
        low + (high - low) * self.shape[i]
    }

    pub(super) fn input(&self) -> &Signal {
        &self.scales.inputs[self.index]
    }

    pub(super) fn output(&self) -> &Signal {
        &self.scales.outputs[self.index]
    }

    pub(super) fn site(&self) -> &SiteScale {
        &self.scales.sites[self.index]
    }

    pub(super) fn inner(&self) -> &Signal {
        &self.scales.inner[self.index]
    }

    /// Spread of the velocity or, where there is none, of the position.
    pub(super) fn velocity(&self) -> f64 {
        self.site().velocity.as_ref().map_or(1.0, |signal| signal.std)
    }

    pub(super) fn position(&self) -> f64 {
        self.site()
            .position
            .as_ref()
            .map_or_else(|| self.velocity() * 10.0 * self.scales.ts, |signal| signal.std)
    }

    pub(super) fn random(&self) -> Random {
        Random::new(self.seed)
    }
}

/// What arrives at an input.
pub(in crate::blind) struct Arriving<'a> {
    pub u: f64,
    pub all: &'a [f64],
    pub t: f64,
    pub h: f64,
}

/// What a sensor measures.
pub(in crate::blind) struct Measured<'a> {
    pub y: f64,
    pub all: &'a [f64],
    pub t: f64,
    pub h: f64,
}

/// What is at a site.
#[derive(Clone, Copy)]
pub(in crate::blind) struct Site<'a> {
    pub x: f64,
    pub v: f64,
    /// Acceleration without the force, and per force.
    pub a: f64,
    pub c: f64,
    pub t: f64,
    pub states: &'a [f64],
}

impl Site<'_> {
    /// A force against a motion to which `force` is positive.
    pub(super) fn against(&self, force: f64) -> f64 {
        -force.copysign(force * self.c)
    }
}

type InputLaw = Box<dyn FnMut(&Arriving<'_>) -> f64 + Send>;

type SensorLaw = Box<dyn FnMut(&Measured<'_>) -> f64 + Send>;

type CorruptLaw = Box<dyn FnMut(f64, f64, f64) -> f64 + Send>;

type ForceLaw = Box<dyn Fn(&Site<'_>, &[f64]) -> f64 + Send>;

type StateLaw = Box<dyn Fn(&Site<'_>, &[f64], &mut [f64]) + Send>;

type HeldLaw = Box<dyn FnMut(&Site<'_>, f64) -> f64 + Send>;

type LevelLaw = Box<dyn FnMut(&Site<'_>, f64) -> [f64; 2] + Send>;

/// From the value and the length of a step to what it is instead.
type InnerLaw = Box<dyn FnMut(f64, f64) -> f64 + Send>;

type FactorLaw = Box<dyn Fn(f64) -> f64 + Send>;

/// A law at work.
pub(in crate::blind) enum Mechanism {
    /// Changes an input, once per integration step.
    Input(InputLaw),
    /// A force, with states of its own.
    Force {
        states: usize,
        /// Whether it has to know the acceleration.
        accelerated: bool,
        force: ForceLaw,
        rates: StateLaw,
    },
    /// A force, constant during a step.
    HeldForce(HeldLaw),
    /// Dry friction: what stops the site within a step, at most so much against positive and
    /// negative motion.
    Stick(LevelLaw),
    /// A store that cannot rise above a brim; the share reaches the partner.
    Brim { brim: f64, share: f64 },
    /// A wall at both ends that gives back a share of the velocity.
    Wall { low: f64, high: f64, restitution: f64 },
    /// Changes what an output shows, once per integration step.
    Sensor(SensorLaw),
    /// Changes a sample after noise was added: from value, noise and its standard deviation.
    Corrupt(CorruptLaw),
    /// A factor of a parameter over time.
    Factor(FactorLaw),
    /// Changes a signal inside the plant, once per integration step.
    Inside(InnerLaw),
}

impl Law {
    pub(in crate::blind) fn at(&self, setting: &Setting<'_>) -> Mechanism {
        (self.build)(setting)
    }
}

/// A value from before, and the grid on which it was.
#[derive(Default)]
pub(super) struct History {
    pub values: Vec<f64>,
}

impl History {
    /// Adds a value and returns that of `late` steps ago, interpolated; before the beginning it is
    /// the first one.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    pub(super) fn after(&mut self, value: f64, late: f64) -> f64 {
        self.values.push(value);
        let newest = self.values.len() - 1;
        let (whole, part) = (late.max(0.0).floor(), late.max(0.0).fract());
        let at = |back: usize| self.values[newest.saturating_sub(back)];
        let back = whole as usize;
        (1.0 - part) * at(back) + part * at(back + 1)
    }
}
