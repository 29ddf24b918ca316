//! A free signal at a place: what would have to be added there to explain the gap?

use fd_effect::SiteRef;
use fd_numeric::rms;
use fd_sim::{
    equation::Expr,
    model::{Input, Law, Model},
    patch::Patch,
    simulate::Simulator,
};

use super::{
    bench::{Bench, Rows, settled},
    columns::Column,
    empirical_bayes::regress,
    result::FreeSignal,
};
use crate::{
    diagnose::{Case, Diagnosis, Nuisance, Start},
    fit::Variable,
};

/// Samples per knot, as long as there are not too many knots …
const SAMPLES_PER_KNOT: usize = 8;
/// … and so many are too many.
const MOST_KNOTS: usize = 96;
/// Own unknowns of segments (initial states) that are fitted beside the signal; more are left as
/// they are.
const MOST_OWN: usize = 120;
/// Deviation of a nuisance, in standard deviations, from which it sits at the edge of its box.
const EDGE: f64 = 2.9;
/// Step of finite differences, in prior standard deviations.
const STEP: f64 = 1e-4;
/// Standard deviation of the initial state of a window, in ranges of the state.
const WINDOW_PRIOR: f64 = 3.0;
/// Tries to find the size of a signal that can just be seen.
const TRIES: usize = 40;

/// What is common to all places.
#[derive(Debug)]
pub(super) struct Probe<'a> {
    case: &'a Case<'a>,
    bench: &'a Bench,
    refit: &'a Model,
    starts: &'a [Start],
    /// Noise floor of each output, in sigma.
    floor: &'a [f64],
    /// Residual in units of the floor, stacked.
    residual: Vec<f64>,
    nuisances: Vec<(Column, f64)>,
    /// Knots of each segment.
    knots: Vec<usize>,
    /// Sum of squares above the floor.
    reducible: f64,
}

impl<'a> Probe<'a> {
    pub(super) fn new(
        case: &'a Case<'a>,
        diagnosis: &'a Diagnosis,
        bench: &'a Bench,
        residuals: &[Vec<Vec<f64>>],
    ) -> Self {
        let floor = &diagnosis.floor;
        let residual = bench.stack(residuals, floor);
        let measured = residuals.iter().flatten().flatten().filter(|r| r.is_finite()).count();
        let squares = residual.iter().map(|r| r * r).sum::<f64>();
        let samples: usize = bench.segments.iter().map(|s| s.to - s.from).sum();
        let knots = (samples / SAMPLES_PER_KNOT).clamp(4, MOST_KNOTS);
        let share = |len: usize| (knots * len).div_ceil(samples.max(1)).max(1);
        let knots = bench.segments.iter().map(|s| share(s.to - s.from)).collect();
        let (refit, starts) = (&diagnosis.refit.model, diagnosis.refit.starts.as_slice());
        let reducible = squares - measured as f64;
        let mut probe = Self {
            case,
            bench,
            refit,
            starts,
            floor,
            residual,
            nuisances: Vec::new(),
            knots,
            reducible,
        };
        probe.nuisances = probe.nuisance_columns(diagnosis).unwrap_or_default();
        probe
    }

    /// The nominal simulator.
    pub(super) fn simulator(&self) -> &dyn Simulator {
        &*self.bench.simulator
    }

    /// The change of the outputs from `base` to `moved`, stacked, in units of the floor.
    fn change(&self, base: &Rows, moved: &Rows) -> Vec<f64> {
        let difference = |c: usize| -> Vec<Vec<f64>> {
            let of_log = |(base, (moved, log)): (&Vec<f64>, (&Vec<f64>, &crate::fit::Log))| {
                let pairs = base.iter().zip(moved).zip(&log.y).skip(c).step_by(log.ny);
                // Only where something was measured.
                let sigma = self.bench.sigma[c];
                pairs.map(|((b, m), y)| if y.is_finite() { (m - b) / sigma } else { 0.0 }).collect()
            };
            base.iter().zip(moved.iter().zip(&self.bench.logs)).map(of_log).collect()
        };
        let differences: Vec<_> = (0..self.bench.ny()).map(difference).collect();
        self.bench.stack(&differences, self.floor)
    }

    /// The change of the outputs per standard deviation, of a step of a finite difference.
    fn slope(&self, base: &Rows, moved: &Rows) -> Vec<f64> {
        self.change(base, moved).into_iter().map(|change| change / STEP).collect()
    }

    /// Slopes of uncertain parameters and initial states, with the precisions of their priors.
    fn nuisance_columns(&self, diagnosis: &Diagnosis) -> Option<Vec<(Column, f64)>> {
        let nominal = self.case.nominal.model();
        let mut simulator =
            self.case.nominal.patched(self.refit, self.bench.simulator.ts()).ok()?;
        let theta = settled(&*simulator);
        let base = self.bench.run(&mut *simulator, &theta, self.starts, &Vec::new())?;
        let mut columns = Vec::new();
        let whole = 0..self.residual.len();
        for Nuisance { name, deviation, .. } in &diagnosis.refit.nuisances {
            let known = nominal.parameter(name);
            let place = simulator.parameters().iter().position(|p| p.name == *name);
            let variable = known.and_then(Variable::nuisance);
            let (Some(place), Some(variable)) = (place, variable) else { continue };
            if EDGE < deviation.abs() {
                continue;
            }
            let mut moved = theta.clone();
            moved[place] += STEP * variable.scale;
            let run = self.bench.run(&mut *simulator, &moved, self.starts, &Vec::new());
            let Some((outputs, _)) = run else { continue };
            let slope = self.slope(&base.0, &outputs);
            columns.push((Column::of(&slope, whole.clone()), variable.precision()));
        }
        let initial = simulator.initial().to_vec();
        let is_cut = self.bench.is_cut();
        for (i, state) in initial.iter().enumerate() {
            let range = range(&base.1, i, initial.len());
            let (scale, precision) = match Variable::initial(state) {
                _ if is_cut && 0.0 < range => (range, WINDOW_PRIOR.powi(-2)),
                Some(variable) => (variable.scale, variable.precision()),
                None => continue,
            };
            if MOST_OWN < columns.len() + self.starts.len() {
                break;
            }
            let mut starts = self.starts.to_vec();
            for start in &mut starts {
                start.state[i] += STEP * scale;
            }
            let run = self.bench.run(&mut *simulator, &theta, &starts, &Vec::new());
            let Some((outputs, _)) = run else { continue };
            let slope = self.slope(&base.0, &outputs);
            for rows in self.bench.row_ranges() {
                columns.push((Column::of(&slope, rows), precision));
            }
        }
        columns.retain(|(column, _)| column.values.iter().any(|v| v.abs() > 0.0));
        Some(columns)
    }

    /// The free signal at a place; `None` where nothing can be added or nothing is seen of it.
    pub(super) fn at(&self, site: &SiteRef) -> Option<FreeSignal> {
        let (columns, scale, unit) = match site {
            SiteRef::Output(i, _) => {
                let unit = self.refit.outputs[*i].unit.clone();
                (self.sensor_columns(*i), self.bench.sigma[*i], unit)
            }
            _ => self.plant_columns(site)?,
        };
        let fit = regress(&self.nuisances, &columns, &self.residual)?;
        let values = self.spread(&fit.coefficients, scale);
        let rms = rms(values.iter().flatten().copied());
        let share = if 0.0 < self.reducible { fit.explained / self.reducible } else { 0.0 };
        let share = share.clamp(0.0, 1.0);
        Some(FreeSignal { share, log_evidence: fit.log_evidence, unit, rms, values })
    }

    /// Hats at the sensor of an output, which nothing stands between.
    fn sensor_columns(&self, output: usize) -> Vec<Column> {
        let mut columns = Vec::new();
        for (s, rows) in self.bench.row_ranges().into_iter().enumerate() {
            let segment = self.bench.segments[s];
            let log = &self.bench.logs[segment.log];
            let length = segment.to - segment.from;
            for knot in 0..self.knots[s] {
                let value = |k: usize| {
                    let is_there = log.y[(segment.from + k) * log.ny + output].is_finite();
                    if is_there { self.hat(s, knot, k) / self.floor[output] } else { 0.0 }
                };
                let from = rows.start + output * length;
                let values = (0..length).map(value).collect();
                columns.push(Column { rows: from..from + length, values });
            }
        }
        columns
    }

    /// Responses to hats at a place of the plant, the size of a unit coefficient, and its unit.
    fn plant_columns(&self, site: &SiteRef) -> Option<(Vec<Column>, f64, String)> {
        let (model, unit) = with_free_input(self.refit, site)?;
        let mut simulator = self.case.nominal.patched(&model, self.bench.simulator.ts()).ok()?;
        let theta = settled(&*simulator);
        let silent: Rows = self.bench.logs.iter().map(|log| vec![0.0; log.samples]).collect();
        let base = self.bench.run(&mut *simulator, &theta, self.starts, &silent)?.0;
        let size = self.visible_size(&mut *simulator, &theta, &base)?;
        let rows = self.bench.row_ranges();
        let most = self.knots.iter().copied().max().unwrap_or(0);
        let mut columns: Vec<Vec<Column>> = vec![Vec::new(); rows.len()];
        for knot in 0..most {
            // One hat in every segment at once: it is not seen in the others.
            let mut signal = silent.clone();
            for (s, segment) in self.bench.segments.iter().enumerate() {
                let part = &mut signal[segment.log][segment.from..segment.to];
                for (k, value) in part.iter_mut().enumerate() {
                    *value = size * self.hat(s, knot, k);
                }
            }
            let (moved, _) = self.bench.run(&mut *simulator, &theta, self.starts, &signal)?;
            let response = self.change(&base, &moved);
            for (s, rows) in rows.iter().enumerate().filter(|(s, _)| knot < self.knots[*s]) {
                columns[s].push(Column::of(&response, rows.clone()));
            }
        }
        Some((columns.concat(), size, unit))
    }

    /// Size of a constant signal whose response is one floor in the mean: large against rounding,
    /// small against the motion.
    fn visible_size(
        &self,
        simulator: &mut dyn Simulator,
        theta: &[f64],
        base: &Rows,
    ) -> Option<f64> {
        let mut size = 1.0;
        for _ in 0..TRIES {
            let constant = |value: f64| -> Rows {
                self.bench.logs.iter().map(|log| vec![value; log.samples]).collect()
            };
            let rms = self
                .bench
                .run(simulator, theta, self.starts, &constant(size))
                .map(|run| rms(self.change(base, &run.0)));
            match rms {
                Some(rms) if (0.5..2.0).contains(&rms) => return Some(size / rms),
                Some(rms) if rms <= 1e-9 => size *= 1e3,
                Some(rms) if rms.is_finite() => size /= rms.clamp(1e-6, 1e6),
                _ => size *= 1e-3,
            }
            if !(1e-30..1e30).contains(&size) {
                return None;
            }
        }
        None
    }

    /// Value of a hat at sample `k` of a segment. A single knot is a constant.
    fn hat(&self, segment: usize, knot: usize, k: usize) -> f64 {
        let Self { bench, knots, .. } = self;
        let length = bench.segments[segment].to - bench.segments[segment].from;
        match knots[segment] {
            1 => f64::from(u8::from(knot == 0)),
            count => {
                let distance = (length.max(2) - 1) as f64 / (count - 1) as f64;
                (1.0 - (k as f64 / distance - knot as f64).abs()).max(0.0)
            }
        }
    }

    /// The signal with these coefficients, at all samples.
    fn spread(&self, coefficients: &[f64], scale: f64) -> Vec<Vec<f64>> {
        let mut values: Rows = self.bench.logs.iter().map(|log| vec![0.0; log.samples]).collect();
        let mut first = 0;
        for (s, segment) in self.bench.segments.iter().enumerate() {
            let own = &coefficients[first..first + self.knots[s]];
            first += self.knots[s];
            for k in 0..segment.to - segment.from {
                let hats = own.iter().enumerate().map(|(knot, c)| c * self.hat(s, knot, k));
                values[segment.log][segment.from + k] = scale * hats.sum::<f64>();
            }
        }
        values
    }
}

/// Distance between the largest and the smallest value of a column.
fn range(rows: &Rows, column: usize, width: usize) -> f64 {
    let values = rows.iter().flat_map(|rows| rows.iter().skip(column).step_by(width));
    let ends = values
        .filter(|v| v.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |e, v| [e[0].min(*v), e[1].max(*v)]);
    (ends[1] - ends[0]).max(0.0)
}

/// The model with one more input, which is added at the place, and the unit of that input.
fn with_free_input(model: &Model, site: &SiteRef) -> Option<(Model, String)> {
    let mut patch = Patch::of(model);
    let name = patch.fresh_name("free_signal");
    let free = Expr::name(&name);
    let unit = match site {
        SiteRef::Input(i, input) => {
            let applied = patch.fresh_name("with_free_signal");
            patch.wrap_input(input, &applied, Expr::name(input) + free).ok()?;
            model.inputs[*i].unit.clone()
        }
        SiteRef::Force(i, place) => {
            patch.add_force(place, &patch.fresh_name("free_force"), free).ok()?;
            model.sites[*i].unit.clone()
        }
        SiteRef::State(i, state) => {
            patch.add_to_law(state, free).ok()?;
            let unit = &model.states[*i].unit;
            match model.states[*i].law {
                Law::Derivative(_) => format!("{unit}/s"),
                Law::Update(_) => unit.clone(),
            }
        }
        SiteRef::Output(..)
        | SiteRef::Signal(..)
        | SiteRef::Parameter(..)
        | SiteRef::Part(..)
        | SiteRef::Alike(..)
        | SiteRef::WholeModel => return None,
    };
    patch.add_input(Input { name, unit: unit.clone(), saturation: None });
    Some((patch.finish().ok()?, unit))
}
