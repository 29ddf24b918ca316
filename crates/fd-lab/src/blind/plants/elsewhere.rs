//! Plants of logs as people have them only: an integrator, two that are unstable, a curve between
//! two filters.

use super::{
    equations::Laws,
    plant::{Plant, parse},
};
use crate::blind::excitation::Drive;

const SERVO_FILE: &str = include_str!("servo.toml");
const PENDULUM: &str = include_str!("standing_pendulum.toml");
const MAGNET: &str = include_str!("levitation.toml");
const FILTERS: &str = include_str!("two_filters.toml");

pub(super) const SERVO: Plant = Plant {
    name: "servo",
    model: || parse(SERVO_FILE, "servo.toml"),
    physics: |p| Ok(Laws::open(servo, both, joint).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 4.0, band: [0.1, 2.0] }],
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 15,
};

pub(super) const STANDING_PENDULUM: Plant = Plant {
    name: "standing-pendulum",
    model: || parse(PENDULUM, "standing_pendulum.toml"),
    physics: |p| Ok(Laws::open(standing, first, joint).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 1.0, band: [0.1, 1.5] }],
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 10,
};

pub(super) const LEVITATION: Plant = Plant {
    name: "levitation",
    model: || parse(MAGNET, "levitation.toml"),
    physics: |p| Ok(Laws::open(levitation, first, joint).at(p)),
    drives: &[Drive { centre: 1.0, amplitude: 0.1, band: [0.5, 8.0] }],
    noise_in_loop: false,
    step: 0.000_2,
    reverses: true,
    weight: 10,
};

pub(super) const TWO_FILTERS: Plant = Plant {
    name: "two-filters",
    model: || parse(FILTERS, "two_filters.toml"),
    physics: |p| Ok(Laws::open(filters, last, second_velocity).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 4.0, band: [0.1, 3.0] }],
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 10,
};

/// Parameters `k_t`, J, d.
fn servo(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[k_t, j, d] = p else { return };
    dx[0] = x[1];
    dx[1] = (k_t * u[0] + f[0] - d * x[1]) / j;
}

/// Parameters m, l, d, g; the pendulum stands at 0.
fn standing(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[m, l, d, g] = p else { return };
    dx[0] = x[1];
    dx[1] = (u[0] + f[0] - d * x[1] + m * g * l * x[0].sin()) / (m * l * l);
}

/// Parameters m, c, g; the magnet pulls upwards, the gap grows downwards.
fn levitation(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[m, c, g] = p else { return };
    let pull = c * (u[0] / x[0].max(0.001)).powi(2);
    dx[0] = x[1];
    dx[1] = g + (f[0] - pull) / m;
}

/// Parameters `T_1`, `T_2`, k, b.
fn filters(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[t_1, t_2, ..] = p else { return };
    dx[0] = (u[0] - x[0]) / t_1 + f[0];
    dx[1] = (between(p, x) - x[1]) / t_2 + f[1];
}

/// What the curve between the filters gives.
pub(super) fn between(p: &[f64], x: &[f64]) -> f64 {
    let &[_, _, k, b] = p else { return 0.0 };
    k * x[0] / (1.0 + b * x[0] * x[0])
}

fn both(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y.copy_from_slice(x);
}

fn first(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y[0] = x[0];
}

fn last(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y[0] = x[1];
}

fn joint(x: &[f64], _: usize) -> [Option<f64>; 2] {
    [Some(x[0]), Some(x[1])]
}

fn second_velocity(x: &[f64], site: usize) -> [Option<f64>; 2] {
    [None, Some(x[site])]
}
