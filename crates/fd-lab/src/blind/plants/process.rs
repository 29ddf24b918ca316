//! Tanks, a mixer, and a linear engine.

use super::{
    equations::Laws,
    plant::{Plant, parse},
};
use crate::blind::excitation::Drive;

const CASCADE: &str = include_str!("../../../../../examples/models/tanks.toml");
const MIXER: &str = include_str!("../../../../../examples/models/two_input.toml");
const SPOOLS: &str = include_str!("../../../../../examples/models/two_spool_engine.toml");

pub(super) const TANKS: Plant = Plant {
    name: "tanks",
    model: || parse(CASCADE, "tanks.toml"),
    physics: |p| Ok(Laws::open(cascade, states, levels).at(p)),
    drives: &[Drive { centre: 4.5, amplitude: 2.0, band: [0.001, 0.02] }],
    noise_in_loop: false,
    step: 0.1,
    reverses: false,
    weight: 10,
};

pub(super) const TWO_INPUT: Plant = Plant {
    name: "two-input",
    model: || parse(MIXER, "two_input.toml"),
    physics: |p| Ok(Laws::open(mixer, level_and_temperature, level_and_heat).at(p)),
    drives: &[
        Drive { centre: 1e-4, amplitude: 5e-5, band: [0.0007, 0.01] },
        Drive { centre: 1e-4, amplitude: 5e-5, band: [0.0007, 0.01] },
    ],
    noise_in_loop: false,
    step: 0.2,
    reverses: false,
    weight: 10,
};

pub(super) const TWO_SPOOL_ENGINE: Plant = Plant {
    name: "two-spool-engine",
    model: || parse(SPOOLS, "two_spool_engine.toml"),
    physics: |p| Ok(Laws::open(spools, states, spool_speeds).at(p)),
    drives: &[
        Drive { centre: 0.0, amplitude: 0.05, band: [0.05, 2.0] },
        Drive { centre: 0.0, amplitude: 0.03, band: [0.05, 2.0] },
    ],
    noise_in_loop: false,
    step: 0.0025,
    reverses: false,
    weight: 10,
};

/// Flow of the pump over its voltage, as the maker measured it.
const PUMP: [(f64, f64); 5] = [(0.0, 0.0), (1.0, 0.0), (4.0, 8e-5), (7.0, 1.45e-4), (10.0, 1.9e-4)];

fn pump(voltage: f64) -> f64 {
    let voltage = voltage.clamp(0.0, 10.0);
    let piece = PUMP.windows(2).find(|piece| voltage <= piece[1].0).unwrap_or(&PUMP[3..]);
    let [(a, low), (b, high)] = [piece[0], piece[1]];
    low + (high - low) * (voltage - a) / (b - a)
}

/// Parameters `S_1`, `S_2`, `a_1`, `a_2`, g.
fn cascade(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[s_1, s_2, a_1, a_2, g] = p else { return };
    let out = |a: f64, h: f64| a * (2.0 * g * h.max(0.0)).sqrt();
    let (q_1, q_2) = (out(a_1, x[0]), out(a_2, x[1]));
    dx[0] = (pump(u[0]) + f[0] - q_1) / s_1;
    dx[1] = (q_1 + f[1] - q_2) / s_2;
}

/// The flow from the first tank into the second.
pub(super) fn between_tanks(p: &[f64], x: &[f64]) -> f64 {
    let &[_, _, a_1, _, g] = p else { return 0.0 };
    a_1 * (2.0 * g * x[0].max(0.0)).sqrt()
}

/// Parameters S, a, `T_hot`, `T_cold`, `T_room`, U, `rho_c`, `tau_s`, g.
fn mixer(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[s, a, hot, cold, room, loss, rho_c, tau, g] = p else { return };
    let outflow = a * (2.0 * g * x[0].max(0.001)).sqrt();
    let volume = s * x[0].max(0.01);
    dx[0] = (u[0] + u[1] + f[0] - outflow) / s;
    let mixed = u[0] * (hot - x[1]) + u[1] * (cold - x[1]);
    dx[1] = (mixed + (f[1] - loss * (x[1] - room)) / rho_c) / volume;
    dx[2] = (x[1] - x[2]) / tau;
}

/// Parameters `T_l`, `T_h`, `T_t`, `a_lh`, `a_hl`, `k_l`, `k_h`, `k_t`, `c_l`, `c_h`, `b_l`, `b_h`,
/// `b_t`.
fn spools(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[t_l, t_h, t_t, a_lh, a_hl, k_l, k_h, k_t, c_l, c_h, b_l, b_h, b_t] = p else { return };
    let gas = c_l * x[0] + c_h * x[1] + k_t * u[0] + b_t * u[1];
    dx[0] = (a_lh * x[1] + k_l * u[0] + b_l * u[1] + f[0] - x[0]) / t_l;
    dx[1] = (a_hl * x[0] + k_h * u[0] + b_h * u[1] + f[1] - x[1]) / t_h;
    dx[2] = (gas + f[2] - x[2]) / t_t;
}

fn states(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y.copy_from_slice(x);
}

fn level_and_temperature(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y.copy_from_slice(&[x[0], x[2]]);
}

fn levels(x: &[f64], site: usize) -> [Option<f64>; 2] {
    [Some(x[site]), None]
}

/// Level for the leak, temperature of the tank for the heat.
fn level_and_heat(x: &[f64], site: usize) -> [Option<f64>; 2] {
    [Some(x[site]), None]
}

fn spool_speeds(x: &[f64], site: usize) -> [Option<f64>; 2] {
    if site < 2 { [None, Some(x[site])] } else { [Some(x[2]), None] }
}
