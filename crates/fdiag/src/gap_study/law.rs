//! The law of the best explanation, along its simulation, and what the data say without it.

use std::collections::{HashMap, HashSet};

use fd_effect::SiteRef;
use fd_gap::{
    diagnose::{Cause, Diagnosis},
    fit::Log,
    locate::Location,
};
use fd_model::SampleTime;
use fd_sim::{
    equation::Expr,
    model::{Model, Output},
    simulate::{Nominal, Run},
};
use schemars::JsonSchema;
use serde::Serialize;

/// Most points of the law, and of the data.
const POINTS: usize = 400;
/// Way up and down of a curve, in ranges, beyond which it is none.
const CURVE: f64 = 3.0;

/// The effect whose path over time is drawn.
const WANDERS: &str = "parameter-wander";

/// The law of the best explanation, along its simulation of the fitted logs.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Law {
    /// Its expression in the patched model.
    pub expression: String,
    /// What it is drawn over.
    pub over: String,
    /// Unit of that.
    pub over_unit: String,
    /// Unit of the law.
    pub unit: String,
    /// Whether it is a curve (a value of the law for each value below).
    pub is_curve: bool,
    /// Points `[over, value]` of the law, in `over_unit` and `unit`, in the order of `over` for a curve,
    /// else of time.
    pub points: Vec<[f64; 2]>,
    /// Points `[over, value]`, in `over_unit` and `unit`, that were estimated from the data without the
    /// law: the signal that the refitted model lacks at this place.
    pub data: Vec<[f64; 2]>,
}

/// What is drawn over what, as expressions of the patched model.
struct Axes {
    value: Expr,
    expression: String,
    over: Expr,
    over_name: String,
    over_unit: String,
    unit: String,
    /// Whether the value is `over` with something added.
    adds: bool,
}

/// The law of the first cause of a diagnosis, if it is one of a place with a signal.
pub(super) fn law(
    nominal: &dyn Nominal,
    diagnosis: &Diagnosis,
    cause: &Cause,
    location: &Location,
    logs: &[Log],
    ts: SampleTime,
) -> Option<Law> {
    let model = &diagnosis.best.model;
    let axes = axes(nominal.model(), model, cause)?;
    let signals = signals(nominal, diagnosis, &axes, logs, ts)?;
    let place = location.places.iter().find(|place| place.site == cause.site);
    let free = place.and_then(|place| place.free.as_ref());
    let data: Vec<[f64; 2]> = free.map_or_else(Vec::new, |free| {
        let pairs = signals.iter().zip(&free.values).flat_map(|(log, free)| log.iter().zip(free));
        pairs.map(|([x, _], f)| [*x, if axes.adds { x + f } else { *f }]).collect()
    });
    let mut points: Vec<[f64; 2]> = signals.into_iter().flatten().collect();
    points.retain(|[x, y]| x.is_finite() && y.is_finite());
    let mut sorted = points.clone();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let is_curve = way(&sorted) <= CURVE * range(&sorted);
    Some(Law {
        expression: axes.expression,
        over: axes.over_name,
        over_unit: axes.over_unit,
        unit: axes.unit,
        is_curve,
        points: thin(if is_curve { sorted } else { points }),
        data: thin(data),
    })
}

fn axes(nominal: &Model, patched: &Model, cause: &Cause) -> Option<Axes> {
    let is_new = |name: &str| !nominal.definitions.iter().any(|known| known.name == name);
    let added = || patched.definitions.iter().filter(|d| is_new(&d.name));
    let name = cause.site.name()?;
    match &cause.site {
        SiteRef::Input(..) | SiteRef::Signal(..) => {
            let applied = added().find(|d| d.name.starts_with(&format!("{name}_applied")))?;
            // Nobody states the unit of a signal inside.
            let input = nominal.inputs.iter().find(|input| input.name == name);
            let unit = input.map_or_else(|| "1".to_owned(), |input| input.unit.clone());
            Some(Axes {
                value: Expr::name(&applied.name),
                expression: format!("{} = {}", applied.name, applied.value),
                over: Expr::name(name),
                over_name: name.to_owned(),
                over_unit: unit.clone(),
                unit,
                adds: true,
            })
        }
        SiteRef::Output(i, _) => {
            let measured = added().find(|d| d.name.starts_with(&format!("{name}_measured")))?;
            let output = patched.outputs.iter().find(|output| output.name == name)?;
            let unit = nominal.outputs[*i].unit.clone();
            Some(Axes {
                value: output.value.clone(),
                expression: format!("{name} = {}", output.value),
                over: Expr::name(&measured.name),
                over_name: format!("true {name}"),
                over_unit: unit.clone(),
                unit,
                adds: true,
            })
        }
        SiteRef::Force(i, _) => {
            let site = nominal.sites.get(*i)?;
            let (state, _) = site.enters.first()?;
            let law = patched.states.iter().find(|known| known.name == *state)?.law.expr();
            let force = added().find(|d| d.name.starts_with(name) && law.mentions(&d.name))?;
            let used = names(&force.value, patched, &is_new);
            let (over, over_name) = [(&site.velocity, "velocity"), (&site.position, "position")]
                .into_iter()
                .filter_map(|(expr, what)| Some((expr.as_ref()?, what)))
                .find(|(expr, _)| mentions_only(expr, &used))
                .map_or_else(
                    || (Expr::name(state), state.clone()),
                    |(expr, what)| (expr.clone(), format!("{what} {expr}")),
                );
            let unit_of = |expr: &Expr| {
                let known = nominal.states.iter().find(|state| expr.mentions(&state.name));
                known.map_or_else(|| "1".to_owned(), |state| state.unit.clone())
            };
            Some(Axes {
                expression: format!("{} = {}", force.name, force.value),
                value: Expr::name(&force.name),
                over_unit: unit_of(&over),
                over,
                over_name,
                unit: site.unit.clone(),
                adds: false,
            })
        }
        SiteRef::Parameter(i, _) if cause.label == WANDERS => {
            let real = added().find(|d| d.name.starts_with(&format!("{name}_real")))?;
            Some(Axes {
                value: Expr::name(&real.name),
                expression: format!("{} = {}", real.name, real.value),
                over: Expr::name("t"),
                over_name: "time".to_owned(),
                over_unit: "s".to_owned(),
                unit: nominal.parameters.get(*i)?.unit.clone(),
                adds: false,
            })
        }
        SiteRef::State(..)
        | SiteRef::Parameter(..)
        | SiteRef::Part(..)
        | SiteRef::Alike(..)
        | SiteRef::WholeModel => None,
    }
}

/// Names in an expression and in the added definitions that it uses.
fn names<'a>(expr: &'a Expr, model: &'a Model, is_new: &dyn Fn(&str) -> bool) -> HashSet<&'a str> {
    let added: HashMap<&str, &Expr> =
        (model.definitions.iter().filter(|d| is_new(&d.name)).map(|d| (d.name.as_str(), &d.value)))
            .collect();
    let (mut names, mut open) = (HashSet::new(), vec![expr]);
    while let Some(expr) = open.pop() {
        expr.visit_names(&mut |name| {
            if names.insert(name) {
                open.extend(added.get(name));
            }
        });
    }
    names
}

fn mentions_only(expr: &Expr, names: &HashSet<&str>) -> bool {
    let mut all = true;
    expr.visit_names(&mut |name| all &= names.contains(name));
    all
}

/// `[over, value]` at all samples of each log, in the simulation of the best explanation.
fn signals(
    nominal: &dyn Nominal,
    diagnosis: &Diagnosis,
    axes: &Axes,
    logs: &[Log],
    ts: SampleTime,
) -> Option<Vec<Vec<[f64; 2]>>> {
    let mut draft = diagnosis.best.model.clone().into_draft();
    let ny = draft.outputs.len();
    for (wish, value) in [("law_over", &axes.over), ("law_value", &axes.value)] {
        let name = draft.fresh_name(wish);
        draft.outputs.push(Output::new(name, "1", value.clone()));
    }
    let model = Model::try_from(draft).ok()?;
    let mut simulator = nominal.patched(&model, ts).ok()?;
    let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
    let mut all: Vec<Vec<[f64; 2]>> = vec![Vec::new(); logs.len()];
    let starts = &diagnosis.best.starts;
    for (i, start) in starts.iter().enumerate() {
        let log = &logs[start.log];
        let next = starts.get(i + 1).filter(|next| next.log == start.log);
        let to = next.map_or(log.samples(), |next| next.from);
        let rows = start.from..(to + 1).min(log.samples());
        let u: Vec<f64> = rows.flat_map(|k| log.input(k).to_vec()).collect();
        let mut y = vec![0.0; (to - start.from) * (ny + 2)];
        let mut runs = [Run::new(&theta, &start.state, &mut y)];
        simulator.simulate_many(start.from as u64, &u, &mut runs);
        all[start.log].extend(y.chunks_exact(ny + 2).map(|y| [y[ny], y[ny + 1]]));
    }
    Some(all)
}

fn way(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|w| (w[1][1] - w[0][1]).abs()).sum()
}

fn range(points: &[[f64; 2]]) -> f64 {
    let values = points.iter().map(|p| p[1]);
    let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v), h.max(v)]);
    ends[1] - ends[0]
}

fn thin(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let step = points.len().div_ceil(POINTS).max(1);
    points.into_iter().step_by(step).collect()
}
