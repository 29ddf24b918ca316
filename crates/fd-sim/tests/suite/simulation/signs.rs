//! Dry friction as a set-valued sign: what holds, what slides, what it costs in energy.

use fd_sim::{
    model::Model,
    simulate::{EquationSimulator, Run, Simulator},
};

/// A block on a table, pushed by `u`, at a spring `k`; `f` rubs in motion and `f + g` at rest.
const BLOCK: &str = r#"
version = 1
kind = "equations"
name = "block"
sample_time = 0.01
step = 0.01
inputs = { u = { unit = "N" } }
definitions = { friction = "(f + g*exp(-(v/0.05)^2))*slip" }
signs = { slip = "v" }
[parameters]
m = { unit = "kg", value = 1.2 }
f = { unit = "N", value = 0.35 }
g = { unit = "N", value = 0.0 }
k = { unit = "N/m", value = 0.0 }
[states]
x = { unit = "m", initial = 0.0, derivative = "v" }
v = { unit = "m/s", initial = 0.0, derivative = "(u - k*x - friction)/m" }
[outputs]
place = { unit = "m", value = "x" }
speed = { unit = "m/s", value = "v" }
force = { unit = "N", value = "friction" }
"#;

const M: f64 = 1.2;
const F: f64 = 0.35;

fn block() -> EquationSimulator {
    let model: Model = BLOCK.parse().unwrap();
    assert_eq!(model.to_string().parse::<Model>().unwrap(), model);
    EquationSimulator::new(&model).unwrap()
}

/// Rows of place, speed and force.
fn run(
    simulator: &mut EquationSimulator,
    theta: [f64; 4],
    x0: [f64; 2],
    u: &[f64],
) -> Vec<[f64; 3]> {
    let mut y = vec![0.0; 3 * u.len()];
    Simulator::simulate(simulator, &theta, &x0, u, &mut y);
    y.chunks(3).map(|row| [row[0], row[1], row[2]]).collect()
}

#[test]
fn nothing_creeps_under_a_load_that_friction_holds() {
    for (g, load) in [(0.0, 0.99 * F), (0.0, -0.99 * F), (0.1, 0.99 * (F + 0.1))] {
        // Pushed to the usual speed, then left to stop, under a load for a minute.
        let u: Vec<f64> = (0..6400)
            .map(|i| {
                if i < 100 {
                    1.0
                } else if i < 400 {
                    0.0
                } else {
                    load
                }
            })
            .collect();
        let rows = run(&mut block(), [M, F, g, 0.0], [0.0, 0.0], &u);
        let (usual, there) = (rows[100][1], rows[400][0]);
        assert!(usual > 0.3 && rows[400][1].abs() < 1e-12 * usual, "{usual} {:?}", rows[400]);
        for row in &rows[400..] {
            assert!(row[1].abs() < 1e-12 * usual, "{row:?}");
            assert!((row[0] - there).abs() < 1e-11, "{row:?}, {there}");
            assert!((row[2] - load).abs() < 1e-9, "what is shown holds the load: {row:?}");
        }
    }
}

#[test]
fn stops_and_reversals_are_exact_for_constant_forces() {
    // Thrown against a load below and one above the friction: at rest from v₀/a on, or back with another acceleration.
    for load in [-0.2, -0.9] {
        let v0 = 0.713;
        let u = vec![load; 800];
        let rows = run(&mut block(), [M, F, 0.0, 0.0], [0.0, v0], &u);
        let slower = (F - load) / M;
        let stop = v0 / slower;
        let back = ((load + F) / M).min(0.0);
        for (i, [x, v, _]) in rows.iter().enumerate() {
            let t = 0.01 * i as f64;
            let after = (t - stop).max(0.0);
            let before = t.min(stop);
            let speed = v0 - slower * before + back * after;
            let place = v0 * before - 0.5 * slower * before * before + 0.5 * back * after * after;
            assert!((v - speed).abs() < 1e-12, "{load} {t}: {v} {speed}");
            assert!((x - place).abs() < PLACE, "{load} {t}: {x} {place}");
        }
    }
}

/// Two hundred steps of some ulps of a metre.
const PLACE: f64 = 1e-12;

#[test]
fn energy_is_only_lost() {
    let energy =
        |[x, v, _]: [f64; 3], k: f64, load: f64| 0.5 * M * v * v + 0.5 * k * x * x - load * x;
    for (k, load, g) in [(30.0, 0.0, 0.0), (30.0, 0.2, 0.0), (5.0, -0.3, 0.1), (0.0, 0.2, 0.0)] {
        let rows = run(&mut block(), [M, F, g, k], [0.05, 0.4], &[load; 1000]);
        let all: Vec<f64> = rows.iter().map(|row| energy(*row, k, load)).collect();
        for (i, pair) in all.windows(2).enumerate() {
            assert!(pair[1] <= pair[0] + 1e-6 * all[0].abs(), "{k} {load} {i}: {pair:?}");
        }
        assert!(all[999] < all[0]);
    }
}

#[test]
fn converges_with_the_square_of_the_step() {
    let u: Vec<f64> = (0..600).map(|i| 0.8 * (0.021 * f64::from(i)).sin()).collect();
    let theta = [M, F, 0.1, 3.0];
    let simulator = block();
    let fine = run(&mut simulator.refined(200), theta, [0.0, 0.3], &u);
    let error = |factor: usize| {
        let rows = run(&mut simulator.refined(factor), theta, [0.0, 0.3], &u);
        let squares = rows.iter().zip(&fine).map(|(a, b)| (a[0] - b[0]).powi(2));
        (squares.sum::<f64>() / 600.0).sqrt()
    };
    let errors = [1, 2, 4, 8].map(error);
    println!("errors of the place: {errors:?}");
    assert!(errors[3] < errors[0] / 20.0, "{errors:?}");
}

#[test]
fn places_are_coupled_through_the_masses() {
    // A block on a sledge on the ground: what rubs between the two is not more than what the upper one needs.
    let model: Model = r#"
version = 1
kind = "equations"
name = "sledge"
sample_time = 0.01
step = 0.01
inputs = { u = { unit = "N" } }
signs = { between = "v - w", below = "w" }
[states]
x = { unit = "m", initial = 0.0, derivative = "v" }
v = { unit = "m/s", initial = 0.0, derivative = "-0.6*between/0.5" }
w = { unit = "m/s", initial = 0.0, derivative = "(u + 0.6*between - 0.9*below)/2" }
[outputs]
upper = { unit = "m/s", value = "v" }
lower = { unit = "m/s", value = "w" }
upper_force = { unit = "N", value = "0.6*between" }
lower_force = { unit = "N", value = "0.9*below" }
"#
    .parse()
    .unwrap();
    let mut simulator = EquationSimulator::<f64>::new(&model).unwrap();
    // Held, carried along (1.1 m/s² needs 0.56 N), torn off (4.55 m/s²), carried again to the end.
    let push = |i: usize| [0.8, 3.7, 10.6, 0.0][(i / 100).min(3)];
    let u: Vec<f64> = (0..2000).map(push).collect();
    let mut y = vec![0.0; 4 * 2000];
    Simulator::simulate(&mut simulator, &[], &[0.0; 3], &u, &mut y);
    let [mut v, mut w] = [0.0_f64; 2];
    for (i, row) in y.chunks(4).enumerate() {
        if i <= 300 {
            assert!(
                (row[0] - v).abs() < 1e-12 && (row[1] - w).abs() < 1e-12,
                "{i}: {row:?} {v} {w}"
            );
        }
        let [a, b] = [[0.0, 0.0], [1.12, 1.12], [1.2, 4.55], [0.0, 0.0]][(i / 100).min(3)];
        (v, w) = (v + 0.01 * a, w + 0.01 * b);
    }
    assert!(
        (y[4 * 50 + 3] - 0.8).abs() < 1e-11 && y[4 * 50 + 2].abs() < 1e-11,
        "{:?}",
        &y[200..204]
    );
    assert!((y[4 * 150 + 2] + 0.56).abs() < 1e-11, "{:?}", &y[600..604]);
    let end = &y[4 * 1999..];
    assert!(end[0].abs() < 1e-12 && end[1].abs() < 1e-12, "both rest: {end:?}");
}

#[test]
fn lanes_are_single_runs_to_the_bit() {
    let u: Vec<f64> = (0..700).map(|i| (0.05 * f64::from(i)).sin() + 0.2).collect();
    let thetas: Vec<[f64; 4]> =
        (0..11).map(|i| [M, 0.08 * f64::from(i), 0.02 * f64::from(i % 3), 2.0]).collect();
    let mut simulator = block();
    let mut all = vec![vec![0.0; 3 * 700]; 11];
    let mut runs: Vec<Run<'_>> =
        thetas.iter().zip(&mut all).map(|(theta, y)| Run::new(theta, &[0.0, 0.1], y)).collect();
    simulator.simulate_many(0, &u, &mut runs);
    for (theta, many) in thetas.iter().zip(&all) {
        let one: Vec<f64> = run(&mut simulator, *theta, [0.0, 0.1], &u).into_flattened();
        assert!(one.iter().zip(many).all(|(a, b)| a.to_bits() == b.to_bits()), "{theta:?}");
    }
}

#[test]
fn there_are_slopes_on_both_sides_of_a_switch() {
    // How far it slides, v₀² m/(2 f), has a slope along f; also where the stop moves from one step into the next.
    let mut simulator = block();
    let mut place = |f: f64| run(&mut simulator, [M, f, 0.0, 0.0], [0.0, 0.5], &[0.0; 300])[299][0];
    for i in 0..400 {
        let f = 0.3 + 0.0003 * f64::from(i);
        let slope = (place(f + 1e-6) - place(f - 1e-6)) / 2e-6;
        let exact = -0.5 * 0.25 * M / (f * f);
        assert!((slope - exact).abs() < 1e-5 * exact.abs(), "{f}: {slope} {exact}");
    }
}
