//! Sparse regression on residual rates, as `SINDy` does (Brunton, Proctor & Kutz 2016): what the rates
//! of the states lack is a sum of few terms of a library, by least squares with sequential
//! thresholds.
//!
//! The states are what the outputs show, smoothed (local parabolas), velocities are derivatives of
//! measured positions, and the rest comes from the simulation. The residual rate is what a
//! simulation over one sample lacks from there.

use fd_numeric::{dot, rms};
use fd_sim::{
    equation::Expr,
    model::{Law, Model},
    patch::Patch,
    simulate::{EquationSimulator, Simulator},
};

use super::bench::{Baseline, Bench};
use crate::blind::error::BlindError;

/// Half width of a parabola, in samples.
const HALF: usize = 4;
/// Thresholds, as parts of the largest coefficient, among which the last third chooses.
const THRESHOLDS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];
/// Sequences of thresholds.
const PASSES: usize = 10;
/// Share of the variance that must be explained for a cause to be named.
const EXPLAINED: f64 = 0.1;

/// A term of the library.
struct Term {
    text: String,
    expr: Expr,
    /// What stands for it in words: label and site.
    cause: (String, String),
}

/// The terms that were chosen for an equation.
struct Chosen {
    state: usize,
    /// Share of the variance of the last third that they explain.
    explained: f64,
    /// Place of a term, coefficient, size of what it adds.
    terms: Vec<(usize, f64, f64)>,
    library: Vec<Term>,
}

pub(super) fn sparse(bench: &Bench<'_>) -> Result<Baseline, BlindError> {
    let model = bench.model;
    let Some(states) = states(bench) else { return Ok(Baseline::default()) };
    let rates = residual_rates(bench, &states);
    let mut equations: Vec<Chosen> = Vec::new();
    for (j, rate) in rates.iter().enumerate() {
        let Some(rate) = rate else { continue };
        let library = library(model, j);
        if let Some(chosen) = choose(bench, &states, rate, j, library) {
            equations.push(chosen);
        }
    }
    equations.sort_by(|a, b| b.explained.total_cmp(&a.explained));
    let leading = equations.first();
    let named = leading.and_then(|chosen| {
        let largest = chosen.terms.iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
        Some(chosen.library[largest.0].cause.clone())
    });
    // All equations with terms are changed at once.
    let mut patch = Patch::of(model);
    for chosen in &equations {
        for (place, coefficient, _) in &chosen.terms {
            let text = format!("{coefficient:e}*({})", chosen.library[*place].text);
            if let Ok(term) = Expr::parse(&text) {
                // The state is one of the model.
                let _ = patch.add_to_law(&model.states[chosen.state].name, term);
            }
        }
    }
    let patched = patch
        .finish()
        .ok()
        .and_then(|model| EquationSimulator::<f64>::at(&model, bench.train.ts()).ok());
    let after = match &patched {
        Some(simulator) if !equations.is_empty() => {
            bench.held_out_errors(&bench.nominal, simulator, &bench.refit)?
        }
        _ => Some(bench.before.clone()),
    };
    // A regression whose simulation diverges is of no use.
    let closed = after.map_or(Some(f64::NEG_INFINITY), |after| bench.closed(&after));
    Ok(Baseline { named, closed: closed.map(|share| share.max(-1.0)) })
}

/// States of all samples, and which of them are measured.
struct States {
    x: Vec<Vec<f64>>,
    is_measured: Vec<bool>,
}

fn states(bench: &Bench<'_>) -> Option<States> {
    let model = bench.model;
    let mut simulator = bench.nominal.clone();
    let theta: Vec<f64> = model
        .parameters
        .iter()
        .map(|p| bench.refit.iter().find(|(name, _)| *name == p.name).map_or(p.value, |r| r.1))
        .collect();
    simulator.start(&theta, &model.initial(), 0);
    let mut y = vec![0.0; model.outputs.len()];
    let samples = bench.train.len();
    let mut x: Vec<Vec<f64>> = Vec::with_capacity(samples);
    for k in 0..samples {
        x.push(simulator.state().to_vec());
        let next = (k + 1).min(samples - 1);
        simulator.step(bench.train.u(k), bench.train.u(next), &[], &mut y);
        if y.iter().any(|y| !y.is_finite()) {
            return None;
        }
    }
    let mut is_measured = vec![false; model.states.len()];
    let ts = bench.train.ts().seconds();
    for (j, state) in model.states.iter().enumerate() {
        let shows = |name: &str| model.outputs.iter().position(|o| o.value == Expr::name(name));
        let integral = model.states.iter().find(
            |other| matches!(&other.law, Law::Derivative(law) if *law == Expr::name(&state.name)),
        );
        let found = match (shows(&state.name), integral.and_then(|s| shows(&s.name))) {
            (Some(output), _) => Some((output, false)),
            (None, Some(output)) => Some((output, true)),
            (None, None) => None,
        };
        if let Some((output, is_rate)) = found {
            let signal: Vec<f64> = bench.train.output(output).collect();
            let smooth = parabolas(&signal, ts);
            for (x, (value, rate)) in x.iter_mut().zip(smooth) {
                x[j] = if is_rate { rate } else { value };
            }
            is_measured[j] = true;
        }
    }
    Some(States { x, is_measured })
}

/// Value and rate of local parabolas (Savitzky & Golay 1964).
fn parabolas(signal: &[f64], ts: f64) -> Vec<(f64, f64)> {
    let n = signal.len();
    let fit = |k: usize| {
        let middle = k.clamp(HALF, n.saturating_sub(HALF + 1).max(HALF));
        let (mut s, mut sum) = ([0.0; 5], [0.0; 3]);
        let (from, to) = (middle.saturating_sub(HALF), (middle + HALF + 1).min(n));
        for (i, value) in signal.iter().enumerate().take(to).skip(from) {
            let d = i as f64 - middle as f64;
            let powers = [1.0, d, d * d, d * d * d, d * d * d * d];
            s.iter_mut().zip(powers).for_each(|(s, p)| *s += p);
            sum.iter_mut().zip(powers).for_each(|(sum, p)| *sum += p * value);
        }
        // Odd sums vanish on the even grid.
        let determinant = s[0] * s[4] - s[2] * s[2];
        let a = (s[4] * sum[0] - s[2] * sum[2]) / determinant;
        let c = (s[0] * sum[2] - s[2] * sum[0]) / determinant;
        let (b, d) = (sum[1] / s[2], k as f64 - middle as f64);
        (a + b * d + c * d * d, (b + 2.0 * c * d) / ts)
    };
    (0..n).map(fit).collect()
}

/// Per state: what its rate lacks, sample by sample.
fn residual_rates(bench: &Bench<'_>, states: &States) -> Vec<Option<Vec<f64>>> {
    let mut simulator = bench.nominal.clone();
    let model = bench.model;
    let theta: Vec<f64> = model
        .parameters
        .iter()
        .map(|p| bench.refit.iter().find(|(name, _)| *name == p.name).map_or(p.value, |r| r.1))
        .collect();
    let (ts, samples) = (bench.train.ts().seconds(), bench.train.len());
    let mut y = vec![0.0; model.outputs.len()];
    let mut rates = vec![Vec::with_capacity(samples); model.states.len()];
    for k in 0..samples - 1 {
        simulator.start(&theta, &states.x[k], k as u64);
        simulator.step(bench.train.u(k), bench.train.u(k + 1), &[], &mut y);
        for (j, rates) in rates.iter_mut().enumerate() {
            rates.push((states.x[k + 1][j] - simulator.state()[j]) / ts);
        }
    }
    let keep = |(j, rates): (usize, Vec<f64>)| {
        let is_position = matches!(&model.states[j].law, Law::Derivative(Expr::Name(_)));
        (states.is_measured[j] && !is_position && rates.iter().all(|r| r.is_finite()))
            .then_some(rates)
    };
    rates.into_iter().enumerate().map(keep).collect()
}

/// Terms for the equation of a state, each with the cause that it would be.
fn library(model: &Model, equation: usize) -> Vec<Term> {
    let own = &model.states[equation].name;
    let enters = |site: &&fd_sim::model::Site| site.enters.iter().any(|(state, _)| state == own);
    let site = model.sites.iter().find(enters);
    let place = site.map_or_else(|| own.clone(), |site| site.name.clone());
    let is = |expr: Option<&Option<Expr>>, name: &str| {
        expr.and_then(Option::as_ref).is_some_and(|expr| *expr == Expr::name(name))
    };
    let mut all = Vec::new();
    let mut add = |text: String, label: &str, place: &str| {
        if let Ok(expr) = Expr::parse(&text) {
            all.push(Term { text, expr, cause: (label.to_owned(), place.to_owned()) });
        }
    };
    add("1".to_owned(), "constant-load", &place);
    for state in &model.states {
        let x = &state.name;
        let is_velocity = is(site.map(|s| &s.velocity), x) || (x == own && site.is_some());
        let labels = if is(site.map(|s| &s.position), x) {
            ["linear-stiffness", "stiffening", "stiffening", "coulomb-friction"]
        } else if is_velocity {
            ["viscous-friction", "drag", "drag", "coulomb-friction"]
        } else {
            ["state-coupling"; 4]
        };
        add(x.clone(), labels[0], &place);
        add(format!("{x}*abs({x})"), labels[1], &place);
        add(format!("{x}^3"), labels[2], &place);
        add(format!("sign({x})"), labels[3], &place);
        if state.unit == "rad" {
            add(format!("sin({x})"), "gravity-load", &place);
        }
    }
    for input in model.inputs.iter().filter(|input| !model.is_driven(&input.name)) {
        add(input.name.clone(), "input-gain", &input.name);
        add(format!("abs({})", input.name), "input-gain", &input.name);
        add(format!("{0}^3", input.name), "input-saturation", &input.name);
    }
    all
}

/// Least squares with sequential thresholds; `None` when nothing is explained.
fn choose(
    bench: &Bench<'_>,
    states: &States,
    rate: &[f64],
    state: usize,
    library: Vec<Term>,
) -> Option<Chosen> {
    let model = bench.model;
    let inputs = model.external_inputs();
    let columns: Vec<Vec<f64>> = library
        .iter()
        .map(|term| {
            let value = |k: usize| {
                let names = |name: &str| {
                    let state = model.states.iter().position(|s| s.name == name);
                    let input = || inputs.iter().position(|i| i.name == name);
                    state.map(|j| states.x[k][j]).or_else(|| input().map(|i| bench.train.u(k)[i]))
                };
                term.expr.evaluate(&names).unwrap_or(0.0)
            };
            (0..rate.len()).map(value).collect()
        })
        .collect();
    let sizes: Vec<f64> = columns.iter().map(|c| rms(c.iter().copied()).max(1e-300)).collect();
    let unit: Vec<Vec<f64>> =
        columns.iter().zip(&sizes).map(|(c, size)| c.iter().map(|v| v / size).collect()).collect();
    // The ends of the smoothing are left out.
    let (from, to) = (HALF, rate.len() - HALF);
    let cut = to - (to - from) / 3;
    let total = rate[cut..to].iter().map(|r| r * r).sum::<f64>();
    let mut best: Option<(f64, Vec<(usize, f64)>)> = None;
    for threshold in THRESHOLDS {
        let Some(terms) = thresholded(&unit, rate, from..cut, threshold) else { continue };
        let left: f64 = (cut..to)
            .map(|k| {
                let fit: f64 = terms.iter().map(|(i, c)| c * unit[*i][k]).sum();
                (rate[k] - fit).powi(2)
            })
            .sum();
        let explained = 1.0 - left / total;
        if best.as_ref().is_none_or(|(most, _)| *most < explained) {
            best = Some((explained, terms));
        }
    }
    let (explained, terms) = best.filter(|(explained, _)| EXPLAINED < *explained)?;
    let terms = terms.into_iter().map(|(i, c)| (i, c / sizes[i], c.abs())).collect();
    Some(Chosen { state, explained, terms, library })
}

fn thresholded(
    columns: &[Vec<f64>],
    rate: &[f64],
    rows: std::ops::Range<usize>,
    threshold: f64,
) -> Option<Vec<(usize, f64)>> {
    let mut active: Vec<usize> = (0..columns.len()).collect();
    let mut coefficients = Vec::new();
    for _ in 0..PASSES {
        coefficients = solve(columns, rate, rows.clone(), &active)?;
        let largest = coefficients.iter().fold(0.0_f64, |m: f64, c: &f64| m.max(c.abs()));
        let kept: Vec<usize> = active
            .iter()
            .zip(&coefficients)
            .filter(|(_, c)| threshold * largest <= c.abs())
            .map(|(i, _)| *i)
            .collect();
        if kept.len() == active.len() {
            break;
        }
        active = kept;
    }
    Some(active.into_iter().zip(coefficients).collect())
}

/// Least squares with a little ridge, by Gaussian elimination.
fn solve(
    columns: &[Vec<f64>],
    rate: &[f64],
    rows: std::ops::Range<usize>,
    active: &[usize],
) -> Option<Vec<f64>> {
    let n = active.len();
    let product = |a: &[f64], b: &[f64]| dot(&a[rows.clone()], &b[rows.clone()]);
    let mut m: Vec<Vec<f64>> = active
        .iter()
        .map(|&i| {
            let mut row: Vec<f64> =
                active.iter().map(|&j| product(&columns[i], &columns[j])).collect();
            row.push(product(&columns[i], rate));
            row
        })
        .collect();
    for (i, row) in m.iter_mut().enumerate() {
        row[i] *= 1.0 + 1e-6;
        row[i] += 1e-12;
    }
    for i in 0..n {
        let pivot = m[i].clone();
        if !pivot[i].is_normal() {
            return None;
        }
        for (j, row) in m.iter_mut().enumerate() {
            if j != i {
                let factor = row[i] / pivot[i];
                row.iter_mut().zip(&pivot).for_each(|(r, p)| *r -= factor * p);
            }
        }
    }
    Some((0..n).map(|i| m[i][n] / m[i][i]).collect())
}
