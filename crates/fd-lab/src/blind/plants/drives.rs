//! Electric drives.

use super::{
    equations::Laws,
    plant::{Plant, parse},
};
use crate::blind::excitation::Drive;

const MOTOR: &str = include_str!("../../../../../examples/models/dc_drive.toml");
const LOOP: &str = include_str!("../../../../../examples/models/dc_drive_closed_loop.toml");
const ELASTIC: &str = include_str!("../../../../../examples/models/two_mass_drive.toml");

pub(super) const DC_DRIVE: Plant = Plant {
    name: "dc-drive",
    model: || parse(MOTOR, "dc_drive.toml"),
    physics: |p| Ok(Laws::open(motor, current_and_speed, winding_and_shaft).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 12.0, band: [0.5, 20.0] }],
    noise_in_loop: false,
    step: 0.000_125,
    reverses: true,
    weight: 10,
};

pub(super) const DC_DRIVE_CLOSED_LOOP: Plant = Plant {
    name: "dc-drive-closed-loop",
    model: || parse(LOOP, "dc_drive_closed_loop.toml"),
    physics: |p| {
        let open = Laws::open(motor, speed_current_voltage, winding_and_shaft);
        Ok(Laws { control: speed_control, memory: 1, ..open }.at(p))
    },
    drives: &[Drive { centre: 0.0, amplitude: 120.0, band: [0.5, 8.0] }],
    noise_in_loop: true,
    step: 0.000_125,
    reverses: true,
    weight: 10,
};

pub(super) const TWO_MASS_DRIVE: Plant = Plant {
    name: "two-mass-drive",
    model: || parse(ELASTIC, "two_mass_drive.toml"),
    physics: |p| Ok(Laws::open(elastic, both_speeds, three_sites).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 3.0, band: [0.5, 25.0] }],
    noise_in_loop: false,
    step: 0.000_25,
    reverses: true,
    weight: 10,
};

/// Parameters R, L, `k_m`, J, d first; those of a controller may follow.
fn motor(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[r, l, k_m, j, d, ..] = p else { return };
    dx[0] = (u[0] + f[0] - r * x[0] - k_m * x[1]) / l;
    dx[1] = (k_m * x[0] + f[1] - d * x[1]) / j;
}

/// Parameters `k_p`, `k_i`, `u_max`, `T_c` after those of the motor.
fn speed_control(p: &[f64], memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]) {
    let &[.., k_p, k_i, u_max, period] = p else { return };
    let error = reference[0] - y[0];
    u[0] = k_p * error + memory[0];
    memory[0] = (memory[0] + period * k_i * error).clamp(-u_max, u_max);
}

/// Parameters `J_m`, `J_l`, k, `d_s`, `d_m`, `d_l`.
fn elastic(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[j_m, j_l, k, d_s, d_m, d_l] = p else { return };
    // A force at the shaft acts like the torque of the shaft itself, with the other sign.
    let shaft = k * x[1] + d_s * (x[0] - x[2]) + f[2];
    dx[0] = (u[0] + f[0] - d_m * x[0] - shaft) / j_m;
    dx[1] = x[0] - x[2];
    dx[2] = (shaft + f[1] - d_l * x[2]) / j_l;
}

fn current_and_speed(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y.copy_from_slice(x);
}

fn speed_current_voltage(_: &[f64], x: &[f64], u: &[f64], y: &mut [f64]) {
    y.copy_from_slice(&[x[1], x[0], u[0]]);
}

fn both_speeds(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y.copy_from_slice(&[x[0], x[2]]);
}

/// The current is to the winding what a velocity is to a joint.
fn winding_and_shaft(x: &[f64], site: usize) -> [Option<f64>; 2] {
    [None, Some(x[site])]
}

fn three_sites(x: &[f64], site: usize) -> [Option<f64>; 2] {
    match site {
        0 => [None, Some(x[0])],
        1 => [None, Some(x[2])],
        _ => [Some(x[1]), Some(x[0] - x[2])],
    }
}
