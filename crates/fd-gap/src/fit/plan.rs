//! What is fitted to what: logs, segments, and the unknowns of the nominal model.

use fd_model::Record;
use fd_sim::simulate::{Outcome, Simulator, walk};
use schemars::JsonSchema;
use serde::Serialize;

use super::{error::FitError, hidden_states, log::Log, variable::Variable};

/// Samples per state in a window, at least: its first half settles the states.
const SAMPLES_PER_STATE: usize = 4;
/// Shortest window, in samples.
const SHORTEST: usize = 8;

/// Samples of the shortest window that settles so many states.
pub(crate) fn shortest_window(states: usize) -> usize {
    SHORTEST.max(SAMPLES_PER_STATE * states)
}

/// How long a simulation runs without seeing the outputs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Horizon {
    /// Through the whole log.
    FreeRun,
    /// Through windows, each with an initial state of its own.
    Windows {
        /// Length of a window, in samples.
        samples: usize,
    },
}

/// A stretch of a log that is simulated in one go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Segment {
    /// Number of the log, from 0.
    pub log: usize,
    /// First sample.
    pub from: usize,
    /// One after the last sample.
    pub to: usize,
}

/// Standard deviation of the initial state of a window, in ranges of the state.
const WINDOW_PRIOR: f64 = 3.0;
/// Half width of its box, in ranges of the state.
const WINDOW_BOX: f64 = 30.0;

/// Logs cut into segments, with the unknowns of the nominal model: its uncertain parameters,
/// which all segments share, and the initial states of each segment.
///
/// At the start of a log only states with a tolerance are unknown. Within a log (where inputs were missing as well), and where it begins
/// in motion, every state of the nominal model is, and states that an effect adds start where the
/// effect says (left free, they would win falsely).
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    pub(crate) logs: Vec<Log>,
    pub(crate) segments: Vec<Segment>,
    /// Uncertain parameters.
    pub(crate) shared: Vec<Variable>,
    /// Names of the states that are unknown somewhere.
    pub(crate) own_names: Vec<String>,
    /// Their values in each segment.
    pub(crate) own: Vec<Vec<Variable>>,
}

impl Plan {
    /// A plan for records, of which the simulator gives the nominal model.
    ///
    /// # Errors
    ///
    /// Returns an error when there is no record, a record does not fit the simulator (see
    /// [`Log::new`]) or has fewer than two values per unknown, or the nominal simulation diverges.
    pub fn new(
        simulator: &dyn Simulator,
        records: &[Record],
        horizon: Horizon,
    ) -> Result<Self, FitError> {
        Self::of_logs(simulator, Log::all(records, simulator, &[])?, horizon)
    }

    pub(crate) fn of_logs(
        simulator: &dyn Simulator,
        logs: Vec<Log>,
        horizon: Horizon,
    ) -> Result<Self, FitError> {
        if logs.is_empty() {
            return Err(FitError::NoLog);
        }
        let shared = simulator.parameters().iter().filter_map(Variable::nuisance).collect();
        let mut plan =
            Self { logs, segments: Vec::new(), shared, own_names: Vec::new(), own: Vec::new() };
        plan.cut(simulator, horizon)?;
        for (i, log) in plan.logs.iter().enumerate() {
            let unknowns = plan.shared.len() + plan.own_names.len();
            let (found, needed) = (log.measured(), 2 * unknowns.max(4));
            if found < needed {
                return Err(FitError::TooShort { log: i + 1, found, unknowns, needed });
            }
        }
        Ok(plan)
    }

    /// Runs through each log with the nominal model, notes where its states are at the start of
    /// each segment, and how far they move.
    fn cut(&mut self, simulator: &dyn Simulator, horizon: Horizon) -> Result<(), FitError> {
        let mut simulator = simulator.boxed();
        let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let initial = simulator.initial().to_vec();
        let x0: Vec<f64> = initial.iter().map(|state| state.value).collect();
        let mut starts: Vec<Vec<f64>> = Vec::new();
        let mut range = vec![[f64::INFINITY, f64::NEG_INFINITY]; x0.len()];
        let mut first = Vec::new();
        for (l, log) in self.logs.iter().enumerate() {
            let length = match horizon {
                Horizon::FreeRun => log.samples,
                Horizon::Windows { samples } => samples.max(2),
            };
            let mut begun = 0;
            let segments = &mut self.segments;
            let note = |k: usize, x: &[f64]| {
                if log.restarts.contains(&k) {
                    begun = k;
                }
                let until = log.restarts.iter().find(|restart| k < **restart);
                let left = until.copied().unwrap_or(log.samples) - k;
                // A last window that is shorter than half a window joins the one before.
                let is_start =
                    (k - begun).is_multiple_of(length) && (k == begun || length / 2 <= left);
                if is_start {
                    if let Some(last) = segments.last_mut().filter(|last| last.log == l) {
                        last.to = k;
                    }
                    segments.push(Segment { log: l, from: k, to: log.samples });
                    starts.push(x.to_vec());
                }
                for (range, x) in range.iter_mut().zip(x) {
                    *range = [range[0].min(*x), range[1].max(*x)];
                }
            };
            let mut y = vec![0.0; log.samples * log.ny];
            if walk(&mut *simulator, &theta, &x0, 0, &log.u, &mut y, note) != Outcome::Complete {
                return Err(FitError::Diverged);
            }
            if l == 0 {
                first = y;
            }
        }
        let logs = &self.logs;
        let is_free = |segment: &Segment| 0 < segment.from || logs[segment.log].is_in_motion;
        let is_any_free = self.segments.iter().any(is_free);
        let free: Vec<usize> = (0..initial.len())
            .filter(|&i| is_any_free || Variable::initial(&initial[i]).is_some())
            .collect();
        let widths: Vec<f64> = range.iter().map(|[low, high]| high - low).collect();
        let is_hidden = is_any_free && widths.iter().all(|width| *width == 0.0);
        let reach = if is_hidden {
            let known: Vec<_> =
                initial.iter().map(|state| (state.value, state.tolerance)).collect();
            hidden_states::scales(&mut *simulator, &theta, &known, &logs[0], &first)
        } else {
            vec![None; initial.len()]
        };
        self.own_names = free.iter().map(|&i| initial[i].channel.name.clone()).collect();
        for (segment, start) in self.segments.iter().zip(&starts) {
            let own = free.iter().map(|&i| {
                let state = &initial[i];
                let width = reach[i].unwrap_or(widths[i]);
                let smallest = (1e-3 * start[i].abs()).max(1e-6);
                let scale = width.max(state.tolerance.unwrap_or(0.0)).max(smallest);
                let (name, unit) = (&state.channel.name, &state.channel.unit);
                if is_free(segment) {
                    let mut own = Variable::known(name, unit, start[i], scale);
                    own.prior = Some(WINDOW_PRIOR * scale);
                    own.low = start[i] - WINDOW_BOX * scale;
                    own.high = start[i] + WINDOW_BOX * scale;
                    own
                } else {
                    Variable::initial(state).unwrap_or_else(|| {
                        let mut exact = Variable::known(name, unit, start[i], scale);
                        (exact.low, exact.high) = (start[i], start[i]);
                        exact
                    })
                }
            });
            self.own.push(own.collect());
        }
        Ok(())
    }

    /// Segments, in order.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// Uncertain parameters of the nominal model.
    #[must_use]
    pub fn nuisances(&self) -> &[Variable] {
        &self.shared
    }

    /// Initial states, segment by segment.
    pub(crate) fn own_variables(&self) -> impl Iterator<Item = &Variable> {
        self.own.iter().flatten()
    }

    /// Number of measured values.
    #[must_use]
    pub fn measured(&self) -> usize {
        self.logs.iter().map(Log::measured).sum()
    }

    /// The same plan with more uncertain parameters, such as those of an effect that is taken for
    /// granted.
    #[must_use]
    pub fn with_parameters(&self, more: &[Variable]) -> Self {
        let mut plan = self.clone();
        plan.shared.extend_from_slice(more);
        plan
    }

    /// The same plan for other logs of the same lengths, centred at other nuisances (all of the
    /// plan: shared, then segment by segment).
    pub(crate) fn moved(&self, logs: Vec<Log>, nuisances: &[f64]) -> Self {
        let mut plan = Self { logs, ..self.clone() };
        let all = plan.shared.iter_mut().chain(plan.own.iter_mut().flatten());
        for (variable, value) in all.zip(nuisances) {
            variable.start = *value;
        }
        plan
    }
}
