//! Published engines: eigenvalues and Hankel values against the reference files.

use faer::Mat;
use fd_model::{Continuous, StateSpace};
use serde_json::Value;

// The numbers lie beside the engines that they describe.
const ENGINE17: &str = include_str!("../../../fd-jetengine/tests/data/engine17_linear.json");
const F100: &str = include_str!("../../../fd-jetengine/tests/data/f100.json");

fn parsed(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn matrix(value: &Value) -> Mat<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    Mat::from_fn(rows.len(), rows[0].len(), |i, j| rows[i][j])
}

/// The engine of the reference design in per-unit variables, with its Hankel values.
pub(crate) fn engine17(point: &str) -> (StateSpace<Continuous>, Vec<f64>) {
    let file = parsed(ENGINE17);
    let point = &file["points"][point];
    let (a, b, c) = (matrix(&point["A_pu"]), matrix(&point["B_pu"]), matrix(&point["C_pu"]));
    let d = Mat::zeros(c.nrows(), b.ncols());
    let model = StateSpace::new(a, b, c, d, Continuous).unwrap();
    (model, numbers(&point["hsv_pu"]))
}

/// The F100 engine in its own, badly scaled units, with its Hankel values.
pub(crate) fn f100() -> (StateSpace<Continuous>, Vec<f64>) {
    let file = parsed(F100);
    let (a, b, c, d) =
        (matrix(&file["A"]), matrix(&file["B"]), matrix(&file["C"]), matrix(&file["D"]));
    (StateSpace::new(a, b, c, d, Continuous).unwrap(), numbers(&file["hsv"]))
}

#[test]
fn hankel_values_of_published_engines_agree_with_the_reference() {
    let mut cases = Vec::from(["idle", "mid", "high", "ref"].map(engine17));
    cases.push(f100());
    for (model, expected) in cases {
        let found = model.hankel_singular_values().unwrap();
        assert_eq!(found.len(), expected.len());
        for (found, expected_value) in found.iter().zip(&expected) {
            // The reference took eigenvalues of P Q, which costs half of the digits.
            let error = (found - expected_value).abs() / expected[0];
            println!("{found:.12e} {expected_value:.12e} {error:.1e}");
            assert!(error < 1e-8, "{found} is not {expected_value}");
        }
    }
}

#[test]
fn eigenvalues_of_published_engines_agree_with_the_reference() {
    for case in [parsed(F100), parsed(ENGINE17)["points"]["ref"].take()] {
        let a = matrix(&case["A"]);
        let (n, re, im) = (a.nrows(), numbers(&case["eig_re"]), numbers(&case["eig_im"]));
        let model =
            StateSpace::new(a, Mat::zeros(n, 1), Mat::zeros(1, n), Mat::zeros(1, 1), Continuous)
                .unwrap();
        let poles = model.poles().unwrap();
        for (re, im) in re.into_iter().zip(im) {
            let size = re.hypot(im);
            let nearest =
                poles.iter().map(|p| (p.re - re).hypot(p.im - im)).fold(f64::MAX, f64::min);
            // Close pairs of eigenvalues lose about half of the digits.
            assert!(nearest < 1e-8 * size, "no pole at {re} {im:+}i ({nearest:e} away)");
        }
    }
}
