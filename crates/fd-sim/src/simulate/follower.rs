//! A simulator that follows what was logged.
//!
//! A plant that is unstable without its controller runs away from any start: a free run of its log is lost,
//! and windows forget what is slow and restart every delay, lag and hysteresis. Here the simulation is corrected at each sample
//! by what it has missed of the logged outputs, with a fixed gain: what is left are the *innovations* of a
//! Kalman filter (L. Ljung, *System Identification*, 2nd ed. 1999, section 7.4), white where the model is right.
//! The corrections act on the states of the plant alone; what effects remember stays in the simulator and is never
//! reset.
//!
//! The gain is that of the steady-state filter of the model, linearised at its initial state, with hardly any
//! process noise: an unstable mode is followed with its mirror image, an integrator slowly, and what is stable
//! runs as freely as it can.
//!
//! *When not to use:* on plants that forget their start, or only integrate. There the free run says more: an effect that is
//! slow is taken for a disturbance by a filter, and followed.

use fd_model::{Circle, Continuous, Record, SampleTime, StateSpace, riccati};

use faer::{Mat, Scale, prelude::Solve};
use fd_numeric::dense::Dense;

use super::{
    Nominal, OperatingPoint, Outcome, SimulateError, Simulator, linearize,
    logged_outputs::{samples_of_action, see_logged, with_logged_outputs},
};
use crate::{
    equation::{Expr, Unary},
    model::{Input, Law, Model, ModelError, Signal},
    scales::{ForceScale, ReplayScales, SignalScale},
};

/// Process noise of a sample, as of a disturbance of the inputs of this part of their size.
const DISTURBANCE: f64 = 1e-3;
/// The same where so little does not hold a plant that is far from linear, one after the other.
const STRONGER: [f64; 3] = [1e-2, 1e-1, 1.0];

/// A model whose simulation is corrected by logged outputs.
///
/// Each output is one more external input, which has to be in the [`record`](Self::record). The model that effects
/// are spliced into is the one that came, with the noise of its outputs raised to that of the innovations.
#[derive(Clone, Debug)]
pub struct Follower<'a> {
    nominal: &'a dyn Nominal,
    model: Model,
    /// States that are corrected.
    states: Vec<String>,
    /// Corrections of their derivatives by errors of the outputs.
    gain: Mat<f64>,
    /// Names of the outputs and of the inputs that bring their logged values.
    logged: Vec<(String, String)>,
    /// Outputs that a controller makes of the log.
    commanded: Vec<String>,
}

impl<'a> Follower<'a> {
    /// Designs the gain for samples `ts` apart, outputs with this `noise` (standard deviations, in their units)
    /// and inputs `u` of the plant (mean and size of each). A controller sees the logged outputs. `None` for a model with a
    /// controller that does not act at each sample, states with update laws or delays, and where no gain can hold it.
    ///
    /// ```
    /// use fd_sim::{model::Model, simulate::{Follower, Nominal}};
    /// use fd_model::{Channel, Record};
    ///
    /// // Falls over within a second.
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "pole"
    /// sample_time = 0.02
    /// inputs = { u = { unit = "1/s^2" } }
    /// outputs = { y = { unit = "rad", value = "q", noise = 0.001 } }
    /// [states]
    /// q = { unit = "rad", initial = 0.0, derivative = "w" }
    /// w = { unit = "rad/s", initial = 0.0, derivative = "9*sin(q) + u" }
    /// "#.parse()?;
    /// let ts = model.sample_time()?;
    /// let follower = Follower::of(&model, ts, &[0.001], &[[0.0, 1.0]]).ok_or("can be held")?;
    /// // It starts 0.1 rad beside the logged pole, and is there soon.
    /// let (u, y) = ([Channel::new("u", "1/s^2")], [Channel::new("y", "rad")]);
    /// let record = Record::from_rows(u.to_vec(), y.to_vec(), vec![([0.0], [0.0]); 200], ts)?;
    /// let record = follower.record(&record)?;
    /// let inputs: Vec<f64> = (0..200).flat_map(|k| record.u(k).to_vec()).collect();
    /// let mut simulator = follower.simulator(ts)?;
    /// let mut simulated = vec![0.0; 200];
    /// simulator.simulate(&[], &[0.1, 0.0], &inputs, &mut simulated);
    /// assert!(simulated[199].abs() < 1e-3, "{}", simulated[199]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn of(
        nominal: &'a dyn Nominal,
        ts: SampleTime,
        noise: &[f64],
        u: &[[f64; 2]],
    ) -> Option<Self> {
        Self::disturbed(nominal, ts, noise, u, DISTURBANCE)
    }

    /// The same for a `record` that it is to follow: with more process noise where its run diverges, as that of a plant
    /// does which is far from linear. `None` where none holds it.
    ///
    /// ```
    /// use fd_sim::{model::Model, simulate::Follower};
    /// use fd_model::{Channel, Record};
    ///
    /// let model: Model = r#"
    /// version = 1
    /// kind = "equations"
    /// name = "pole"
    /// sample_time = 0.02
    /// inputs = { u = { unit = "1/s^2" } }
    /// outputs = { y = { unit = "rad", value = "q" } }
    /// [states]
    /// q = { unit = "rad", initial = 0.0, derivative = "w" }
    /// w = { unit = "rad/s", initial = 0.0, derivative = "9*sin(q) + u" }
    /// "#.parse()?;
    /// let (u, y) = ([Channel::new("u", "1/s^2")], [Channel::new("y", "rad")]);
    /// let ts = model.sample_time()?;
    /// let record = Record::from_rows(u.to_vec(), y.to_vec(), vec![([0.0], [0.0]); 200], ts)?;
    /// assert!(Follower::along(&model, &record, &[0.001], &[[0.0, 1.0]]).is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn along(
        nominal: &'a dyn Nominal,
        record: &Record,
        noise: &[f64],
        u: &[[f64; 2]],
    ) -> Option<Self> {
        let mut each = std::iter::once(DISTURBANCE)
            .chain(STRONGER)
            .filter_map(|size| Self::disturbed(nominal, record.ts(), noise, u, size));
        each.find(|follower| follower.holds(record).unwrap_or(false))
    }

    /// The same corrections around another simulator of these states and outputs, such as a patched one.
    ///
    /// ```
    /// use fd_sim::{model::Model, simulate::{Follower, Nominal}};
    ///
    /// let pole = |gravity: f64| format!(r#"
    /// version = 1
    /// kind = "equations"
    /// name = "pole"
    /// sample_time = 0.02
    /// inputs = {{ u = {{ unit = "1/s^2" }} }}
    /// outputs = {{ y = {{ unit = "rad", value = "q" }} }}
    /// [states]
    /// q = {{ unit = "rad", initial = 0.0, derivative = "w" }}
    /// w = {{ unit = "rad/s", initial = 0.0, derivative = "{gravity}*sin(q) + u" }}
    /// "#).parse::<Model>();
    /// let (model, other) = (pole(9.0)?, pole(8.0)?);
    /// let ts = model.sample_time()?;
    /// let follower = Follower::of(&model, ts, &[0.001], &[[0.0, 1.0]]).ok_or("can be held")?;
    /// assert_eq!(follower.around(&other).model(), &other);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn around<'b>(&self, nominal: &'b dyn Nominal) -> Follower<'b> {
        Follower {
            nominal,
            model: nominal.model().clone(),
            states: self.states.clone(),
            gain: self.gain.clone(),
            logged: self.logged.clone(),
            commanded: self.commanded.clone(),
        }
    }

    /// Whether the run along a record stays finite; `None` where it cannot be made.
    fn holds(&self, record: &Record) -> Option<bool> {
        let record = self.record(record).ok()?;
        let mut simulator = self.simulator(record.ts()).ok()?;
        let places: Option<Vec<usize>> =
            simulator.inputs().iter().map(|c| record.input_index(&c.name)).collect();
        let places = places?;
        // A missing input is the last one that was there.
        let mut held = vec![0.0; places.len()];
        let mut u = Vec::with_capacity(record.len() * places.len());
        for k in 0..record.len() {
            for (held, place) in held.iter_mut().zip(&places) {
                let value = record.u(k)[*place];
                *held = if value.is_finite() { value } else { *held };
            }
            u.extend_from_slice(&held);
        }
        let theta: Vec<f64> = simulator.parameters().iter().map(|p| p.value).collect();
        let x0: Vec<f64> = simulator.initial().iter().map(|state| state.value).collect();
        let mut y = vec![0.0; record.len() * simulator.outputs().len()];
        Some(simulator.simulate(&theta, &x0, &u, &mut y) == Outcome::Complete)
    }

    fn disturbed(
        nominal: &'a dyn Nominal,
        ts: SampleTime,
        noise: &[f64],
        u: &[[f64; 2]],
        disturbance: f64,
    ) -> Option<Self> {
        let model = nominal.model();
        let acts_at_each = |controller| samples_of_action(controller, ts) == Some(1.0);
        if !model.controller.as_ref().is_none_or(acts_at_each) {
            return None;
        }
        let plant = model.without_controller().ok()?;
        let at = OperatingPoint {
            u: u.iter().map(|[mean, _]| *mean).collect(),
            ..OperatingPoint::initial(&plant)
        };
        let linear = linearize(&plant, &at).ok()?;
        let (gain, innovations) = design(&linear, ts, noise, u, disturbance)?;
        let mut draft = model.clone().into_draft();
        for (output, size) in draft.outputs.iter_mut().zip(innovations) {
            output.noise = output.noise.map(|noise| noise.max(size));
        }
        let fresh = |name: &String| draft.fresh_name(&format!("{name}_logged"));
        let logged = draft.outputs.iter().map(|o| (o.name.clone(), fresh(&o.name))).collect();
        let states = draft.states.iter().map(|state| state.name.clone()).collect();
        let model = Model::try_from(draft).ok()?;
        Some(Self { nominal, model, states, gain, logged, commanded: Vec::new() })
    }

    /// A record with the logged outputs among its inputs, interpolated where they are missing.
    ///
    /// # Errors
    ///
    /// Never for a record of this model, which has values for all its channels.
    pub fn record(&self, record: &Record) -> Result<Record, fd_model::ModelError> {
        with_logged_outputs(record, &self.logged, &self.commanded)
    }

    /// The same where a controller makes these outputs of the log, as commands are: they say nothing of the plant, and
    /// are not measured in a [`record`](Self::record).
    #[must_use]
    pub fn with_commanded(self, commanded: &[String]) -> Self {
        Self { commanded: commanded.to_vec(), ..self }
    }

    /// The model with its corrections: a sampled controller of inputs that are added to the derivatives.
    fn corrected(&self, model: &Model, ts: SampleTime) -> Result<Model, ModelError> {
        let mut draft = model.clone().into_draft();
        let mut controller = draft.controller.take().unwrap_or_default();
        see_logged(&mut controller, model, &self.logged);
        controller.sample_time = Some(ts.seconds());
        for (i, state) in self.states.iter().enumerate() {
            let Some(at) = draft.states.iter().position(|known| known.name == *state) else {
                continue;
            };
            let name = draft.fresh_name(&format!("correction_of_{state}"));
            let terms = self.logged.iter().enumerate().map(|(j, (output, logged))| {
                let error = Expr::name(logged) - Expr::name(output);
                Expr::from(self.gain[(i, j)]) * shortest(model.outputs[j].channel().circle(), error)
            });
            let Some(value) = terms.reduce(|sum, term| sum + term) else { continue };
            let unit = format!("({})/s", draft.states[at].unit);
            draft.inputs.push(Input { name: name.clone(), unit, saturation: None });
            if let Law::Derivative(derivative) = &mut draft.states[at].law {
                *derivative = derivative.clone() + Expr::name(&name);
            }
            controller.signals.push(Signal { input: name, value });
        }
        draft.controller = Some(controller);
        Model::try_from(draft)
    }
}

impl Nominal for Follower<'_> {
    fn model(&self) -> &Model {
        &self.model
    }

    fn patched(&self, model: &Model, ts: SampleTime) -> Result<Box<dyn Simulator>, SimulateError> {
        self.nominal.patched(&self.corrected(model, ts)?, ts)
    }

    fn sees_the_log(&self) -> bool {
        true
    }

    fn commanded(&self) -> &[String] {
        &self.commanded
    }

    /// Sizes of the signals along the log, `u` with the logged outputs: those of a free run mean nothing.
    fn scales(
        &self,
        ts: SampleTime,
        u: &[f64],
        samples: usize,
    ) -> Result<ReplayScales, SimulateError> {
        let followed = ReplayScales::of(&self.corrected(&self.model, ts)?, ts, u, samples)?;
        let width = u.len() / samples.max(1);
        let plain = width - self.logged.len();
        let own: Vec<f64> =
            u.chunks_exact(width).flat_map(|row| row[..plain].iter().copied()).collect();
        // Expressions are those of the model as it came, sizes those of the corrected run.
        let model = ReplayScales::of(&self.model, ts, &own, samples)?;
        let both = |(expr, _): (Expr, SignalScale), size: Option<(Expr, SignalScale)>| {
            size.map(|(_, scale)| (expr, scale))
        };
        let sites = model.sites.into_iter().zip(followed.sites).map(|(site, size)| {
            let velocity = site.velocity.and_then(|signal| both(signal, size.velocity));
            let position = site.position.and_then(|signal| both(signal, size.position));
            let (acceleration, compliance, helpers) =
                (site.acceleration, site.compliance, site.helpers);
            let ForceScale { name, unit, force, mobility, kick, is_discrete, motion, .. } = size;
            ForceScale {
                name,
                unit,
                force,
                mobility,
                kick,
                is_discrete,
                motion,
                acceleration,
                compliance,
                helpers,
                velocity,
                position,
            }
        });
        let inputs = followed.inputs.into_iter().take(self.model.inputs.len()).collect();
        Ok(ReplayScales { inputs, sites: sites.collect(), ..followed })
    }
}

/// Corrections of the derivatives, and the standard deviations of the innovations.
fn design(
    linear: &StateSpace<Continuous>,
    ts: SampleTime,
    noise: &[f64],
    u: &[[f64; 2]],
    disturbance: f64,
) -> Option<(Mat<f64>, Vec<f64>)> {
    let (n, m) = (linear.nx(), linear.nu());
    // Beside the inputs, each derivative has one of its own.
    let b = Mat::from_fn(n, m + n, |i, j| {
        if j < m { linear.b()[(i, j)] } else { f64::from(u8::from(i == j - m)) }
    });
    let d = Mat::zeros(linear.ny(), m + n);
    let wide =
        StateSpace::new(linear.a().to_owned(), b, linear.c().to_owned(), d, Continuous).ok()?;
    let sampled = wide.sample_zoh(ts).ok()?;
    let by_inputs = Mat::from_fn(n, m, |i, j| sampled.b()[(i, j)] * disturbance * u[j][1]);
    let by_corrections = sampled.b().subcols(m, n).to_owned();
    let q = &by_inputs * by_inputs.transpose();
    // Rounding leaves a product of a matrix with itself unsymmetric.
    let q = Scale(0.5) * (&q + q.transpose());
    let r =
        Mat::from_fn(noise.len(), noise.len(), |i, j| if i == j { noise[i].powi(2) } else { 0.0 });
    let filter = riccati::discrete_filter(sampled.a(), sampled.c(), q.as_ref(), r.as_ref()).ok()?;
    let gain = by_corrections.lu().solve(&filter.gain);
    let is_finite = (0..n).all(|i| (0..noise.len()).all(|j| f64::is_finite(gain[(i, j)])));
    let sizes = (0..noise.len()).map(|j| filter.weight[(j, j)].sqrt()).collect();
    is_finite.then_some((gain, sizes))
}

/// A difference without whole turns.
fn shortest(circle: Circle, difference: Expr) -> Expr {
    let Some(turn) = circle.turn() else { return difference };
    let turns = difference.clone() / Expr::from(turn) + Expr::from(0.5);
    difference - Expr::from(turn) * Expr::unary(Unary::Floor, turns)
}
