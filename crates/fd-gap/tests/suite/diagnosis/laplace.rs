//! The evidence of models that are linear in all that is unknown, against Laplace's formula written out.

use std::{f64::consts::PI, sync::Arc};

use faer::Mat;
use fd_effect::InAnotherRun;
use fd_gap::{
    evidence::{DECADES, Likelihood, NoisePrior, distance, evidence, likelihood},
    fit::{Horizon, LeastSquares, Minimum, Plan, Problem, Search, Variable, Weights, minimise},
};
use fd_model::{Channel, Record, SampleTime, signal::WhiteNoise};
use fd_numeric::dense::Dense;
use fd_sim::{model::Model, simulate::EquationSimulator};

/// `y = m u + k v + s w + l v²`, with a mass that is known to a tolerance, and `d`, which does nothing.
const LINE: &str = r#"
version = 1
kind = "equations"
name = "line"
sample_time = 1.0
inputs = { u = { unit = "1" }, v = { unit = "1" }, w = { unit = "1" } }
outputs = { y = { unit = "1", value = "x + m*u + k*v + s*w + l*v^2 + 0*d" } }
[parameters]
m = { unit = "1", value = 2.0, tolerance = 0.1 }
k = { unit = "1", value = 0.0 }
s = { unit = "1", value = 0.0 }
l = { unit = "1", value = 0.0 }
d = { unit = "1", value = 0.0 }
[states]
x = { unit = "1", initial = 0.0, derivative = "0*x" }
"#;
const SIGMA: f64 = 0.1;
const SAMPLES: usize = 60;

/// Inputs u, v, w of a sample.
fn inputs(k: usize) -> [f64; 3] {
    let phase = |omega: f64| (omega * k as f64).sin();
    [1.0 + 0.2 * phase(0.9), phase(0.31), phase(0.71)]
}

/// A log of `m = 2.05` and these `[k, s, l]`, with noise 1.3 times of what is stated.
fn log([k, s, l]: [f64; 3]) -> Record {
    let noise = WhiteNoise::new(1.3 * SIGMA, 5).values(SAMPLES).unwrap();
    let rows = (0..SAMPLES).map(|i| {
        let [u, v, w] = inputs(i);
        ([u, v, w], [2.05 * u + k * v + s * w + l * v * v + noise[i]])
    });
    let inputs = ["u", "v", "w"].map(|name| Channel::new(name, "1")).to_vec();
    let outputs = vec![Channel::new("y", "1")];
    Record::from_rows(inputs, outputs, rows, SampleTime::new(1.0).unwrap()).unwrap()
}

/// A parameter of an effect; what has a range is a shape.
fn effect(name: &str, scale: f64, range: Option<[f64; 2]>) -> Variable {
    let [low, high] = range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let (name, unit) = (name.to_owned(), "1".to_owned());
    Variable {
        name,
        unit,
        start: 0.0,
        scale,
        low,
        high,
        prior: None,
        is_native: false,
        in_another_run: InAnotherRun::Same,
    }
}

fn fitted(log: &Record, effects: Vec<Variable>) -> (Problem, Minimum, Likelihood) {
    let model: Model = LINE.parse().unwrap();
    let simulator = EquationSimulator::<f64>::new(&model).unwrap();
    let plan = Plan::new(&simulator, std::slice::from_ref(log), Horizon::FreeRun).unwrap();
    let weights = Weights::white(vec![SIGMA]);
    let mut problem = Problem::new(Arc::new(plan), Box::new(simulator), effects, weights).unwrap();
    let start = vec![0.0; problem.layout().unknowns()];
    let exact = Search { iterations: 60, absolute: 0.0, relative: 1e-15, ..Search::PLAIN };
    let minimum = minimise(&mut problem, &start, None, exact).unwrap();
    let errors = problem.errors_at(&minimum).unwrap();
    let likelihood = likelihood(&errors, &[NoisePrior::white(0.15)]);
    (problem, minimum, likelihood)
}

/// `ln det H`, and the standard deviations of the unknowns: of m, in its 0.67 tolerances of 0.2, then of the effects.
fn curvature(effects: &[Variable], noise: f64) -> (f64, Vec<f64>) {
    let column = |name: &str, i: usize| {
        let [u, v, w] = inputs(i);
        match name {
            "m" => u,
            "k" => v,
            "s" => w,
            "d" => 0.0,
            _ => v * v,
        }
    };
    let all: Vec<(&str, f64)> = std::iter::once(("m", 0.67 * 0.2))
        .chain(effects.iter().map(|e| (e.name.as_str(), e.scale)))
        .collect();
    let h = Mat::from_fn(all.len(), all.len(), |a, b| {
        let ((one, unit), (other, other_unit)) = (all[a], all[b]);
        let sum: f64 = (0..SAMPLES).map(|i| column(one, i) * column(other, i)).sum();
        let own = if a != b {
            0.0
        } else if a == 0 {
            1.0
        } else {
            let [low, high] = effects[a - 1].range();
            if (high - low).is_finite() { 12.0 / (high - low).powi(2) } else { 0.0 }
        };
        sum * unit * other_unit / (noise * SIGMA).powi(2) + own
    });
    let inverse = h.lu().inverse();
    let deviations = (0..all.len()).map(|i| inverse[(i, i)].sqrt()).collect();
    (h.determinant().ln(), deviations)
}

/// What all of them have in common: the fit, the prior of m and the volume of what fits.
fn common(at: &Minimum, likelihood: &Likelihood, log_determinant: f64) -> f64 {
    let of_m = 0.5 * at.z[0].powi(2);
    likelihood.log - of_m - 0.5 * log_determinant
}

/// Rounding of sums of 60 products, and a minimum of which the last relative step was 1e-15.
const ROUNDING: f64 = 1e-6;

#[test]
fn nothing_but_a_nuisance() {
    let (problem, at, likelihood) = fitted(&log([0.0; 3]), vec![]);
    assert!(1.1 < likelihood.scale[0] && at.z[0] > 0.1, "{likelihood:?} {:?}", at.z);
    let (determinant, _) = curvature(&[], likelihood.scale[0]);
    let expected = common(&at, &likelihood, determinant);
    let found = evidence(&problem, &at, &likelihood, &[]).unwrap();
    assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
}

/// `p(φ) = 1/(13.8 √(2π) |φ|)` for a strength, uniform in its box for a shape.
#[test]
fn a_strength_and_a_shape() {
    let effects = vec![effect("k", 0.5, None), effect("s", 2.0, Some([-3.0, 1.0]))];
    let (problem, at, likelihood) = fitted(&log([0.8, 0.4, 0.0]), effects.clone());
    let (determinant, deviations) = curvature(&effects, likelihood.scale[0]);
    let size = at.z[1].abs();
    assert!(10.0 * deviations[1] < size, "{size} {deviations:?}");
    let shape = 0.5 * (2.0 * PI).ln() - (4.0_f64 / 2.0).ln();
    let expected = common(&at, &likelihood, determinant) - DECADES.ln() - size.ln() + shape;
    let found = evidence(&problem, &at, &likelihood, &[&[Some(0.0), None]]).unwrap();
    assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
    // Its size is the distance from where it is neutral.
    let found = evidence(&problem, &at, &likelihood, &[&[Some(0.3), None]]).unwrap();
    let further = (at.z[1] - 0.3 / 0.5).abs();
    assert!((found - expected - size.ln() + further.ln()).abs() < ROUNDING, "{found}");
}

/// Below its standard error nobody knows a strength: that error is its size then.
#[test]
fn a_strength_that_may_be_none() {
    let effects = vec![effect("k", 0.5, None)];
    let (problem, at, likelihood) = fitted(&log([0.0; 3]), effects.clone());
    let (determinant, deviations) = curvature(&effects, likelihood.scale[0]);
    assert!(at.z[1].abs() < deviations[1], "{:?} {deviations:?}", at.z);
    let expected = common(&at, &likelihood, determinant) - DECADES.ln() - deviations[1].ln();
    let found = evidence(&problem, &at, &likelihood, &[&[Some(0.0)]]).unwrap();
    assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
}

/// Strengths of one effect have one size in common; those of two effects have their own, each within its decades.
#[test]
fn strengths_of_one_effect_and_of_two() {
    let effects = vec![effect("k", 0.5, None), effect("l", 0.25, None)];
    let (problem, at, likelihood) = fitted(&log([0.8, 0.0, -0.6]), effects.clone());
    let (determinant, deviations) = curvature(&effects, likelihood.scale[0]);
    let sizes = [at.z[1].abs(), at.z[2].abs()];
    assert!(sizes.iter().zip(&deviations[1..]).all(|(size, d)| 5.0 * d < *size), "{sizes:?}");
    let common = common(&at, &likelihood, determinant);
    let one = (0.5 * (sizes[0].powi(2) + sizes[1].powi(2))).sqrt();
    let expected = common - DECADES.ln() - 2.0 * one.ln();
    let found = evidence(&problem, &at, &likelihood, &[&[Some(0.0), Some(0.0)]]).unwrap();
    assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
    let expected = common - 2.0 * DECADES.ln() - sizes[0].ln() - sizes[1].ln();
    let found = evidence(&problem, &at, &likelihood, &[&[Some(0.0)], &[Some(0.0)]]).unwrap();
    assert!((found - expected).abs() < ROUNDING, "{found} {expected}");
}

/// What is left of `l v²` when a mass as near its own as its prior has it, and `s w`, are fitted to it: least squares with
/// one more row.
#[test]
fn the_distance_of_two_laws_is_what_the_rival_leaves() {
    let log = log([0.0, 0.0, 0.5]);
    let (truth, at, _) = fitted(&log, vec![effect("l", 0.5, None)]);
    let (rival, rival_at, _) = fitted(&log, vec![effect("s", 2.0, None)]);
    let column =
        |f: &dyn Fn([f64; 3]) -> f64| Mat::from_fn(SAMPLES, 1, |i, _| f(inputs(i)) / SIGMA);
    let b = column(&|[_, v, _]| 0.5 * at.z[1] * v * v);
    let (u, w) = (column(&|[u, ..]| 0.67 * 0.2 * u), column(&|[.., w]| w));
    let a = Mat::from_fn(SAMPLES, 2, |i, j| if j == 0 { u[(i, 0)] } else { w[(i, 0)] });
    let prior = Mat::from_fn(2, 2, |i, j| if i == 0 && j == 0 { 1.0 } else { 0.0 });
    let h = a.transpose() * &a + prior;
    let shared = a.transpose() * &b;
    let explained = shared.transpose() * faer::linalg::solvers::Solve::solve(&h.lu(), &shared);
    let expected = b.squared_norm_l2() - explained[(0, 0)];
    let found = distance(&truth, &at, &rival, &rival_at);
    // A search ends where a step would change the cost by less than a thousandth.
    assert!((found - expected).abs() < 1e-2, "{found} {expected}");
    // The mean of v² is that of a mass.
    assert!(50.0 < expected && expected < 0.5 * b.squared_norm_l2(), "{expected}");
    assert!(distance(&truth, &at, &truth, &at) < 1e-6);
}

/// Errors of a law are those of its information; a shape that does nothing has that of its box, and takes none from others.
#[test]
fn a_shape_that_does_nothing_takes_no_error_from_others() {
    let law = effect("k", 0.5, None);
    let effects = vec![law.clone(), effect("d", 2.0, Some([0.0, 3.0]))];
    let (problem, at, _) = fitted(&log([0.8, 0.0, 0.0]), effects);
    let errors = problem.standard_errors(&at, 1.3).unwrap();
    let (_, deviations) = curvature(std::slice::from_ref(&law), 1.3);
    let expected = [0.5 * deviations[1], 3.0 / 12.0_f64.sqrt()];
    assert!(errors.iter().zip(expected).all(|(e, of)| (e - of).abs() < ROUNDING), "{errors:?}");
    // Of parameters of the model alone the same.
    let variance = problem.covariance(&at, 1.3).unwrap()[(0, 0)];
    assert!((variance - deviations[0].powi(2)).abs() < ROUNDING, "{variance}");
}
