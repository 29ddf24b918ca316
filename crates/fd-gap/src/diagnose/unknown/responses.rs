//! Responses of a fitted simulation to disturbances at its places.

use std::ops::Range;

use fd_effect::SiteRef;
use fd_numeric::rms;
use fd_sim::{
    equation::Expr,
    model::{Law, Model},
    simulate::Nominal,
};

use crate::{
    diagnose::result::Start,
    fit::{Log, Problem, Segment},
    locate::{
        bench::{Bench, Rows, settled},
        with_free_input,
    },
    shrink::Forecast,
};

/// Samples per knot, as long as there are not too many knots …
const SAMPLES_PER_KNOT: usize = 8;
/// … and so many are too many.
const MOST_KNOTS: usize = 96;
/// Tries to find the size of a disturbance that can just be seen.
const TRIES: usize = 40;

/// A disturbance at a place: the responses of all residuals to its knots.
#[derive(Clone, Debug)]
pub(super) struct Disturbance {
    pub(super) site: SiteRef,
    pub(super) columns: Vec<Vec<f64>>,
}

impl Disturbance {
    /// The part of it that acts within one segment, and responds there.
    pub(super) fn within(&self, rows: &Range<usize>) -> Self {
        let columns = self.columns.iter().map(|column| column[rows.clone()].to_vec());
        let columns = columns.filter(|column| column.iter().any(|v| v.abs() > 0.0)).collect();
        Self { site: self.site.clone(), columns }
    }
}

/// A simulation of logs that disturbances are added to.
pub(super) struct Disturbed<'a> {
    nominal: &'a dyn Nominal,
    bench: Bench,
    /// With all values settled.
    model: &'a Model,
    starts: Vec<Start>,
    /// Knots of each segment.
    knots: Vec<usize>,
    /// Residuals of each segment.
    rows: Vec<Range<usize>>,
}

impl<'a> Disturbed<'a> {
    /// A problem at `z`, of which `model` is the settled model.
    pub(super) fn fitted(
        nominal: &'a dyn Nominal,
        model: &'a Model,
        problem: &Problem,
        z: &[f64],
    ) -> Self {
        let plan = problem.plan();
        let starts = (0..plan.segments().len()).map(|s| problem.start_of(s, z)).collect();
        let segments = plan.segments().to_vec();
        Self::new(nominal, model, problem, (plan.logs.clone(), segments), starts)
    }

    /// Forecasts of other logs by this model.
    pub(super) fn forecast(
        nominal: &'a dyn Nominal,
        model: &'a Model,
        problem: &Problem,
        logs: &[Log],
        forecast: &Forecast,
    ) -> Self {
        let Forecast { errors, segments, starts, .. } = forecast;
        let mut logs = logs.to_vec();
        // What is no forecast, since it tells where that begins, is not compared.
        for (s, segment) in segments.iter().enumerate() {
            let log = &mut logs[segment.log];
            for (c, signals) in errors.iter().enumerate() {
                for (k, _) in signals[s].iter().enumerate().filter(|(_, e)| !e.is_finite()) {
                    log.y[(segment.from + k) * log.ny + c] = f64::NAN;
                }
            }
        }
        Self::new(nominal, model, problem, (logs, segments.clone()), starts.clone())
    }

    fn new(
        nominal: &'a dyn Nominal,
        model: &'a Model,
        problem: &Problem,
        (logs, segments): (Vec<Log>, Vec<Segment>),
        states: Vec<Vec<f64>>,
    ) -> Self {
        let pairs = segments.iter().zip(states);
        let starts = pairs
            .map(|(segment, state)| Start { log: segment.log, from: segment.from, state })
            .collect();
        let samples: usize = segments.iter().map(|s| s.to - s.from).sum();
        let all = (samples / SAMPLES_PER_KNOT).clamp(4, MOST_KNOTS);
        let share = |len: usize| (all * len).div_ceil(samples.max(1)).max(1);
        let knots = segments.iter().map(|s| share(s.to - s.from)).collect();
        let sigma = problem.weights().sigma.clone();
        let mut end = 0;
        let rows = segments.iter().map(|segment| {
            let from = end;
            end += (segment.to - segment.from) * sigma.len();
            from..end
        });
        let rows = rows.collect();
        let bench = Bench { simulator: problem.simulator().boxed(), logs, segments, sigma };
        Self { nominal, bench, model, starts, knots, rows }
    }

    /// Residuals of each segment.
    pub(super) fn rows(&self) -> &[Range<usize>] {
        &self.rows
    }

    fn residuals(&self) -> usize {
        self.rows.last().map_or(0, |rows| rows.end)
    }

    /// The disturbance at a place; `None` where nothing can be added or nothing is seen of it.
    pub(super) fn at(&self, site: &SiteRef) -> Option<Disturbance> {
        match site {
            SiteRef::Output(output, _) => Some(self.at_a_sensor(*output)),
            _ => self.in_the_plant(site.clone()),
        }
    }

    /// Disturbances at all places of the plant, and at its sensors. Each at a place of the plant takes a run per knot: where
    /// runs are dear there are none.
    pub(super) fn disturbances(&self) -> Vec<Disturbance> {
        let sensors = (0..self.bench.ny()).map(|c| self.at_a_sensor(c));
        if self.bench.simulator.stand_in().is_some() {
            return sensors.collect();
        }
        let forces = self.model.sites.iter().enumerate();
        let forces = forces.map(|(i, site)| SiteRef::Force(i, site.name.clone()));
        let states = self.model.states.iter().enumerate().filter(|(_, state)| {
            let is_known = |name: &str| {
                self.bench.simulator.initial().iter().any(|known| known.channel.name == name)
            };
            let is_entered = |name: &str| {
                let mut sites = self.model.sites.iter();
                sites.any(|site| site.enters.iter().any(|(entered, _)| entered == name))
            };
            // The rate of a position is a velocity, whatever acts.
            let is_kinematic = match &state.law {
                Law::Derivative(law) | Law::Update(law) => {
                    self.model.states.iter().any(|other| *law == Expr::name(&other.name))
                }
            };
            self.nominal.model().states.iter().any(|known| known.name == state.name)
                && is_known(&state.name)
                && !is_entered(&state.name)
                && !is_kinematic
        });
        let states = states.map(|(i, state)| SiteRef::State(i, state.name.clone()));
        let plant = forces.chain(states).filter_map(|site| self.in_the_plant(site));
        plant.chain(sensors).collect()
    }

    /// Hats at the sensor of an output, which nothing stands between.
    fn at_a_sensor(&self, output: usize) -> Disturbance {
        let mut columns = Vec::new();
        for (s, (segment, rows)) in self.bench.segments.iter().zip(&self.rows).enumerate() {
            let log = &self.bench.logs[segment.log];
            let length = segment.to - segment.from;
            for knot in 0..self.knots[s] {
                let mut column = vec![0.0; self.residuals()];
                for k in 0..length {
                    if log.y[(segment.from + k) * log.ny + output].is_finite() {
                        column[rows.start + output * length + k] = self.hat(s, knot, k);
                    }
                }
                columns.push(column);
            }
        }
        let name = self.bench.simulator.outputs()[output].name.clone();
        Disturbance { site: SiteRef::Output(output, name), columns }
    }

    /// Responses to hats at a place of the plant; `None` where nothing can be added or nothing is seen of it.
    fn in_the_plant(&self, site: SiteRef) -> Option<Disturbance> {
        let (model, _) = with_free_input(self.model, &site)?;
        let mut simulator = self.nominal.patched(&model, self.bench.simulator.ts()).ok()?;
        let theta = settled(&*simulator);
        let mut run = |signal: &Rows| {
            self.bench.run(&mut *simulator, &theta, &self.starts, signal).map(|run| run.0)
        };
        let silent: Rows = self.bench.logs.iter().map(|log| vec![0.0; log.samples]).collect();
        let base = run(&silent)?;
        let size = self.visible_size(&mut run, &base)?;
        let most = self.knots.iter().copied().max().unwrap_or(0);
        let mut columns = Vec::new();
        for knot in 0..most {
            // One hat in every segment at once: it is not seen in the others.
            let mut signal = silent.clone();
            for (s, segment) in self.bench.segments.iter().enumerate() {
                let part = &mut signal[segment.log][segment.from..segment.to];
                for (k, value) in part.iter_mut().enumerate() {
                    *value = size * self.hat(s, knot, k);
                }
            }
            let moved = run(&signal)?;
            let response = self.change(&base, &moved);
            for (s, rows) in self.rows.iter().enumerate() {
                if knot < self.knots[s] {
                    let mut column = vec![0.0; response.len()];
                    column[rows.clone()].copy_from_slice(&response[rows.clone()]);
                    columns.push(column);
                }
            }
        }
        Some(Disturbance { site, columns })
    }

    /// The change of the outputs from `base` to `moved` in the order of the residuals, in units of the noise.
    fn change(&self, base: &Rows, moved: &Rows) -> Vec<f64> {
        let mut all = vec![0.0; self.residuals()];
        for (segment, rows) in self.bench.segments.iter().zip(&self.rows) {
            let log = &self.bench.logs[segment.log];
            let length = segment.to - segment.from;
            for (c, sigma) in self.bench.sigma.iter().enumerate() {
                for k in 0..length {
                    let i = (segment.from + k) * log.ny + c;
                    if log.y[i].is_finite() {
                        let change = moved[segment.log][i] - base[segment.log][i];
                        all[rows.start + c * length + k] = change / sigma;
                    }
                }
            }
        }
        all
    }

    /// Size of a constant signal whose response is about once the noise in the mean: large against rounding, small against
    /// the motion. Where it breaks loose what dry friction holds, the least that does.
    fn visible_size(&self, run: &mut dyn FnMut(&Rows) -> Option<Rows>, base: &Rows) -> Option<f64> {
        let (mut size, mut small, mut large) = (1.0, None, None);
        for _ in 0..TRIES {
            let constant = self.bench.logs.iter().map(|log| vec![size; log.samples]).collect();
            let seen = run(&constant).map(|moved| rms(self.change(base, &moved)));
            let guess = match seen {
                Some(rms) if (0.5..2.0).contains(&rms) => return Some(size / rms),
                Some(rms) if rms < 0.5 => {
                    small = Some(size);
                    if rms <= 1e-9 { size * 1e3 } else { size / rms }
                }
                Some(rms) if rms.is_finite() => {
                    large = Some(size);
                    size / rms.min(1e6)
                }
                _ => size * 1e-3,
            };
            size = match (small, large) {
                (Some(small), Some(large)) if !(small..large).contains(&guess) => {
                    f64::sqrt(small * large)
                }
                _ => guess,
            };
            if !(1e-30..1e30).contains(&size) {
                return None;
            }
        }
        large
    }

    /// Value of a hat at sample `k` of a segment. A single knot is a constant.
    fn hat(&self, segment: usize, knot: usize, k: usize) -> f64 {
        let length = self.bench.segments[segment].to - self.bench.segments[segment].from;
        match self.knots[segment] {
            1 => f64::from(u8::from(knot == 0)),
            count => {
                let distance = (length.max(2) - 1) as f64 / (count - 1) as f64;
                (1.0 - (k as f64 / distance - knot as f64).abs()).max(0.0)
            }
        }
    }
}
