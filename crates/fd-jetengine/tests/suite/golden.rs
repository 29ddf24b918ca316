//! engine17 against vectors of an independent prototype (numpy, f64).

#![allow(clippy::unwrap_used, reason = "tests stop at the first broken fixture")]

use fd_jetengine::engine17::{Engine17, Environment, Health, NX, Parameters};
use serde_json::Value;

use crate::common::{numbers, reference};

fn array(value: &Value) -> [f64; NX] {
    numbers(value).try_into().unwrap()
}

fn environment(e: &Value) -> Environment {
    let f = |name: &str| e[name].as_f64().unwrap();
    Environment {
        altitude: f("alt"),
        mach: f("mach"),
        isa_deviation: f("dT"),
        nozzle_area: f("A8"),
        guide_vanes: f("igv"),
        handling_bleed: f("hb"),
    }
}

fn health(h: &Value) -> Health {
    let f = |name: &str| h[name].as_f64().unwrap();
    Health {
        lpc_efficiency: f("LPC_eta"),
        lpc_flow: f("LPC_flow"),
        hpc_efficiency: f("HPC_eta"),
        hpc_flow: f("HPC_flow"),
        hpt_efficiency: f("HPT_eta"),
        hpt_flow: f("HPT_flow"),
        lpt_efficiency: f("LPT_eta"),
        lpt_flow: f("LPT_flow"),
        nozzle_area: f("A8"),
        bleed_leak: f("bleed_leak"),
        cooling_flow: f("cool"),
        combustor_efficiency: f("comb_eta"),
        heating_value: f("LHV"),
    }
}

/// Right-hand sides within 1e-9 of the golden values, relative to the larger of the rate and
/// `|x| / s`: at the trim the rates themselves are rounding errors.
#[test]
fn right_hand_side_matches_the_golden_vectors() {
    let golden = reference("engine17_golden.json");
    let engine = Engine17::<f64>::new(&Parameters::default()).unwrap();
    let cases = golden["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 4);
    for (n, case) in cases.iter().enumerate() {
        let engine = engine
            .clone()
            .at(environment(&case["env"]))
            .with_health(health(&case["env"]["health"]));
        let x = array(&case["x"]);
        let dx = engine.rhs(&x, case["Wf"].as_f64().unwrap());
        let mut worst = 0.0_f64;
        for ((got, want), x) in dx.iter().zip(array(&case["dx"])).zip(x) {
            let scale = if n == 0 { x.abs() } else { want.abs() };
            worst = worst.max((got - want).abs() / scale);
        }
        println!("case {n}: worst relative error {worst:.1e}");
        assert!(worst < 1e-9, "case {n}: {worst}");
    }
}

/// Derived constants within 1e-12 relative: both evaluate the same closed form, in about a
/// hundred roundings.
#[test]
fn derived_constants_match_the_prototype() {
    let linear = reference("engine17_linear.json");
    let d = Parameters::default().design().unwrap();
    for (name, got) in [
        ("T1", d.t_1),
        ("P1", d.p_1),
        ("pi_LPC", d.pi_lpc),
        ("T2", d.t_2),
        ("pi_HPC", d.pi_hpc),
        ("W_LPC_corr", d.lpc_corrected_flow),
        ("NLc", d.lpc_corrected_speed),
        ("W_HPC_corr", d.hpc_corrected_flow),
        ("NHc", d.hpc_corrected_speed),
        ("eta_HPT", d.hpt_efficiency),
        ("eta_LPT", d.lpt_efficiency),
        ("kb", d.combustor_loss),
        ("K_HPT", d.hpt_flow),
        ("K_LPT", d.lpt_flow),
        ("nuH", d.hpt_speed),
        ("nuL", d.lpt_speed),
        ("k6", d.k_6),
        ("kB", d.k_b),
        ("k29", d.k_29),
        ("A8", d.nozzle_area),
        ("psi0", d.psi_0),
        ("T4", d.reference.t_4),
        ("T5", d.reference.t_5),
        ("T6", d.reference.t_6),
        ("T7", d.reference.t_7),
    ] {
        let want = linear["derived"][name].as_f64().unwrap();
        assert!((got / want - 1.0).abs() < 1e-12, "{name}: {got} instead of {want}");
    }
}

/// Single precision follows double precision within what cancelling fluxes leave of 1e-7.
#[test]
fn single_precision_runs() {
    let parameters = Parameters::default();
    let x = parameters.design().unwrap().reference.to_array().map(|v| 1.01 * v);
    let wide = Engine17::<f64>::new(&parameters).unwrap().rhs(&x, 0.7);
    #[allow(clippy::cast_possible_truncation, reason = "rounding to f32 is the point")]
    let narrow = Engine17::<f32>::new(&parameters).unwrap().rhs(&x.map(|v| v as f32), 0.7);
    for ((a, b), x) in wide.iter().zip(narrow).zip(x) {
        // Fluxes of up to 1e3 per second times x meet eps(f32) = 1.2e-7 a few dozen times.
        assert!((a - f64::from(b)).abs() < 1e-2 * x.abs(), "{a} {b}");
    }
}
