//! Trims and linear models of engine17 against those of the prototype.

#![allow(clippy::unwrap_used, reason = "tests stop at the first broken fixture")]

use faer::c64;
use fd_jetengine::{
    EngineModel,
    engine17::{Engine17, ExtendedEngine, Parameters, Unmodelled},
};
use serde_json::Value;

use crate::common::{numbers, reference, rows};

const POINTS: [&str; 4] = ["idle", "mid", "ref", "high"];

fn sorted(mut poles: Vec<c64>) -> Vec<c64> {
    poles.sort_by(|a, b| b.re.total_cmp(&a.re).then(a.im.total_cmp(&b.im)));
    poles
}

fn relative(got: f64, want: f64) -> f64 {
    (got / want - 1.0).abs()
}

fn at_each_point(check: impl Fn(&str, &Value, &Engine17)) {
    let linear = reference("engine17_linear.json");
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    for name in POINTS {
        check(name, &linear["points"][name], &engine);
    }
}

/// Both stop when relative rates are rounding errors of about 1e-13 per second; the slowest pole
/// (0.7 1/s) turns that into 2e-13 of the states.
#[test]
fn trims_match() {
    at_each_point(|name, point, engine| {
        let trim = engine.trim(point["Wf"].as_f64().unwrap()).unwrap();
        assert!(trim.iterations <= 16, "{name}: {} iterations", trim.iterations);
        assert!(trim.residual < 1e-12, "{name}: {}", trim.residual);
        for (got, want) in trim.x.iter().zip(numbers(&point["x"])) {
            assert!(relative(*got, want) < 1e-11, "{name}: {got} {want}");
        }
        let a = trim.auxiliary;
        for (key, got) in [
            ("piL", a.pi_lpc),
            ("piH", a.pi_hpc),
            ("etL", a.lpc_efficiency),
            ("etH", a.hpc_efficiency),
            ("T2", a.t_2),
            ("T3", a.t_3),
            ("W3", a.w_3),
            ("W4", a.w_4),
            ("W5", a.w_5),
            ("W8", a.w_8),
            ("Fn", a.thrust),
            ("OPR", a.overall_pressure_ratio),
            ("BPR", a.bypass_ratio),
            ("y", a.hpc_loading),
            ("phiL", a.lpc_relative_flow),
            ("NPR", a.nozzle_pressure_ratio),
            ("f4", a.fuel_air_ratio),
            ("SMH", a.hpc_surge_margin),
            ("Pt7", a.pt_7),
        ] {
            let want = point["aux"][key].as_f64().unwrap();
            assert!(relative(got, want) < 1e-10, "{name}, {key}: {got} {want}");
        }
    });
}

/// Central differences with a relative step of 2e-6 amplify rounding of the fluxes (rates of up
/// to 1e3 per second, a few eps each) to 1e3 · 1e-15 / 4e-6 = 2.5e-7 per second and entry.
#[test]
fn per_unit_matrices_match() {
    at_each_point(|name, point, engine| {
        let trim = engine.trim(point["Wf"].as_f64().unwrap()).unwrap();
        let linear = engine.linearise(&trim).unwrap().per_unit().unwrap().model;
        let mut worst = 0.0_f64;
        for (i, row) in rows(&point["A_pu"]).iter().enumerate() {
            for (j, want) in row.iter().enumerate() {
                worst = worst.max((linear.a()[(i, j)] - want).abs());
            }
        }
        for (i, row) in rows(&point["B_pu"]).iter().enumerate() {
            worst = worst.max((linear.b()[(i, 0)] - row[0]).abs());
        }
        for (i, row) in rows(&point["C_pu"]).iter().enumerate() {
            for (j, want) in row.iter().enumerate() {
                worst = worst.max((linear.c()[(i, j)] - want).abs());
            }
        }
        println!("{name}: worst absolute error of A, B, C per unit {worst:.1e} 1/s");
        assert!(worst < 2.5e-6, "{name}: {worst}");
    });
}

/// Physical and per-unit models are similar, so their poles agree with the prototype's both ways.
/// A perturbation of 1e-6 of `A` moves a pole by at most its condition number (below 30) times.
#[test]
fn poles_match() {
    at_each_point(|name, point, engine| {
        let trim = engine.trim(point["Wf"].as_f64().unwrap()).unwrap();
        let physical = engine.linearise(&trim).unwrap();
        let want = sorted(
            numbers(&point["eig_re"])
                .into_iter()
                .zip(numbers(&point["eig_im"]))
                .map(|(re, im)| c64::new(re, im))
                .collect(),
        );
        for model in [physical.per_unit().unwrap(), physical] {
            let got = sorted(model.model.poles().unwrap());
            for (got, want) in got.iter().zip(&want) {
                assert!((got - want).norm() < 3e-5, "{name}: {got} {want}");
            }
        }
    });
}

/// The slow poles that hot metal adds, and the order of the model.
#[test]
fn unmodelled_dynamics_add_slow_stable_poles() {
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    let trim = engine.trim(0.712).unwrap();
    let extended = ExtendedEngine::new(engine, Unmodelled::default()).unwrap();
    let EngineModel { model, states, .. } = extended.linearise(&trim).unwrap();
    assert_eq!((model.nx(), states.len()), (23, 23));
    assert!(model.is_stable().unwrap());
    let poles = sorted(model.poles().unwrap());
    println!("slowest poles of the extended engine: {} {} {}", poles[0], poles[1], poles[2]);
    assert!((poles[0].re + 0.12).abs() < 0.01 && (poles[1].re + 0.25).abs() < 0.01);
}

/// Steady gains in percent per percent of fuel, `N_L, N_H, T_7, P_6, T_29`, in printed digits.
#[test]
fn steady_gains_match_the_printed_table() {
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    for (fuel, want) in [
        (0.12, [0.43, 0.23, 0.09, 0.19, 0.08]),
        (0.40, [0.31, 0.20, 0.28, 0.49, 0.13]),
        (0.712, [0.31, 0.22, 0.33, 0.59, 0.16]),
        (0.95, [0.32, 0.24, 0.34, 0.61, 0.17]),
    ] {
        let linear = engine.linearise(&engine.trim(fuel).unwrap()).unwrap().per_unit().unwrap();
        let gain = linear.model.dc_gain().unwrap();
        for (i, want) in want.into_iter().enumerate() {
            let got = gain[(i, 0)];
            assert!((got - want).abs() <= 0.0051, "{fuel} kg/s, output {i}: {got} {want}");
        }
    }
}

/// Hankel singular values of the per-unit models against scipy's. Gramians of a model with poles
/// from -0.7 to -540 lose about four digits in each of the two programs.
#[test]
fn hankel_values_match() {
    at_each_point(|name, point, engine| {
        let trim = engine.trim(point["Wf"].as_f64().unwrap()).unwrap();
        let linear = engine.linearise(&trim).unwrap().per_unit().unwrap();
        let got = linear.model.hankel_singular_values().unwrap();
        for (got, want) in got.iter().zip(numbers(&point["hsv_pu"])) {
            assert!((got - want).abs() < 1e-7, "{name}: {got} {want}");
        }
    });
}
