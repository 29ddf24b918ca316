//! Carriage, pendulum, crane and balanced pole.

use super::{
    equations::Laws,
    plant::{Plant, parse},
};
use crate::blind::excitation::Drive;

const CRANE: &str = include_str!("../../../../../examples/models/cart_pole.toml");
const CARRIAGE: &str = include_str!("../../../../../examples/models/mass_spring_damper.toml");
const SWING: &str = include_str!("../../../../../examples/models/pendulum.toml");
const BALANCED: &str = include_str!("cart_pole_balanced.toml");

pub(super) const MASS_SPRING_DAMPER: Plant = Plant {
    name: "mass-spring-damper",
    model: || parse(CARRIAGE, "mass_spring_damper.toml"),
    physics: |p| Ok(Laws::open(carriage, first_state, first_joint).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 12.0, band: [0.1, 3.0] }],
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 10,
};

pub(super) const PENDULUM: Plant = Plant {
    name: "pendulum",
    model: || parse(SWING, "pendulum.toml"),
    physics: |p| Ok(Laws::open(swing, first_state, first_joint).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 0.8, band: [0.1, 2.0] }],
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 10,
};

pub(super) const CART_POLE: Plant = Plant {
    name: "cart-pole",
    model: || parse(CRANE, "cart_pole.toml"),
    physics: |p| Ok(Laws::open(crane, two_places, two_joints).at(p)),
    drives: &[Drive { centre: 0.0, amplitude: 4.0, band: [0.1, 2.0] }],
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 8,
};

pub(super) const CART_POLE_BALANCED: Plant = Plant {
    name: "cart-pole-balanced",
    model: || parse(BALANCED, "cart_pole_balanced.toml"),
    physics: |p| {
        let open = Laws::open(balanced, places_and_force, two_joints);
        Ok(Laws { control: balance, memory: 4, ..open }.at(p))
    },
    drives: &[Drive { centre: 0.0, amplitude: 0.15, band: [0.05, 1.0] }],
    // The loop has sensors of its own; what is logged comes from others.
    noise_in_loop: false,
    step: 0.001,
    reverses: true,
    weight: 7,
};

/// Parameters m, k, d.
fn carriage(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[m, k, d] = p else { return };
    dx[0] = x[1];
    dx[1] = (u[0] + f[0] - d * x[1] - k * x[0]) / m;
}

/// Parameters m, l, d, g.
fn swing(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[m, l, d, g] = p else { return };
    dx[0] = x[1];
    dx[1] = (u[0] + f[0] - d * x[1] - m * g * l * x[0].sin()) / (m * l * l);
}

/// Solves the equations of motion of cart and pole for the accelerations:
/// `(M + m) v' + m l cos φ ω' = force + m l ω² sin φ`, `m l cos φ v' + m l² ω' = torque`.
fn cart_and_pole(
    [cart, bob, l]: [f64; 3],
    [angle, omega]: [f64; 2],
    [force, torque]: [f64; 2],
) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    let (a, b, d) = (cart + bob, bob * l * cos, bob * l * l);
    let pushed = force + bob * l * omega * omega * sin;
    let determinant = a * d - b * b;
    [(d * pushed - b * torque) / determinant, (a * torque - b * pushed) / determinant]
}

/// Parameters M, m, l, `k_c`, `d_c`, `d_p`, g; the pole hangs at 0.
fn crane(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[cart, bob, l, k_c, d_c, d_p, g] = p else { return };
    let force = u[0] + f[0] - k_c * x[0] - d_c * x[1];
    let torque = f[1] - bob * g * l * x[2].sin() - d_p * x[3];
    let [v, w] = cart_and_pole([cart, bob, l], [x[2], x[3]], [force, torque]);
    dx.copy_from_slice(&[x[1], v, x[3], w]);
}

/// Parameters M, m, l, `d_c`, `d_p`, g, and five of the controller; the pole stands at 0.
fn balanced(p: &[f64], x: &[f64], u: &[f64], f: &[f64], dx: &mut [f64]) {
    let &[cart, bob, l, d_c, d_p, g, ..] = p else { return };
    let force = u[0] + f[0] - d_c * x[1];
    let torque = f[1] + bob * g * l * x[2].sin() - d_p * x[3];
    let [v, w] = cart_and_pole([cart, bob, l], [x[2], x[3]], [force, torque]);
    dx.copy_from_slice(&[x[1], v, x[3], w]);
}

/// State feedback with filtered differences for velocities. Memory: position, its rate, angle, its
/// rate.
fn balance(p: &[f64], memory: &mut [f64], y: &[f64], reference: &[f64], u: &mut [f64]) {
    let &[.., k_x, k_v, k_phi, k_w, period] = p else { return };
    let v = 0.5 * memory[1] + 0.5 * (y[0] - memory[0]) / period;
    let w = 0.5 * memory[3] + 0.5 * (y[1] - memory[2]) / period;
    u[0] = k_x * (y[0] - reference[0]) + k_v * v + k_phi * y[1] + k_w * w;
    memory.copy_from_slice(&[y[0], v, y[1], w]);
}

fn first_state(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y[0] = x[0];
}

fn two_places(_: &[f64], x: &[f64], _: &[f64], y: &mut [f64]) {
    y.copy_from_slice(&[x[0], x[2]]);
}

fn places_and_force(_: &[f64], x: &[f64], u: &[f64], y: &mut [f64]) {
    y.copy_from_slice(&[x[0], x[2], u[0]]);
}

fn first_joint(x: &[f64], _: usize) -> [Option<f64>; 2] {
    [Some(x[0]), Some(x[1])]
}

fn two_joints(x: &[f64], site: usize) -> [Option<f64>; 2] {
    [Some(x[2 * site]), Some(x[2 * site + 1])]
}
