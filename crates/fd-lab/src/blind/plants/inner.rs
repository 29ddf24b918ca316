//! Signals inside plants: what flows between two vessels, the torque in a shaft, what is between
//! two filters. The model file has each as a definition; no sensor shows it.

use super::{elsewhere, plant::Plant, process};

/// A signal inside a plant, which enters the rates linearly.
#[derive(Clone, Copy)]
pub(in crate::blind) struct Inner {
    /// Name of its definition in the model file.
    pub name: &'static str,
    /// Its value, from parameters and states.
    pub value: fn(p: &[f64], x: &[f64]) -> f64,
    /// What a change of it adds to the rates.
    pub add: fn(p: &[f64], change: f64, dx: &mut [f64]),
}

const OF_TANKS: [Inner; 1] = [Inner {
    name: "q_1",
    value: process::between_tanks,
    add: |p, change, dx| {
        dx[0] -= change / p[0];
        dx[1] += change / p[1];
    },
}];

const OF_DRIVE: [Inner; 1] = [Inner {
    name: "tau_s",
    value: |p, x| p[2] * x[1] + p[3] * (x[0] - x[2]),
    add: |p, change, dx| {
        dx[0] -= change / p[0];
        dx[2] += change / p[1];
    },
}];

const OF_FILTERS: [Inner; 1] =
    [Inner { name: "w", value: elsewhere::between, add: |p, change, dx| dx[1] += change / p[1] }];

/// The signals inside a plant.
pub(in crate::blind) fn inner(plant: &Plant) -> &'static [Inner] {
    match plant.name {
        "tanks" => &OF_TANKS,
        "two-mass-drive" => &OF_DRIVE,
        "two-filters" => &OF_FILTERS,
        _ => &[],
    }
}
