//! The model of a plant of one's own, linearised where it rests, in ordinary changes.

use std::collections::BTreeMap;

use faer::{Mat, MatRef, linalg::solvers::Solve};
use fd_model::{Channel, ChannelScale, Discrete, SampleTime, Scaling, StateSpace};
use fd_sim::{model::Model, simulate::StateMap};
use fdiag::nonlinear::{OperatingPoint, StateEquations, linearise};

use super::{config::OwnPlant, error::OwnError};

/// Most steps of the search for the state at rest.
const STEPS: usize = 50;
/// Distance from rest that is none, in ordinary changes.
const AT_REST: f64 = 1e-9;

/// The linear model of one sample, and what its signals are in units.
pub(super) fn linear(
    plant: &OwnPlant,
    model: &Model,
    ts: SampleTime,
) -> Result<(StateSpace<Discrete>, Scaling), OwnError> {
    let mut map = StateMap::new(model, &model.nominal(), ts)?;
    let names = |channels: &[Channel]| channels.iter().map(|c| c.name.clone()).collect::<Vec<_>>();
    let states: Vec<String> = map.states().iter().map(|s| s.channel.name.clone()).collect();
    let (inputs, outputs) = (names(map.inputs()), names(map.outputs()));
    let change = |names: &[String]| sizes(&plant.changes, names);
    let (dx, du, dy) = (change(&states)?, change(&inputs)?, change(&outputs)?);
    let known = || states.iter().chain(&inputs).chain(&outputs);
    unknown("changes", &plant.changes, &known().cloned().collect::<Vec<_>>())?;
    unknown("at", &plant.at, &inputs)?;
    let u: Vec<f64> =
        inputs.iter().map(|name| plant.at.get(name).copied().unwrap_or(0.0)).collect();
    let mut at = OperatingPoint { x: model.initial(), u, dx, du };
    rest(&map, &mut at, ts)?;
    let p = linearise(&map, &at, ts)?;
    let OperatingPoint { x, u, dx, du } = at;
    let mut y = vec![0.0; dy.len()];
    map.output(1, &x, &u, &mut y);
    let scaled = |m: MatRef<'_, f64>, to: &[f64], from: &[f64]| {
        Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)] * from[j] / to[i])
    };
    let (a, b) = (scaled(p.a(), &dx, &dx), scaled(p.b(), &dx, &du));
    let (c, d) = (scaled(p.c(), &dy, &dx), scaled(p.d(), &dy, &du));
    let scales = |values: &[f64], changes: &[f64]| {
        values.iter().zip(changes).map(|(&v, &d)| ChannelScale::per_unit(v, d)).collect()
    };
    let scaling = Scaling { inputs: scales(&u, &du), outputs: scales(&y, &dy) };
    Ok((StateSpace::new(a, b, c, d, p.domain())?, scaling))
}

/// Newton's method on `f(x, u) = x`, from the states of the operating point on.
fn rest(map: &StateMap, at: &mut OperatingPoint, ts: SampleTime) -> Result<(), OwnError> {
    let n = at.x.len();
    let mut equations = map.boxed();
    let mut next = vec![0.0; n];
    for _ in 0..STEPS {
        equations.advance(1, &at.x, &at.u, &at.u, &mut next);
        let off = Mat::from_fn(n, 1, |i, _| (next[i] - at.x[i]) / at.dx[i]);
        let p = linearise(map, at, ts)?;
        let slope = Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) - p.a()[(i, j)] * at.dx[j] / at.dx[i]
        });
        let step = slope.partial_piv_lu().solve(&off);
        if !step.norm_max().is_finite() {
            return Err(OwnError::NoRest);
        }
        at.x.iter_mut().zip(&at.dx).enumerate().for_each(|(i, (x, dx))| *x += step[(i, 0)] * dx);
        if step.norm_max() < AT_REST {
            return Ok(());
        }
    }
    Err(OwnError::NoRest)
}

fn sizes(changes: &BTreeMap<String, f64>, names: &[String]) -> Result<Vec<f64>, OwnError> {
    let one = |name: &String| match changes.get(name) {
        Some(&change) if change > 0.0 && change.is_finite() => Ok(change),
        found => Err(OwnError::Missing {
            setting: "changes",
            name: name.clone(),
            found: found.map_or_else(|| "none".to_owned(), f64::to_string),
        }),
    };
    names.iter().map(one).collect()
}

/// The first name of a table that is not among those that may be there.
pub(super) fn unknown<T>(
    setting: &'static str,
    table: &BTreeMap<String, T>,
    known: &[String],
) -> Result<(), OwnError> {
    table.keys().find(|name| !known.contains(name)).map_or(Ok(()), |found| {
        Err(OwnError::Setting {
            setting,
            expected: format!("one of {}", known.join(", ")),
            found: found.clone(),
        })
    })
}
